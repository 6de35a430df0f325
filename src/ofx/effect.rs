//! An effect of the host: its properties, clips and parameters, and words for its user.
//!
//! In: the handle that comes with an action. Out: values, or a [`Fault`] where the host has nothing there.

use super::api::{ClipHandle, EffectHandle, Message, ParamHandle, ParamSetHandle, PropertySet, RectD};
use super::fault::Fault;
use super::host::Suites;
use super::props::{Props, c_text, owned};
use std::collections::BTreeMap;
use std::ffi::{CStr, c_char, c_int};
use std::sync::{Mutex, PoisonError};

/// What was last said about each effect, by its handle, so that a message does not come with every frame.
static SAID: Mutex<BTreeMap<usize, String>> = Mutex::new(BTreeMap::new());

/// A descriptor or an instance.
#[derive(Clone, Copy)]
pub(super) struct Effect<'a> {
    pub(super) suites: &'a Suites,
    pub(super) handle: EffectHandle,
}

// SAFETY: the API lets a render ask from any of its threads whether it is still wanted.
unsafe impl Sync for Effect<'_> {}

impl<'a> Effect<'a> {
    /// The effect's properties; none where the host fails to give them.
    pub(super) fn props(self) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let Some(get) = self.suites.effect.get_property_set.filter(|_| !self.handle.is_null()) {
            // SAFETY: the host's function with its own handle; the place outlives the call.
            let _stays_null = unsafe { get(self.handle, &raw mut set) };
        }
        Props::new(self.suites, set)
    }

    /// The effect's parameters.
    pub(super) fn params(self) -> Result<Params<'a>, Fault> {
        let mut set = ParamSetHandle::NULL;
        if let Some(get) = self.suites.effect.get_param_set.filter(|_| !self.handle.is_null()) {
            // SAFETY: as in `props`.
            let _stays_null = unsafe { get(self.handle, &raw mut set) };
        }
        if set.is_null() { Err(Fault::Missing("parameters")) } else { Ok(Params { suites: self.suites, set }) }
    }

    /// Declares a clip; its properties.
    pub(super) fn define_clip(self, name: &CStr) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let Some(define) = self.suites.effect.clip_define.filter(|_| !self.handle.is_null()) {
            // SAFETY: as in `props`.
            let _stays_null = unsafe { define(self.handle, name.as_ptr(), &raw mut set) };
        }
        Props::new(self.suites, set)
    }

    /// The clip of a name; `None`: this context has none.
    pub(super) fn clip(self, name: &'static CStr) -> Option<Clip<'a>> {
        let mut handle = ClipHandle::NULL;
        let get = self.suites.effect.clip_get_handle.filter(|_| !self.handle.is_null())?;
        // SAFETY: as in `props`; the place for properties may be null.
        let status = unsafe { get(self.handle, name.as_ptr(), &raw mut handle, std::ptr::null_mut()) };
        (status.is_ok() && !handle.is_null()).then_some(Clip { suites: self.suites, handle, name })
    }

    /// Whether the host wants the result no more.
    pub(super) fn is_aborted(self) -> bool {
        // SAFETY: the host's function with its own handle.
        self.suites.effect.abort.is_some_and(|abort| unsafe { abort(self.handle) } != 0)
    }

    /// Says `text` to the user, once for as long as it stays the same.
    pub(super) fn say(self, kind: &CStr, text: &str) {
        let mut said = SAID.lock().unwrap_or_else(PoisonError::into_inner);
        if said.insert(self.handle.0 as usize, text.to_owned()).is_some_and(|before| before == text) {
            return;
        }
        drop(said);
        let lasting = self.suites.lasting_message.and_then(|suite| suite.set_persistent_message);
        self.tell(lasting.or(self.message()), kind, text);
    }

    /// Says `text` to the user this once.
    pub(super) fn say_once(self, kind: &CStr, text: &str) {
        self.tell(self.message(), kind, text);
    }

    fn message(self) -> Message {
        self.suites.message.and_then(|suite| suite.message)
    }

    fn tell(self, message: Message, kind: &CStr, text: &str) {
        let Some(message) = message else { return };
        let text = c_text(text);
        // SAFETY: the host's function, `printf` style: one "%s" and one string, which outlive the call.
        let _nobody_else_to_tell =
            unsafe { message(self.handle.0, kind.as_ptr(), c"".as_ptr(), c"%s".as_ptr(), text.as_ptr()) };
    }

    /// Takes back what was said, as it no longer holds (or the effect ends).
    pub(super) fn unsay(self) {
        let mut said = SAID.lock().unwrap_or_else(PoisonError::into_inner);
        let clear = self.suites.lasting_message.and_then(|suite| suite.clear_persistent_message);
        if let (Some(_), Some(clear)) = (said.remove(&(self.handle.0 as usize)), clear) {
            drop(said);
            // SAFETY: the host's function with its own handle.
            let _nothing_to_do_about_it = unsafe { clear(self.handle.0) };
        }
    }
}

/// A clip of an instance.
#[derive(Clone, Copy)]
pub(super) struct Clip<'a> {
    pub(super) suites: &'a Suites,
    pub(super) handle: ClipHandle,
    pub(super) name: &'static CStr,
}

impl<'a> Clip<'a> {
    /// The clip's properties.
    pub(super) fn props(self) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let Some(get) = self.suites.effect.clip_get_property_set {
            // SAFETY: the host's function with its own handle; the place outlives the call.
            let _stays_null = unsafe { get(self.handle, &raw mut set) };
        }
        Props::new(self.suites, set)
    }

    /// Where the clip has pixels at a time, canonical; `None`: nowhere, or the host does not say.
    pub(super) fn region(self, time: f64) -> Option<RectD> {
        let mut region = RectD::default();
        let get = self.suites.effect.clip_get_region_of_definition?;
        // SAFETY: the host's function with its own handle; the place outlives the call.
        let status = unsafe { get(self.handle, time, &raw mut region) };
        (status.is_ok() && region.x1 < region.x2 && region.y1 < region.y2).then_some(region)
    }
}

/// When a value is set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum When {
    /// Now: a host makes a key of it where there are others.
    Now,
    /// As a key at a time.
    Key(f64),
}

/// The parameters of a descriptor or of an instance.
#[derive(Clone, Copy)]
pub(super) struct Params<'a> {
    suites: &'a Suites,
    set: ParamSetHandle,
}

impl<'a> Params<'a> {
    /// Declares a parameter; its properties.
    pub(super) fn define(self, kind: &CStr, id: &str) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let Some(define) = self.suites.parameter.define {
            // SAFETY: the host's function with its own handle; strings and place outlive the call.
            let _stays_null = unsafe { define(self.set, kind.as_ptr(), c_text(id).as_ptr(), &raw mut set) };
        }
        Props::new(self.suites, set)
    }

    /// Properties of the whole set.
    pub(super) fn props(self) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let Some(get) = self.suites.parameter.set_get_property_set {
            // SAFETY: as in `define`.
            let _stays_null = unsafe { get(self.set, &raw mut set) };
        }
        Props::new(self.suites, set)
    }

    fn handle(self, id: &str) -> Option<ParamHandle> {
        let mut param = ParamHandle::NULL;
        let get = self.suites.parameter.get_handle?;
        // SAFETY: as in `define`; the place for properties may be null.
        let status = unsafe { get(self.set, c_text(id).as_ptr(), &raw mut param, std::ptr::null_mut()) };
        (status.is_ok() && !param.is_null()).then_some(param)
    }

    /// An int, boolean or choice at a time.
    pub(super) fn int(self, id: &str, time: f64) -> Option<i32> {
        let (param, mut value): (_, c_int) = (self.handle(id)?, 0);
        // SAFETY: the parameter holds one int, for which there is a place.
        unsafe { (self.suites.parameter.get_value_at_time?)(param, time, &raw mut value) }.is_ok().then_some(value)
    }

    /// A double at a time.
    pub(super) fn double(self, id: &str, time: f64) -> Option<f64> {
        let (param, mut value) = (self.handle(id)?, 0.0_f64);
        // SAFETY: the parameter holds one double, for which there is a place.
        let status = unsafe { (self.suites.parameter.get_value_at_time?)(param, time, &raw mut value) };
        (status.is_ok() && value.is_finite()).then_some(value)
    }

    /// A point at a time, canonical.
    pub(super) fn point(self, id: &str, time: f64) -> Option<[f64; 2]> {
        let (param, mut x, mut y) = (self.handle(id)?, 0.0_f64, 0.0_f64);
        // SAFETY: the parameter holds two doubles, for which there are places.
        let status = unsafe { (self.suites.parameter.get_value_at_time?)(param, time, &raw mut x, &raw mut y) };
        (status.is_ok() && x.is_finite() && y.is_finite()).then_some([x, y])
    }

    /// A string at a time.
    pub(super) fn text(self, id: &str, time: f64) -> Option<String> {
        let (param, mut text): (_, *mut c_char) = (self.handle(id)?, std::ptr::null_mut());
        // SAFETY: the parameter holds a string, for whose address there is a place.
        let status = unsafe { (self.suites.parameter.get_value_at_time?)(param, time, &raw mut text) };
        status.is_ok().then(|| owned(text)).flatten()
    }

    /// Properties of a parameter of an instance.
    pub(super) fn props_of(self, id: &str) -> Props<'a> {
        let mut set = PropertySet::NULL;
        if let (Some(param), Some(get)) = (self.handle(id), self.suites.parameter.get_property_set) {
            // SAFETY: the host's function with its own handle; the place outlives the call.
            let _stays_null = unsafe { get(param, &raw mut set) };
        }
        Props::new(self.suites, set)
    }

    /// Sets an int, boolean or choice.
    pub(super) fn set_int(self, id: &str, value: i32) {
        let (Some(param), Some(set)) = (self.handle(id), self.suites.parameter.set_value) else { return };
        // SAFETY: the parameter holds one int.
        let _stays_as_it_was = unsafe { set(param, value) };
    }

    /// Sets a string.
    pub(super) fn set_text(self, id: &str, value: &str) {
        let (Some(param), Some(set)) = (self.handle(id), self.suites.parameter.set_value) else { return };
        let value = c_text(value);
        // SAFETY: the parameter holds a string; the host copies this one.
        let _stays_as_it_was = unsafe { set(param, value.as_ptr()) };
    }

    /// Sets a double, or a key of it.
    pub(super) fn set_double(self, id: &str, value: f64, when: When) {
        let Some(param) = self.handle(id) else { return };
        let _stays_as_it_was = match (when, self.suites.parameter.set_value, self.suites.parameter.set_value_at_time) {
            // SAFETY: the parameter holds one double.
            (When::Now, Some(set), _) => unsafe { set(param, value) },
            // SAFETY: as above.
            (When::Key(time), _, Some(set)) => unsafe { set(param, time, value) },
            _ => return,
        };
    }

    /// Sets a point, canonical, or a key of it.
    pub(super) fn set_point(self, id: &str, [x, y]: [f64; 2], when: When) {
        let Some(param) = self.handle(id) else { return };
        let _stays_as_it_was = match (when, self.suites.parameter.set_value, self.suites.parameter.set_value_at_time) {
            // SAFETY: the parameter holds two doubles.
            (When::Now, Some(set), _) => unsafe { set(param, x, y) },
            // SAFETY: as above.
            (When::Key(time), _, Some(set)) => unsafe { set(param, time, x, y) },
            _ => return,
        };
    }

    /// Removes all keys.
    pub(super) fn delete_keys(self, id: &str) {
        if let (Some(param), Some(delete)) = (self.handle(id), self.suites.parameter.delete_all_keys) {
            // SAFETY: the host's function with its own handle.
            let _had_none = unsafe { delete(param) };
        }
    }

    /// Times of the keys.
    pub(super) fn keys(self, id: &str) -> Vec<f64> {
        let suite = self.suites.parameter;
        let (Some(param), Some(count), Some(get)) = (self.handle(id), suite.get_num_keys, suite.get_key_time) else {
            return Vec::new();
        };
        let mut keys = 0;
        // SAFETY: the host's function with its own handle; the place outlives the call.
        let _stays_none = unsafe { count(param, &raw mut keys) };
        let key = |index| {
            let mut time = 0.0;
            // SAFETY: as above.
            unsafe { get(param, index, &raw mut time) }.is_ok().then_some(time)
        };
        (0..keys).filter_map(key).collect()
    }

    /// Begins a change that the user undoes in one step.
    pub(super) fn begin_edit(self, label: &CStr) {
        if let Some(begin) = self.suites.parameter.edit_begin {
            // SAFETY: the host's function with its own handle and a constant.
            let _undone_in_pieces = unsafe { begin(self.set, label.as_ptr()) };
        }
    }

    /// Ends it.
    pub(super) fn end_edit(self) {
        if let Some(end) = self.suites.parameter.edit_end {
            // SAFETY: the host's function with its own handle.
            let _nothing_to_do_about_it = unsafe { end(self.set) };
        }
    }
}
