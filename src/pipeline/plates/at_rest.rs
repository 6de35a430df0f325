//! Renders the scene of a shot with all its layers at rest, frame by frame.
//!
//! In: a [`PreparedShot`], layers to leave out, a device. Out: frames of any size, with the ids and names that a render
//! of the shot gives to the remaining layers.

use crate::image::{Frame, FrameMetadata, Plate};
use crate::pipeline::draw::draw_frame;
use crate::pipeline::{PipelineError, PreparedShot};
use crate::plate::{Matte, WarpSettings, coverage_of};
use crate::raster::{self, ChannelGroup, DeviceChoice, Raster};
use crate::scene::Scene;
use crate::shot::Shot;
use crate::space::FrameSize;
use std::sync::Arc;

/// Renders the unwarped scene.
pub(super) struct SceneAtRest<'a> {
    /// The shot without pins, handles and transfers.
    shot: Shot,
    scene: &'a Scene,
    /// Indices of the layers that are left out.
    hidden: Vec<usize>,
    device: &'a DeviceChoice,
    /// The device and the prepared shot, for the frame size drawn last.
    ready: Option<(Box<dyn Raster + Send>, PreparedShot)>,
}

impl<'a> SceneAtRest<'a> {
    pub(super) fn new(prepared: &'a PreparedShot, device: &'a DeviceChoice, hidden: Vec<usize>) -> Self {
        let mut shot = prepared.shot.clone();
        for layer in &mut shot.layers {
            layer.pins.clear();
            layer.handles.clear();
            layer.transfer = None;
        }
        Self { shot, scene: &prepared.scene, hidden, device, ready: None }
    }

    /// Sets one sample per pixel at mid-exposure.
    pub(super) fn with_one_sample(mut self) -> Self {
        (self.shot.samples, self.shot.shutter.angle) = (1, 0.0);
        self
    }

    /// Names the layers by [`Self::number_of`], so that no name clashes with that of parts without a layer.
    pub(super) fn with_numbered_layers(mut self) -> Self {
        self.shot.layers.iter_mut().enumerate().for_each(|(index, layer)| layer.name = Self::number_of(index));
        self
    }

    /// Returns the name of a numbered layer.
    pub(super) fn number_of(layer: usize) -> String {
        format!("layer {layer}")
    }

    /// Renders a frame with the given channels, and returns the metadata of its file.
    pub(super) fn draw(
        &mut self,
        frame: i32,
        (size, channels): (FrameSize, &[ChannelGroup]),
    ) -> Result<(Frame, FrameMetadata), PipelineError> {
        let (mut device, mut prepared) = match self.ready.take().filter(|(_, prepared)| prepared.shot.size == size) {
            Some(ready) => ready,
            None => self.opened(size)?,
        };
        prepared.shot.output.channels = channels.to_vec();
        let drawn = draw_frame(device.as_mut(), &prepared, frame);
        let metadata = FrameMetadata { frame, mattes: prepared.draw_inputs.mattes.clone(), ..FrameMetadata::default() };
        self.ready = Some((device, prepared));
        Ok((drawn?, metadata))
    }

    /// Renders the unwarped frame of a plate and returns the coverage of each list of names in a Cryptomatte of the render.
    pub(super) fn mattes(
        &mut self,
        frame: i32,
        plate: &Plate,
        (layer, names): (&str, &[Vec<String>]),
    ) -> Result<Vec<Matte>, PipelineError> {
        let (drawn, metadata) = self.draw(frame, (plate.frame_size(), &[ChannelGroup::Cryptomatte]))?;
        let drawn = Plate::from_render(drawn, &metadata);
        let matte = |names: &Vec<String>| {
            let matte = Matte::Cryptomatte { layer: Some(layer.to_owned()), names: names.clone() };
            Ok(Matte::Drawn(Arc::new(coverage_of(&drawn, &matte, &WarpSettings::default())?)))
        };
        names.iter().map(matte).collect()
    }

    /// Opens the raster, and prepares the shot for a frame size.
    pub(super) fn opened(&self, size: FrameSize) -> Result<(Box<dyn Raster + Send>, PreparedShot), PipelineError> {
        let mut prepared = PreparedShot::with_scene(Shot { size, ..self.shot.clone() }, self.scene.clone())?;
        prepared.draw_inputs.hidden_layers.clone_from(&self.hidden);
        Ok((raster::open(self.device, &prepared.scene)?.0, prepared))
    }
}
