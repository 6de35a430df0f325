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

/// Returns the usual name of a key; `None` if there is no such key.
pub(super) fn known(name: &str) -> Option<&'static str> {
    Key::from_name(name).map(|key| key.name())
}

/// Returns the chord of an event that the toolkit makes of it, for the clipboard.
fn clipboard_chord(event: &egui::Event) -> Option<Chord> {
    let key = match event {
        egui::Event::Copy => "C",
        egui::Event::Cut => "X",
        egui::Event::Paste(_) => "V",
        _ => return None,
    };
    Some(Chord { command: true, key: key.to_owned(), ..Chord::default() })
}

/// Returns whether Space or Enter, alone, presses the button that has keyboard focus.
fn presses_button(ctx: &egui::Context, chord: &Chord) -> bool {
    let is_plain = !chord.command && !chord.shift && !chord.alt;
    let is_pressing = is_plain && matches!(key(chord), Some(Key::Space | Key::Enter));
    let focused = ctx.memory(|memory| memory.focused()).filter(|_| is_pressing);
    // The picture, rows and curves are dragged, too.
    let sense = focused.and_then(|id| ctx.read_response(id)).map(|response| response.sense);
    sense.is_some_and(|sense| sense.senses_click() && !sense.senses_drag())
}

/// Returns whether keys are meant for a text field or a question, and trigger nothing else.
pub(super) fn are_taken(ctx: &egui::Context) -> bool {
    ctx.text_edit_focused() || ctx.memory(|memory| memory.top_modal_layer().is_some())
}

/// Returns the actions whose keys were pressed; none while keys are taken.
pub(super) fn pressed(ctx: &egui::Context, shortcuts: &Shortcuts) -> Vec<Action> {
    if are_taken(ctx) {
        return Vec::new();
    }
    let is_held_kind = |action: Action| action.group() == "Hold";
    let mut found = Vec::new();
    let is_left_to_button = |action: Action| shortcuts.of(action).is_some_and(|chord| presses_button(ctx, chord));
    let left: Vec<Action> = Action::ALL.iter().copied().filter(|action| is_left_to_button(*action)).collect();
    ctx.input_mut(|input| {
        // Chords with more modifiers come first, so that Ctrl+Shift+Z does not match Ctrl+Z.
        let mut actions: Vec<Action> =
            Action::ALL.iter().copied().filter(|action| !is_held_kind(*action) && !left.contains(action)).collect();
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
        input.events.retain(|event| match clipboard_chord(event) {
            Some(chord) => {
                found.extend(shortcuts.action_of(&chord));
                false
            }
            None => true,
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
