//! The panels around the picture: timeline, layers, numbers of the pin.
//!
//! In: a [`Session`], the remembered sizes. Out: the sizes of this pass, and whether the user is changing one.

use super::panel_edge::{PanelEdge, Side};
use super::timeline::Timeline;
use super::{inspector, layers, menus};
use crate::edit::{PanelSizes, Session};
use eframe::egui::{Panel, Ui, UiBuilder};

/// Width in points of what stands beside a slider in a panel: its indent, its name and its number.
const BESIDE_SLIDER: f32 = 164.0;

/// Shows the panels. `now`: the time in seconds.
pub(super) fn show(
    ui: &mut Ui,
    session: &mut Session,
    (timeline, now): (&mut Timeline, f64),
    kept: PanelSizes,
) -> (PanelSizes, bool) {
    Panel::bottom("hint").exact_size(26.0).show(ui, |ui| menus::hint(ui, session));
    // A small window leaves room for the picture.
    let window = ui.ctx().content_rect().size();
    let height = (0.25 * window.y).clamp(130.0, 220.0);
    let width = (0.19 * window.x).clamp(200.0, 262.0);
    let mut is_resized = ui.input(|input| input.pointer.any_down());

    let edge = PanelEdge::of(ui, "timeline", (Side::Top, "Height of the timeline"));
    is_resized |= edge.keyboard(ui);
    let panel = Panel::bottom("timeline").resizable(true).default_size(kept.timeline.unwrap_or(height));
    let shown = panel.size_range(110.0..=520.0).show(ui, |ui| {
        fixed(ui, |ui| {
            // Buttons begin below what catches the edge.
            ui.add_space(6.0);
            timeline.show(ui, session, now);
        });
    });
    edge.show(ui, shown.response.rect);
    let timeline = Some(shown.response.rect.height());

    let side = |panel: Panel, size: Option<f32>| panel.default_size(size.unwrap_or(width)).size_range(200.0..=420.0);
    let edge = PanelEdge::of(ui, "layers", (Side::Right, "Width of the layers"));
    is_resized |= edge.keyboard(ui);
    let shown = side(Panel::left("layers"), kept.layers).show(ui, |ui| fixed(ui, |ui| layers::show(ui, session)));
    edge.show(ui, shown.response.rect);
    let layers = Some(shown.response.rect.width());

    let edge = PanelEdge::of(ui, "pin", (Side::Left, "Width of the numbers"));
    is_resized |= edge.keyboard(ui);
    let shown = side(Panel::right("pin"), kept.inspector).show(ui, |ui| fixed(ui, |ui| inspector::show(ui, session)));
    edge.show(ui, shown.response.rect);
    (PanelSizes { timeline, layers, inspector: Some(shown.response.rect.width()) }, is_resized)
}

/// Shows what a panel contains. The panel keeps its size, whatever that is: the picture must not move under the pointer.
fn fixed(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    let rect = ui.available_rect_before_wrap();
    let mut own = ui.new_child(UiBuilder::new().max_rect(rect));
    own.shrink_clip_rect(rect);
    own.spacing_mut().slider_width = (rect.width() - BESIDE_SLIDER).clamp(30.0, own.spacing().slider_width);
    add(&mut own);
    ui.advance_cursor_after_rect(rect);
}
