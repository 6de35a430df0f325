//! The list of shortcuts, in which each can be given another key.

use super::accessible::Accessible;
use super::keys::words;
use crate::edit::{Action, Chord, Shortcuts};
use eframe::egui::{self, Align2, Button, Event, Grid, Id, Key, RichText, ScrollArea, Vec2, vec2};
use std::path::Path;

/// What the list leaves of the window: room for its title, and a margin.
const BORDER: Vec2 = vec2(48.0, 88.0);

/// The shortcuts, and the action that is waiting for its new key.
pub(super) struct Chords<'a> {
    pub(super) shortcuts: &'a mut Shortcuts,
    pub(super) rebound: &'a mut Option<Action>,
}

/// Shows the list of shortcuts. Returns false once closed.
pub(super) fn show(ctx: &egui::Context, mut chords: Chords, file: &Path) -> bool {
    let note = Id::unique("note about keys");
    let was_waiting = chords.rebound.is_some();
    if let Some(action) = *chords.rebound
        && let Some(chord) = pressed(ctx)
    {
        *chords.rebound = None;
        let outcome = chord.map_or(Ok(()), |chord| chords.shortcuts.rebind(action, chord, file));
        let text = outcome.err().map(|error| error.to_string()).unwrap_or_default();
        ctx.data_mut(|data| data.insert_temp(note, text));
    }
    let mut is_open = true;
    // In a small window the list scrolls, below its title and its close button.
    let room = ctx.content_rect().size() - BORDER;
    let window = egui::Window::new("Keys").open(&mut is_open).collapsible(false).resizable(false);
    window.anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0)).show(ctx, |ui| {
        let area = ScrollArea::both().max_width(room.x).max_height(room.y);
        area.min_scrolled_width(room.x).min_scrolled_height(room.y).show(ui, |ui| {
            ui.horizontal_top(|ui| {
                ui.spacing_mut().item_spacing.x = 26.0;
                for groups in [["File", "Edit", "Help"], ["Time", "Hold", "Nudge"], ["View", "", ""]] {
                    ui.vertical(|ui| groups.iter().for_each(|group| key_group(ui, &mut chords, group)));
                }
            });
            ui.separator();
            let fault = ctx.data(|data| data.get_temp::<String>(note)).unwrap_or_default();
            if !fault.is_empty() {
                ui.label(RichText::new(fault).color(ui.visuals().error_fg_color));
            }
            ui.weak("Alt and a click: the pin takes its surroundings along. Arrow keys belong to rows and curves of keys while these have the focus.");
            ui.weak(format!("Click a key to bind another one, which is kept in {}", file.display()));
        });
    });
    let is_left = ctx.input(|input| input.key_pressed(Key::Escape)) && !was_waiting;
    if !is_open || is_left {
        *chords.rebound = None;
        ctx.data_mut(|data| data.remove::<String>(note));
    }
    is_open && !is_left
}

/// Shows the shortcuts of one group.
fn key_group(ui: &mut egui::Ui, chords: &mut Chords, group: &str) {
    if group.is_empty() {
        return;
    }
    ui.set_min_width(210.0);
    ui.strong(group);
    Grid::new(group).num_columns(2).min_col_width(90.0).spacing([12.0, 3.0]).show(ui, |ui| {
        for &action in Action::ALL.iter().filter(|action| action.group() == group) {
            let is_waiting = *chords.rebound == Some(action);
            let text = if is_waiting { "press a key".to_owned() } else { words(chords.shortcuts, action) };
            let button = Button::new(RichText::new(text).monospace()).frame(is_waiting);
            if ui.add(button).accessible(&format!("Key of {}", action.words())).clicked() {
                *chords.rebound = Some(action);
            }
            ui.label(action.words());
            ui.end_row();
        }
    });
    ui.add_space(8.0);
}

/// Takes the chord that was pressed, and all other input; `Some(None)` for Escape; `None` if there was none.
fn pressed(ctx: &egui::Context) -> Option<Option<Chord>> {
    ctx.input_mut(|input| {
        let found = input.events.iter().find_map(|event| match event {
            Event::Key { key: Key::Escape, pressed: true, .. } => Some(None),
            Event::Key { key, pressed: true, modifiers, .. } => Some(Some(Chord {
                command: modifiers.command,
                shift: modifiers.shift,
                alt: modifiers.alt,
                key: key.name().to_owned(),
            })),
            // The toolkit turns these chords into events of their own.
            Event::Copy => Chord::parse("Ctrl+C").map(Some),
            Event::Cut => Chord::parse("Ctrl+X").map(Some),
            Event::Paste(_) => Chord::parse("Ctrl+V").map(Some),
            _ => None,
        });
        if found.is_some() {
            input.events.clear();
        }
        found
    })
}
