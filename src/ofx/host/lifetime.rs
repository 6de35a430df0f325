//! Tracks destroyed effects, whose handles must not be used any more.
//!
//! In: creation and destruction of effects. Out: whether one has been destroyed. Hosts destroy overlays after their
//! effects, and call actions on effects that are partly destroyed (Natron at the end of a session).

use super::kept::Kept;
use super::messages;
use crate::ofx::api::EffectHandle;

/// Destroyed effects, by handle.
static ENDED: Kept<()> = Kept::new();

/// Marks a handle as in use; hosts reuse addresses.
pub(in crate::ofx) fn begin_effect(handle: EffectHandle) {
    ENDED.remove(handle.0 as usize);
    messages::forget(handle);
}

/// Marks an effect as destroyed.
pub(in crate::ofx) fn end_effect(handle: EffectHandle) {
    messages::forget(handle);
    ENDED.insert(handle.0 as usize, ());
}

/// Returns whether the effect of a handle has been destroyed.
pub(in crate::ofx) fn has_ended(handle: EffectHandle) -> bool {
    ENDED.get(handle.0 as usize).is_some()
}
