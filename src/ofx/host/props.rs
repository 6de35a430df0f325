//! Property access that tolerates missing properties.
//!
//! In: a handle of the host, which may be null. Out: values, or `None`; setting an unknown property has no effect.

use crate::ofx::api::{PropertySet, PropertySuiteV1, Status};
use std::ffi::{CStr, CString, c_char, c_int, c_void};

/// Reads one value of a property.
type Get<T> = Option<unsafe extern "C" fn(PropertySet, *const c_char, c_int, *mut T) -> Status>;
/// Sets one value of a property.
type Set<T> = Option<unsafe extern "C" fn(PropertySet, *const c_char, c_int, T) -> Status>;

/// Marks an out value that the host left unwritten; no property in use takes this value.
const UNWRITTEN: i32 = i32::MIN;

/// A set of properties.
#[derive(Clone, Copy)]
pub(in crate::ofx) struct Props<'a> {
    suite: &'a PropertySuiteV1,
    set: PropertySet,
}

impl<'a> Props<'a> {
    /// Wraps a handle of the host; null is an empty set.
    pub(in crate::ofx) fn new(suite: &'a PropertySuiteV1, set: PropertySet) -> Self {
        Self { suite, set }
    }

    fn get<T>(self, get: Get<T>, name: &CStr, index: usize, mut value: T) -> Option<T> {
        let get = get.filter(|_| !self.set.is_null())?;
        let index = c_int::try_from(index).ok()?;
        // SAFETY: the host's function with its own handle; name and out pointer outlive the call.
        let status = unsafe { get(self.set, name.as_ptr(), index, &raw mut value) };
        status.is_ok().then_some(value)
    }

    /// Reads several values in one call, for hosts that answer OK to a query for a single value but leave it unwritten,
    /// as pyofx does for windows.
    fn get_all<T: Copy, const N: usize>(self, get: Get<T>, name: &CStr, mut values: [T; N]) -> Option<[T; N]> {
        let get = get.filter(|_| !self.set.is_null())?;
        let count = c_int::try_from(N).ok()?;
        // SAFETY: the host's function with its own handle; name and out array, of `count` values, outlive the call.
        let status = unsafe { get(self.set, name.as_ptr(), count, values.as_mut_ptr()) };
        status.is_ok().then_some(values)
    }

    fn set<T>(self, set: Set<T>, name: &CStr, index: usize, value: T) {
        let (Some(set), Ok(index), false) = (set, c_int::try_from(index), self.set.is_null()) else { return };
        // SAFETY: the host's function with its own handle; it copies what `value` may point to.
        let _unknown_to_this_host = unsafe { set(self.set, name.as_ptr(), index, value) };
    }

    /// Returns the first `N` ints of a property; `None` if one is missing.
    pub(in crate::ofx) fn ints<const N: usize>(self, name: &CStr) -> Option<[i32; N]> {
        let mut values = [UNWRITTEN; N];
        for (index, value) in values.iter_mut().enumerate() {
            *value = self.get(self.suite.get_int, name, index, UNWRITTEN)?;
        }
        if values.contains(&UNWRITTEN) {
            let written = self.get_all(self.suite.get_int_n, name, values)?;
            return Some(written).filter(|values| !values.contains(&UNWRITTEN));
        }
        Some(values)
    }

    /// Returns an int.
    pub(in crate::ofx) fn int(self, name: &CStr) -> Option<i32> {
        self.ints(name).map(|[value]| value)
    }

    /// Returns the first `N` doubles of a property; `None` if one is missing or not finite.
    pub(in crate::ofx) fn doubles<const N: usize>(self, name: &CStr) -> Option<[f64; N]> {
        let mut values = [0.0; N];
        for (index, value) in values.iter_mut().enumerate() {
            *value = self.get(self.suite.get_double, name, index, f64::NAN).filter(|value| value.is_finite())?;
        }
        Some(values)
    }

    /// Returns a double.
    pub(in crate::ofx) fn double(self, name: &CStr) -> Option<f64> {
        self.doubles(name).map(|[value]| value)
    }

    /// Returns a string, copied.
    pub(in crate::ofx) fn text(self, name: &CStr) -> Option<String> {
        let text = self.get(self.suite.get_string, name, 0, std::ptr::null_mut())?;
        owned(text)
    }

    /// Returns a pointer; `None` if it is null.
    pub(in crate::ofx) fn pointer(self, name: &CStr) -> Option<*mut c_void> {
        self.get(self.suite.get_pointer, name, 0, std::ptr::null_mut()).filter(|pointer| !pointer.is_null())
    }

    /// Sets an int.
    pub(in crate::ofx) fn set_int(self, name: &CStr, value: i32) {
        self.set(self.suite.set_int, name, 0, value);
    }

    /// Sets ints.
    pub(in crate::ofx) fn set_ints(self, name: &CStr, values: &[i32]) {
        for (index, value) in values.iter().enumerate() {
            self.set(self.suite.set_int, name, index, *value);
        }
    }

    /// Sets doubles.
    pub(in crate::ofx) fn set_doubles(self, name: &CStr, values: &[f64]) {
        for (index, value) in values.iter().enumerate() {
            self.set(self.suite.set_double, name, index, *value);
        }
    }

    /// Sets C strings.
    pub(in crate::ofx) fn set_names(self, name: &CStr, values: &[&CStr]) {
        for (index, value) in values.iter().enumerate() {
            self.set(self.suite.set_string, name, index, value.as_ptr());
        }
    }

    /// Sets Rust strings.
    pub(in crate::ofx) fn set_texts(self, name: &CStr, values: &[&str]) {
        for (index, value) in values.iter().enumerate() {
            self.set(self.suite.set_string, name, index, c_text(value).as_ptr());
        }
    }

    /// Sets a pointer.
    pub(in crate::ofx) fn set_pointer(self, name: &CStr, value: *mut c_void) {
        self.set(self.suite.set_pointer, name, 0, value);
    }
}

/// Copies a string of the host at once: it is valid until the host's next call only.
pub(in crate::ofx) fn owned(text: *const c_char) -> Option<String> {
    if text.is_null() {
        return None;
    }
    // SAFETY: not null, and the host's strings are NUL-terminated.
    let text = unsafe { CStr::from_ptr(text) };
    Some(text.to_string_lossy().into_owned())
}

/// Converts a text to a C string, truncated at the first NUL.
pub(in crate::ofx) fn c_text(text: &str) -> CString {
    CString::new(text.split('\0').next().unwrap_or_default()).unwrap_or_default()
}
