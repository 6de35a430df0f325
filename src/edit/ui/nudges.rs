//! Arrow keys and Escape.

use super::keys;
use crate::edit::Session;
use eframe::egui::{self, Key, Modifiers};
use glam::DVec2;

/// Handles arrow keys, which move the selection by a pixel, or ten with Shift, and Escape, which cancels the gesture.
pub(super) fn show(ctx: &egui::Context, session: &mut Session) {
    if keys::are_taken(ctx) {
        return;
    }
    if ctx.input(|input| input.key_pressed(Key::Escape)) {
        session.cancel();
    }
    if session.selection.pins.is_empty() && session.selection.handles.is_empty() {
        return;
    }
    let pixel = 1.0 / f64::from(session.shot().size.height.max(1));
    let arrows = [
        (Key::ArrowLeft, DVec2::NEG_X),
        (Key::ArrowRight, DVec2::X),
        (Key::ArrowUp, DVec2::Y),
        (Key::ArrowDown, DVec2::NEG_Y),
    ];
    let mut by = DVec2::ZERO;
    ctx.input_mut(|input| {
        for (key, way) in arrows {
            by += way * 10.0 * input.count_and_consume_key(Modifiers::SHIFT, key) as f64;
            by += way * input.count_and_consume_key(Modifiers::NONE, key) as f64;
        }
    });
    if by != DVec2::ZERO {
        session.nudge(by * pixel);
    }
}
