//! The edge of a panel by keyboard: with focus, arrow keys move it.
//!
//! In: key events, before the panel is shown. Out: the toolkit's own requests to resize the panel, and a name for
//! screen readers.

use super::arrow_keys::{self, Arrow, With};
use super::theme::ACCENT;
use eframe::egui::accesskit::{Action, ActionData, ActionRequest, TreeId};
use eframe::egui::containers::panel::PanelState;
use eframe::egui::{Event, Id, Rect, Stroke, Ui};

/// Points by which an arrow key moves an edge, alone and with Shift.
const STEPS: [f32; 2] = [10.0, 50.0];

/// The side of a panel on which its edge lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
    Top,
}

impl Side {
    /// Returns the points by which an arrow key resizes the panel.
    fn growth(self, Arrow { way: [right, up], with }: Arrow) -> f32 {
        let steps = match self {
            Self::Left => -right,
            Self::Right => right,
            Self::Top => up,
        };
        STEPS[usize::from(with == With::Shift)] * steps as f32
    }
}

/// The edge of a resizable panel.
pub(super) struct PanelEdge {
    panel: Id,
    /// The toolkit's widget.
    id: Id,
    side: Side,
    name: &'static str,
}

impl PanelEdge {
    /// Finds the edge of a panel by the panel's id; `name` is what screen readers say.
    pub(super) fn of(ui: &Ui, panel: &str, (side, name): (Side, &'static str)) -> Self {
        let panel = ui.scope_id().with(panel);
        Self { panel, id: panel.with("__resize"), side, name }
    }

    /// Handles the arrow keys. Returns whether a key or a screen reader resizes the panel in this pass.
    pub(super) fn keyboard(&self, ui: &Ui) -> bool {
        let arrows = ui.ctx().read_response(self.id).map_or_else(Vec::new, |response| arrow_keys::take(ui, &response));
        let by: f32 = arrows.into_iter().map(|arrow| self.side.growth(arrow)).sum();
        if let Some(state) = PanelState::load(ui.ctx(), self.panel).filter(|_| by != 0.0) {
            let (size, available) = (state.size(), ui.available_rect_before_wrap().size());
            let share = match self.side {
                Side::Left | Side::Right => (size.x + by) / available.x.max(1.0),
                Side::Top => (size.y + by) / available.y.max(1.0),
            };
            let data = Some(ActionData::NumericValue(share.into()));
            let (action, target_node, target_tree) = (Action::SetValue, self.id.accesskit_id(), TreeId::ROOT);
            let request = ActionRequest { action, target_tree, target_node, data };
            ui.input_mut(|input| input.events.push(Event::AccessKitActionRequest(request)));
        }
        let kinds = [Action::SetValue, Action::Increment, Action::Decrement];
        ui.input(|input| kinds.iter().any(|&kind| input.has_accesskit_action_request(self.id, kind)))
    }

    /// Names the edge, and marks it if it has focus. `panel`: the panel as shown.
    pub(super) fn show(&self, ui: &Ui, panel: Rect) {
        let size = if self.side == Side::Top { panel.height() } else { panel.width() };
        ui.ctx().accesskit_node_builder(self.id, |node| {
            node.set_label(self.name);
            node.set_value(format!("{size:.0} points"));
        });
        if ui.ctx().memory(|memory| memory.has_focus(self.id)) {
            let stroke = Stroke::new(2.0, ACCENT);
            match self.side {
                Side::Left => ui.painter().vline(panel.left() + 1.0, panel.y_range(), stroke),
                Side::Right => ui.painter().vline(panel.right() - 1.0, panel.y_range(), stroke),
                Side::Top => ui.painter().hline(panel.x_range(), panel.top() + 1.0, stroke),
            };
        }
    }
}
