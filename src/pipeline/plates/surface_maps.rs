//! Maps of a shot over a scene: every pixel follows the surface that it shows, whatever layers move it.
//!
//! In: a [`PreparedShot`] with a scene. Out: the [`WarpMap`] of a frame, from the scene drawn before and after the
//! warp, with the displacement of every surface between the two.

use super::at_rest::SceneAtRest;
use crate::image::Frame;
use crate::pipeline::draw::geometry_thread::geometry_between;
use crate::pipeline::draw::{draw_tiles, tiles};
use crate::pipeline::{PipelineError, PreparedShot, TimeSample};
use crate::plate::{SurfacePicture, WarpMap};
use crate::raster::{ChannelGroup, DeviceChoice, Draw, Geometry, Pass, PassRole, Raster, Target};
use crate::space::FrameWindow;
use glam::Vec2;
use std::collections::BTreeSet;

/// What the maps need to know of each pixel.
const CHANNELS: [ChannelGroup; 3] = [ChannelGroup::Depth, ChannelGroup::Motion, ChannelGroup::Id];

/// Draws the maps of a shot.
pub struct SurfaceMaps<'a> {
    prepared: &'a PreparedShot,
    /// The shot with all layers at rest.
    still: PreparedShot,
    device: Box<dyn Raster + Send>,
    /// The display window and the pixels of the maps.
    place: FrameWindow,
    /// Indices of the nodes that are drawn; `None`: all.
    nodes: Option<BTreeSet<usize>>,
}

impl<'a> SurfaceMaps<'a> {
    /// Prepares maps of a display window, for the pixels of a window.
    ///
    /// # Errors
    /// [`PipelineError`] if the scene cannot be prepared.
    pub fn new(prepared: &'a PreparedShot, place: FrameWindow) -> Result<Self, PipelineError> {
        let at_rest = SceneAtRest::new(prepared, &DeviceChoice::Cpu, Vec::new()).with_one_sample();
        let (device, still) = at_rest.opened(prepared.shot.size)?;
        Ok(Self { prepared, still, device, place, nodes: None })
    }

    /// Restricts the pictures to the meshes of some nodes.
    pub(super) fn of_nodes(self, nodes: BTreeSet<usize>) -> Self {
        Self { nodes: Some(nodes), ..self }
    }

    /// The display window and the pixels of the maps.
    pub(super) const fn place(&self) -> FrameWindow {
        self.place
    }

    /// Returns the source of every pixel of the warped picture of a frame.
    ///
    /// # Errors
    /// [`PipelineError`] if a layer cannot be solved or the scene cannot be drawn.
    pub fn backward(&mut self, frame: i32) -> Result<WarpMap, PipelineError> {
        let [unwarped, warped] = self.pictures(f64::from(frame))?;
        Ok(WarpMap::between(&warped, &unwarped, self.place.frame))
    }

    /// Returns the target of every pixel of the unwarped picture of a frame.
    ///
    /// # Errors
    /// The errors of [`Self::backward`].
    #[cfg(any(test, feature = "cli"))]
    pub(crate) fn forward(&mut self, frame: i32) -> Result<WarpMap, PipelineError> {
        let [unwarped, warped] = self.pictures(f64::from(frame))?;
        Ok(WarpMap::between(&unwarped, &warped, self.place.frame))
    }

    /// Draws the scene at a (fractional) frame before and after the warp, each with its displacement to the other.
    pub(super) fn pictures(&mut self, frame: f64) -> Result<[SurfacePicture; 2], PipelineError> {
        let [before, after] = self.geometries(frame)?;
        Ok([self.picture(&before)?, self.picture(&after)?])
    }

    /// As [`Self::pictures`], each followed by the picture of a part of the scene alone.
    pub(super) fn pictures_with(
        &mut self,
        frame: f64,
        part: &dyn Fn(&Draw) -> bool,
    ) -> Result<[[SurfacePicture; 2]; 2], PipelineError> {
        let [before, after] = self.geometries(frame)?;
        let mut with_part = |mut geometry: Geometry| -> Result<_, PipelineError> {
            let all = self.picture(&geometry)?;
            geometry.draws.retain(part);
            Ok([all, self.picture(&geometry)?])
        };
        Ok([with_part(before)?, with_part(after)?])
    }

    /// Builds the geometry at a (fractional) frame before and after the warp.
    fn geometries(&self, frame: f64) -> Result<[Geometry; 2], PipelineError> {
        let unwarped = self.still.sample_at(frame)?;
        let warped = self.prepared.sample_at(frame)?;
        let between = |ends: [&TimeSample; 2]| {
            let mut geometry = geometry_between(self.prepared, ends, &warped);
            if let Some(nodes) = &self.nodes {
                geometry.draws.retain(|draw| nodes.contains(&(draw.object_id as usize - 1)));
            }
            geometry
        };
        Ok([between([&unwarped, &warped]), between([&warped, &unwarped])])
    }

    /// Draws geometry whose motion is the displacement to the other picture.
    fn picture(&mut self, geometry: &Geometry) -> Result<SurfacePicture, PipelineError> {
        let pass = Pass { geometry, jitter_px: Vec2::ZERO, role: PassRole::Data };
        let device = self.device.as_mut();
        let tiles = tiles(self.place.window, device.max_side());
        let drawn = draw_tiles(self.place, &tiles, |window| {
            let target = Target { frame: self.place.frame, window, channels: CHANNELS.to_vec(), beauty_passes: 1 };
            device.start(&target)?;
            device.draw(&pass)?;
            Ok(device.finish()?)
        })?;
        Ok(surfaces_of(&drawn))
    }
}

/// Converts a frame with [`CHANNELS`].
fn surfaces_of(drawn: &Frame) -> SurfacePicture {
    let samples = |name| drawn.channel(name).map(|channel| channel.samples.as_slice()).unwrap_or_default();
    // Motion has y up.
    let offsets = samples("forward.u").iter().zip(samples("forward.v")).map(|(x, y)| [*x, -*y]);
    SurfacePicture {
        window: drawn.data_window,
        objects: samples("id.object").to_vec(),
        depths: samples("depth.Z").to_vec(),
        offsets: offsets.collect(),
    }
}
