//! The box and the pinned points of a layer over time.
//!
//! In: a [`PreparedShot`], a layer, frames. Out: sizes and positions, computed once per frame for all pins of the layer.

use super::LiveError;
use crate::pipeline::{PreparedShot, RestPoint};
use crate::space::ScreenPoint;
use std::cell::RefCell;
use std::collections::HashMap;

/// Sizes and positions that are known already, by the bits of the frame.
pub(super) struct LayerPlaces<'a> {
    prepared: &'a PreparedShot,
    layer: usize,
    box_sizes: RefCell<HashMap<u64, [f64; 2]>>,
    rests: RefCell<HashMap<u64, Vec<RestPoint>>>,
}

impl<'a> LayerPlaces<'a> {
    /// The layer by its index.
    pub(super) fn new(prepared: &'a PreparedShot, layer: usize) -> Self {
        Self { prepared, layer, box_sizes: RefCell::default(), rests: RefCell::default() }
    }

    /// Returns width and height of the box at a frame; 1 if nothing of the layer is seen.
    pub(super) fn box_size(&self, frame: f64) -> Result<[f64; 2], LiveError> {
        if let Some(size) = self.box_sizes.borrow().get(&frame.to_bits()) {
            return Ok(*size);
        }
        let size = self.prepared.box_size(self.layer, self.prepared.mid_exposure_time(frame))?.unwrap_or([1.0; 2]);
        self.box_sizes.borrow_mut().insert(frame.to_bits(), size);
        Ok(size)
    }

    /// Returns the position of a pin's point at a frame.
    pub(super) fn rest(&self, pin: usize, frame: f64) -> ScreenPoint {
        let mut known = self.rests.borrow_mut();
        let all = || self.prepared.rests_of(self.layer, self.prepared.mid_exposure_time(frame));
        known.entry(frame.to_bits()).or_insert_with(all)[pin].point
    }
}
