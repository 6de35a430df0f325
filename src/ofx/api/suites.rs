//! Suites: tables of the host's functions. Any entry may be null, so each is an `Option`.
//!
//! In: nothing. Out: layouts with asserted offsets.
//!
//! Functions declared with `...` are variadic in C and must be called as such: their arguments are promoted as in C.

use super::{
    ClipHandle, DrawContextHandle, EffectHandle, InteractHandle, MemoryHandle, ParamHandle, ParamSetHandle, PointD,
    PropertySet, RangeD, RectD, RgbaColour, Status,
};
use std::ffi::{c_char, c_int, c_uint, c_void};
use std::mem::offset_of;

/// Sets one value. Arguments: property set, name, index, value.
type SetOne<T> = Option<unsafe extern "C" fn(PropertySet, *const c_char, c_int, T) -> Status>;
/// Sets the first values. Arguments: property set, name, count, array of values.
type SetMany<T> = Option<unsafe extern "C" fn(PropertySet, *const c_char, c_int, *const T) -> Status>;
/// Reads one value. Arguments: property set, name, index, where to write the value.
type GetOne<T> = Option<unsafe extern "C" fn(PropertySet, *const c_char, c_int, *mut T) -> Status>;

/// The Property suite: named arrays of pointers, strings, doubles or ints. Strings that are read belong to the host and
/// are valid until its next call.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct PropertySuiteV1 {
    /// Sets one pointer.
    pub set_pointer: SetOne<*mut c_void>,
    /// Sets one string; the host copies it.
    pub set_string: SetOne<*const c_char>,
    /// Sets one double.
    pub set_double: SetOne<f64>,
    /// Sets one int.
    pub set_int: SetOne<c_int>,
    /// Sets pointers.
    pub set_pointer_n: SetMany<*mut c_void>,
    /// Sets strings.
    pub set_string_n: SetMany<*const c_char>,
    /// Sets doubles.
    pub set_double_n: SetMany<f64>,
    /// Sets ints.
    pub set_int_n: SetMany<c_int>,
    /// Reads one pointer.
    pub get_pointer: GetOne<*mut c_void>,
    /// Reads one string.
    pub get_string: GetOne<*mut c_char>,
    /// Reads one double.
    pub get_double: GetOne<f64>,
    /// Reads one int.
    pub get_int: GetOne<c_int>,
    /// Reads the first pointers: count, where to write them.
    pub get_pointer_n: GetOne<*mut c_void>,
    /// Reads the first strings.
    pub get_string_n: GetOne<*mut c_char>,
    /// Reads the first doubles.
    pub get_double_n: GetOne<f64>,
    /// Reads the first ints.
    pub get_int_n: GetOne<c_int>,
    /// Resets a property to its default.
    pub reset: Option<unsafe extern "C" fn(PropertySet, *const c_char) -> Status>,
    /// Reads the number of values of a property.
    pub get_dimension: Option<unsafe extern "C" fn(PropertySet, *const c_char, *mut c_int) -> Status>,
}

/// The Image Effect suite: effects, their clips and images.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct ImageEffectSuiteV1 {
    /// Gets the properties of an effect.
    pub get_property_set: Option<unsafe extern "C" fn(EffectHandle, *mut PropertySet) -> Status>,
    /// Gets the parameter set of an effect.
    pub get_param_set: Option<unsafe extern "C" fn(EffectHandle, *mut ParamSetHandle) -> Status>,
    /// Declares a clip while a context is described; returns the clip's properties.
    pub clip_define: Option<unsafe extern "C" fn(EffectHandle, *const c_char, *mut PropertySet) -> Status>,
    /// Gets a clip by name; the last argument, for its properties, may be null.
    pub clip_get_handle:
        Option<unsafe extern "C" fn(EffectHandle, *const c_char, *mut ClipHandle, *mut PropertySet) -> Status>,
    /// Gets the properties of a clip.
    pub clip_get_property_set: Option<unsafe extern "C" fn(ClipHandle, *mut PropertySet) -> Status>,
    /// Gets a clip's image at a time; the region (canonical) may be null. `FAILED`: no image, treat as transparent
    /// black.
    pub clip_get_image: Option<unsafe extern "C" fn(ClipHandle, f64, *const RectD, *mut PropertySet) -> Status>,
    /// Releases an image.
    pub clip_release_image: Option<unsafe extern "C" fn(PropertySet) -> Status>,
    /// Gets a clip's region of definition at a time, canonical.
    pub clip_get_region_of_definition: Option<unsafe extern "C" fn(ClipHandle, f64, *mut RectD) -> Status>,
    /// Returns 1 if the host no longer needs the result.
    pub abort: Option<unsafe extern "C" fn(EffectHandle) -> c_int>,
    /// Allocates memory from the host's image pool.
    pub image_memory_alloc: Option<unsafe extern "C" fn(EffectHandle, usize, *mut MemoryHandle) -> Status>,
    /// Frees that memory.
    pub image_memory_free: Option<unsafe extern "C" fn(MemoryHandle) -> Status>,
    /// Locks the memory to a fixed address.
    pub image_memory_lock: Option<unsafe extern "C" fn(MemoryHandle, *mut *mut c_void) -> Status>,
    /// Unlocks the memory.
    pub image_memory_unlock: Option<unsafe extern "C" fn(MemoryHandle) -> Status>,
}

/// The Parameter suite: declaring, reading and writing parameters, keys, undo blocks.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct ParameterSuiteV1 {
    /// Declares a parameter: parameter set, type, name; returns its properties.
    pub define: Option<unsafe extern "C" fn(ParamSetHandle, *const c_char, *const c_char, *mut PropertySet) -> Status>,
    /// Gets a parameter by name; the last argument, for its properties, may be null.
    pub get_handle:
        Option<unsafe extern "C" fn(ParamSetHandle, *const c_char, *mut ParamHandle, *mut PropertySet) -> Status>,
    /// Gets the properties of a parameter set.
    pub set_get_property_set: Option<unsafe extern "C" fn(ParamSetHandle, *mut PropertySet) -> Status>,
    /// Gets the properties of a parameter.
    pub get_property_set: Option<unsafe extern "C" fn(ParamHandle, *mut PropertySet) -> Status>,
    /// Reads the current value; one pointer per dimension.
    pub get_value: Option<unsafe extern "C" fn(ParamHandle, ...) -> Status>,
    /// Reads the value at a time.
    pub get_value_at_time: Option<unsafe extern "C" fn(ParamHandle, f64, ...) -> Status>,
    /// Reads the derivative at a time.
    pub get_derivative: Option<unsafe extern "C" fn(ParamHandle, f64, ...) -> Status>,
    /// Reads the integral between two times.
    pub get_integral: Option<unsafe extern "C" fn(ParamHandle, f64, f64, ...) -> Status>,
    /// Sets the current value; one value per dimension.
    pub set_value: Option<unsafe extern "C" fn(ParamHandle, ...) -> Status>,
    /// Sets a key at a time.
    pub set_value_at_time: Option<unsafe extern "C" fn(ParamHandle, f64, ...) -> Status>,
    /// Reads the number of keys.
    pub get_num_keys: Option<unsafe extern "C" fn(ParamHandle, *mut c_uint) -> Status>,
    /// Reads the time of the nth key.
    pub get_key_time: Option<unsafe extern "C" fn(ParamHandle, c_uint, *mut f64) -> Status>,
    /// Finds the key at, before (< 0) or after (> 0) a time; -1: there is none.
    pub get_key_index: Option<unsafe extern "C" fn(ParamHandle, f64, c_int, *mut c_int) -> Status>,
    /// Deletes the key at a time.
    pub delete_key: Option<unsafe extern "C" fn(ParamHandle, f64) -> Status>,
    /// Deletes all keys.
    pub delete_all_keys: Option<unsafe extern "C" fn(ParamHandle) -> Status>,
    /// Copies the second parameter to the first, keys included.
    pub copy: Option<unsafe extern "C" fn(ParamHandle, ParamHandle, f64, *const RangeD) -> Status>,
    /// Begins an undo block.
    pub edit_begin: Option<unsafe extern "C" fn(ParamSetHandle, *const c_char) -> Status>,
    /// Ends an undo block.
    pub edit_end: Option<unsafe extern "C" fn(ParamSetHandle) -> Status>,
}

/// A message function. Arguments: effect (may be null), type, id (may be null), `printf` format, its arguments.
pub(crate) type Message =
    Option<unsafe extern "C" fn(*mut c_void, *const c_char, *const c_char, *const c_char, ...) -> Status>;

/// The Message suite, version 1.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct MessageSuiteV1 {
    /// Shows a message.
    pub message: Message,
}

/// The Message suite, version 2: adds persistent messages, which stay at the effect until cleared. Some hosts end the
/// process when it is requested.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct MessageSuiteV2 {
    /// Shows a message.
    pub message: Message,
    /// Sets a persistent message at an instance.
    pub set_persistent_message: Message,
    /// Clears the persistent message.
    pub clear_persistent_message: Option<unsafe extern "C" fn(*mut c_void) -> Status>,
}

/// The Memory suite.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct MemorySuiteV1 {
    /// Allocates memory. Arguments: effect (may be null), bytes, where to write the address.
    pub(crate) alloc: Option<unsafe extern "C" fn(*mut c_void, usize, *mut *mut c_void) -> Status>,
    /// Frees memory.
    pub(crate) free: Option<unsafe extern "C" fn(*mut c_void) -> Status>,
}

/// The Interact suite.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct InteractSuiteV1 {
    /// Swaps the OpenGL buffers (custom parameter widgets only).
    pub swap_buffers: Option<unsafe extern "C" fn(InteractHandle) -> Status>,
    /// Requests a redraw.
    pub redraw: Option<unsafe extern "C" fn(InteractHandle) -> Status>,
    /// Gets the properties of an overlay.
    pub get_property_set: Option<unsafe extern "C" fn(InteractHandle, *mut PropertySet) -> Status>,
}

/// The Draw suite: drawing without OpenGL (API 1.5).
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct DrawSuiteV1 {
    /// Gets one of the host's standard colours (see `names::draw`).
    pub get_colour: Option<unsafe extern "C" fn(DrawContextHandle, c_int, *mut RgbaColour) -> Status>,
    /// Sets the current colour.
    pub set_colour: Option<unsafe extern "C" fn(DrawContextHandle, *const RgbaColour) -> Status>,
    /// Sets the line width in screen pixels; 0: the thinnest possible.
    pub set_line_width: Option<unsafe extern "C" fn(DrawContextHandle, f32) -> Status>,
    /// Sets the line stipple.
    pub set_line_stipple: Option<unsafe extern "C" fn(DrawContextHandle, c_int) -> Status>,
    /// Draws a primitive. Arguments: its kind, its points (canonical), their number.
    pub draw: Option<unsafe extern "C" fn(DrawContextHandle, c_int, *const PointD, c_int) -> Status>,
    /// Draws text at a point, with an alignment.
    pub draw_text: Option<unsafe extern "C" fn(DrawContextHandle, *const c_char, *const PointD, c_int) -> Status>,
}

#[cfg(target_pointer_width = "64")]
const _: () = {
    assert!(size_of::<PropertySuiteV1>() == 18 * 8 && offset_of!(PropertySuiteV1, get_pointer) == 8 * 8);
    assert!(offset_of!(PropertySuiteV1, get_int_n) == 15 * 8 && offset_of!(PropertySuiteV1, get_dimension) == 17 * 8);
    assert!(size_of::<ImageEffectSuiteV1>() == 13 * 8 && offset_of!(ImageEffectSuiteV1, clip_get_image) == 5 * 8);
    assert!(offset_of!(ImageEffectSuiteV1, abort) == 8 * 8);
    assert!(size_of::<ParameterSuiteV1>() == 18 * 8 && offset_of!(ParameterSuiteV1, get_value) == 4 * 8);
    assert!(offset_of!(ParameterSuiteV1, set_value) == 8 * 8 && offset_of!(ParameterSuiteV1, get_num_keys) == 10 * 8);
    assert!(offset_of!(ParameterSuiteV1, copy) == 15 * 8 && offset_of!(ParameterSuiteV1, edit_begin) == 16 * 8);
    assert!(size_of::<MessageSuiteV1>() == 8 && size_of::<MessageSuiteV2>() == 3 * 8);
    assert!(size_of::<MemorySuiteV1>() == 2 * 8 && size_of::<InteractSuiteV1>() == 3 * 8);
    assert!(size_of::<DrawSuiteV1>() == 6 * 8 && offset_of!(DrawSuiteV1, draw) == 4 * 8);
};
