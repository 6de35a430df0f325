//! Handles whose effects have ended: nothing of the host is touched through them any more.
//!
//! In: the beginning and end of effects. Out: whether one has ended. Hosts destroy overlays after their effects, and send
//! actions to effects that are half gone (Natron at the end of a session).

use super::kept::Kept;
use super::messages;
use crate::ofx::api::EffectHandle;

/// Effects that have ended, by handle.
static ENDED: Kept<()> = Kept::new();

/// A handle is in use, perhaps again: hosts reuse addresses.
pub(in crate::ofx) fn begin_effect(handle: EffectHandle) {
    ENDED.remove(handle.0 as usize);
    messages::forget(handle);
}

/// An effect ends.
pub(in crate::ofx) fn end_effect(handle: EffectHandle) {
    messages::forget(handle);
    ENDED.insert(handle.0 as usize, ());
}

/// Whether the effect of a handle has ended.
pub(in crate::ofx) fn has_ended(handle: EffectHandle) -> bool {
    ENDED.get(handle.0 as usize).is_some()
}
