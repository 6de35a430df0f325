//! Accessible names for widgets that show icons or numbers.

use eframe::egui::Response;

/// Gives a widget an accessible name.
pub(super) trait Accessible {
    /// Sets the name used by screen readers and tests, also shown as a tooltip.
    fn accessible(self, name: &str) -> Self;
}

impl Accessible for Response {
    fn accessible(self, name: &str) -> Self {
        self.accessible_name(name).on_hover_text(name)
    }
}
