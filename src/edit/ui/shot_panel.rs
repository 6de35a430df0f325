//! Settings of the shot: clip, frames, camera, samples, hidden nodes.

use super::accessible::Accessible;
use super::number_field::whole;
use crate::edit::Session;
use crate::shot::edit::Setting;
use crate::shot::{CameraRule, ClipName};
use eframe::egui::{CollapsingHeader, ComboBox, Grid, Label, ScrollArea, Ui};

/// Views for scenes without a camera.
const VIEWS: [&str; 7] = ["fit", "front", "three-quarter", "left", "right", "back", "top"];

pub(super) fn show(ui: &mut Ui, session: &mut Session) {
    CollapsingHeader::new("Shot").default_open(false).show(ui, |ui| {
        Grid::new("shot").num_columns(2).spacing([10.0, 6.0]).show(ui, |ui| {
            clip(ui, session);
            frames(ui, session);
            camera(ui, session);
            if let Some(plate) = session.shot().plate.clone() {
                ui.label("Plate");
                let name = plate.file_name().unwrap_or_default().to_string_lossy().into_owned();
                ui.horizontal(|ui| {
                    let hint = "Removes the plate from the shot; File, Choose plate sets another";
                    if ui.small_button("Remove").accessible("Remove plate").on_hover_text(hint).clicked() {
                        session.set_plate(None);
                    }
                    ui.add(Label::new(name).truncate()).on_hover_text(plate.display().to_string());
                });
                ui.end_row();
            }
            ui.label("Frames go to");
            let output = session.shot().output.path.display().to_string();
            let name = session.shot().output.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            ui.add(Label::new(name).truncate()).on_hover_text(output);
            ui.end_row();
            let shutter = session.shot().shutter.angle;
            let (name, hint) = match shutter > 0.0 {
                true => ("Motion blur", format!("Samples of a pixel, spread over a shutter of {shutter:.0} degrees: more are smoother and slower")),
                false => ("Smoothing", "Samples of a pixel; the shutter is closed: no motion blur".to_owned()),
            };
            ui.label(name);
            let mut samples = session.shot().samples;
            if ui
                .add(whole(&mut samples, 1..=4096).suffix(" samples"))
                .explained("Samples", &hint)
                .changed()
            {
                session.set_shot("Change samples", &["samples"], &Setting::Whole(i64::from(samples)), Some("samples"));
            }
            ui.end_row();
        });
        nodes(ui, session);
    });
}

fn clip(ui: &mut Ui, session: &mut Session) {
    let clips = session.loaded().clips.clone();
    if clips.is_empty() {
        return;
    }
    let chosen = match &session.shot().clip {
        Some(ClipName::Name(name)) => name.clone(),
        Some(ClipName::Index(index)) => clips.get(*index).map_or_else(String::new, |(name, _)| name.clone()),
        None => clips[0].0.clone(),
    };
    ui.label("Clip");
    let list =
        ComboBox::from_id_salt("clip").selected_text(&chosen).width(100.0).truncate().height(320.0).show_ui(ui, |ui| {
            for (name, secs) in &clips {
                if ui.selectable_label(*name == chosen, format!("{name}  {secs:.2} s")).clicked() {
                    session.choose_clip(name, *secs);
                }
            }
        });
    list.response.explained("Clip", "The animation of the scene that is played");
    ui.end_row();
}

fn frames(ui: &mut Ui, session: &mut Session) {
    ui.label("Frames");
    let [mut first, mut last] = session.playhead.shot_range();
    ui.horizontal(|ui| {
        let mut is_changed = ui.add(whole(&mut first, -100_000..=last)).accessible("First of the shot").changed();
        ui.label("to");
        is_changed |= ui.add(whole(&mut last, first..=100_000)).accessible("Last of the shot").changed();
        if is_changed {
            session.set_frames([first, last]);
        }
    });
    ui.end_row();
}

fn camera(ui: &mut Ui, session: &mut Session) {
    if !session.shot().scene().is_some_and(|scene| scene.is_file()) {
        return;
    }
    let own = session.loaded().cameras.clone();
    let chosen = match &session.shot().camera {
        CameraRule::Named(name) => name.clone(),
        CameraRule::Own(_) => "of the shot".to_owned(),
        _ => own.first().cloned().unwrap_or_else(|| "fit".into()),
    };
    ui.label("Camera");
    let list = ComboBox::from_id_salt("camera").selected_text(&chosen).width(100.0).truncate().show_ui(ui, |ui| {
        for name in own.iter().map(String::as_str).chain(VIEWS) {
            if ui.selectable_label(name == chosen, name).clicked() {
                session.set_shot("Choose camera", &["camera"], &Setting::Text(name.to_owned()), None);
            }
        }
    });
    list.response.explained("Camera", "The camera of the scene, or a view of it");
    ui.end_row();
}

fn nodes(ui: &mut Ui, session: &mut Session) {
    let nodes = session.loaded().nodes.clone();
    if nodes.len() < 2 {
        return;
    }
    ui.add_space(4.0);
    ui.weak("Drawn nodes");
    ScrollArea::vertical().id_salt("nodes").max_height(180.0).show(ui, |ui| {
        for (name, is_hidden) in nodes {
            let mut is_drawn = !is_hidden;
            if ui.checkbox(&mut is_drawn, &name).changed() {
                session.toggle_node(&name);
            }
        }
    });
}
