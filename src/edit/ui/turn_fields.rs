//! Rotation and scale of the selected pin, in the inspector.
//!
//! In: the values of the pin in the current frame. Out: typed keys; channels freed, keyed separately and joined.

use super::number_field::NumberField;
use crate::edit::{Channel, Session};
use crate::shot::{Goal, PinKey, Rotation};
use eframe::egui::{DragValue, Ui};

/// A pin, with its values in the current frame.
#[derive(Clone, Copy)]
pub(super) struct PinValues {
    pub(super) at: [usize; 2],
    pub(super) key: PinKey,
}

/// A channel of a pin.
#[derive(Clone, Copy)]
struct PinChannel {
    at: [usize; 2],
    channel: Channel,
}

/// Shows rotation and scale of a pin.
pub(super) fn show(ui: &mut Ui, session: &mut Session, PinValues { at, key }: PinValues) {
    session.want_turns_when_drawn(at);
    let is_in_scene = matches!(key.goal, Goal::SceneOffset(_) | Goal::SceneTarget(_));
    match key.rotate_degrees {
        Some(Rotation::Axes(angles)) => turn_in_scene(ui, session, PinValues { at, key }, Some(angles)),
        None if is_in_scene => turn_in_scene(ui, session, PinValues { at, key }, None),
        Some(Rotation::InView(angle)) => turn_in_view(ui, session, PinValues { at, key }, Some(angle)),
        None => turn_in_view(ui, session, PinValues { at, key }, None),
    }
    ui.label("Scale");
    let mut scale = key.scale.unwrap_or(1.0);
    let field = NumberField {
        name: "Scale",
        hint: "Size of what surrounds the pin, in this frame; 1: as it is",
        range: 0.001..=1000.0,
        decimals: 3,
    };
    let style = free_number(key.scale.is_none(), "");
    if held_or_free(ui, session, PinChannel { at, channel: Channel::Scale }, key.scale.is_none(), |ui| {
        field.drag(ui, &mut scale, |number| style(number.speed(0.005)))
    }) {
        session.put_key(at, PinKey { scale: Some(scale), ..key });
    }
    ui.end_row();
}

/// Edits the angle in the view; `None`: free.
fn turn_in_view(ui: &mut Ui, session: &mut Session, PinValues { at, key }: PinValues, angle: Option<f64>) {
    ui.label("Rotation");
    let mut new = angle.unwrap_or(0.0);
    if held_or_free(ui, session, PinChannel { at, channel: Channel::Rotation }, angle.is_none(), |ui| {
        angle_field(ui, &mut new, ("Rotation", ""), angle.is_none())
    }) {
        session.put_key(at, PinKey { rotate_degrees: Some(Rotation::InView(new)), ..key });
    }
    ui.end_row();
}

/// Edits the angles about three axes; `None`: free.
fn turn_in_scene(ui: &mut Ui, session: &mut Session, PinValues { at, key }: PinValues, angles: Option<[f64; 3]>) {
    let axes = [Channel::RotationX, Channel::RotationY, Channel::RotationZ];
    let mut new = angles.unwrap_or_default();
    let mut is_changed = false;
    for ((value, channel), axis) in new.iter_mut().zip(axes).zip(["x", "y", "z"]) {
        ui.label(if axis == "x" { "Rotation" } else { "" }).on_hover_text("degrees about x, then y, then z");
        // One button frees all three.
        let is_free = angles.is_none() || axis != "x";
        is_changed |= held_or_free(ui, session, PinChannel { at, channel }, is_free, |ui| {
            angle_field(ui, value, (&format!("Rotation {axis}"), &format!("{axis} ")), angles.is_none())
        });
        ui.end_row();
    }
    if is_changed {
        session.put_key(at, PinKey { rotate_degrees: Some(Rotation::Axes(new)), ..key });
    }
}

/// Shows an angle in degrees. Returns whether it is changed.
fn angle_field(ui: &mut Ui, angle: &mut f64, (name, prefix): (&str, &str), is_free: bool) -> bool {
    let hint = "Turns what surrounds the pin, in this frame, in degrees; its ring in the picture does the same";
    let field = NumberField { name, hint, range: f64::MIN..=f64::MAX, decimals: 3 };
    let style = free_number(is_free, "\u{b0}");
    field.drag(ui, angle, |number| style(number.speed(0.5)).prefix(prefix))
}

/// Returns a style of number fields that shows "free" if the pin has no value in that channel.
fn free_number(is_free: bool, unit: &'static str) -> impl Fn(DragValue) -> DragValue {
    let write = move |value: f64, _: std::ops::RangeInclusive<usize>| match is_free {
        true => "free".to_owned(),
        false => format!("{}{unit}", (value * 1e3).round() / 1e3),
    };
    let read = move |text: &str| text.trim_end_matches(unit).trim().parse().ok();
    move |number| number.custom_formatter(write).custom_parser(read)
}

/// Shows a number field and, unless the channel is free, buttons that clear it and that key it separately. Returns whether the value
/// changed.
fn held_or_free(
    ui: &mut Ui,
    session: &mut Session,
    of: PinChannel,
    is_free: bool,
    number: impl FnOnce(&mut Ui) -> bool,
) -> bool {
    ui.horizontal(|ui| {
        let is_changed = number(ui);
        if !is_free {
            let hint = "Unconstrained: the pin leaves rotation and scale free";
            if ui.small_button("free").on_hover_text(hint).clicked() {
                session.free_channel(of.at, of.channel);
            }
            keyed_apart(ui, session, of);
        }
        is_changed
    })
    .inner
}

/// Shows a button that gives a channel keys of its own, or joins them with those of the pin.
fn keyed_apart(ui: &mut Ui, session: &mut Session, PinChannel { at, channel }: PinChannel) {
    let what = if channel == Channel::Scale { "scale" } else { "rotation" };
    if session.is_keyed_separately(at, channel) {
        let hint =
            format!("The {what} has keys of its own: put them among the keys of the pin, where that changes no motion");
        let button = ui.small_button("join").on_hover_text(hint);
        if button.accessible_name(format!("Join {what} with the keys of the pin")).clicked() {
            session.join_channel(at, channel);
        }
    } else {
        let hint = format!("Give the {what} keys of its own, on its own frames and with its own eases");
        let button = ui.small_button("own keys").on_hover_text(hint);
        if button.accessible_name(format!("Key {what} separately")).clicked() {
            session.key_separately(at, channel);
        }
    }
}
