//! Renders frames of a shot in memory; the device is kept from frame to frame.
//!
//! In: a prepared shot, a frame, a device. Out: the frame as a render would write it.

use super::failure::Failure;
use super::work::Watch;
use crate::image::Frame;
use crate::pipeline::{Device, PreparedShot};
use crate::raster::{self, DeviceChoice};
use std::sync::{Arc, Mutex, PoisonError};

/// A prepared shot and the device that rendered it last. Access is serialised between threads.
pub(super) struct Drawer {
    prepared: Arc<PreparedShot>,
    device: Mutex<Option<(DeviceChoice, Box<Device>)>>,
}

impl Drawer {
    pub(super) const fn new(prepared: Arc<PreparedShot>) -> Self {
        Self { prepared, device: Mutex::new(None) }
    }

    /// Renders a frame in memory, as a render would write it.
    pub(super) fn draw(&self, frame: i32, choice: &DeviceChoice, watch: &Watch) -> Result<Frame, Failure> {
        let prepared = &*self.prepared;
        let stop = || watch.is_stopped();
        // A layer whose solve over time fails falls back to solving frame by frame, so an error here does not concern
        // this frame.
        _ = prepared.solve_trajectories(&stop, &|_| {});
        watch.check()?;
        let drawn = if prepared.needs_raster() {
            let mut kept = self.device.lock().unwrap_or_else(PoisonError::into_inner);
            if kept.as_ref().is_none_or(|(known, _)| known != choice) {
                *kept = Some((choice.clone(), raster::open(choice, &prepared.scene)?.0));
            }
            let device = kept.as_mut().map(|(_, device)| &mut **device);
            let drawn = prepared.finished(device, frame, &stop);
            if !matches!(drawn, Ok(Some(_))) {
                // A failed device may be in the middle of a frame.
                *kept = None;
            }
            drawn?
        } else {
            prepared.finished(None, frame, &stop)?
        };
        drawn.ok_or(Failure::Cancelled)
    }
}
