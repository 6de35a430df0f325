//! Maps the chords of [`Shortcuts`] to the toolkit's key events.

use crate::edit::{Action, Chord, Shortcuts};
use eframe::egui::{self, InputState, Key, Modifiers};

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
    // The picture, rows and curves are dragged, too.
    is_pressing && focused_sense(ctx).is_some_and(|sense| sense.senses_click() && !sense.senses_drag())
}

/// Returns whether a slider has keyboard focus, which arrow keys move.
fn moves_slider(ctx: &egui::Context) -> bool {
    // The picture, rows and curves are clicked, too.
    focused_sense(ctx).is_some_and(|sense| sense.senses_drag() && !sense.senses_click())
}

/// Returns what the widget with keyboard focus responds to.
fn focused_sense(ctx: &egui::Context) -> Option<egui::Sense> {
    let focused = ctx.memory(|memory| memory.focused())?;
    ctx.read_response(focused).map(|response| response.sense)
}

/// Returns whether keys are meant for a text field or a question, and trigger nothing else.
pub(super) fn are_taken(ctx: &egui::Context) -> bool {
    ctx.text_edit_focused() || ctx.memory(|memory| memory.top_modal_layer().is_some())
}

/// Returns whether a chord has an arrow key. Widgets with keyboard focus use these themselves.
fn has_arrow(chord: &Chord) -> bool {
    matches!(key(chord), Some(Key::ArrowLeft | Key::ArrowRight | Key::ArrowUp | Key::ArrowDown))
}

/// Takes the chords of actions out of the input; returns the actions, steps as often as they were pressed: a slow window gets several
/// presses at once.
fn taken(input: &mut InputState, shortcuts: &Shortcuts, mut actions: Vec<Action>) -> Vec<Action> {
    // Chords with more modifiers come first, so that Ctrl+Shift+Z does not match Ctrl+Z.
    let count = |action: &Action| {
        shortcuts.of(*action).map_or(0, |chord| u8::from(chord.command) + u8::from(chord.shift) + u8::from(chord.alt))
    };
    actions.sort_by_key(|action| std::cmp::Reverse(count(action)));
    let mut found = Vec::new();
    for action in actions {
        let Some((key, chord)) = shortcuts.of(action).and_then(|chord| Some((key(chord)?, chord))) else {
            continue;
        };
        let count = input.count_and_consume_key(modifiers(chord), key);
        let count = if action.is_counted() { count } else { count.min(1) };
        found.extend(std::iter::repeat_n(action, count));
    }
    found
}

/// A press or a release of the key that both plays and pans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tap {
    Down,
    Up,
}

/// Takes the presses of the key that both plays and pans out of the input, and returns them with its releases, in order; none if
/// two keys do so, and while keys are taken or the key presses a button.
pub(super) fn taps(ctx: &egui::Context, shortcuts: &Shortcuts) -> Vec<Tap> {
    let chord = shortcuts.of(Action::Pan).filter(|chord| shortcuts.of(Action::Play) == Some(chord));
    let Some((chord, own)) = chord.and_then(|chord| Some((chord, key(chord)?))) else { return Vec::new() };
    if are_taken(ctx) || presses_button(ctx, chord) {
        return Vec::new();
    }
    let mut found = Vec::new();
    ctx.input_mut(|input| {
        input.events.retain(|event| match event {
            egui::Event::Key { key, pressed: true, repeat, modifiers, .. }
                if *key == own && !(modifiers.command || modifiers.shift || modifiers.alt) =>
            {
                found.extend((!repeat).then_some(Tap::Down));
                false
            }
            egui::Event::Key { key, pressed: false, .. } if *key == own => {
                found.push(Tap::Up);
                true
            }
            _ => true,
        });
    });
    found
}

/// Returns the actions whose keys were pressed, except arrow keys; none while keys are taken.
pub(super) fn pressed(ctx: &egui::Context, shortcuts: &Shortcuts) -> Vec<Action> {
    if are_taken(ctx) {
        return Vec::new();
    }
    let is_left = |chord: &Chord| presses_button(ctx, chord) || has_arrow(chord);
    let is_taken = |action: &Action| action.group() != "Hold" && !shortcuts.of(*action).is_some_and(is_left);
    let actions = Action::ALL.iter().copied().filter(is_taken).collect();
    ctx.input_mut(|input| {
        let mut found = taken(input, shortcuts, actions);
        input.events.retain(|event| match clipboard_chord(event) {
            Some(chord) => {
                found.extend(shortcuts.action_of(&chord));
                false
            }
            None => true,
        });
        found
    })
}

/// Returns the actions whose arrow keys were pressed and taken by no widget; none while keys are taken. `can_nudge`: whether
/// something is selected; else the keys of nudges move the focus.
pub(super) fn pressed_arrows(ctx: &egui::Context, shortcuts: &Shortcuts, can_nudge: bool) -> Vec<Action> {
    if are_taken(ctx) || moves_slider(ctx) {
        return Vec::new();
    }
    let is_taken = |action: &Action| {
        let can_act = action.group() != "Hold" && (can_nudge || action.nudge().is_none());
        can_act && shortcuts.of(*action).is_some_and(has_arrow)
    };
    let actions = Action::ALL.iter().copied().filter(is_taken).collect();
    ctx.input_mut(|input| taken(input, shortcuts, actions))
}

/// Returns whether the key of an action is held.
pub(super) fn is_held(ctx: &egui::Context, shortcuts: &Shortcuts, action: Action) -> bool {
    if are_taken(ctx) {
        return false;
    }
    let key = shortcuts.of(action).and_then(key);
    key.is_some_and(|key| ctx.input(|input| input.key_down(key) && !input.modifiers.command))
}

/// Returns the shortcut text for a menu entry.
pub(super) fn words(shortcuts: &Shortcuts, action: Action) -> String {
    shortcuts.of(action).map(ToString::to_string).unwrap_or_default()
}
