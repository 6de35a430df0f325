//! The parameters of an effect: declaration, values, keys and undo blocks.
//!
//! In: the id of a parameter. Out: values; `None` if the host has none or it is not finite.

use super::props::{Props, c_text, owned};
use super::suites::Suites;
use crate::ofx::api::names::param;
use crate::ofx::api::{ParamHandle, ParamSetHandle, PropertySet};
use std::ffi::{CStr, c_char, c_int};

/// When a value is set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::ofx) enum When {
    /// The current time: the host makes it a key if the parameter is animated.
    Now,
    /// A key at this time.
    Key(f64),
}

/// The parameters of a descriptor or instance.
#[derive(Clone, Copy)]
pub(in crate::ofx) struct Params<'a> {
    suites: &'a Suites,
    set: ParamSetHandle,
}

impl<'a> Params<'a> {
    /// Wraps a handle of the host, which must not be null.
    pub(super) fn new(suites: &'a Suites, set: ParamSetHandle) -> Self {
        Self { suites, set }
    }

    /// Declares a parameter and returns its properties.
    pub(in crate::ofx) fn define(self, kind: &CStr, id: &str) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let Some(define) = self.suites.parameter.define {
            // SAFETY: the host's function with its own handle; strings and out pointer outlive the call.
            let _stays_null = unsafe { define(self.set, kind.as_ptr(), c_text(id).as_ptr(), &raw mut set) };
        }
        Props::new(self.suites.property, set)
    }

    /// Returns the properties of the whole set.
    pub(in crate::ofx) fn props(self) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let Some(get) = self.suites.parameter.set_get_property_set {
            // SAFETY: as in `define`.
            let _stays_null = unsafe { get(self.set, &raw mut set) };
        }
        Props::new(self.suites.property, set)
    }

    fn handle(self, id: &str) -> Option<ParamHandle> {
        let mut param = ParamHandle::NULL;
        let get = self.suites.parameter.get_handle?;
        // SAFETY: as in `define`; the pointer for properties may be null.
        let status = unsafe { get(self.set, c_text(id).as_ptr(), &raw mut param, std::ptr::null_mut()) };
        (status.is_ok() && !param.is_null()).then_some(param)
    }

    /// Returns an int, boolean or choice at a time.
    pub(in crate::ofx) fn int(self, id: &str, time: f64) -> Option<i32> {
        let (param, mut value): (_, c_int) = (self.handle(id)?, 0);
        // SAFETY: the parameter holds one int, and so does the out pointer.
        unsafe { (self.suites.parameter.get_value_at_time?)(param, time, &raw mut value) }.is_ok().then_some(value)
    }

    /// Returns a double at a time.
    pub(in crate::ofx) fn double(self, id: &str, time: f64) -> Option<f64> {
        let (param, mut value) = (self.handle(id)?, 0.0_f64);
        // SAFETY: the parameter holds one double, and so does the out pointer.
        let status = unsafe { (self.suites.parameter.get_value_at_time?)(param, time, &raw mut value) };
        (status.is_ok() && value.is_finite()).then_some(value)
    }

    /// Returns a position at a time, canonical.
    pub(in crate::ofx) fn point(self, id: &str, time: f64) -> Option<[f64; 2]> {
        let (param, mut at) = (self.handle(id)?, [0.0_f64; 2]);
        // pyofx writes both values through the first pointer: both pointers are valid for the whole array.
        let x = at.as_mut_ptr();
        let y = x.wrapping_add(1);
        // SAFETY: the parameter holds two doubles, and so does the array; a host may write both through the first
        // pointer.
        let status = unsafe { (self.suites.parameter.get_value_at_time?)(param, time, x, y) };
        (status.is_ok() && at.iter().all(|value| value.is_finite())).then_some(at)
    }

    /// Returns a string at a time.
    pub(in crate::ofx) fn text(self, id: &str, time: f64) -> Option<String> {
        let (param, mut text): (_, *mut c_char) = (self.handle(id)?, std::ptr::null_mut());
        // SAFETY: the parameter holds a string, whose address the out pointer receives.
        let status = unsafe { (self.suites.parameter.get_value_at_time?)(param, time, &raw mut text) };
        status.is_ok().then(|| owned(text)).flatten()
    }

    /// Returns the properties of a parameter of an instance.
    pub(in crate::ofx) fn props_of(self, id: &str) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let (Some(param), Some(get)) = (self.handle(id), self.suites.parameter.get_property_set) {
            // SAFETY: the host's function with its own handle; the out pointer outlives the call.
            let _stays_null = unsafe { get(param, &raw mut set) };
        }
        Props::new(self.suites.property, set)
    }

    /// Sets an int, boolean or choice.
    pub(in crate::ofx) fn set_int(self, id: &str, value: i32) {
        let (Some(param), Some(set)) = (self.handle(id), self.suites.parameter.set_value) else { return };
        // SAFETY: the parameter holds one int.
        let _stays_as_it_was = unsafe { set(param, value) };
    }

    /// Sets a string.
    pub(in crate::ofx) fn set_text(self, id: &str, value: &str) {
        let (Some(param), Some(set)) = (self.handle(id), self.suites.parameter.set_value) else { return };
        let value = c_text(value);
        // SAFETY: the parameter holds a string; the host copies this one.
        let _stays_as_it_was = unsafe { set(param, value.as_ptr()) };
    }

    /// Sets a double, or a key of one.
    pub(in crate::ofx) fn set_double(self, id: &str, value: f64, when: When) {
        let Some(param) = self.handle(id) else { return };
        let _stays_as_it_was = match (when, self.suites.parameter.set_value, self.suites.parameter.set_value_at_time) {
            // SAFETY: the parameter holds one double.
            (When::Now, Some(set), _) => unsafe { set(param, value) },
            // SAFETY: as above.
            (When::Key(time), _, Some(set)) => unsafe { set(param, time, value) },
            _ => return,
        };
    }

    /// Sets a position, canonical, or a key of one.
    pub(in crate::ofx) fn set_point(self, id: &str, [x, y]: [f64; 2], when: When) {
        let Some(param) = self.handle(id) else { return };
        let _stays_as_it_was = match (when, self.suites.parameter.set_value, self.suites.parameter.set_value_at_time) {
            // SAFETY: the parameter holds two doubles.
            (When::Now, Some(set), _) => unsafe { set(param, x, y) },
            // SAFETY: as above.
            (When::Key(time), _, Some(set)) => unsafe { set(param, time, x, y) },
            _ => return,
        };
    }

    /// Deletes all keys, if the host can be asked safely.
    pub(in crate::ofx) fn delete_keys(self, id: &str) {
        if self.suites.are_fragile() {
            return;
        }
        if let (Some(param), Some(delete)) = (self.handle(id), self.suites.parameter.delete_all_keys) {
            // SAFETY: the host's function with its own handle.
            let _had_none = unsafe { delete(param) };
        }
    }

    /// Returns the times of the keys; empty if the parameter is not animated, or the host cannot be asked safely.
    pub(in crate::ofx) fn keys(self, id: &str) -> Vec<f64> {
        let suite = self.suites.parameter;
        let told = self.props_of(id).int(param::IS_ANIMATING);
        if told == Some(0) || told.is_none() && self.suites.are_fragile() {
            return Vec::new();
        }
        let (Some(param), Some(count), Some(get)) = (self.handle(id), suite.get_num_keys, suite.get_key_time) else {
            return Vec::new();
        };
        let mut keys = 0;
        // SAFETY: the host's function with its own handle; the out pointer outlives the call.
        let _stays_none = unsafe { count(param, &raw mut keys) };
        let key = |index| {
            let mut time = 0.0;
            // SAFETY: as above.
            unsafe { get(param, index, &raw mut time) }.is_ok().then_some(time)
        };
        (0..keys).filter_map(key).collect()
    }

    /// Begins an undo block.
    pub(in crate::ofx) fn begin_edit(self, label: &CStr) {
        if let Some(begin) = self.suites.parameter.edit_begin {
            // SAFETY: the host's function with its own handle and a constant.
            let _undone_in_pieces = unsafe { begin(self.set, label.as_ptr()) };
        }
    }

    /// Ends the undo block.
    pub(in crate::ofx) fn end_edit(self) {
        if let Some(end) = self.suites.parameter.edit_end {
            // SAFETY: the host's function with its own handle.
            let _nothing_to_do_about_it = unsafe { end(self.set) };
        }
    }
}
