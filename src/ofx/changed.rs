//! Instances come, change and go: what is greyed out, buttons, pins that are switched on.
//!
//! In: what changed, and why. Out: parameters.

use super::api::Status;
use super::api::names::{self, param, prop};
use super::buttons;
use super::canvas::canvas_of;
use super::entry::Call;
use super::fault::Fault;
use super::host::When;
use super::overlay;
use super::params::{PINS, SHAPES, ShapeFrom, pin_id, table};
use super::settings::Moment;
use crate::live::{self, Canvas};

/// A new instance: what does not matter is greyed out. Its handle may be that of one which the host never ended.
pub(super) fn created(call: Call) -> Result<Status, Fault> {
    call.effect.forget();
    enable(Moment::of(call.effect, 0.0)?);
    Ok(Status::OK)
}

/// An instance ends; it owns nothing but its last message and its overlays.
pub(super) fn destroyed(call: Call) -> Result<Status, Fault> {
    call.effect.unsay();
    overlay::forget(call.effect);
    Ok(Status::OK)
}

/// Memory is short: what was computed goes, for all instances.
pub(super) fn purged(_: Call) -> Result<Status, Fault> {
    live::purge();
    Ok(Status::OK)
}

/// The user changed a parameter or pressed a button.
pub(super) fn changed(call: Call) -> Result<Status, Fault> {
    let by_user =
        call.args.text(prop::CHANGE_REASON).is_some_and(|why| why.as_bytes() == prop::CHANGE_USER_EDITED.to_bytes());
    let Some(id) = call.args.text(prop::NAME).filter(|_| by_user) else { return Ok(Status::REPLY_DEFAULT) };
    let time = call.args.double(prop::TIME).unwrap_or(0.0);
    let moment = Moment::of(call.effect, time)?;
    // What was wrong before the edit is told again, or is over.
    call.effect.unsay();
    if let Some(done) = buttons::press(call, &id, moment) {
        call.effect.say_once(names::MESSAGE_MESSAGE, &done?);
        enable(moment);
        return Ok(Status::OK);
    }
    match id.as_str() {
        "shape" => enable(moment),
        _ => match (0..PINS).find(|pin| id == pin_id(*pin, "On")) {
            Some(pin) => place(moment, pin, &canvas_of(call.effect, time)),
            None => return Ok(Status::REPLY_DEFAULT),
        },
    }
    Ok(Status::OK)
}

/// Greys out what the choice of shape leaves without effect.
fn enable(moment: Moment) {
    let shape = moment.choice("shape", &SHAPES);
    let of_shot = ["camera", "layer", "frameOffset", "pinFrame", "shotPins"];
    for param in table().iter().filter(|param| of_shot.contains(&param.id.as_str())) {
        moment.params.props_of(&param.id).set_int(param::ENABLED, i32::from(shape == ShapeFrom::Shot));
    }
    moment.params.props_of("holdBorder").set_int(param::ENABLED, i32::from(shape != ShapeFrom::Alpha));
}

/// A pin that was never placed starts in the middle of the frame, where it can be seen: hosts differ in what they make
/// of defaults that are given in parts of the frame.
fn place(moment: Moment, pin: usize, canvas: &Canvas) {
    if moment.int(&pin_id(pin, "On")) == 0 || moment.is_placed(pin) {
        return;
    }
    let [x1, y1, x2, y2] = canvas.region(canvas.frame.window());
    moment.params.begin_edit(c"Place a pin");
    for end in ["Rest", "Target"] {
        moment.params.set_point(&pin_id(pin, end), [0.5 * (x1 + x2), 0.5 * (y1 + y2)], When::Now);
    }
    moment.params.end_edit();
}
