//! Accessible names for widgets that show icons or numbers, and for the parts of widgets that draw many.

use eframe::egui::accesskit::Action;
use eframe::egui::{Id, Rect, Response, Role, Sense, Ui, WidgetInfo};

/// Gives a widget an accessible name.
pub(super) trait Accessible {
    /// Sets the name used by screen readers and tests, also shown as a tooltip.
    fn accessible(self, name: &str) -> Self;

    /// Sets the name used by screen readers and tests, and a tooltip that says what the widget does.
    fn explained(self, name: &str, hint: &str) -> Self;
}

impl Accessible for Response {
    fn accessible(self, name: &str) -> Self {
        self.accessible_name(name).on_hover_text(name)
    }

    fn explained(self, name: &str, hint: &str) -> Self {
        self.accessible_name(name).on_hover_text(hint)
    }
}

/// A part of a widget, such as a key in a row of keys.
pub(super) struct Part {
    pub(super) id: Id,
    pub(super) rect: Rect,
    /// What screen readers say.
    pub(super) label: String,
    pub(super) is_chosen: bool,
}

/// Makes the parts of a widget known to screen readers. Returns the part that one of them wants to choose, by its place.
///
/// Parts take neither pointer nor focus: the widget has both. While nothing reads the screen this costs nothing.
pub(super) fn parts(ui: &Ui, whole: &Response, parts: impl Iterator<Item = Part>) -> Option<usize> {
    if !ui.ctx().has_accesskit_node(whole.id) {
        return None;
    }
    let (mut wanted, mut current) = (None, None);
    for (place, part) in parts.enumerate() {
        let response = ui.interact(part.rect, part.id, Sense::hover());
        response.widget_info(|| WidgetInfo::selected(Role::ListBoxOption, true, part.is_chosen, &part.label));
        ui.ctx().accesskit_node_builder(part.id, |node| {
            node.add_action(Action::Click);
            node.add_action(Action::Focus);
        });
        let asks = |action| ui.input(|input| input.has_accesskit_action_request(part.id, action));
        if asks(Action::Click) || asks(Action::Focus) {
            wanted = Some(place);
        }
        current = current.or(part.is_chosen.then_some(part.id));
    }
    if let Some(current) = current {
        ui.ctx().accesskit_node_builder(whole.id, |node| node.set_active_descendant(current.accesskit_id()));
    }
    wanted
}
