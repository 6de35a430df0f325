//! Operations on whole pins: place, delete, reset, move to their targets. Used by buttons, keys and clicks.
//!
//! In: the parameters of an instance. Out: the same, changed; callers begin and end the undo block.

use super::host::When;
use super::params::{PINS, ParamKind, pin_id, table};
use super::values::ParamValues;

/// Returns the pins that are switched on and placed.
pub(super) fn acting(values: ParamValues) -> Vec<usize> {
    (0..PINS).filter(|pin| values.is_on(&pin_id(*pin, "On")) && values.is_placed(*pin)).collect()
}

/// Returns the first pin that is neither on nor placed; `None` if all are in use.
pub(super) fn free(values: ParamValues) -> Option<usize> {
    (0..PINS).find(|pin| !values.is_on(&pin_id(*pin, "On")) && !values.is_placed(*pin))
}

/// Returns the active pin before (-1) or after (1) the last selected one.
pub(super) fn neighbour(values: ParamValues, selected: &[usize], step: i32) -> Option<usize> {
    let pins = acting(values);
    let at = selected.iter().max().and_then(|last| pins.iter().position(|pin| pin == last));
    let count = pins.len() as i32;
    let next = match (at, step) {
        _ if count == 0 => return None,
        (Some(at), step) => (at as i32 + step).rem_euclid(count),
        (None, 1) => 0,
        (None, _) => count - 1,
    };
    pins.get(next as usize).copied()
}

/// Moves both ends of a pin to a canonical position, and switches it on.
pub(super) fn place(values: ParamValues, pin: usize, at: [f64; 2]) {
    for end in ["Rest", "Target"] {
        values.params.set_point(&pin_id(pin, end), at, When::Now);
    }
    values.params.set_int(&pin_id(pin, "On"), 1);
}

/// Switches a pin off and resets all its parameters.
pub(super) fn delete(values: ParamValues, pin: usize) {
    let group = pin_id(pin, "");
    for entry in table().iter().filter(|entry| entry.group == group) {
        if entry.animates {
            values.params.delete_keys(&entry.id);
        }
        match &entry.kind {
            ParamKind::Toggle(default) => values.params.set_int(&entry.id, *default),
            ParamKind::Double(default, ..) => values.params.set_double(&entry.id, *default, When::Now),
            ParamKind::Point => values.params.set_point(&entry.id, [0.0, 0.0], When::Now),
            ParamKind::Text(_) => values.params.set_text(&entry.id, ""),
            ParamKind::Group(_) | ParamKind::Integer(..) | ParamKind::Choice(_) | ParamKind::Button => {}
        }
    }
}

/// Resets a pin's target to the pin, without rotation, at the time of the values.
pub(super) fn reset(values: ParamValues, pin: usize) {
    if let Some(rest) = values.params.point(&pin_id(pin, "Rest"), values.time) {
        values.params.set_point(&pin_id(pin, "Target"), rest, When::Now);
    }
    values.params.set_double(&pin_id(pin, "Angle"), 0.0, When::Now);
}

/// Moves a pin to its target, and resets its rotation, at the time of the values.
pub(super) fn rest_to_target(values: ParamValues, pin: usize) {
    if let Some(target) = values.params.point(&pin_id(pin, "Target"), values.time) {
        values.params.set_point(&pin_id(pin, "Rest"), target, When::Now);
    }
    values.params.set_double(&pin_id(pin, "Angle"), 0.0, When::Now);
}
