//! Instance creation and changes: enables and disables parameters, handles buttons, places pins when switched on.
//!
//! In: what changed, and why. Out: parameters.

use super::api::Status;
use super::api::names::{param, prop};
use super::buttons;
use super::buttons::select;
use super::call::Call;
use super::fault::Fault;
use super::host_frame::{HostFrame, host_frame_of};
use super::overlay;
use super::params::{PINS, SHAPES, ShapeFrom, pin_id, table};
use super::pins;
use super::values::ParamValues;
use crate::live;
use crate::spelling::escaped;

/// Handles the creation of an instance: disables the parameters that have no effect.
pub(super) fn created(call: Call) -> Result<Status, Fault> {
    let values = ParamValues::of(call.effect, 0.0)?;
    enable(values);
    open_groups(values);
    Ok(Status::OK)
}

/// Handles low memory: drops the cached results of all instances.
pub(super) fn purged(_: Call) -> Result<Status, Fault> {
    live::purge();
    Ok(Status::OK)
}

/// Handles a parameter edited or a button pressed by the user.
pub(super) fn changed(call: Call) -> Result<Status, Fault> {
    let by_user =
        call.args.text(prop::CHANGE_REASON).is_some_and(|why| why.as_bytes() == prop::CHANGE_USER_EDITED.to_bytes());
    let Some(id) = call.args.text(prop::NAME).filter(|_| by_user) else { return Ok(Status::REPLY_DEFAULT) };
    let time = call.args.double(prop::TIME).unwrap_or(0.0);
    let values = ParamValues::of(call.effect, time)?;
    overlay::end_open_edit(call.effect);
    // Earlier messages may no longer apply; those that do are shown again.
    call.effect.clear_messages();
    if let Some(done) = buttons::press_pins(call.effect, &id, values) {
        done.iter().for_each(|told| call.effect.inform(&escaped(told)));
        open_groups(values);
        return Ok(Status::OK);
    }
    if let Some(done) = buttons::press(call, &id, values) {
        call.effect.inform(&escaped(&done?));
        enable(values);
        return Ok(Status::OK);
    }
    let pin = (0..PINS).find(|pin| id == pin_id(*pin, "On"));
    match (id.as_str(), pin) {
        ("shape", _) => enable(values),
        ("selected", _) => select(call.effect, usize::try_from(values.int("selected") - 1).ok()),
        (_, Some(pin)) => place(values, pin, &host_frame_of(call.effect, time)),
        _ => return Ok(Status::REPLY_DEFAULT),
    }
    Ok(Status::OK)
}

/// Disables the parameters that have no effect with the chosen shape.
fn enable(values: ParamValues) {
    let shape = values.choice("shape", &SHAPES);
    let of_shot = ["camera", "layer", "frameOffset", "pinFrame", "shotPins"];
    for param in table().iter().filter(|param| of_shot.contains(&param.id.as_str())) {
        values.params.props_of(&param.id).set_int(param::ENABLED, i32::from(shape == ShapeFrom::Shot));
    }
    values.params.props_of("holdBorder").set_int(param::ENABLED, i32::from(shape != ShapeFrom::Alpha));
}

/// Opens the groups of pins in use, in hosts that allow it.
fn open_groups(values: ParamValues) {
    for pin in 0..PINS {
        let is_used = values.is_on(&pin_id(pin, "On"));
        values.params.props_of(&pin_id(pin, "")).set_int(param::GROUP_OPEN, i32::from(is_used));
    }
}

/// Places a pin that was never placed in the middle of the frame, where it is visible: hosts interpret normalised
/// defaults differently.
fn place(values: ParamValues, pin: usize, host_frame: &HostFrame) {
    if values.is_on(&pin_id(pin, "On")) && !values.is_placed(pin) {
        let [x1, y1, x2, y2] = host_frame.canonical_region();
        values.params.begin_edit(c"Place a pin");
        pins::place(values, pin, [0.5 * (x1 + x2), 0.5 * (y1 + y2)]);
        values.params.end_edit();
    }
    open_groups(values);
}
