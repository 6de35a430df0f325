//! The selection: pins, handles and keys.
//!
//! In: clicks. Out: sets of indices into the shot.

use crate::shot::Shot;
use std::collections::BTreeSet;

/// Selected pins, handles and keys.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// The active layer: new pins go to it, and its settings are shown.
    pub(crate) layer: usize,
    /// Indices of layer and pin.
    pub pins: BTreeSet<[usize; 2]>,
    /// Index of the layer, and lattice coordinates of the handle.
    pub(crate) handles: BTreeSet<(usize, [usize; 3])>,
    /// Indices of layer and pin, and the times of their keys.
    pub(crate) keys: Vec<([usize; 2], f64)>,
    /// Index of the layer, lattice coordinates of handles, and the times of their keys.
    pub(crate) handle_keys: Vec<((usize, [usize; 3]), f64)>,
}

impl Selection {
    /// Selects one pin only.
    pub(crate) fn only_pin(&mut self, at: [usize; 2]) {
        *self = Self { layer: at[0], pins: BTreeSet::from([at]), ..Self::default() };
    }

    /// Clears the selection; the active layer is kept.
    pub fn clear(&mut self) {
        *self = Self { layer: self.layer, ..Self::default() };
    }

    /// Returns the single selected pin; `None` if there are none or several.
    #[must_use]
    pub fn single_pin(&self) -> Option<[usize; 2]> {
        if self.pins.len() == 1 { self.pins.first().copied() } else { None }
    }

    /// Returns the layers with selected elements.
    #[must_use]
    pub(crate) fn layers(&self) -> Vec<usize> {
        let of_pins = self.pins.iter().map(|[layer, _]| *layer);
        let all: BTreeSet<usize> = of_pins.chain(self.handles.iter().map(|(layer, _)| *layer)).collect();
        all.into_iter().collect()
    }

    /// Drops what no longer exists in the shot.
    pub(crate) fn retain(&mut self, shot: &Shot) {
        let pin = |[layer, pin]: [usize; 2]| shot.layers.get(layer).and_then(|layer| layer.pins.get(pin));
        self.layer = self.layer.min(shot.layers.len().saturating_sub(1));
        self.pins.retain(|&at| pin(at).is_some());
        self.keys.retain(|(at, time)| pin(*at).is_some_and(|pin| pin.keys.iter().any(|key| key.frame == *time)));
        self.handle_keys.retain(|((layer, index), time)| {
            let tracks = shot.layers.get(*layer).into_iter().flat_map(|layer| &layer.handles);
            tracks.filter(|track| track.index == *index).any(|track| track.keys.iter().any(|key| key.frame == *time))
        });
        self.handles.retain(|(layer, index)| {
            let dims = shot.layers.get(*layer).map(|layer| layer.space.dims());
            dims.is_some_and(|dims| (0..3).all(|axis| index[axis] < dims[axis]))
        });
    }

    /// Returns whether a key is selected.
    #[must_use]
    pub(crate) fn has_key(&self, at: [usize; 2], time: f64) -> bool {
        self.keys.iter().any(|(other, when)| *other == at && *when == time)
    }

    /// Returns whether any key of a pin or handle is selected.
    #[must_use]
    pub(crate) fn has_keys(&self) -> bool {
        !(self.keys.is_empty() && self.handle_keys.is_empty())
    }

    /// Clears the selected keys.
    pub(crate) fn clear_keys(&mut self) {
        self.keys.clear();
        self.handle_keys.clear();
    }

    /// Returns the times of the selected keys of a handle.
    #[must_use]
    pub(crate) fn times_of_handle(&self, at: (usize, [usize; 3])) -> Vec<f64> {
        self.handle_keys.iter().filter(|(other, _)| *other == at).map(|(_, time)| *time).collect()
    }

    /// Returns the times of the selected keys of a pin.
    #[must_use]
    pub(crate) fn times_of(&self, at: [usize; 2]) -> Vec<f64> {
        self.keys.iter().filter(|(other, _)| *other == at).map(|(_, time)| *time).collect()
    }
}
