//! The frames in which a layer has keys: its poses.
//!
//! In: a layer. Out: times, in order, each with the ease that leaves it.

use crate::shot::{Ease, Layer};

/// Returns the times of all keys of a layer's pins and handles, in order; of several keys at one time the ease of the first counts.
#[must_use]
pub(in crate::edit) fn keyed_frames(layer: &Layer) -> Vec<(f64, Ease)> {
    let of_pins = layer.pins.iter().flat_map(|pin| {
        let place = pin.keys.iter().map(|key| (key.frame, key.ease));
        let rotation = pin.rotate_keys.iter().map(|key| (key.frame, key.ease));
        place.chain(rotation).chain(pin.scale_keys.iter().map(|key| (key.frame, key.ease)))
    });
    let of_handles = layer.handles.iter().flat_map(|handle| &handle.keys).map(|key| (key.frame, key.ease));
    let mut found: Vec<(f64, Ease)> = of_pins.chain(of_handles).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.dedup_by(|next, first| next.0 == first.0);
    found
}
