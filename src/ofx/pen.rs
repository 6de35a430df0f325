//! The pen over the overlays of an effect, and which pins are selected.
//!
//! In: handles of effects and overlays. Out: what is kept for them. Nothing here touches the host.

use super::host::Kept;
use crate::live::Picker;

/// The pen of each effect, by its handle.
static PENS: Kept<Pen> = Kept::new();

/// The effect of each overlay, by the overlay's handle.
static EFFECTS: Kept<usize> = Kept::new();

/// The pen over an effect's overlays, and what it selected.
#[derive(Clone, Default)]
pub(super) struct Pen {
    pub(super) picker: Picker,
    /// Shift is held: what is selected stays so.
    pub(super) is_adding: bool,
    /// Pins that are dragged: index, place of pin and target when the pen went down, canonical.
    pub(super) starts: Vec<(usize, [[f64; 2]; 2])>,
    /// An edit that is undone in one step has begun, and has to be ended.
    pub(super) is_editing: bool,
}

impl Pen {
    /// Lets go of keys; whether the pen was up.
    pub(super) fn rest(&mut self) -> bool {
        self.is_adding = false;
        self.picker.is_up()
    }
}

/// The pen of an effect.
pub(super) fn pen_of(effect: usize) -> Pen {
    PENS.get(effect).unwrap_or_default()
}

/// Keeps the pen of an effect, seen through an overlay.
pub(super) fn keep(effect: usize, overlay: usize, pen: Pen) {
    PENS.insert(effect, pen);
    EFFECTS.insert(overlay, effect);
}

/// Changes the pen of an effect.
pub(super) fn change<R>(effect: usize, change: impl FnOnce(&mut Pen) -> R) -> R {
    PENS.update(effect, change)
}

/// The effect that an overlay was last used on.
pub(super) fn effect_of(overlay: usize) -> Option<usize> {
    EFFECTS.get(overlay)
}

/// An overlay closes: its drag is over, and the edit that it began stays open until the effect's next action.
pub(super) fn close(overlay: usize) {
    if let Some(effect) = EFFECTS.remove(overlay) {
        PENS.update(effect, |pen| {
            pen.picker.let_go();
            pen.is_adding = false;
        });
    }
}

/// An effect ends.
pub(super) fn forget(effect: usize) {
    PENS.remove(effect);
    EFFECTS.retain(|of| *of != effect);
}
