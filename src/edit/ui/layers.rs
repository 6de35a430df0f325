//! The layer list and the settings of the selected layer.

use super::accessible::Accessible;
use super::icons::{self, Icon};
use super::name_field::NameField;
use super::number_field::NumberField;
use super::{brush, lattice_panel, matte, shot_panel};
use crate::edit::Session;
use crate::shot::edit::Setting;
use eframe::egui::{self, CollapsingHeader, Grid, RichText, ScrollArea, Ui};

/// A click in the list.
enum Click {
    Layer(usize),
    Mute(String),
    Solo(String),
    Pin([usize; 2], bool),
    MutePin([usize; 2]),
}

pub(super) fn show(ui: &mut Ui, session: &mut Session) {
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        ui.strong("Layers");
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if icons::button(ui, Icon::Minus, "Delete layer").clicked() {
                session.delete_layer();
            }
            let add = icons::button(ui, Icon::Plus, "Add layer");
            egui::Popup::menu(&add).show(|ui| add_menu(ui, session));
            if icons::button(ui, Icon::Down, "Layer down").clicked() {
                session.move_layer(1);
            }
            if icons::button(ui, Icon::Up, "Layer up").clicked() {
                session.move_layer(-1);
            }
        });
    });
    ui.separator();
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let mut click = None;
        for layer in 0..session.shot().layers.len() {
            row(ui, session, layer, &mut click);
        }
        match click {
            Some(Click::Layer(layer)) => {
                session.selection.clear();
                session.selection.layer = layer;
            }
            Some(Click::Mute(name)) => session.toggle_mute(&name),
            Some(Click::Solo(name)) => session.toggle_solo(&name),
            Some(Click::MutePin(at)) => session.toggle_pin_mute(&[at]),
            Some(Click::Pin(at, true)) => _ = session.selection.pins.insert(at),
            Some(Click::Pin(at, false)) => session.selection.only_pin(at),
            None => {}
        }
        ui.add_space(8.0);
        settings(ui, session);
        brush::settings(ui, session);
        shot_panel::show(ui, session);
    });
}

fn row(ui: &mut Ui, session: &Session, index: usize, click: &mut Option<Click>) {
    let layer = &session.shot().layers[index];
    let is_chosen = session.selection.layer == index;
    let is_muted = layer.is_muted;
    ui.horizontal(|ui| {
        let (eye, name) = if is_muted { (Icon::Unseen, "Unmute") } else { (Icon::Seen, "Mute") };
        if icons::button(ui, eye, &format!("{name} the layer \"{}\"", layer.name)).clicked() {
            *click = Some(Click::Mute(layer.name.clone()));
        }
        let solo = ui.selectable_label(session.is_solo(&layer.name), "S").accessible(&format!("Solo {}", layer.name));
        if solo.clicked() {
            *click = Some(Click::Solo(layer.name.clone()));
        }
        let name = RichText::new(&layer.name);
        let name = if is_chosen { name.strong() } else { name };
        if ui.selectable_label(is_chosen && session.selection.pins.is_empty(), name).clicked() {
            *click = Some(Click::Layer(index));
        }
        ui.weak(format!("{}", layer.pins.len()));
    });
    if !is_chosen {
        return;
    }
    for (pin, own) in layer.pins.iter().enumerate() {
        ui.horizontal(|ui| {
            ui.add_space(26.0);
            let (sign, word) = if own.is_muted { (Icon::Unseen, "Unmute") } else { (Icon::Seen, "Mute") };
            if icons::button(ui, sign, &format!("{word} pin {}", own.name)).clicked() {
                *click = Some(Click::MutePin([index, pin]));
            }
            let is_chosen = session.selection.pins.contains(&[index, pin]);
            let name = RichText::new(&own.name);
            let name = if own.is_muted { name.weak() } else { name };
            if ui.selectable_label(is_chosen, name).clicked() {
                let adds = ui.input(|input| input.modifiers.shift || input.modifiers.command);
                *click = Some(Click::Pin([index, pin], adds));
            }
            let count = own.key_frames().count();
            if count > 1 {
                ui.weak(crate::spelling::pluralised(count, "key", "keys"));
            }
        });
    }
}

fn add_menu(ui: &mut Ui, session: &mut Session) {
    let offers = session.loaded().offers.clone();
    if offers.is_empty() {
        ui.weak("The shot is not loaded.");
    }
    ScrollArea::vertical().max_height(300.0).show(ui, |ui| {
        for offer in offers {
            let button = egui::Button::new(offer.node.as_deref().unwrap_or("Everything"));
            let button = ui.add_enabled(offer.place.is_ok(), button);
            match &offer.place {
                Ok(_) if button.clicked() => session.add_layer(&offer),
                Ok(_) => {}
                Err(reason) => _ = button.on_disabled_hover_text(reason),
            }
        }
    });
}

fn settings(ui: &mut Ui, session: &mut Session) {
    let index = session.selection.layer;
    let Some(layer) = session.shot().layers.get(index).cloned() else { return };
    CollapsingHeader::new(format!("Settings of '{}'", layer.name)).default_open(true).show(ui, |ui| {
        Grid::new("layer settings").num_columns(2).spacing([10.0, 6.0]).show(ui, |ui| {
            // The layer's effective strength includes the shot's, so the file's own value is edited.
            let mut strength = session.own_strength(index);
            ui.label("Strength");
            let field = NumberField {
                name: "Strength",
                hint: "How much of the warp is applied. 1: all; 0: none; above 1 exaggerates",
                range: 0.0..=2.0,
                decimals: 2,
            };
            if field.slider(ui, &mut strength, |slider| slider.clamping(egui::SliderClamping::Never)) {
                let setting =
                    if strength == 1.0 { Setting::Default } else { Setting::Number((strength * 1e3).round() / 1e3) };
                session.set_layer("Change strength", &["strength"], &setting, Some("strength"));
            }
            ui.end_row();
            lattice_panel::show(ui, session, &layer);
            ui.label("Smoothness");
            let mut smoothness = session.own_smoothness(index);
            let field = NumberField {
                name: "Smoothness",
                hint: "Higher: a pin pulls more of the layer along. Lower: its pull stays near it",
                range: 0.1..=10.0,
                decimals: 2,
            };
            if field.slider(ui, &mut smoothness, |slider| slider.logarithmic(true)) {
                let setting = Setting::Number((smoothness * 1e2).round() / 1e2);
                session.set_layer("Change smoothness", &["solve", "smoothness"], &setting, Some("smoothness"));
            }
            ui.end_row();
            ui.label("Over time");
            let mut temporal = layer.settings.temporal;
            let hint = "Frames are solved together, so that nothing snaps; 0: each alone";
            let field = NumberField { name: "Over time", hint, range: 0.0..=100.0, decimals: 2 };
            if field.drag(ui, &mut temporal, |number| number.speed(0.02)) {
                session.set_layer(
                    "Change weight over time",
                    &["solve", "temporal"],
                    &Setting::Number(temporal),
                    Some("temporal"),
                );
            }
            ui.end_row();
            if session.shot().plate.is_some() {
                ui.label("Matte");
                ui.vertical(|ui| matte::show(ui, session, &layer));
                ui.end_row();
            }
            ui.label("Name");
            // A field as wide as the panel would keep the panel from becoming narrower.
            let field = NameField { name: "Layer name", hint: "Layer name", width: 120.0 };
            if let Some((index, name)) = field.show(ui, index, &layer.name) {
                session.rename_layer(index, &name);
            }
            ui.end_row();
        });
    });
}
