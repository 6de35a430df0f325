//! An effect of the host: its properties and clips.
//!
//! In: the handle that comes with an action. Out: values, or a [`HostError`] where the host has nothing there.

use super::error::HostError;
use super::param_set::Params;
use super::props::Props;
use super::suites::Suites;
use crate::ofx::api::{ClipHandle, EffectHandle, ParamSetHandle, PropertySet, RectD};
use std::ffi::CStr;

/// A descriptor or an instance.
#[derive(Clone, Copy)]
pub(in crate::ofx) struct Effect<'a> {
    pub(in crate::ofx) suites: &'a Suites,
    pub(in crate::ofx) handle: EffectHandle,
}

// SAFETY: the API lets a render ask from any of its threads whether it is still wanted.
unsafe impl Sync for Effect<'_> {}

impl<'a> Effect<'a> {
    /// What is kept for the effect is kept under this number.
    pub(in crate::ofx) fn key(self) -> usize {
        self.handle.0 as usize
    }

    /// The effect's properties; none where the host fails to give them.
    pub(in crate::ofx) fn props(self) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let Some(get) = self.suites.effect.get_property_set.filter(|_| !self.handle.is_null()) {
            // SAFETY: the host's function with its own handle; the place outlives the call.
            let _stays_null = unsafe { get(self.handle, &raw mut set) };
        }
        Props::new(self.suites.property, set)
    }

    /// The effect's parameters.
    pub(in crate::ofx) fn params(self) -> Result<Params<'a>, HostError> {
        let mut set = ParamSetHandle::NULL;
        if let Some(get) = self.suites.effect.get_param_set.filter(|_| !self.handle.is_null()) {
            // SAFETY: as in `props`.
            let _stays_null = unsafe { get(self.handle, &raw mut set) };
        }
        if set.is_null() { Err(HostError::Missing("parameters")) } else { Ok(Params::new(self.suites, set)) }
    }

    /// Declares a clip; its properties.
    pub(in crate::ofx) fn define_clip(self, name: &CStr) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let Some(define) = self.suites.effect.clip_define.filter(|_| !self.handle.is_null()) {
            // SAFETY: as in `props`.
            let _stays_null = unsafe { define(self.handle, name.as_ptr(), &raw mut set) };
        }
        Props::new(self.suites.property, set)
    }

    /// The clip of a name; `None`: this context has none.
    pub(in crate::ofx) fn clip(self, name: &'static CStr) -> Option<Clip<'a>> {
        let mut handle = ClipHandle::NULL;
        let get = self.suites.effect.clip_get_handle.filter(|_| !self.handle.is_null())?;
        // SAFETY: as in `props`; the place for properties may be null.
        let status = unsafe { get(self.handle, name.as_ptr(), &raw mut handle, std::ptr::null_mut()) };
        (status.is_ok() && !handle.is_null()).then_some(Clip { suites: self.suites, handle, name })
    }

    /// Whether the host wants the result no more.
    pub(in crate::ofx) fn is_aborted(self) -> bool {
        // SAFETY: the host's function with its own handle.
        self.suites.effect.abort.is_some_and(|abort| unsafe { abort(self.handle) } != 0)
    }
}

/// A clip of an instance.
#[derive(Clone, Copy)]
pub(in crate::ofx) struct Clip<'a> {
    pub(in crate::ofx) suites: &'a Suites,
    pub(in crate::ofx) handle: ClipHandle,
    pub(in crate::ofx) name: &'static CStr,
}

impl<'a> Clip<'a> {
    /// The clip's properties.
    pub(in crate::ofx) fn props(self) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let Some(get) = self.suites.effect.clip_get_property_set {
            // SAFETY: the host's function with its own handle; the place outlives the call.
            let _stays_null = unsafe { get(self.handle, &raw mut set) };
        }
        Props::new(self.suites.property, set)
    }

    /// Where the clip has pixels at a time: left, lower, right, upper edge, canonical; `None`: nowhere, or the host does
    /// not say.
    pub(in crate::ofx) fn region(self, time: f64) -> Option<[f64; 4]> {
        let mut region = RectD::default();
        let get = self.suites.effect.clip_get_region_of_definition?;
        // SAFETY: the host's function with its own handle; the place outlives the call.
        let status = unsafe { get(self.handle, time, &raw mut region) };
        let RectD { x1, y1, x2, y2 } = region;
        (status.is_ok() && x1 < x2 && y1 < y2).then_some([x1, y1, x2, y2])
    }
}
