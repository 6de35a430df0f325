//! Draws the frames of a render: a scene on a device, or pictures by warping them.
//!
//! In: frame numbers. Out: [`Drawn`] frames.

use super::write::Drawn;
use crate::pipeline::PreparedShot;
use crate::pipeline::draw::{FramesToDraw, draw_frames};
use crate::pipeline::pictures::{Gallery, left_out_channels, paint_frames};
use crate::raster::{DeviceClass, Raster};
use std::sync::mpsc::SyncSender;

/// What draws the frames of a render.
pub(in crate::pipeline) enum Renderer<'a> {
    /// A device that draws a scene.
    Scene(&'a mut dyn Raster),
    /// The pictures of a shot, which are warped on the CPU.
    Pictures(&'a Gallery),
}

impl Renderer<'_> {
    /// Returns the class of the device.
    pub(in crate::pipeline) fn class(&self) -> DeviceClass {
        match self {
            Self::Scene(device) => device.class(),
            Self::Pictures(_) => DeviceClass::Cpu,
        }
    }

    /// Returns the name of the device for events and metadata.
    pub(in crate::pipeline) fn name(&self) -> String {
        match self {
            Self::Scene(device) => device.name(),
            Self::Pictures(_) => "the CPU, as pictures".to_owned(),
        }
    }

    /// Returns what the user should know of the frames, if anything.
    pub(in crate::pipeline) fn note(&self, prepared: &PreparedShot) -> Option<String> {
        match self {
            Self::Scene(_) => None,
            Self::Pictures(_) => left_out_channels(prepared),
        }
    }

    /// Draws frames until the render is cancelled or the receiver is gone. Returns the milliseconds spent drawing.
    pub(in crate::pipeline) fn draw(
        self,
        prepared: &PreparedShot,
        frames: FramesToDraw,
        drawn: SyncSender<Drawn>,
    ) -> f64 {
        match self {
            Self::Scene(device) => draw_frames(device, prepared, frames, drawn),
            Self::Pictures(gallery) => paint_frames(gallery, prepared, frames, drawn),
        }
    }
}
