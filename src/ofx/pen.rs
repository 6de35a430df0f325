//! The state of the pen over an effect's overlays, and the selected pins.
//!
//! In: handles of effects and overlays. Out: their stored state. The host is never called from here.

use super::host::Kept;
use crate::live::Picker;

/// The pen of each effect, by its handle.
static PENS: Kept<Pen> = Kept::new();

/// The effect of each overlay, by the overlay's handle.
static EFFECTS: Kept<usize> = Kept::new();

/// The pen over an effect's overlays, and the selection.
#[derive(Clone, Default)]
pub(super) struct Pen {
    pub(super) picker: Picker,
    /// Whether Shift is held, so that clicks extend the selection.
    pub(super) is_adding: bool,
    /// Pins being dragged: index, and positions of pin and target when the drag began, canonical.
    pub(super) starts: Vec<(usize, [[f64; 2]; 2])>,
    /// Whether an undo block is open and has to be ended.
    pub(super) is_editing: bool,
}

impl Pen {
    /// Releases held keys; returns whether the pen was up.
    pub(super) fn rest(&mut self) -> bool {
        self.is_adding = false;
        self.picker.is_up()
    }
}

/// Returns the pen of an effect.
pub(super) fn pen_of(effect: usize) -> Pen {
    PENS.get(effect).unwrap_or_default()
}

/// Stores the pen of an effect, used through an overlay.
pub(super) fn keep(effect: usize, overlay: usize, pen: Pen) {
    PENS.insert(effect, pen);
    EFFECTS.insert(overlay, effect);
}

/// Modifies the pen of an effect.
pub(super) fn change<R>(effect: usize, change: impl FnOnce(&mut Pen) -> R) -> R {
    PENS.update(effect, change)
}

/// Returns the effect that an overlay was last used on.
pub(super) fn effect_of(overlay: usize) -> Option<usize> {
    EFFECTS.get(overlay)
}

/// Closes an overlay: its drag ends, but its undo block stays open until the effect's next action.
pub(super) fn close(overlay: usize) {
    if let Some(effect) = EFFECTS.remove(overlay) {
        PENS.update(effect, |pen| {
            pen.picker.let_go();
            pen.is_adding = false;
        });
    }
}

/// Forgets a destroyed effect.
pub(super) fn forget(effect: usize) {
    PENS.remove(effect);
    EFFECTS.retain(|of| *of != effect);
}
