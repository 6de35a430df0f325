//! What the keyed frames of a layer show, for pins and channels that get their first keys in another frame.
//!
//! In: a prepared shot, a frame. Out: where points lie and how pins are turned in keyed frames; of many, in the nearest ones.

use super::mail::HeldPlace;
use crate::edit::keyed_frames::keyed_frames;
use crate::edit::track::key_time;
use crate::pipeline::{PickedPoint, PinTurn, PreparedShot, TimeSample};
use crate::shot::{Ease, Layer};

/// Maximum number of keyed frames that are looked at, where the range is solved over time.
const LOOKED_AT: usize = 32;

/// Maximum number of keyed frames that are solved alone, while the pen waits.
const SOLVED: usize = 8;

/// Returns where the layer of a point shows it in keyed frames other than `frame`.
pub(super) fn held_places(prepared: &PreparedShot, frame: i32, point: &PickedPoint) -> Vec<HeldPlace> {
    let Some((index, layer)) = point.layer.and_then(|index| Some((index, prepared.shot.layers.get(index)?))) else {
        return Vec::new();
    };
    let now = key_time(&prepared.shot.frames, layer, frame);
    let held = |(time, ease): (f64, Ease)| {
        let sample = prepared.sample_of_layer(time.round() as i32, index).ok()?;
        Some(HeldPlace { time, ease, offset: prepared.displacement(&sample, point)? })
    };
    others(prepared, layer, now).into_iter().filter_map(held).collect()
}

/// Returns how the pins of a layer are turned in a frame that is solved, and in the other keyed ones.
pub(super) fn turns(
    prepared: &PreparedShot,
    (frame, index): (i32, usize),
    seen: &TimeSample,
) -> Vec<(f64, Vec<PinTurn>)> {
    let Some(layer) = prepared.shot.layers.get(index) else { return Vec::new() };
    let now = key_time(&prepared.shot.frames, layer, frame);
    let others = others(prepared, layer, now).into_iter().filter_map(|(time, _)| {
        let sample = prepared.sample_of_layer(time.round() as i32, index).ok()?;
        Some((time, prepared.pin_turns(&sample, index)))
    });
    others.chain([(now, prepared.pin_turns(seen, index))]).collect()
}

/// Returns the times of a layer's keys that are nearest to `now`, without it, in order.
fn others(prepared: &PreparedShot, layer: &Layer, now: f64) -> Vec<(f64, Ease)> {
    let mut found: Vec<(f64, Ease)> = keyed_frames(layer).into_iter().filter(|(time, _)| *time != now).collect();
    found.sort_by(|a, b| (a.0 - now).abs().total_cmp(&(b.0 - now).abs()));
    found.truncate(if prepared.is_settled() { LOOKED_AT } else { SOLVED });
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}
