//! Maps the chords of [`Shortcuts`] to the toolkit's key events.

use crate::edit::{Action, Chord, Shortcuts};
use eframe::egui::{self, Key, Modifiers};

fn modifiers(chord: &Chord) -> Modifiers {
    let none = Modifiers::NONE;
    let held = [(chord.command, Modifiers::COMMAND), (chord.shift, Modifiers::SHIFT), (chord.alt, Modifiers::ALT)];
    held.into_iter().filter(|(is_held, _)| *is_held).fold(none, |all, (_, one)| all | one)
}

fn key(chord: &Chord) -> Option<Key> {
    Key::from_name(&chord.key)
}

/// Returns the actions whose keys were pressed; none while a text field has focus.
pub(super) fn pressed(ctx: &egui::Context, shortcuts: &Shortcuts) -> Vec<Action> {
    if ctx.text_edit_focused() {
        return Vec::new();
    }
    let is_held_kind = |action: Action| action.group() == "Hold";
    let mut found = Vec::new();
    ctx.input_mut(|input| {
        // Chords with more modifiers come first, so that Ctrl+Shift+Z does not match Ctrl+Z.
        let mut actions: Vec<Action> = Action::ALL.iter().copied().filter(|action| !is_held_kind(*action)).collect();
        let count = |action: &Action| {
            shortcuts
                .of(*action)
                .map_or(0, |chord| u8::from(chord.command) + u8::from(chord.shift) + u8::from(chord.alt))
        };
        actions.sort_by_key(|action| std::cmp::Reverse(count(action)));
        for action in actions {
            let Some((key, chord)) = shortcuts.of(action).and_then(|chord| Some((key(chord)?, chord))) else {
                continue;
            };
            if input.consume_key(modifiers(chord), key) {
                found.push(action);
            }
        }
        // The toolkit turns these chords into events of their own.
        input.events.retain(|event| match event {
            egui::Event::Copy => {
                found.push(Action::Copy);
                false
            }
            egui::Event::Paste(_) => {
                found.push(Action::Paste);
                false
            }
            _ => true,
        });
    });
    found
}

/// Returns whether the key of an action is held.
pub(super) fn is_held(ctx: &egui::Context, shortcuts: &Shortcuts, action: Action) -> bool {
    if ctx.text_edit_focused() {
        return false;
    }
    let key = shortcuts.of(action).and_then(key);
    key.is_some_and(|key| ctx.input(|input| input.key_down(key) && !input.modifiers.command))
}

/// Returns the shortcut text for a menu entry.
pub(super) fn words(shortcuts: &Shortcuts, action: Action) -> String {
    shortcuts.of(action).map(ToString::to_string).unwrap_or_default()
}
