//! Arrow keys of a widget with keyboard focus.
//!
//! In: key events. Out: steps, which other widgets do not see.

use eframe::egui::{EventFilter, Key, Modifiers, Response, Ui};

/// The modifier held with an arrow key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum With {
    Nothing,
    Shift,
    Alt,
}

/// One press of an arrow key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Arrow {
    /// Rightwards and upwards: -1, 0 or 1.
    pub(super) way: [i32; 2],
    pub(super) with: With,
}

const ARROWS: [(Key, [i32; 2]); 4] =
    [(Key::ArrowLeft, [-1, 0]), (Key::ArrowRight, [1, 0]), (Key::ArrowUp, [0, 1]), (Key::ArrowDown, [0, -1])];

/// Takes the arrow keys pressed while a widget has focus, in place of moving the focus.
pub(super) fn take(ui: &Ui, response: &Response) -> Vec<Arrow> {
    if !response.has_focus() {
        return Vec::new();
    }
    let filter = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    let mut found = Vec::new();
    ui.input_mut(|input| {
        for (key, way) in ARROWS {
            // A pattern without modifiers matches those with Shift or Alt, too.
            let held = [(With::Alt, Modifiers::ALT), (With::Shift, Modifiers::SHIFT), (With::Nothing, Modifiers::NONE)];
            for (with, modifiers) in held {
                let count = input.count_and_consume_key(modifiers, key);
                found.extend((0..count).map(|_| Arrow { way, with }));
            }
        }
    });
    found
}
