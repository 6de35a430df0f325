//! The menu bar with the file's name and status, and the hint line.

use super::accessible::Accessible;
use super::icons::{self, Icon};
use super::keys::words;
use super::references;
use crate::edit::{Action, EXPORTS, Onion, RenderRun, Session, Shortcuts, Wipe};
use eframe::egui::containers::menu::MenuConfig;
use eframe::egui::widgets::color_picker;
use eframe::egui::{self, Button, Color32, PopupCloseBehavior, ProgressBar, RichText, ThemePreference, Ui};
use std::path::PathBuf;

/// The default hint after its first words: the basic operations in one line.
const HINT: &str = "Drag a pin: move it.  Its ring: turn, with Shift scale, too.  Empty space: select.  Wheel: zoom.  \
                    Middle button or Space: pan.  F1: keys.";

/// Shows the menus; returns the selected actions, and the shot to open of the `recent` ones.
pub(super) fn show(
    ui: &mut Ui,
    mut session: Option<&mut Session>,
    shortcuts: &Shortcuts,
    recent: &[PathBuf],
) -> (Vec<Action>, Option<PathBuf>) {
    let (mut chosen, mut opened) = (Vec::new(), None);
    let is_open = session.is_some();
    // Switches and sliders leave their menu open, so that several can be set at once; actions close it.
    let config = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    egui::MenuBar::new().config(config).ui(ui, |ui| {
        let mut entry = |ui: &mut Ui, action: Action, is_enabled: bool| {
            let button = Button::new(action.words()).shortcut_text(words(shortcuts, action));
            if ui.add_enabled(is_enabled, button).clicked() {
                chosen.push(action);
                ui.close();
            }
        };
        ui.menu_button("File", |ui| {
            entry(ui, Action::Start, is_open);
            entry(ui, Action::Open, true);
            opened = open_recent(ui, recent);
            entry(ui, Action::Save, is_open);
            entry(ui, Action::SaveAs, is_open);
            ui.separator();
            entry(ui, Action::Render, is_open);
            entry(ui, Action::RenderOptions, is_open);
            entry(ui, Action::Plate, is_open);
            entry(ui, Action::Reference, is_open);
            if let Some(session) = session.as_deref_mut() {
                exports(ui, session);
            }
            ui.separator();
            entry(ui, Action::Quit, true);
        });
        ui.menu_button("Edit", |ui| {
            for action in [
                Action::Undo,
                Action::Redo,
                Action::Copy,
                Action::Paste,
                Action::Delete,
                Action::Mute,
                Action::Hard,
                Action::MirrorPins,
                Action::All,
                Action::Key,
            ] {
                entry(ui, action, is_open);
            }
            if let Some(session) = session.as_deref_mut() {
                ui.separator();
                let hint = "Pins named left and right, near and far, .L and .R are moved alike, mirrored";
                ui.checkbox(&mut session.mirrors, Action::Mirror.words()).on_hover_text(hint);
            }
        });
        ui.menu_button("View", |ui| {
            for action in [Action::Fit, Action::OneToOne, Action::ZoomIn, Action::ZoomOut] {
                entry(ui, action, is_open);
            }
            ui.separator();
            if let Some(session) = session {
                switches(ui, session, shortcuts);
                references::show(ui, session);
            }
            ui.separator();
            theme(ui);
        });
        ui.menu_button("Time", |ui| {
            use Action::{Back, First, Forward, KeyBack, KeyForward, Last, Play, RangeAll, RangeIn, RangeOut};
            for action in [Play, Back, Forward, KeyBack, KeyForward, First, Last, RangeIn, RangeOut, RangeAll] {
                entry(ui, action, is_open);
            }
        });
        ui.menu_button("Help", |ui| {
            entry(ui, Action::Tour, true);
            entry(ui, Action::Keys, true);
        });
    });
    (chosen, opened)
}

fn switches(ui: &mut Ui, session: &mut Session, shortcuts: &Shortcuts) {
    let mut shown = session.shown;
    let switch = |ui: &mut Ui, action: Action, value: &mut bool| {
        ui.horizontal(|ui| {
            ui.checkbox(value, action.words());
            ui.weak(words(shortcuts, action));
        });
    };
    switch(ui, Action::Lattice, &mut shown.lattice);
    switch(ui, Action::Handles, &mut shown.handles);
    switch(ui, Action::Pins, &mut shown.pins);
    ui.checkbox(&mut shown.names, "Names of pins");
    ui.checkbox(&mut shown.rest, "Rest places");
    ui.checkbox(&mut shown.folds, "Folded cells");
    switch(ui, Action::Distortion, &mut shown.distortion);
    switch(ui, Action::Painted, &mut shown.painted);
    switch(ui, Action::Trails, &mut shown.trails);
    switch(ui, Action::SafeAreas, &mut shown.safe_areas);
    let mut has_onion = shown.onion.count > 0;
    switch(ui, Action::Onion, &mut has_onion);
    shown.onion.count = if has_onion { shown.onion.count.max(1) } else { 0 };
    if has_onion {
        onion(ui, &mut shown.onion);
    }
    session.shown = shown;
    for (action, usual) in [(Action::Wipe, Wipe::At(0.5)), (Action::Ghost, Wipe::Ghost(0.4))] {
        let is_this = std::mem::discriminant(&session.shown.wipe) == std::mem::discriminant(&usual);
        let mut is_on = is_this;
        switch(ui, action, &mut is_on);
        if is_on != is_this {
            session.set_wipe(if is_on { usual } else { Wipe::Off });
        }
    }
    match &mut session.shown.wipe {
        Wipe::At(share) => _ = ui.add(egui::Slider::new(share, 0.0..=1.0).text("wipe")),
        Wipe::Ghost(opacity) => _ = ui.add(egui::Slider::new(opacity, 0.05..=1.0).text("opacity of the ghost")),
        Wipe::Off => {}
    }
}

/// Lists recent shots; returns the one to open.
fn open_recent(ui: &mut Ui, recent: &[PathBuf]) -> Option<PathBuf> {
    let mut opened = None;
    ui.menu_button("Open recent", |ui| {
        for shot in recent {
            let name = shot.file_name().unwrap_or_default().to_string_lossy();
            if ui.button(&*name).on_hover_text(shot.display().to_string()).clicked() {
                opened = Some(shot.clone());
                ui.close();
            }
        }
    });
    opened
}

/// Shows the export formats.
fn exports(ui: &mut Ui, session: &mut Session) {
    ui.menu_button("Export", |ui| {
        for format in &EXPORTS {
            if ui.button(format.name).clicked() {
                session.order_export(format);
                ui.close();
            }
        }
    });
}

fn onion(ui: &mut Ui, onion: &mut Onion) {
    ui.indent("onion", |ui| {
        ui.add(egui::Slider::new(&mut onion.count, 1..=5).text("on either side"));
        let mut by_keys = onion.every == 0;
        if ui.checkbox(&mut by_keys, "by keys of what is selected").changed() {
            onion.every = if by_keys { 0 } else { 2 };
        }
        if !by_keys {
            ui.add(egui::Slider::new(&mut onion.every, 1..=24).text("frames apart"));
        }
        ui.add(egui::Slider::new(&mut onion.opacity, 0.05..=1.0).text("opacity"));
        for (tint, name) in onion.tints.iter_mut().zip(["Tint before", "Tint after"]) {
            ui.horizontal(|ui| {
                let [red, green, blue] = *tint;
                color_picker::show_color(ui, Color32::from_rgb(red, green, blue), ui.spacing().interact_size);
                // A submenu, because a window of its own would close the menu.
                ui.menu_button(name, |ui| {
                    for (value, part) in tint.iter_mut().zip(["red", "green", "blue"]) {
                        let slider = ui.add(egui::Slider::new(value, 0..=255).text(part));
                        slider.accessible_name(format!("{name}, {part}"));
                    }
                });
            });
        }
    });
}

fn theme(ui: &mut Ui) {
    ui.horizontal(|ui| {
        let mut preference = ui.ctx().options(|options| options.theme_preference);
        let names =
            [(ThemePreference::Dark, "Dark"), (ThemePreference::Light, "Light"), (ThemePreference::System, "System")];
        for (value, name) in names {
            if ui.selectable_value(&mut preference, value, name).clicked() {
                ui.ctx().set_theme(value);
            }
        }
    });
}

/// A click at the right end of the bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BarClick {
    Render,
    /// Shows the window of the render.
    ShowRender,
}

/// Shows the button that renders; returns whether it was clicked.
fn render(ui: &mut Ui, session: &Session, shortcuts: &Shortcuts) -> bool {
    let hint = format!(
        "Writes the frames to {}, with previews beside them ({}). Frames that are up to date are kept.",
        session.shot().output.path.display(),
        words(shortcuts, Action::Render)
    );
    ui.button("Render").on_hover_text(hint).accessible_name("Render frames").clicked()
}

/// Shows the file's name at the right end of the bar, the button that renders, and the progress, that of renders of other shots, too.
/// `is_hidden`: whether the window of the render is not shown.
pub(super) fn state(
    ui: &mut Ui,
    session: &Session,
    background: &[RenderRun],
    (shortcuts, is_hidden): (&Shortcuts, bool),
) -> Option<BarClick> {
    let mut click = None;
    let name = session.document().path().file_name().unwrap_or_default().to_string_lossy().into_owned();
    let sign = if session.document().is_dirty() { "not saved" } else { "" };
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.add_space(6.0);
        if icons::button(ui, Icon::Down, "Render options").clicked() {
            click = Some(BarClick::ShowRender);
        }
        if render(ui, session, shortcuts) {
            click = Some(BarClick::Render);
        }
        if let Some(part) = session.progress() {
            ui.add(ProgressBar::new(part as f32).desired_width(110.0).text("over time"));
        }
        for run in background {
            let name = run.name();
            if ui.small_button("Cancel").accessible(&format!("Cancel the render of {name}")).clicked() {
                run.cancel();
            }
            let bar = ui.add(progress(run, true)).on_hover_text(format!("Rendering {}", run.shot.display()));
            bar.accessible_name(format!("Rendering {name}"));
        }
        if let Some(run) = session.run() {
            if run.is_running() {
                ui.add(progress(run, !background.is_empty()));
            }
            if is_hidden && ui.button("Show the render").on_hover_text("Progress, log, frames").clicked() {
                click = Some(BarClick::ShowRender);
            }
        }
        ui.weak(sign);
        ui.label(RichText::new(name).strong());
    });
    click
}

/// Returns the progress of a render, with its shot where there are several.
fn progress(run: &RenderRun, is_named: bool) -> ProgressBar {
    let (part, stage) = run.progress();
    let text = if is_named { format!("{}: {stage}", run.name()) } else { stage };
    ProgressBar::new(part as f32).desired_width(if is_named { 260.0 } else { 160.0 }).text(text)
}

/// Shows the bottom line: the message of the last action, or a hint.
pub(super) fn hint(ui: &mut Ui, session: &mut Session) {
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.add_space(6.0);
        ui.weak(&session.loaded().device);
        ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
            ui.add_space(4.0);
            let words = match (session.fault(), session.message()) {
                (Some(fault), None) => RichText::new(fault).color(ui.visuals().error_fg_color),
                // The picture says what the fault is.
                (Some(_), Some(message)) => RichText::new(message).color(ui.visuals().error_fg_color),
                (None, Some(message)) => RichText::new(message),
                (None, None) => RichText::new(format!("Click the {}: pin.  {HINT}", session.subject())).weak(),
            };
            // Truncated text is shown in full as a tooltip.
            let full = words.text().to_owned();
            ui.add(egui::Label::new(words).truncate()).on_hover_text(full);
        });
    });
}
