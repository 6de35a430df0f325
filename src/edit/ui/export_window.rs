//! The window of an export: the options that its format has, its progress, and what it said.
//!
//! In: a [`Session`]. Out: an order, started or cancelled.

use super::accessible::Accessible;
use super::number_field::whole;
use crate::edit::{ExportOrder, Session};
use eframe::egui::{self, Align2, Button, Grid, Id, ProgressBar, ScrollArea, TextEdit, Ui, vec2};

/// Largest side of a map, and margin around it, in pixels.
const PIXELS: u32 = 16_384;

/// Shows the window if an export is ordered.
pub(super) fn show(ctx: &egui::Context, session: &mut Session) {
    let Some(mut order) = session.export_run().order.clone() else { return };
    let mut is_open = true;
    let window = egui::Window::new(format!("Export: {}", order.format.name)).id(Id::unique("export window"));
    let window = window.open(&mut is_open).collapsible(false).resizable(false);
    window.anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0)).show(ctx, |ui| {
        ui.set_width(420.0);
        ui.add_enabled_ui(!session.is_exporting(), |ui| {
            Grid::new("export").num_columns(2).spacing([10.0, 6.0]).show(ui, |ui| options(ui, session, &mut order));
        });
        ui.separator();
        run(ui, session, &order);
    });
    session.export_run().order = is_open.then_some(order);
}

fn options(ui: &mut Ui, session: &Session, order: &mut ExportOrder) {
    let (shot, format) = (session.shot(), order.format);
    let text = |ui: &mut Ui, (name, hint): (&str, &str), value: &mut String| {
        ui.label(name);
        ui.add(TextEdit::singleline(value).hint_text(hint).desired_width(280.0))
            .accessible_name(format!("Export {name}"));
        ui.end_row();
    };
    text(ui, ("Output", "beside the shot, under its name"), &mut order.output);
    text(ui, ("Frames", "all; or 1-48x2,60"), &mut order.frames);
    if format.has_layers && shot.layers.len() > 1 {
        ui.label("Layers");
        ui.horizontal_wrapped(|ui| {
            for layer in &shot.layers {
                let mut is_chosen = !order.left_out.contains(&layer.name);
                let chosen =
                    ui.checkbox(&mut is_chosen, &layer.name).accessible(&format!("Export layer {}", layer.name));
                if chosen.changed() && !is_chosen {
                    order.left_out.insert(layer.name.clone());
                } else if chosen.changed() {
                    order.left_out.remove(&layer.name);
                }
            }
        });
        ui.end_row();
    }
    if format.has_maps {
        ui.label("Size");
        ui.horizontal(|ui| {
            let mut pixels = order.pixels(shot.size);
            for (side, name) in pixels.iter_mut().zip(["Width of the maps", "Height of the maps"]) {
                ui.add(whole(side, 1..=PIXELS)).accessible(name);
            }
            order.size = (pixels != [shot.size.width, shot.size.height]).then_some(pixels);
        });
        ui.end_row();
        ui.label("Overscan");
        let hint = "Pixels that the maps extend beyond the frame on each side";
        ui.add(whole(&mut order.overscan, 0..=PIXELS).suffix(" px")).accessible_name("Overscan").on_hover_text(hint);
        ui.end_row();
    }
    if format.has_inverse {
        ui.label("");
        ui.checkbox(&mut order.is_inverse, "Inverse maps, which undo the warp");
        ui.end_row();
    }
    ui.label("");
    ui.checkbox(&mut order.replaces, "Replace existing files");
    ui.end_row();
}

/// Shows the buttons, the progress, and what was said.
fn run(ui: &mut Ui, session: &mut Session, order: &ExportOrder) {
    let written = session.export_run().written;
    ui.horizontal(|ui| {
        if session.is_exporting() {
            let of = session.shot().frames.count();
            // Other formats are written at once, or layer by layer.
            if order.format.has_inverse && order.frames.trim().is_empty() {
                let part = written as f32 / of.max(1) as f32;
                ui.add(ProgressBar::new(part).desired_width(280.0).text(format!("{written} / {of}")));
            } else {
                ui.spinner();
                ui.label(if written == 0 {
                    "Solving \u{2026}".to_owned()
                } else {
                    format!("{written} frames written")
                });
            }
            if ui.button("Cancel export").clicked() {
                session.cancel_export();
            }
            return;
        }
        let layers = &session.shot().layers;
        let has_layers = !order.format.has_layers || layers.iter().any(|layer| !order.left_out.contains(&layer.name));
        let button = ui.add_enabled(has_layers, Button::new("Start export"));
        if button.on_disabled_hover_text("Choose a layer").clicked() {
            let wake = ui.ctx().clone();
            session.export(order, move || wake.request_repaint());
        }
    });
    let told = session.export_run().told.clone();
    if !told.is_empty() {
        ScrollArea::vertical().max_height(160.0).show(ui, |ui| ui.label(told));
    }
}
