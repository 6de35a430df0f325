//! The panels around the picture: timeline, layers, numbers of the pin.
//!
//! In: a [`Session`], the remembered sizes. Out: the sizes of this pass, and whether the user is changing one.

use super::panel_edge::{PanelEdge, Side};
use super::timeline::Timeline;
use super::{inspector, layers, menus};
use crate::edit::{PanelSizes, Session};
use eframe::egui::{Panel, Ui};

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
        ui.add_space(3.0);
        timeline.show(ui, session, now);
    });
    edge.show(ui, shown.response.rect);
    let timeline = Some(shown.response.rect.height());

    let side = |panel: Panel, size: Option<f32>| panel.default_size(size.unwrap_or(width)).size_range(200.0..=420.0);
    let edge = PanelEdge::of(ui, "layers", (Side::Right, "Width of the layers"));
    is_resized |= edge.keyboard(ui);
    let shown = side(Panel::left("layers"), kept.layers).show(ui, |ui| layers::show(ui, session));
    edge.show(ui, shown.response.rect);
    let layers = Some(shown.response.rect.width());

    let edge = PanelEdge::of(ui, "pin", (Side::Left, "Width of the numbers"));
    is_resized |= edge.keyboard(ui);
    let shown = side(Panel::right("pin"), kept.inspector).show(ui, |ui| inspector::show(ui, session));
    edge.show(ui, shown.response.rect);
    (PanelSizes { timeline, layers, inspector: Some(shown.response.rect.width()) }, is_resized)
}
