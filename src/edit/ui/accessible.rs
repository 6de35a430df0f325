//! Names for widgets whose faces are signs or numbers.

use eframe::egui::Response;

/// A widget whose face is a sign gets a name.
pub(super) trait Accessible {
    /// The name that screen readers and tests know it by, shown on hover, too.
    fn accessible(self, name: &str) -> Self;
}

impl Accessible for Response {
    fn accessible(self, name: &str) -> Self {
        self.accessible_name(name).on_hover_text(name)
    }
}
