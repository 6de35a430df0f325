//! Overlay colours, the same in both themes, as they lie over pictures.

use super::theme::ACCENT;
use eframe::egui::Color32;

/// Lattice lines.
pub(super) const LATTICE: Color32 = Color32::from_rgba_premultiplied(52, 120, 150, 150);
/// Lattice lines of layers that are not selected.
pub(super) const OTHER_LATTICE: Color32 = Color32::from_rgba_premultiplied(40, 46, 50, 60);
/// Handles.
pub(super) const HANDLE: Color32 = Color32::from_rgb(120, 200, 235);
/// Rest positions of pinned points.
pub(super) const REST: Color32 = Color32::from_rgb(205, 205, 205);
/// Pins.
pub(super) const PIN: Color32 = ACCENT;
/// Selected pins.
pub(super) const CHOSEN: Color32 = Color32::WHITE;
/// Outline under lines and text, so that they are visible on any picture.
pub(super) const SHADE: Color32 = Color32::from_rgba_premultiplied(0, 0, 0, 170);
/// Folded cells.
pub(super) const FOLD: Color32 = Color32::from_rgba_premultiplied(150, 14, 14, 150);
/// Outline of a region.
pub(super) const REGION: Color32 = Color32::from_rgb(120, 210, 120);
/// Safe areas and selection boxes.
pub(super) const GUIDE: Color32 = Color32::from_rgba_premultiplied(130, 130, 130, 130);
/// Rings that turn about x, y and z.
pub(super) const AXES: [Color32; 3] =
    [Color32::from_rgb(236, 96, 84), Color32::from_rgb(112, 200, 96), Color32::from_rgb(96, 158, 246)];
