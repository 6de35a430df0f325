//! Number fields and sliders that leave a value as it is until the user changes it.
//!
//! In: a value, its range. Out: the value as edited. The toolkit's own ones clamp and round what they merely show.

use eframe::egui::emath::Numeric;
use eframe::egui::{DragValue, Response, Slider, SliderClamping, Ui};
use std::ops::RangeInclusive;

/// A number as it is shown.
pub(super) struct NumberField<'a> {
    /// The name that screen readers say.
    pub(super) name: &'a str,
    /// The tooltip.
    pub(super) hint: &'a str,
    /// The values that can be typed.
    pub(super) range: RangeInclusive<f64>,
    /// The digits after the point that are shown.
    pub(super) decimals: usize,
}

impl NumberField<'_> {
    /// Shows a field to drag or to type in, styled further by `style`. Returns whether the user changed the value.
    pub(super) fn drag(&self, ui: &mut Ui, value: &mut f64, style: impl FnOnce(DragValue) -> DragValue) -> bool {
        let old = *value;
        let field = DragValue::new(value).range(self.range.clone()).clamp_existing_to_range(false);
        let response = ui.add(style(field.max_decimals(self.decimals)));
        self.is_edited(response, old, value)
    }

    /// Shows a slider, styled further by `style`. Returns whether the user changed the value.
    pub(super) fn slider(&self, ui: &mut Ui, value: &mut f64, style: impl FnOnce(Slider) -> Slider) -> bool {
        let old = *value;
        let slider = Slider::new(value, self.range.clone()).clamping(SliderClamping::Edits);
        let response = ui.add(style(slider.max_decimals(self.decimals)));
        self.is_edited(response, old, value)
    }

    /// Names the widget. Returns whether it changed the value.
    fn is_edited(&self, response: Response, old: f64, value: &mut f64) -> bool {
        let response = response.accessible_name(self.name).on_hover_text(self.hint);
        response.changed() && !(response.lost_focus() && self.is_read_back(old, value))
    }

    /// Returns whether a value is an old one as it was shown, and then restores that one. Whoever enters a field and leaves it
    /// without typing reads back the rounded text.
    fn is_read_back(&self, old: f64, value: &mut f64) -> bool {
        let shown = |value: f64| format!("{value:.*}", self.decimals);
        let is_same = shown(old) == shown(*value);
        if is_same {
            *value = old;
        }
        is_same
    }
}

/// Returns a field of a whole number that leaves values outside its range alone.
pub(super) fn whole<N: Numeric>(value: &mut N, range: RangeInclusive<N>) -> DragValue<'_> {
    DragValue::new(value).range(range).clamp_existing_to_range(false).speed(0.2)
}

#[cfg(test)]
mod tests {
    use super::NumberField;

    #[test]
    fn a_rounded_text_that_is_read_back_is_no_edit() {
        let field = NumberField { name: "a", hint: "", range: 0.0..=1.0, decimals: 2 };
        for (read, is_same, kept) in [(0.12, true, 0.123), (0.13, false, 0.13)] {
            let mut value = read;
            assert_eq!((field.is_read_back(0.123, &mut value), value), (is_same, kept));
        }
    }
}
