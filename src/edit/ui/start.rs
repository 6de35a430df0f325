//! The start screen: how to begin, recent shots, bundled scenes, and interrupted work to recover.

use super::bundled::BUNDLED;
use super::theme;
use crate::edit::Unfinished;
use eframe::egui::{self, Align2, FontId, RichText, Ui, vec2};
use std::path::PathBuf;

/// What may be dropped on the window.
const DROPPED: &str =
    "or drop a scene (.glb, .gltf), a picture or plates (.exr, .png, .jpg), a shot (.toml) or a problem (.json) here";

/// The clicked entry.
pub(super) enum StartAction {
    Open,
    /// The tour, on the first bundled scene.
    Tour,
    Bundled(usize),
    /// A shot that was open before.
    Recent(PathBuf),
    /// Recovers the work in a journal.
    Recover(PathBuf),
    /// Deletes a journal.
    Forget(PathBuf),
}

/// Shows the page. `left`: interrupted work; `recent`: shots that were open last, the newest first.
pub(super) fn show(
    ui: &mut Ui,
    (left, recent): (&[Unfinished], &[PathBuf]),
    fault: Option<&str>,
) -> Option<StartAction> {
    let mut action = None;
    let rect = ui.available_rect_before_wrap();
    ui.painter().rect_filled(rect, 0, ui.visuals().panel_fill);
    let width = 620.0_f32.min(rect.width() - 40.0);
    let middle = egui::Rect::from_center_size(rect.center(), vec2(width, (rect.height() - 40.0).min(560.0)));
    ui.scope_builder(egui::UiBuilder::new().max_rect(middle), |ui| {
        egui::ScrollArea::vertical().show(ui, |ui| {
            ui.vertical_centered(|ui| {
                ui.label(RichText::new("pinwarp").size(34.0).strong());
                ui.weak("Put pins on a model as you see it, drag them, and the shape follows.");
                ui.add_space(18.0);
                let open = egui::Button::new(RichText::new("Open\u{2026}").size(17.0)).min_size(vec2(180.0, 38.0));
                if ui.add(open).clicked() {
                    action = Some(StartAction::Open);
                }
                ui.add_space(4.0);
                ui.weak(DROPPED);
                if let Some(fault) = fault {
                    ui.add_space(8.0);
                    ui.label(RichText::new(fault).color(ui.visuals().error_fg_color));
                }
                if !left.is_empty() {
                    ui.add_space(16.0);
                    recover(ui, left, &mut action);
                }
                if !recent.is_empty() {
                    ui.add_space(16.0);
                    recents(ui, recent, &mut action);
                }
                ui.add_space(18.0);
                ui.label(RichText::new("Or begin with one of these").strong());
                ui.add_space(6.0);
                for (row, scenes) in BUNDLED.chunks(3).enumerate() {
                    let line = 3.0 * 186.0 + 2.0 * ui.spacing().item_spacing.x;
                    ui.horizontal(|ui| {
                        ui.add_space(((ui.available_width() - line) / 2.0).max(0.0));
                        let cards: Vec<_> = scenes.iter().map(|scene| card(ui, scene.title, scene.words)).collect();
                        let clicked = cards.iter().position(egui::Response::clicked);
                        action = clicked.map(|place| StartAction::Bundled(3 * row + place)).or(action.take());
                    });
                }
                ui.add_space(14.0);
                let tour = egui::Button::new(RichText::new("Take the tour of two minutes").strong());
                if ui.add(tour).clicked() {
                    action = Some(StartAction::Tour);
                }
                ui.weak("Open the walking gnome, drag the hand, press play.");
            })
        });
    });
    action
}

fn card(ui: &mut Ui, title: &str, words: &str) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(vec2(186.0, 58.0), egui::Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, title));
    let visuals = ui.style().interact(&response);
    ui.painter().rect_filled(rect, 6, visuals.weak_bg_fill);
    if response.hovered() {
        ui.painter().rect_stroke(rect, 6, egui::Stroke::new(1.5, theme::ACCENT), egui::StrokeKind::Inside);
    }
    let left = rect.left_center() + vec2(12.0, 0.0);
    ui.painter().text(
        left - vec2(0.0, 10.0),
        Align2::LEFT_CENTER,
        title,
        FontId::proportional(14.0),
        visuals.text_color(),
    );
    let weak = ui.visuals().weak_text_color();
    ui.painter().text(left + vec2(0.0, 10.0), Align2::LEFT_CENTER, words, FontId::proportional(11.0), weak);
    response
}

fn recents(ui: &mut Ui, recent: &[PathBuf], action: &mut Option<StartAction>) {
    ui.label(RichText::new("Recent shots").strong());
    for shot in recent {
        let path = shot.display().to_string();
        if ui.add(egui::Button::new(&path).frame(false).truncate()).on_hover_text(&path).clicked() {
            *action = Some(StartAction::Recent(shot.clone()));
        }
    }
}

fn recover(ui: &mut Ui, left: &[Unfinished], action: &mut Option<StartAction>) {
    egui::Frame::group(ui.style()).fill(ui.visuals().faint_bg_color).show(ui, |ui| {
        ui.label(RichText::new("The editor ended before these were saved").strong());
        for one in left {
            ui.horizontal(|ui| {
                ui.label(one.path.display().to_string());
                ui.weak(crate::spelling::pluralised(one.history.labels().count(), "change", "changes"));
                if ui.button("Recover").clicked() {
                    *action = Some(StartAction::Recover(one.journal.clone()));
                }
                if ui.button("Forget").clicked() {
                    *action = Some(StartAction::Forget(one.journal.clone()));
                }
            });
        }
    });
}
