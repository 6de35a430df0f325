//! Records one sample pass.
//!
//! In: an uploaded mesh, attachments, pipelines. Out: recorded draws of colour, data or both. With several beauty
//! passes, the colour of each is added to the frame's mean.

use super::attachments::{Attachments, DataImages};
use super::commands::{Commands, Contents, Usage};
use super::draws::DrawContext;
use super::formats::DATA;
use super::materials::Materials;
use super::memory::Image;
use super::pipeline::{Alpha, Key, Pipelines, Stage};
use super::rendering::{Attachment, Rendering};
use crate::raster::{Draw, Geometry, RasterError};

/// Depth at infinity: z is reversed.
const FAR: f32 = 0.0;

/// The outputs of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PassOutput {
    /// Colour and data, from the same triangles in one rendering.
    Both,
    /// Colour only.
    Beauty,
    /// Data only.
    Data,
}

/// The draws of a pass, in the order of the geometry, grouped by how they are drawn.
pub(super) struct DrawGroups<'a> {
    opaque: Vec<&'a Draw>,
    blended: Vec<&'a Draw>,
}

impl<'a> DrawGroups<'a> {
    /// Groups the draws, and creates the pipelines they need.
    pub(super) fn new(
        geometry: &'a Geometry,
        output: PassOutput,
        materials: &Materials,
        pipelines: &mut Pipelines,
    ) -> Result<Self, RasterError> {
        let mut groups = DrawGroups { opaque: Vec::new(), blended: Vec::new() };
        for draw in geometry.draws.iter().filter(|draw| !draw.indices.is_empty()) {
            let state = materials.state(draw.material)?;
            for &stage in stages(output, state.variant.alpha) {
                pipelines.prepare(Key { stage, variant: state.variant })?;
            }
            match state.variant.alpha {
                Alpha::Blend => groups.blended.push(draw),
                Alpha::Opaque | Alpha::Mask => groups.opaque.push(draw),
            }
        }
        Ok(groups)
    }
}

fn stages(output: PassOutput, alpha: Alpha) -> &'static [Stage] {
    match output {
        PassOutput::Both if alpha != Alpha::Blend => &[Stage::Both],
        PassOutput::Both => &[Stage::Beauty, Stage::Data],
        PassOutput::Beauty => &[Stage::Beauty],
        PassOutput::Data => &[Stage::Data],
    }
}

/// An attachment was used before it was created.
const UNPREPARED: RasterError = RasterError::Misuse("a pass lacks an attachment");

/// Records the draws of a pass; its attachments must be prepared. Colour is drawn into the sample image if the frame is
/// the mean of several passes.
pub(super) fn record(
    context: &DrawContext,
    attachments: &mut Attachments,
    groups: &DrawGroups,
    (output, is_one_of_several): (PassOutput, bool),
) -> Result<(), RasterError> {
    let Attachments { color, sample, beauty_depth, data, .. } = attachments;
    let color = if is_one_of_several { sample.as_mut() } else { color.as_mut() };
    match output {
        PassOutput::Both => both(context, color.ok_or(UNPREPARED)?, data.as_mut().ok_or(UNPREPARED)?, groups),
        PassOutput::Beauty => {
            beauty(context, (color.ok_or(UNPREPARED)?, beauty_depth.as_mut().ok_or(UNPREPARED)?), groups)
        }
        PassOutput::Data => draw_data(context, data.as_mut().ok_or(UNPREPARED)?, groups),
    }
}

fn both(
    context: &DrawContext,
    color: &mut Image,
    data: &mut DataImages,
    groups: &DrawGroups,
) -> Result<(), RasterError> {
    let mut colors = vec![(&mut *color, Some([0.0; 4]))];
    colors.extend(data.images.iter_mut().zip(DATA).map(|(image, spec)| (image, Some(spec.clear()))));
    let rendering = open(context, &mut colors, Some((&mut data.depth, Some(FAR))));
    context.draw(&rendering, Stage::Both, &groups.opaque)?;
    drop(rendering);
    if groups.blended.is_empty() {
        return Ok(());
    }
    // Colour is drawn first: it is occluded by opaque surfaces only, while drawing data also stores the depth of
    // blended ones.
    let rendering = open(context, &mut [(color, None)], Some((&mut data.depth, None)));
    context.draw(&rendering, Stage::Beauty, &groups.blended)?;
    drop(rendering);
    let mut colors: Vec<_> = data.images.iter_mut().map(|image| (image, None)).collect();
    let rendering = open(context, &mut colors, Some((&mut data.depth, None)));
    context.draw(&rendering, Stage::Data, &groups.blended)
}

fn beauty(
    context: &DrawContext,
    (color, depth): (&mut Image, &mut Image),
    groups: &DrawGroups,
) -> Result<(), RasterError> {
    let rendering = open(context, &mut [(color, Some([0.0; 4]))], Some((depth, Some(FAR))));
    context.draw(&rendering, Stage::Beauty, &groups.opaque)?;
    context.draw(&rendering, Stage::Beauty, &groups.blended)
}

fn draw_data(context: &DrawContext, data: &mut DataImages, groups: &DrawGroups) -> Result<(), RasterError> {
    let mut colors: Vec<_> =
        data.images.iter_mut().zip(DATA).map(|(image, spec)| (image, Some(spec.clear()))).collect();
    let rendering = open(context, &mut colors, Some((&mut data.depth, Some(FAR))));
    context.draw(&rendering, Stage::Data, &groups.opaque)?;
    context.draw(&rendering, Stage::Data, &groups.blended)
}

/// Adds the sample colour to the frame's.
pub(super) fn resolve(
    context: &DrawContext,
    attachments: &mut Attachments,
    (weight, is_first): (f32, bool),
) -> Result<(), RasterError> {
    let (pipeline, layout) = context.pipelines.resolve()?;
    let sample = attachments.sample.as_mut().ok_or(UNPREPARED)?;
    context.commands.prepare(sample, Usage::Sampled, Contents::Keep);
    let color = attachments.color.as_mut().ok_or(UNPREPARED)?;
    let rendering = open(context, &mut [(color, is_first.then_some([0.0; 4]))], None);
    rendering.bind_pipeline(pipeline);
    rendering.bind_set(layout, 0, attachments.sample_set);
    rendering.push(layout, bytemuck::bytes_of(&weight));
    rendering.draw_triangle();
    Ok(())
}

/// Begins rendering into images, either cleared to a value or preserving their contents.
fn open<'a>(
    context: &DrawContext<'a>,
    colors: &mut [(&mut Image, Option<[f32; 4]>)],
    depth: Option<(&mut Image, Option<f32>)>,
) -> Rendering<'a> {
    let commands: &'a Commands = context.commands;
    let contents = |is_cleared| if is_cleared { Contents::Discard } else { Contents::Keep };
    for (image, clear) in colors.iter_mut() {
        commands.prepare(image, Usage::ColorAttachment, contents(clear.is_some()));
    }
    let depth = depth.map(|(image, clear)| {
        commands.prepare(image, Usage::DepthAttachment, contents(clear.is_some()));
        Attachment { image: &*image, clear }
    });
    let colors: Vec<_> = colors.iter().map(|(image, clear)| Attachment { image, clear: *clear }).collect();
    Rendering::begin(commands, context.extent, &colors, depth)
}
