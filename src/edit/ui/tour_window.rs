//! The window of the tour.

use crate::edit::{Session, Tour};
use eframe::egui::{self, Align2, vec2};

/// Shows the step of the tour. Returns false once the tour is left.
pub(super) fn show(ctx: &egui::Context, tour: &mut Tour, session: &Session) -> bool {
    let [place, count] = tour.place();
    let [title, text] = tour.words(session);
    let (mut is_open, mut is_next) = (true, false);
    let window = egui::Window::new("Tour").title_bar(false).collapsible(false).resizable(false).default_width(330.0);
    window.anchor(Align2::CENTER_TOP, vec2(0.0, 44.0)).show(ctx, |ui| {
        ui.horizontal(|ui| {
            ui.strong(title);
            ui.weak(format!("{place} of {count}"));
        });
        ui.label(text);
        ui.horizontal(|ui| {
            if place < count {
                is_next = ui.button("Skip this step").clicked();
            }
            is_open = !ui.button("End the tour").clicked();
        });
    });
    if is_next {
        tour.skip(session);
    }
    is_open
}
