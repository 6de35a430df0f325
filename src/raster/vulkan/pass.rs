//! One sample pass as commands.
//!
//! In: filled geometry, attachments, pipelines. Out: recorded draws of colour, data or both; with several beauty
//! passes, their mean grows in the frame's colour.

use super::commands::{Commands, Contents, Usage};
use super::materials::Materials;
use super::memory::Image;
use super::painter::Painter;
use super::pipeline::{Alpha, Key, PUSH_BYTES, Pipelines, Stage};
use super::rendering::{Attachment, Rendering};
use super::target::{Attachments, DATA_CLEAR, DataImages};
use crate::raster::{Draw, Geometry, RasterError, Target};
use bytemuck::{Pod, Zeroable};
use glam::Vec2;

/// Depth of the far plane: z is reversed.
const FAR: f32 = 0.0;

/// `Push` of geometry.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct View {
    clip_scale: [f32; 2],
    clip_offset: [f32; 2],
    pixels_from_screen: [f32; 2],
    pixel_offset: [f32; 2],
    ids: [f32; 2],
}

const _: () = assert!(size_of::<View>() == PUSH_BYTES as usize);

impl View {
    /// Screen space seen through the window of a target, shifted by `jitter` pixels (x right, y down).
    pub(super) fn new(target: &Target, jitter: Vec2) -> Self {
        let (frame, window) = (target.frame, target.window);
        let height = f64::from(frame.height);
        let across = height / frame.pixel_aspect;
        let jitter = jitter.as_dvec2();
        let (left, top) = (f64::from(window.x) - jitter.x, f64::from(window.y) - jitter.y);
        let (width, rows) = (f64::from(window.width), f64::from(window.height));
        // Pixel column of x is x·across - left, row of y is (1 - y)·height - top; clip = 2·pixel / size - 1.
        Self {
            clip_scale: [(2.0 * across / width) as f32, (-2.0 * height / rows) as f32],
            clip_offset: [(-2.0 * left / width - 1.0) as f32, (2.0 * (height - top) / rows - 1.0) as f32],
            pixels_from_screen: [across as f32, height as f32],
            pixel_offset: [left as f32, (height - top) as f32],
            ids: [0.0; 2],
        }
    }

    /// The same for one draw.
    pub(super) fn of_draw(self, draw: &Draw) -> Self {
        Self { ids: [draw.layer_id as f32, draw.object_id as f32], ..self }
    }
}

/// What a pass draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Work {
    /// Colour and data from the same triangles at once: the first data of the frame.
    Both,
    /// Colour.
    Beauty,
    /// Data.
    Data,
    /// Colour, then data again nearer than what is there.
    BeautyThenData,
}

/// Where a beauty pass ends up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Destination {
    /// It is the frame's only one.
    Frame,
    /// It is one of several.
    Mean {
        /// Its share.
        weight: f32,
        /// Nothing has been added yet.
        is_first: bool,
    },
}

/// The draws of a pass in the order of the geometry, by how they are drawn.
pub(super) struct Groups<'a> {
    solid: Vec<&'a Draw>,
    blended: Vec<&'a Draw>,
}

impl<'a> Groups<'a> {
    /// Splits the draws, and makes the pipelines they need.
    pub(super) fn new(
        geometry: &'a Geometry,
        work: Work,
        materials: &Materials,
        pipelines: &mut Pipelines,
    ) -> Result<Self, RasterError> {
        let mut groups = Groups { solid: Vec::new(), blended: Vec::new() };
        for draw in geometry.draws.iter().filter(|draw| !draw.indices.is_empty()) {
            let look = materials.look(draw.material)?;
            for &stage in stages(work, look.alpha) {
                pipelines.prepare(Key { stage, alpha: look.alpha, textures: look.textures })?;
            }
            match look.alpha {
                Alpha::Blend => groups.blended.push(draw),
                Alpha::Opaque | Alpha::Mask => groups.solid.push(draw),
            }
        }
        Ok(groups)
    }
}

fn stages(work: Work, alpha: Alpha) -> &'static [Stage] {
    match work {
        Work::Both if alpha != Alpha::Blend => &[Stage::Both],
        Work::Both | Work::BeautyThenData => &[Stage::Beauty, Stage::Data],
        Work::Beauty => &[Stage::Beauty],
        Work::Data => &[Stage::Data],
    }
}

/// What a pass is drawn into, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plan {
    pub(super) work: Work,
    pub(super) destination: Destination,
    /// Data has been drawn in this frame.
    pub(super) has_data: bool,
}

/// An image was used before it was made.
const UNPREPARED: RasterError = RasterError::Misuse("a pass lacks an attachment");

/// Records the draws of a pass into the painter's commands; the attachments it needs are there.
pub(super) fn record(
    painter: &Painter,
    attachments: &mut Attachments,
    groups: &Groups,
    plan: Plan,
) -> Result<(), RasterError> {
    let Attachments { color, sample, beauty_depth, data, .. } = attachments;
    let color = match plan.destination {
        Destination::Frame => color.as_mut(),
        Destination::Mean { .. } => sample.as_mut(),
    };
    match plan.work {
        Work::Both => {
            both(painter, color.ok_or(UNPREPARED)?, data.as_mut().ok_or(UNPREPARED)?, groups)?;
        }
        Work::Beauty => beauty(painter, (color.ok_or(UNPREPARED)?, beauty_depth.as_mut().ok_or(UNPREPARED)?), groups)?,
        Work::Data => draw_data(painter, data.as_mut().ok_or(UNPREPARED)?, plan.has_data, groups)?,
        Work::BeautyThenData => {
            beauty(painter, (color.ok_or(UNPREPARED)?, beauty_depth.as_mut().ok_or(UNPREPARED)?), groups)?;
            draw_data(painter, data.as_mut().ok_or(UNPREPARED)?, plan.has_data, groups)?;
        }
    }
    Ok(())
}

fn both(painter: &Painter, color: &mut Image, data: &mut DataImages, groups: &Groups) -> Result<(), RasterError> {
    let [normal_depth, motion, ids] = &mut data.images;
    let mut colors = [
        (&mut *color, Some([0.0; 4])),
        (normal_depth, Some(DATA_CLEAR[0])),
        (motion, Some(DATA_CLEAR[1])),
        (ids, Some(DATA_CLEAR[2])),
    ];
    let rendering = open(painter, &mut colors, Some((&mut data.depth, Some(FAR))));
    painter.paint(&rendering, Stage::Both, &groups.solid)?;
    drop(rendering);
    if groups.blended.is_empty() {
        return Ok(());
    }
    // Colour first: it is hidden by solid surfaces only, while data also stores the depth of blended ones.
    let rendering = open(painter, &mut [(color, None)], Some((&mut data.depth, None)));
    painter.paint(&rendering, Stage::Beauty, &groups.blended)?;
    drop(rendering);
    let mut colors = data.images.each_mut().map(|image| (image, None));
    let rendering = open(painter, &mut colors, Some((&mut data.depth, None)));
    painter.paint(&rendering, Stage::Data, &groups.blended)
}

fn beauty(painter: &Painter, (color, depth): (&mut Image, &mut Image), groups: &Groups) -> Result<(), RasterError> {
    let rendering = open(painter, &mut [(color, Some([0.0; 4]))], Some((depth, Some(FAR))));
    painter.paint(&rendering, Stage::Beauty, &groups.solid)?;
    painter.paint(&rendering, Stage::Beauty, &groups.blended)
}

/// All data passes of a frame share their depth, so each pixel keeps the nearest surface of all of them.
fn draw_data(painter: &Painter, data: &mut DataImages, has_data: bool, groups: &Groups) -> Result<(), RasterError> {
    let mut clears = DATA_CLEAR.map(|clear| (!has_data).then_some(clear)).into_iter();
    let mut colors = data.images.each_mut().map(|image| (image, clears.next().flatten()));
    let rendering = open(painter, &mut colors, Some((&mut data.depth, (!has_data).then_some(FAR))));
    painter.paint(&rendering, Stage::Data, &groups.solid)?;
    painter.paint(&rendering, Stage::Data, &groups.blended)
}

/// Adds the sample colour to the frame's.
pub(super) fn resolve(
    painter: &Painter,
    attachments: &mut Attachments,
    pipelines: &Pipelines,
    (weight, is_first): (f32, bool),
) -> Result<(), RasterError> {
    let (pipeline, layout) = pipelines.resolve()?;
    let sample = attachments.sample.as_mut().ok_or(UNPREPARED)?;
    painter.commands.prepare(sample, Usage::Sampled, Contents::Keep);
    let color = attachments.color.as_mut().ok_or(UNPREPARED)?;
    let rendering = open(painter, &mut [(color, is_first.then_some([0.0; 4]))], None);
    rendering.bind_pipeline(pipeline);
    rendering.bind_set(layout, 0, attachments.sample_set);
    rendering.push(layout, bytemuck::bytes_of(&weight));
    rendering.draw_triangle();
    Ok(())
}

/// Starts to draw into images: cleared to a value, or with their contents kept.
fn open<'a>(
    painter: &Painter<'a>,
    colors: &mut [(&mut Image, Option<[f32; 4]>)],
    depth: Option<(&mut Image, Option<f32>)>,
) -> Rendering<'a> {
    let commands: &'a Commands = painter.commands;
    let contents = |is_cleared| if is_cleared { Contents::Discard } else { Contents::Keep };
    for (image, clear) in colors.iter_mut() {
        commands.prepare(image, Usage::ColorAttachment, contents(clear.is_some()));
    }
    let depth = depth.map(|(image, clear)| {
        commands.prepare(image, Usage::DepthAttachment, contents(clear.is_some()));
        Attachment { image: &*image, clear }
    });
    let colors: Vec<_> = colors.iter().map(|(image, clear)| Attachment { image, clear: *clear }).collect();
    Rendering::begin(commands, painter.extent, &colors, depth)
}
