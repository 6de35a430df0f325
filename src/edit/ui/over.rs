//! Overlay colours. Most are the same in both themes, as they lie over pictures; lines also lie over what surrounds the model.

use super::theme::ACCENT;
use eframe::egui::{Color32, Visuals};

/// Returns the colour of lattice lines, of the selected layer or of another one.
pub(super) const fn lattice(visuals: &Visuals, is_selected: bool) -> Color32 {
    match (visuals.dark_mode, is_selected) {
        (true, true) => Color32::from_rgba_premultiplied(52, 120, 150, 150),
        (true, false) => Color32::from_rgba_premultiplied(40, 46, 50, 60),
        (false, true) => Color32::from_rgba_premultiplied(0, 40, 76, 225),
        (false, false) => Color32::from_rgba_premultiplied(16, 34, 48, 120),
    }
}

/// Handles.
pub(super) const HANDLE: Color32 = Color32::from_rgb(120, 200, 235);
/// Rest positions of pinned points.
pub(super) const REST: Color32 = Color32::from_rgb(205, 205, 205);
/// Pins.
pub(super) const PIN: Color32 = ACCENT;
/// Pins of layers that are muted in the editor.
pub(super) const MUTED_PIN: Color32 = Color32::from_rgb(112, 96, 78);
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

#[cfg(test)]
mod tests {
    use super::super::theme::{backdrop, dark, light, surroundings};
    use super::*;

    /// The relative luminance of an opaque colour, by WCAG 2.1.
    fn luminance(color: Color32) -> f32 {
        let linear = |code: u8| {
            let value = f32::from(code) / 255.0;
            if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(color.r()) + 0.7152 * linear(color.g()) + 0.0722 * linear(color.b())
    }

    /// The contrast of a colour over an opaque one, by WCAG 2.1.
    fn contrast(above: Color32, below: Color32) -> f32 {
        let [a, b] = [luminance(below.blend(above)), luminance(below)];
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn words_and_lines_stand_out_in_both_themes() {
        assert!((contrast(Color32::WHITE, Color32::BLACK) - 21.0).abs() < 1e-3);
        for visuals in [dark(), light()] {
            let fills = [
                visuals.panel_fill,
                visuals.window_fill,
                visuals.faint_bg_color,
                visuals.widgets.inactive.weak_bg_fill,
            ];
            for fill in fills {
                let found = [visuals.weak_text_color(), visuals.text_color()].map(|text| contrast(text, fill));
                assert!(found.iter().all(|found| *found >= 4.5), "{found:?} over {fill:?}");
            }
            for fill in [backdrop(&visuals), surroundings(&visuals)] {
                let found = contrast(lattice(&visuals, true), fill);
                assert!(found >= 3.0, "{found} over {fill:?}");
            }
        }
    }
}
