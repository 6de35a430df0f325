//! Panning and zooming without a middle button: by a held key, and by fingers on a trackpad.
//!
//! In: keys, pointer and scroll events. Out: movements of the picture; whether a tap of the key plays.

use super::keys::{self, Tap};
use crate::edit::{Action, Shortcuts};
use eframe::egui::{self, Event, MouseWheelSource, MouseWheelUnit, Pos2, Response, Ui, Vec2};

/// What scrolls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Scroller {
    /// A wheel, which zooms.
    #[default]
    Wheel,
    /// Two fingers on a trackpad, which pan.
    Trackpad,
}

impl Scroller {
    /// Returns what sent an event. Where the system does not say so, wheels scroll by lines and trackpads by points.
    const fn of(source: MouseWheelSource, unit: MouseWheelUnit) -> Self {
        match (source, unit) {
            (MouseWheelSource::Trackpad | MouseWheelSource::Momentum, _)
            | (MouseWheelSource::Unknown, MouseWheelUnit::Point) => Self::Trackpad,
            (MouseWheelSource::Wheel, _) | (MouseWheelSource::Unknown, MouseWheelUnit::Line | MouseWheelUnit::Page) => {
                Self::Wheel
            }
        }
    }
}

/// State of panning kept between passes.
#[derive(Default)]
pub(super) struct Pan {
    /// Whether playback starts or stops when the key is let go.
    is_tap: bool,
    /// Where the pen was in the last pass, while it pans.
    dragged: Option<Pos2>,
    /// What scrolled last.
    scroller: Scroller,
}

impl Pan {
    /// Follows the key, if it also plays. Returns whether it was tapped. `is_free`: whether the pen does nothing else.
    pub(super) fn is_tapped(&mut self, ctx: &egui::Context, shortcuts: &Shortcuts, is_free: bool) -> bool {
        let mut is_tapped = false;
        for tap in keys::taps(ctx, shortcuts) {
            match tap {
                Tap::Down => self.is_tap = is_free && self.dragged.is_none(),
                Tap::Up => is_tapped |= std::mem::take(&mut self.is_tap),
            }
        }
        is_tapped
    }

    /// Returns by how much a drag of the pen with the key moves the picture, points; `None` if the pen does not pan. A drag goes on
    /// though the key is let go.
    pub(super) fn drag(&mut self, ui: &Ui, response: &Response, shortcuts: &Shortcuts) -> Option<Vec2> {
        let (pressed, is_down, at) = ui.input(|input| {
            (input.pointer.primary_pressed(), input.pointer.primary_down(), input.pointer.interact_pos())
        });
        let is_held = keys::is_held(ui.ctx(), shortcuts, Action::Pan);
        if is_held && response.hovered() && self.dragged.is_none() {
            ui.ctx().set_cursor_icon(egui::CursorIcon::Grab);
        }
        if pressed && is_held && response.contains_pointer() {
            (self.dragged, self.is_tap) = (at, false);
        }
        let from = self.dragged?;
        ui.ctx().set_cursor_icon(egui::CursorIcon::Grabbing);
        self.dragged = at.filter(|_| is_down);
        Some(at.map_or(Vec2::ZERO, |at| at - from))
    }

    /// Returns what scrolls, by the last event.
    pub(super) fn scroller(&mut self, ui: &Ui) -> Scroller {
        let last = ui.input(|input| {
            input.events.iter().rev().find_map(|event| match event {
                Event::MouseWheel { source, unit, .. } => Some(Scroller::of(*source, *unit)),
                _ => None,
            })
        });
        self.scroller = last.unwrap_or(self.scroller);
        self.scroller
    }
}
