//! An overlay of the host.
//!
//! In: the handle passed to an overlay's action. Out: its properties and redraw requests.

use super::props::Props;
use super::suites::Suites;
use crate::ofx::api::{InteractHandle, PropertySet};

/// An overlay.
#[derive(Clone, Copy)]
pub(in crate::ofx) struct Interact<'a> {
    pub(in crate::ofx) suites: &'a Suites,
    pub(in crate::ofx) handle: InteractHandle,
}

impl<'a> Interact<'a> {
    /// Returns the key under which data of the overlay is stored.
    pub(in crate::ofx) fn key(self) -> usize {
        self.handle.0 as usize
    }

    /// Returns the overlay's properties; an empty set if the host fails to provide them.
    pub(in crate::ofx) fn props(self) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let Some(get) = self.suites.interact.and_then(|suite| suite.get_property_set) {
            // SAFETY: the host's function with its own handle; the out pointer outlives the call.
            let _stays_null = unsafe { get(self.handle, &raw mut set) };
        }
        Props::new(self.suites.property, set)
    }

    /// Requests a redraw.
    pub(in crate::ofx) fn redraw(self) {
        if let Some(redraw) = self.suites.interact.and_then(|suite| suite.redraw) {
            // SAFETY: the host's function with its own handle.
            let _drawn_later = unsafe { redraw(self.handle) };
        }
    }
}
