//! The selection: pins, handles and keys.
//!
//! In: clicks. Out: sets of indices into the shot.

use crate::edit::Track;
use crate::shot::Shot;
use std::collections::BTreeSet;

/// Selected pins, handles and keys.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Selection {
    /// The active layer: new pins go to it, and its settings are shown.
    pub(crate) layer: usize,
    /// Indices of layer and pin.
    pub pins: BTreeSet<[usize; 2]>,
    /// Index of the layer, and lattice coordinates of the handle.
    pub handles: BTreeSet<(usize, [usize; 3])>,
    /// Pins, channels and handles, and the times of their keys, in the order in which they were chosen.
    pub keys: Vec<(Track, f64)>,
}

impl Selection {
    /// Selects one pin only.
    pub(crate) fn only_pin(&mut self, at: [usize; 2]) {
        *self = Self { layer: at[0], pins: BTreeSet::from([at]), ..Self::default() };
    }

    /// Selects one handle only.
    pub(crate) fn only_handle(&mut self, at: (usize, [usize; 3])) {
        *self = Self { layer: at.0, handles: BTreeSet::from([at]), ..Self::default() };
    }

    /// Clears the selection; the active layer is kept.
    pub(crate) fn clear(&mut self) {
        *self = Self { layer: self.layer, ..Self::default() };
    }

    /// Returns the single selected pin; `None` if there are none or several.
    #[must_use]
    pub(crate) fn single_pin(&self) -> Option<[usize; 2]> {
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
        self.keys.retain(|(track, time)| track.times(shot).iter().any(|(other, _)| other == time));
        self.handles.retain(|(layer, index)| {
            let dims = shot.layers.get(*layer).map(|layer| layer.space.dims());
            dims.is_some_and(|dims| (0..3).all(|axis| index[axis] < dims[axis]))
        });
    }

    /// Selects a pin or handle in addition.
    pub(crate) fn add(&mut self, track: Track) {
        self.layer = track.layer();
        match track {
            Track::Pin(at) | Track::Rotation(at) | Track::Scale(at) => _ = self.pins.insert(at),
            Track::Handle(at) => _ = self.handles.insert(at),
        }
    }

    /// Returns the selected pins, with their channels that have keys of their own, and handles.
    #[must_use]
    pub(crate) fn tracks(&self, shot: &Shot) -> Vec<Track> {
        let pins = self.pins.iter().flat_map(|&at| Track::of_pin(shot, at));
        pins.chain(self.handles.iter().copied().map(Track::Handle)).collect()
    }

    /// Returns whether a pin or handle is selected.
    #[must_use]
    pub(crate) fn has(&self, track: Track) -> bool {
        match track {
            Track::Pin(at) | Track::Rotation(at) | Track::Scale(at) => self.pins.contains(&at),
            Track::Handle(at) => self.handles.contains(&at),
        }
    }

    /// Returns whether a key is selected.
    #[must_use]
    pub(crate) fn has_key(&self, track: Track, time: f64) -> bool {
        self.keys.contains(&(track, time))
    }

    /// Returns the pins and handles with selected keys, in order.
    #[must_use]
    pub(crate) fn keyed(&self) -> BTreeSet<Track> {
        self.keys.iter().map(|(track, _)| *track).collect()
    }

    /// Returns the times of the selected keys of a pin or handle.
    #[must_use]
    pub(crate) fn times_of(&self, track: Track) -> Vec<f64> {
        self.keys.iter().filter(|(other, _)| *other == track).map(|(_, time)| *time).collect()
    }
}
