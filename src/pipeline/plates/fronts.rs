//! Finds what the scene shows in front of moved layers: it has to cover them after the warp, and what it hid of them
//! before is not in the plate.
//!
//! In: a [`PreparedShot`] over a scene, the layers that a plate moves. Out: the [`Front`] of each layer in a frame.

use super::SurfaceMaps;
use crate::image::Frame;
use crate::image::cryptomatte::MatteId;
use crate::pipeline::draw::geometry_thread::geometry_of;
use crate::pipeline::draw::{draw_tiles, tiles};
use crate::pipeline::evaluate::camera_cuts::exposure_time;
use crate::pipeline::{PassPlan, PipelineError, PreparedShot, plan_passes};
use crate::plate::{Coverage, Front, SurfacePicture};
use crate::raster::{self, ChannelGroup, DeviceChoice, Draw, Geometry, MATTE_LAYERS, Pass, Raster, Target};
use crate::shot::LayerSpace;
use crate::space::{FrameWindow, PixelRect};
use glam::DVec2;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Relative difference of depth from which on one surface is in front of another.
const NEARER: f32 = 1e-4;

/// Smallest coverage by which a layer's visible fraction is determined.
const LEAST: f32 = 1e-3;

/// The layers that move as one: a single layer, or all that share meshes.
#[derive(Clone, Debug)]
pub(super) struct MovingGroup {
    /// Index of the layer, or of the first of them.
    pub(super) layer: usize,
    /// Indices of the nodes that they move; `None`: what belongs to the layer.
    pub(super) nodes: Option<BTreeSet<usize>>,
}

impl MovingGroup {
    fn moves(&self, draw: &Draw) -> bool {
        match &self.nodes {
            Some(nodes) => nodes.contains(&(draw.object_id as usize - 1)),
            None => draw.layer_id == self.layer as u32 + 1,
        }
    }

    /// The id by which drawings tell it from others.
    fn id(&self) -> MatteId {
        MatteId::of_name(&format!("mover {}", self.layer))
    }
}

/// Draws what is in front of moved layers.
pub(super) struct Fronts<'a> {
    prepared: &'a PreparedShot,
    groups: Vec<MovingGroup>,
    /// The passes of a frame.
    plan: Vec<PassPlan>,
    /// Opened for the size of the first plate, and again for plates of another size.
    maps: Option<SurfaceMaps<'a>>,
    device: Option<Box<dyn Raster + Send>>,
}

impl<'a> Fronts<'a> {
    /// Creates the finder; `None` if nothing could be in front: all of the scene moves. Layers that are warped in the
    /// scene, or that the plate is not warped by, would stand elsewhere than in the plate, so then `None`, too.
    pub(super) fn of(prepared: &'a PreparedShot, chosen: &[usize], groups: Vec<MovingGroup>) -> Option<Self> {
        let layers = &prepared.shot.layers;
        let is_elsewhere = |index: usize| {
            layers[index].is_moved()
                && (!chosen.contains(&index) || matches!(layers[index].space, LayerSpace::World { .. }))
        };
        let node = |part: usize| prepared.assignment.node_of_part[part];
        let is_moved = |part: usize| {
            groups.iter().any(|group| match &group.nodes {
                Some(nodes) => nodes.contains(&node(part)),
                None => prepared.assignment.layer_of_part[part] == Some(group.layer),
            })
        };
        let has_rest = (0..prepared.assignment.node_of_part.len()).any(|part| !is_moved(part));
        let is_known = !groups.is_empty() && has_rest && !(0..layers.len()).any(is_elsewhere);
        is_known.then(|| {
            let plan = plan_passes(prepared.shot.samples, prepared.shot.shutter);
            Self { prepared, groups, plan, maps: None, device: None }
        })
    }

    /// Returns the fronts of a frame by layer, for the pixels of a plate; none if nothing is in front.
    pub(super) fn at(&mut self, frame: i32, place: FrameWindow) -> Result<BTreeMap<usize, Arc<Front>>, PipelineError> {
        let mut maps = match self.maps.take().filter(|maps| maps.place() == place) {
            Some(maps) => maps,
            None => SurfaceMaps::new(self.prepared, place)?,
        };
        let groups = self.groups.clone();
        let time = self.prepared.mid_exposure_time(f64::from(frame));
        let pictures = maps.pictures_with(time, &|draw| groups.iter().any(|group| group.moves(draw)));
        self.maps = Some(maps);
        let [before, after] = pictures?.map(|[all, moved]| InFront { is_in_front: in_front(&all, &moved), moved });
        let hidden = after.hidden_in(&before);
        if !after.is_in_front.contains(&true) && !hidden.contains(&true) {
            return Ok(BTreeMap::new());
        }
        let [all, alone] = [self.coverages(frame, place, true)?, self.coverages(frame, place, false)?];
        let FrameWindow { frame: size, window } = place;
        let hidden = grown(&hidden, window);
        let front = |(index, group): (usize, &MovingGroup)| {
            let visible = visible_fractions(&all[index], &alone[index], window);
            let missing = all[index].iter().zip(&hidden).map(|(all, hidden)| if *hidden { *all } else { 0.0 });
            let coverage = |samples: Vec<f32>| Coverage { frame: size, window, samples };
            (group.layer, Arc::new(Front { visible: coverage(visible), missing: coverage(missing.collect()) }))
        };
        Ok(self.groups.iter().enumerate().map(front).collect())
    }

    /// Draws the warped scene with the shot's samples and shutter, and returns how much of every pixel shows each group:
    /// behind the rest of the scene, or without it.
    fn coverages(&mut self, frame: i32, place: FrameWindow, has_rest: bool) -> Result<Vec<Vec<f32>>, PipelineError> {
        let mut device = match self.device.take() {
            Some(device) => device,
            None => raster::open(&DeviceChoice::Cpu, &self.prepared.scene)?.0,
        };
        let tiles = tiles(place.window, device.max_side());
        let drawn = draw_tiles(place, &tiles, |window| {
            self.tile(frame, FrameWindow { window, ..place }, has_rest, device.as_mut())
        });
        self.device = Some(device);
        let drawn = drawn?;
        Ok(self.groups.iter().map(|group| coverage_of_id(&drawn, group.id())).collect())
    }

    /// Draws a tile of [`Self::coverages`].
    fn tile(
        &self,
        frame: i32,
        FrameWindow { frame: size, window }: FrameWindow,
        has_rest: bool,
        device: &mut dyn Raster,
    ) -> Result<Frame, PipelineError> {
        let channels = vec![ChannelGroup::Cryptomatte];
        device.start(&Target { frame: size, window, channels, beauty_passes: self.prepared.shot.samples.max(1) })?;
        for same_time in self.plan.chunk_by(|a, b| a.time_frames == b.time_frames) {
            let time = exposure_time(self.prepared, frame, f64::from(frame) + same_time[0].time_frames);
            let mut geometry = geometry_of(self.prepared, &*self.prepared.sample_at(time)?, None);
            self.mark(&mut geometry, has_rest);
            for pass in same_time {
                device.draw(&Pass { geometry: &geometry, jitter_px: pass.jitter_px, role: pass.role })?;
            }
        }
        Ok(device.finish()?)
    }

    /// Gives every draw the id of its group.
    fn mark(&self, geometry: &mut Geometry, has_rest: bool) {
        for draw in &mut geometry.draws {
            let group = self.groups.iter().find(|group| group.moves(draw));
            draw.mattes = [group.map_or(MatteId::NOTHING, MovingGroup::id); MATTE_LAYERS.len()];
        }
        if !has_rest {
            geometry.draws.retain(|draw| draw.mattes[0] != MatteId::NOTHING);
        }
    }
}

/// The moved surfaces of a picture, and where something else is in front of them.
struct InFront {
    moved: SurfacePicture,
    is_in_front: Vec<bool>,
}

impl InFront {
    /// Returns the pixels that show a moved surface that was behind something in the other picture.
    fn hidden_in(&self, other: &Self) -> Vec<bool> {
        let SurfacePicture { window, objects, offsets, .. } = &self.moved;
        let is_hidden = |index: usize| {
            let source =
                DVec2::from(window.pixel_at(index).map(f64::from)) + 0.5 + DVec2::from(offsets[index].map(f64::from));
            let source = window.sample_index(source.floor().as_ivec2().to_array());
            objects[index] > 0.0 && !self.is_in_front[index] && source.is_some_and(|source| other.is_in_front[source])
        };
        (0..window.area()).map(is_hidden).collect()
    }
}

/// Whether each pixel shows something nearer than the moved surface there.
fn in_front(all: &SurfacePicture, moved: &SurfacePicture) -> Vec<bool> {
    let depths = all.depths.iter().zip(&moved.depths).zip(&moved.objects);
    depths.map(|((all, moved), object)| *object > 0.0 && *all < *moved * (1.0 - NEARER)).collect()
}

/// Returns how much of a layer is visible in every pixel. Beside the layer, the nearest pixels tell: filters reach there.
fn visible_fractions(all: &[f32], alone: &[f32], window: PixelRect) -> Vec<f32> {
    let mut known: Vec<Option<f32>> =
        all.iter().zip(alone).map(|(all, alone)| (*alone > LEAST).then(|| (all / alone).clamp(0.0, 1.0))).collect();
    for _ in 0..2 {
        let spread = |index: usize| {
            known[index].or_else(|| {
                let near: Vec<f32> = around(window, index).filter_map(|beside| known[beside]).collect();
                (!near.is_empty()).then(|| near.iter().sum::<f32>() / near.len() as f32)
            })
        };
        known = (0..known.len()).map(spread).collect();
    }
    known.into_iter().map(|known| known.unwrap_or(1.0)).collect()
}

/// Returns the pixels and those beside them.
fn grown(pixels: &[bool], window: PixelRect) -> Vec<bool> {
    (0..pixels.len()).map(|index| pixels[index] || around(window, index).any(|beside| pixels[beside])).collect()
}

/// Returns the indices of the pixels around one.
fn around(window: PixelRect, index: usize) -> impl Iterator<Item = usize> {
    let [x, y] = window.pixel_at(index);
    (0..9).filter(|k| *k != 4).filter_map(move |k| window.sample_index([x + k % 3 - 1, y + k / 3 - 1]))
}

/// Returns how much of every pixel an id covers, from the first Cryptomatte of a drawing.
fn coverage_of_id(drawn: &Frame, id: MatteId) -> Vec<f32> {
    let mut coverage = vec![0.0; drawn.data_window.area()];
    let ranks: Vec<_> = drawn.channels.iter().filter(|channel| channel.name.starts_with(MATTE_LAYERS[0])).collect();
    for [ids, coverages] in ranks.as_chunks().0 {
        for ((sum, own), covered) in coverage.iter_mut().zip(&ids.samples).zip(&coverages.samples) {
            *sum += if MatteId::from_sample(*own) == id { *covered } else { 0.0 };
        }
    }
    coverage
}
