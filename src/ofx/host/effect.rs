//! An effect of the host: its properties and clips.
//!
//! In: the handle passed to an action. Out: values, or a [`HostError`] if the host has none.

use super::error::HostError;
use super::param_set::Params;
use super::props::Props;
use super::suites::Suites;
use crate::ofx::api::{ClipHandle, EffectHandle, ParamSetHandle, PropertySet, RectD};
use std::ffi::CStr;

/// An effect descriptor or instance.
#[derive(Clone, Copy)]
pub(in crate::ofx) struct Effect<'a> {
    pub(in crate::ofx) suites: &'a Suites,
    pub(in crate::ofx) handle: EffectHandle,
}

// SAFETY: the API allows the abort query from any thread of a render.
unsafe impl Sync for Effect<'_> {}

impl<'a> Effect<'a> {
    /// Returns the key under which data of the effect is stored.
    pub(in crate::ofx) fn key(self) -> usize {
        self.handle.0 as usize
    }

    /// Returns the effect's properties; an empty set if the host fails to provide them.
    pub(in crate::ofx) fn props(self) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let Some(get) = self.suites.effect.get_property_set.filter(|_| !self.handle.is_null()) {
            // SAFETY: the host's function with its own handle; the out pointer outlives the call.
            let _stays_null = unsafe { get(self.handle, &raw mut set) };
        }
        Props::new(self.suites.property, set)
    }

    /// Returns the effect's parameters.
    pub(in crate::ofx) fn params(self) -> Result<Params<'a>, HostError> {
        let mut set = ParamSetHandle::NULL;
        if let Some(get) = self.suites.effect.get_param_set.filter(|_| !self.handle.is_null()) {
            // SAFETY: as in `props`.
            let _stays_null = unsafe { get(self.handle, &raw mut set) };
        }
        if set.is_null() { Err(HostError::Missing("parameters")) } else { Ok(Params::new(self.suites, set)) }
    }

    /// Declares a clip and returns its properties.
    pub(in crate::ofx) fn define_clip(self, name: &CStr) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let Some(define) = self.suites.effect.clip_define.filter(|_| !self.handle.is_null()) {
            // SAFETY: as in `props`.
            let _stays_null = unsafe { define(self.handle, name.as_ptr(), &raw mut set) };
        }
        Props::new(self.suites.property, set)
    }

    /// Returns a clip by name; `None` if this context does not have it.
    pub(in crate::ofx) fn clip(self, name: &'static CStr) -> Option<Clip<'a>> {
        let mut handle = ClipHandle::NULL;
        let get = self.suites.effect.clip_get_handle.filter(|_| !self.handle.is_null())?;
        // SAFETY: as in `props`; the pointer for properties may be null.
        let status = unsafe { get(self.handle, name.as_ptr(), &raw mut handle, std::ptr::null_mut()) };
        (status.is_ok() && !handle.is_null()).then_some(Clip { suites: self.suites, handle, name })
    }

    /// Returns whether the host no longer needs the result.
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
    /// Returns the clip's properties.
    pub(in crate::ofx) fn props(self) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let Some(get) = self.suites.effect.clip_get_property_set {
            // SAFETY: the host's function with its own handle; the out pointer outlives the call.
            let _stays_null = unsafe { get(self.handle, &raw mut set) };
        }
        Props::new(self.suites.property, set)
    }

    /// Returns the clip's region of definition at a time: left, bottom, right, top, canonical; `None` if it is empty or
    /// unknown.
    pub(in crate::ofx) fn region(self, time: f64) -> Option<[f64; 4]> {
        let mut region = RectD::default();
        let get = self.suites.effect.clip_get_region_of_definition?;
        // SAFETY: the host's function with its own handle; the out pointer outlives the call.
        let status = unsafe { get(self.handle, time, &raw mut region) };
        let RectD { x1, y1, x2, y2 } = region;
        (status.is_ok() && x1 < x2 && y1 < y2).then_some([x1, y1, x2, y2])
    }
}
