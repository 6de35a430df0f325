//! The buttons above the timeline: playback, keys, eases.

use super::accessible::Accessible;
use super::icons::{self, Icon};
use crate::edit::{AutoKey, EasePreset, Pace, Session};
use eframe::egui::{ComboBox, DragValue, Ui};

/// Shows the buttons; returns whether to toggle between rows and curves.
pub(super) fn transport(ui: &mut Ui, session: &mut Session, (now, has_curves): (f64, bool)) -> bool {
    let mut is_changed = false;
    ui.horizontal(|ui| {
        ui.add_space(4.0);
        let [first, last] = session.playhead.range();
        if icons::button(ui, Icon::First, "First frame").clicked() {
            session.go(first);
        }
        if icons::button(ui, Icon::Back, "Frame back").clicked() {
            session.step(-1);
        }
        let (play, name) = if session.playhead.is_playing() { (Icon::Pause, "Stop") } else { (Icon::Play, "Play") };
        if icons::button(ui, play, name).clicked() {
            session.toggle_play(now);
        }
        if icons::button(ui, Icon::Forward, "Frame forward").clicked() {
            session.step(1);
        }
        if icons::button(ui, Icon::Last, "Last frame").clicked() {
            session.go(last);
        }
        let mut frame = session.playhead.frame();
        let [least, most] = session.playhead.shot_range();
        let value = ui
            .add(DragValue::new(&mut frame).range(least..=most.max(least)).speed(0.2))
            .explained("Frame", "The frame that is shown: type it, or drag");
        if value.changed() {
            session.go(frame);
        }
        ui.weak(format!("of {most}"));
        ui.separator();
        let mut is_auto = session.auto_key == AutoKey::On;
        if ui
            .toggle_value(&mut is_auto, "Auto key")
            .on_hover_text("Dragging keys this frame. Off: all keys of the pin move alike.")
            .changed()
        {
            session.auto_key = if is_auto { AutoKey::On } else { AutoKey::Off };
        }
        if ui.button("Key").on_hover_text("Insert a key for the selected pins").clicked() {
            session.insert_keys();
        }
        eases(ui, session);
        exposure(ui, session);
        let mut is_every = session.playhead.pace == Pace::EveryFrame;
        if ui
            .toggle_value(&mut is_every, "Every frame")
            .on_hover_text("Play every frame; off: in real time, dropping frames")
            .changed()
        {
            session.playhead.pace = if is_every { Pace::EveryFrame } else { Pace::RealTime };
        }
        let mut is_seen = has_curves;
        is_changed = ui.toggle_value(&mut is_seen, "Curves").on_hover_text("Keys of selected pins as curves").changed();
        if session.mirrors {
            let off = ui.selectable_label(true, "Mirror").on_hover_text("Edits are mirrored: click to end that");
            session.mirrors = !off.clicked();
        }
    });
    is_changed
}

fn eases(ui: &mut Ui, session: &mut Session) {
    let chosen = session.chosen_eases();
    let text = match chosen[..] {
        [] => "Ease: no key",
        [ease] => EasePreset::of(ease).map_or("Curve", EasePreset::name),
        _ => "Several eases",
    };
    let list = ComboBox::from_id_salt("ease").selected_text(text).width(104.0).show_ui(ui, |ui| {
        for preset in EasePreset::ALL {
            if ui.selectable_label(chosen == [preset.ease()], preset.name()).clicked() {
                session.ease_keys(preset);
            }
        }
    });
    list.response.explained(
        "Ease",
        "How the selected keys go on to the next one; without selected keys, all of the selected pins and handles",
    );
}

fn exposure(ui: &mut Ui, session: &mut Session) {
    let step = session.shot().layers.get(session.selection.layer).map_or(1, |layer| layer.step);
    let name = |step: u32| match step {
        1 => "On ones".to_owned(),
        2 => "On twos".to_owned(),
        3 => "On threes".to_owned(),
        more => format!("On {more}s"),
    };
    let list = ComboBox::from_id_salt("exposure").selected_text(name(step)).width(84.0).show_ui(ui, |ui| {
        for wanted in [1, 2, 3, 4] {
            if ui.selectable_label(step == wanted, name(wanted)).clicked() {
                session.set_exposure(wanted);
            }
        }
    });
    let hint = "For how many frames each drawing of this layer holds. On twos, keys stand on the first of two frames: a drag in \
                frame 12 keys frame 11";
    list.response.explained("Exposure", hint);
}
