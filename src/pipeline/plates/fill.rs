//! What the geometry path shows where a layer of a plate has moved away.
//!
//! In: a shot with a scene, the layers that have a matte. Out: the unwarped scene of a frame, drawn without them.

use super::super::draw::draw_frame;
use super::super::{PipelineError, Setup};
use crate::image::Plate;
use crate::raster::{self, ChannelGroup, DeviceChoice, Raster};
use crate::scene::Scene;
use crate::shot::Shot;
use crate::space::FrameSize;

/// Everything that can be drawn: a plate may hold any of it.
const CHANNELS: [ChannelGroup; 5] =
    [ChannelGroup::Beauty, ChannelGroup::Depth, ChannelGroup::Motion, ChannelGroup::Normal, ChannelGroup::Id];

/// Draws what lies behind.
pub(super) struct Filler<'a> {
    shot: Shot,
    scene: Scene,
    device: &'a DeviceChoice,
    /// Made for plates of the size last seen.
    ready: Option<(Box<dyn Raster + Send>, Setup)>,
}

impl<'a> Filler<'a> {
    /// `None` where no layer has a matte, or nothing would be left to draw.
    pub(super) fn of(setup: &Setup, device: &'a DeviceChoice, layers: &[usize]) -> Option<Self> {
        let is_moved = |index: usize| layers.contains(&index) && setup.shot.layers[index].matte.is_some();
        let mut scene = setup.scene.clone();
        let (pose, _) = setup.view(f64::from(setup.shot.frames.first));
        let (moved, left): (Vec<_>, Vec<_>) =
            pose.parts.iter().zip(&setup.owners).partition(|(_, owner)| owner.is_some_and(is_moved));
        if moved.is_empty() || left.is_empty() {
            return None;
        }
        moved.iter().for_each(|(part, _)| scene.nodes[part.node].mesh = None);
        let mut shot = setup.shot.clone();
        // The layers that are left bend the whole picture, and this with it.
        shot.layers.clear();
        shot.output.channels = CHANNELS.to_vec();
        Some(Self { shot, scene, device, ready: None })
    }

    /// The unwarped frame without what has a matte, in pixels of a plate of that size.
    pub(super) fn draw(&mut self, frame: i32, size: FrameSize) -> Result<Plate, PipelineError> {
        let (mut device, setup) = match self.ready.take().filter(|(_, setup)| setup.shot.size == size) {
            Some(ready) => ready,
            None => {
                let setup = Setup::with_scene(Shot { size, ..self.shot.clone() }, self.scene.clone())?;
                (raster::open(self.device, &setup.scene)?.0, setup)
            }
        };
        let drawn = draw_frame(device.as_mut(), &setup, frame);
        self.ready = Some((device, setup));
        drawn.map(Plate::from_frame)
    }
}
