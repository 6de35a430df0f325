//! The bar over the picture while rendered frames are shown in place of it.
//!
//! In: a [`Session`]. Out: the way back to the frame.

use crate::edit::Session;
use eframe::egui::{Align2, Area, Frame, Id, Order, Rect, Ui, vec2};

/// Shows the bar at the top of the viewport.
pub(super) fn show(ui: &Ui, viewport: Rect, session: &mut Session) {
    let Some(shown) = session.references.iter_mut().find(|reference| reference.is_rendered) else { return };
    let words = match shown.at(session.playhead.frame()).is_some() || shown.is_pending() {
        true => format!("Showing rendered frames: {}", shown.name()),
        false => format!("This frame was not rendered: {}", shown.name()),
    };
    let area = Area::new(Id::unique("rendered frames")).order(Order::Middle).pivot(Align2::CENTER_TOP);
    area.fixed_pos(viewport.center_top() + vec2(0.0, 10.0)).show(ui.ctx(), |ui| {
        Frame::popup(ui.style()).show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.strong(words);
                let hint = "Back to the frame as it is edited; so do Escape, a click on the picture and the next edit";
                if ui.button("Back to editing").on_hover_text(hint).clicked() {
                    session.leave_rendered();
                }
            });
        });
    });
}
