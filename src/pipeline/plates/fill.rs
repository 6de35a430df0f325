//! What the geometry path shows where a layer of a plate has moved away.
//!
//! In: a shot with a scene, the layers that have a matte. Out: the unwarped scene of a frame, drawn without them, with the
//! ids and names that a render of the shot gives to what is left.

use super::super::draw::draw_frame;
use super::super::{PipelineError, Setup};
use crate::image::{FrameMetadata, Plate};
use crate::plate::{WarpRules, has_cryptomattes};
use crate::raster::{self, ChannelGroup, DeviceChoice, Raster};
use crate::scene::Scene;
use crate::shot::Shot;
use crate::space::FrameSize;

/// What any plate may hold; Cryptomattes come on top where it has some.
const CHANNELS: [ChannelGroup; 5] =
    [ChannelGroup::Beauty, ChannelGroup::Depth, ChannelGroup::Motion, ChannelGroup::Normal, ChannelGroup::Id];

/// Draws what lies behind.
pub(super) struct Filler<'a> {
    /// All its layers are at rest.
    shot: Shot,
    scene: &'a Scene,
    /// Layers that moved away.
    hidden: Vec<usize>,
    device: &'a DeviceChoice,
    /// Made for plates of the size last seen.
    ready: Option<(Box<dyn Raster + Send>, Setup)>,
}

impl<'a> Filler<'a> {
    /// `None` where no layer has a matte, or nothing would be left to draw.
    pub(super) fn of(setup: &'a Setup, device: &'a DeviceChoice, layers: &[usize]) -> Option<Self> {
        let has_matte = |&&layer: &&usize| setup.shot.layers[layer].matte.is_some();
        let hidden: Vec<usize> = layers.iter().filter(has_matte).copied().collect();
        let is_hidden = |owner: &&Option<usize>| owner.is_some_and(|layer| hidden.contains(&layer));
        let hidden_parts = setup.owners.iter().filter(is_hidden).count();
        if hidden_parts == 0 || hidden_parts == setup.owners.len() {
            return None;
        }
        let mut shot = setup.shot.clone();
        // Layers that are left bend the whole picture, and this with it.
        for layer in &mut shot.layers {
            layer.pins.clear();
            layer.handles.clear();
            layer.transfer = None;
        }
        Some(Self { shot, scene: &setup.scene, hidden, device, ready: None })
    }

    /// The unwarped frame without what has a matte, in pixels of a plate; it says of itself what a render says.
    pub(super) fn draw(&mut self, frame: i32, (plate, rules): (&Plate, &WarpRules)) -> Result<Plate, PipelineError> {
        let size = plate.frame_size();
        let (mut device, mut setup) = match self.ready.take().filter(|(_, setup)| setup.shot.size == size) {
            Some(ready) => ready,
            None => self.made_ready(size)?,
        };
        setup.shot.output.channels = CHANNELS.to_vec();
        if has_cryptomattes(plate, rules) {
            setup.shot.output.channels.push(ChannelGroup::Cryptomatte);
        }
        let drawn = draw_frame(device.as_mut(), &setup, frame);
        let metadata = FrameMetadata { frame, mattes: setup.mattes.headers.clone(), ..FrameMetadata::default() };
        self.ready = Some((device, setup));
        Ok(Plate::from_render(drawn?, &metadata))
    }

    fn made_ready(&self, size: FrameSize) -> Result<(Box<dyn Raster + Send>, Setup), PipelineError> {
        let mut setup = Setup::with_scene(Shot { size, ..self.shot.clone() }, self.scene.clone())?;
        setup.hidden.clone_from(&self.hidden);
        Ok((raster::open(self.device, &setup.scene)?.0, setup))
    }
}
