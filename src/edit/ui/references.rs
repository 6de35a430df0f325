//! The reference pictures: their settings, and their places in the viewport.
//!
//! In: a [`Session`]. Out: changed settings; pictures with rectangles to draw.

use super::accessible::Accessible;
use crate::edit::{Lens, Picture, Reference, Session};
use eframe::egui::{Color32, Context, DragValue, Rect, ScrollArea, Slider, Ui, vec2};
use std::sync::Arc;
use std::time::Duration;

/// Time after which pictures that are being decoded are asked for again.
const POLL: Duration = Duration::from_millis(15);

/// Shows the submenu of the reference pictures, if there are any, the uppermost first.
pub(super) fn show(ui: &mut Ui, session: &mut Session) {
    if session.references.iter().all(|reference| reference.is_rendered) {
        return;
    }
    ui.separator();
    ui.menu_button("Reference pictures", |ui| {
        let area = ScrollArea::vertical().min_scrolled_height(420.0).max_height(420.0);
        area.show(ui, |ui| settings(ui, session));
    });
}

fn settings(ui: &mut Ui, session: &mut Session) {
    let mut removed = None;
    for (place, reference) in session.references.iter_mut().enumerate().rev().filter(|(_, own)| !own.is_rendered) {
        let name = reference.name();
        ui.push_id(("reference", place), |ui| {
            ui.horizontal(|ui| {
                ui.label(&name);
                if ui.small_button("Remove").accessible(&format!("Remove {name}")).clicked() {
                    removed = Some(place);
                }
            });
            ui.indent("settings", |ui| {
                let opacity = Slider::new(&mut reference.opacity, 0.0..=1.0).text("opacity");
                ui.add(opacity).accessible_name(format!("Opacity of {name}"));
                let side = ui.checkbox(&mut reference.is_above, "above the frame");
                side.accessible_name(format!("{name} above the frame"));
                ui.horizontal(|ui| {
                    ui.label("Right, up, size");
                    let [right, up] = &mut reference.offset;
                    ui.add(DragValue::new(right).speed(0.002)).accessible(&format!("Right of {name}"));
                    ui.add(DragValue::new(up).speed(0.002)).accessible(&format!("Up of {name}"));
                    let size = DragValue::new(&mut reference.scale).range(0.01..=20.0).speed(0.002);
                    ui.add(size).accessible(&format!("Size of {name}"));
                });
            });
        });
    }
    if let Some(place) = removed {
        session.references.remove(place);
    }
}

/// A reference picture to be drawn.
pub(super) struct Laid {
    pub(super) picture: Arc<Picture>,
    pub(super) rect: Rect,
    pub(super) color: Color32,
    pub(super) is_above: bool,
    /// Whether it takes the place of the frame.
    pub(super) is_rendered: bool,
}

/// Returns the reference pictures of the current frame, from the bottom to the top; `None` where a sequence lacks it.
pub(super) fn laid(ctx: &Context, session: &mut Session, (frame, lens): (Rect, &Lens)) -> Vec<Option<Laid>> {
    let (number, lines) = (session.playhead.frame(), lens.frame_height() as f32);
    let laid = session.references.iter_mut().map(|reference| {
        let picture = reference.at(number)?;
        let height = reference.scale * lines;
        let size = vec2(height * picture.size[0] as f32 / picture.size[1].max(1) as f32, height);
        let moved = vec2(reference.offset[0], -reference.offset[1]) * lines;
        let rect = Rect::from_center_size(frame.center() + moved, size);
        Some(Laid {
            picture,
            rect,
            color: Color32::WHITE.gamma_multiply(reference.opacity),
            is_above: reference.is_above,
            is_rendered: reference.is_rendered,
        })
    });
    let laid = laid.collect();
    let faults: Vec<String> = session.references.iter_mut().filter_map(Reference::take_fault).collect();
    faults.into_iter().for_each(|fault| session.say(fault));
    if session.references.iter().any(Reference::is_pending) {
        ctx.request_repaint_after(POLL);
    }
    laid
}
