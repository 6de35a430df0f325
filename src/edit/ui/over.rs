//! Colours of what is drawn over pictures: the same in both themes, because pictures are.

use super::theme::ACCENT;
use eframe::egui::Color32;

/// Lines of lattices.
pub(super) const LATTICE: Color32 = Color32::from_rgba_premultiplied(52, 120, 150, 150);
/// Of layers that are not chosen.
pub(super) const OTHER_LATTICE: Color32 = Color32::from_rgba_premultiplied(40, 46, 50, 60);
/// Handles.
pub(super) const HANDLE: Color32 = Color32::from_rgb(120, 200, 235);
/// Where pinned points rest.
pub(super) const REST: Color32 = Color32::from_rgb(205, 205, 205);
/// Pins.
pub(super) const PIN: Color32 = ACCENT;
/// Chosen pins.
pub(super) const CHOSEN: Color32 = Color32::WHITE;
/// Under lines and letters, so that they are seen on any picture.
pub(super) const SHADE: Color32 = Color32::from_rgba_premultiplied(0, 0, 0, 170);
/// Cells that fold.
pub(super) const FOLD: Color32 = Color32::from_rgba_premultiplied(150, 14, 14, 150);
/// The rim of a region.
pub(super) const REGION: Color32 = Color32::from_rgb(120, 210, 120);
/// Safe areas and boxes.
pub(super) const GUIDE: Color32 = Color32::from_rgba_premultiplied(130, 130, 130, 130);
