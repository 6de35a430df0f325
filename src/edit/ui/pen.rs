//! The pen over the picture: what the primary button presses, drags and releases, in the order in which it happened.
//!
//! In: the events of a pass. Out: presses, motions and releases of a [`Session`]; the cursor. A slow window gets a press and the
//! motion after it in one pass, so each event counts where it happened, not where the pointer is by then.

use super::keys::is_held;
use super::marks::RING;
use crate::edit::{Action, Held, Lens, PinPart, Ring, Session, Shortcuts};
use crate::space::ScreenPoint;
use eframe::egui::{self, Event, Modifiers, PointerButton, Pos2, Response, Ui};
use glam::DVec2;

/// Hit distance of the pointer in points.
pub(super) const REACH: f32 = 10.0;

/// Hit distance of the ring around a pin in points.
const RING_REACH: f32 = 7.0;

/// What the pen did.
#[derive(Clone, Copy, Debug, PartialEq)]
enum PenEvent {
    Down(Pos2, Modifiers),
    Moved(Pos2),
    Up(Pos2),
}

/// Returns what the pen did in this pass, in order; of motions that follow each other, the last.
fn pen_events(events: &[Event]) -> Vec<PenEvent> {
    let mut found: Vec<PenEvent> = Vec::new();
    for event in events {
        let stroke = match event {
            Event::PointerMoved(at) => PenEvent::Moved(*at),
            Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers } => match pressed {
                true => PenEvent::Down(*pos, *modifiers),
                false => PenEvent::Up(*pos),
            },
            _ => continue,
        };
        if matches!((found.last(), stroke), (Some(PenEvent::Moved(_)), PenEvent::Moved(_))) {
            found.pop();
        }
        found.push(stroke);
    }
    found
}

/// Lets the session follow the pen.
pub(super) fn follow(ui: &Ui, response: &Response, (session, lens): (&mut Session, &Lens), shortcuts: &Shortcuts) {
    let origin = response.rect.min;
    let place = |at: Pos2| -> ScreenPoint {
        lens.screen_from_viewport(DVec2::new((at.x - origin.x).into(), (at.y - origin.y).into()))
    };
    let height = lens.frame_height();
    let reach = f64::from(REACH) / height;
    let (happened, at, shift) =
        ui.input(|input| (pen_events(&input.events), input.pointer.interact_pos(), input.modifiers.shift));
    for event in happened {
        match event {
            PenEvent::Down(at, modifiers) if is_over(ui, response, at) => {
                response.request_focus();
                let is_down = |action: Action| is_held(ui.ctx(), shortcuts, action);
                let part = match (is_down(Action::Region), is_down(Action::Stiffness)) {
                    (true, _) => PinPart::Radius,
                    (false, true) => PinPart::Stiffness,
                    (false, false) => PinPart::Target,
                };
                let held = Held { adds: modifiers.shift, whole: modifiers.alt, part };
                let ring = Ring { radius: f64::from(RING) / height, reach: f64::from(RING_REACH) / height };
                session.press(place(at), (reach, ring), held);
            }
            PenEvent::Down(..) => {}
            PenEvent::Moved(at) => {
                if session.is_dragging() {
                    session.motion_with(place(at), shift);
                }
            }
            PenEvent::Up(at) => {
                if session.is_dragging() {
                    session.motion_with(place(at), shift);
                }
                session.release();
            }
        }
    }
    if let Some(at) = at.map(place).filter(|_| response.hovered()) {
        let is_near = session.pin_near(at, reach).is_some() || session.handle_near(at, reach).is_some();
        ui.ctx().set_cursor_icon(match (session.is_dragging(), is_near) {
            (true, _) => egui::CursorIcon::Grabbing,
            (false, true) => egui::CursorIcon::Grab,
            (false, false) => egui::CursorIcon::Crosshair,
        });
    }
}

/// Returns whether the picture is what lies under a point: no window, menu or question is over it there.
fn is_over(ui: &Ui, response: &Response, at: Pos2) -> bool {
    let layer = response.layer_id;
    let is_top = ui.ctx().layer_id_at(at).is_none_or(|top| top == layer);
    response.rect.contains(at) && is_top && ui.memory(|memory| memory.allows_interaction(layer))
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::pos2;

    #[test]
    fn motions_are_joined_but_not_across_a_press() {
        let moved = |x: f32| Event::PointerMoved(pos2(x, 0.0));
        let button = |x: f32, button, pressed| Event::PointerButton {
            pos: pos2(x, 0.0),
            button,
            pressed,
            modifiers: Modifiers::NONE,
        };
        let primary = PointerButton::Primary;
        let events = [
            moved(1.0),
            moved(2.0),
            button(2.0, primary, true),
            moved(3.0),
            button(3.0, PointerButton::Middle, true),
            moved(4.0),
            button(5.0, primary, false),
            moved(9.0),
        ];
        let [before, after] = [PenEvent::Moved(pos2(2.0, 0.0)), PenEvent::Moved(pos2(4.0, 0.0))];
        let (down, up) = (PenEvent::Down(pos2(2.0, 0.0), Modifiers::NONE), PenEvent::Up(pos2(5.0, 0.0)));
        assert_eq!(pen_events(&events), [before, down, after, up, PenEvent::Moved(pos2(9.0, 0.0))]);
    }
}
