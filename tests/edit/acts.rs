//! What a person does in a window: keys, clicks, drags, numbers and texts, each by the label of what it is meant for.

use super::window::{Window, pointer};
use eframe::egui::{DroppedFile, Event, Key, Modifiers, Pos2, Role};
use egui_kittest::kittest::{Queryable, by};
use std::fs;
use std::path::{Path, PathBuf};

/// A file as the window system hands it over.
#[derive(Debug)]
pub(crate) struct Handed(pub(crate) PathBuf);

impl DroppedFile for Handed {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        fs::read(&self.0).map_err(|error| error.to_string())
    }
}

/// Presses a key with modifiers, and lets go of it.
pub(crate) fn press(window: &mut Window, modifiers: Modifiers, key: Key) {
    window.key_press_modifiers(modifiers, key);
    window.run_steps(2);
}

/// Presses a key, or lets go of it.
pub(crate) fn hold(window: &mut Window, key: Key, pressed: bool) {
    let (physical_key, repeat, modifiers) = (None, false, Modifiers::NONE);
    window.event(Event::Key { key, physical_key, pressed, repeat, modifiers });
    window.step();
}

/// Clicks what has these labels, one after the other.
pub(crate) fn click(window: &mut Window, labels: &[&str]) {
    for label in labels {
        window.get_by_label(label).click();
        window.run_steps(3);
    }
}

/// Drags with the primary button.
pub(crate) fn drag(window: &mut Window, [from, to]: [Pos2; 2]) {
    pointer(window, from, None);
    pointer(window, from, Some(true));
    for step in 1..=4 {
        pointer(window, from + (to - from) * (step as f32 / 4.0), None);
    }
    pointer(window, to, Some(false));
    window.run_steps(2);
}

/// Sets a number as screen readers do.
pub(crate) fn number(window: &mut Window, label: &str, value: f64) {
    // A text and a slider may have its name, too.
    let has_value = by().label(label).predicate(|node| matches!(node.role(), Role::Slider | Role::SpinButton));
    window.get_all(has_value).next().expect("it is there").set_value_accesskit(value);
    window.run_steps(3);
}

/// Chooses an entry of a list.
pub(crate) fn choose(window: &mut Window, list: &str, entry: &str) {
    window.get_by_role_and_label(Role::ComboBox, list).click();
    window.run_steps(3);
    click(window, &[entry]);
}

/// Writes a text into a field, in place of what is there, and enters it.
pub(crate) fn write(window: &mut Window, field: &str, text: &str) {
    window.get_by_label(field).focus();
    window.run_steps(2);
    press(window, Modifiers::COMMAND, Key::A);
    window.event(Event::Text(text.to_owned()));
    window.run_steps(2);
}
