//! Suites: tables of the host's functions. Any entry may be missing, so each is an `Option`.
//!
//! In: nothing. Out: layouts with their offsets asserted.
//!
//! Functions that take "..." are variadic in C and must be called as such: their arguments follow C's promotions.

use super::{
    ClipHandle, DrawContextHandle, EffectHandle, InteractHandle, MemoryHandle, ParamHandle, ParamSetHandle, PointD,
    PropertySet, RangeD, RectD, RgbaColour, Status,
};
use std::ffi::{c_char, c_int, c_uint, c_void};
use std::mem::offset_of;

/// Sets one value: the set, the property's name, the index of the value, the value.
type SetOne<T> = Option<unsafe extern "C" fn(PropertySet, *const c_char, c_int, T) -> Status>;
/// Sets the first values: the set, the name, how many, where they lie.
type SetMany<T> = Option<unsafe extern "C" fn(PropertySet, *const c_char, c_int, *const T) -> Status>;
/// Reads one value: the set, the name, the index, where the value goes.
type GetOne<T> = Option<unsafe extern "C" fn(PropertySet, *const c_char, c_int, *mut T) -> Status>;

/// Properties: named lists of pointers, strings, doubles or ints. Strings that are read belong to the host and last
/// until its next call.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct PropertySuiteV1 {
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
    /// Reads the first pointers: how many, where they go.
    pub get_pointer_n: GetOne<*mut c_void>,
    /// Reads the first strings.
    pub get_string_n: GetOne<*mut c_char>,
    /// Reads the first doubles.
    pub get_double_n: GetOne<f64>,
    /// Reads the first ints.
    pub get_int_n: GetOne<c_int>,
    /// Brings a property back to its default.
    pub reset: Option<unsafe extern "C" fn(PropertySet, *const c_char) -> Status>,
    /// Reads how many values a property has.
    pub get_dimension: Option<unsafe extern "C" fn(PropertySet, *const c_char, *mut c_int) -> Status>,
}

/// Effects, their clips and images.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ImageEffectSuiteV1 {
    /// Properties of an effect.
    pub get_property_set: Option<unsafe extern "C" fn(EffectHandle, *mut PropertySet) -> Status>,
    /// Parameters of an effect.
    pub get_param_set: Option<unsafe extern "C" fn(EffectHandle, *mut ParamSetHandle) -> Status>,
    /// Declares a clip while a context is described; gives the clip's properties.
    pub clip_define: Option<unsafe extern "C" fn(EffectHandle, *const c_char, *mut PropertySet) -> Status>,
    /// The clip of a name; the last place, for its properties, may be null.
    pub clip_get_handle:
        Option<unsafe extern "C" fn(EffectHandle, *const c_char, *mut ClipHandle, *mut PropertySet) -> Status>,
    /// Properties of a clip.
    pub clip_get_property_set: Option<unsafe extern "C" fn(ClipHandle, *mut PropertySet) -> Status>,
    /// The image of a clip at a time; the region (canonical) may be null. `FAILED`: there is none, take transparent black.
    pub clip_get_image: Option<unsafe extern "C" fn(ClipHandle, f64, *const RectD, *mut PropertySet) -> Status>,
    /// Gives an image back.
    pub clip_release_image: Option<unsafe extern "C" fn(PropertySet) -> Status>,
    /// The region of definition of a clip at a time, canonical.
    pub clip_get_region_of_definition: Option<unsafe extern "C" fn(ClipHandle, f64, *mut RectD) -> Status>,
    /// 1 where the host no longer wants the result.
    pub abort: Option<unsafe extern "C" fn(EffectHandle) -> c_int>,
    /// Takes memory from the host's image pool.
    pub image_memory_alloc: Option<unsafe extern "C" fn(EffectHandle, usize, *mut MemoryHandle) -> Status>,
    /// Gives it back.
    pub image_memory_free: Option<unsafe extern "C" fn(MemoryHandle) -> Status>,
    /// Pins it to an address.
    pub image_memory_lock: Option<unsafe extern "C" fn(MemoryHandle, *mut *mut c_void) -> Status>,
    /// Lets it move again.
    pub image_memory_unlock: Option<unsafe extern "C" fn(MemoryHandle) -> Status>,
}

/// Parameters: declaring, reading, writing, keys, undo blocks.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ParameterSuiteV1 {
    /// Declares a parameter: set, type, name; gives its properties.
    pub define: Option<unsafe extern "C" fn(ParamSetHandle, *const c_char, *const c_char, *mut PropertySet) -> Status>,
    /// The parameter of a name; the last place, for its properties, may be null.
    pub get_handle:
        Option<unsafe extern "C" fn(ParamSetHandle, *const c_char, *mut ParamHandle, *mut PropertySet) -> Status>,
    /// Properties of a set of parameters.
    pub set_get_property_set: Option<unsafe extern "C" fn(ParamSetHandle, *mut PropertySet) -> Status>,
    /// Properties of a parameter.
    pub get_property_set: Option<unsafe extern "C" fn(ParamHandle, *mut PropertySet) -> Status>,
    /// Reads the value now: a pointer for each dimension.
    pub get_value: Option<unsafe extern "C" fn(ParamHandle, ...) -> Status>,
    /// Reads the value at a time.
    pub get_value_at_time: Option<unsafe extern "C" fn(ParamHandle, f64, ...) -> Status>,
    /// Reads the derivative at a time.
    pub get_derivative: Option<unsafe extern "C" fn(ParamHandle, f64, ...) -> Status>,
    /// Reads the integral between two times.
    pub get_integral: Option<unsafe extern "C" fn(ParamHandle, f64, f64, ...) -> Status>,
    /// Sets the value now: a value for each dimension.
    pub set_value: Option<unsafe extern "C" fn(ParamHandle, ...) -> Status>,
    /// Sets a key.
    pub set_value_at_time: Option<unsafe extern "C" fn(ParamHandle, f64, ...) -> Status>,
    /// Reads how many keys there are.
    pub get_num_keys: Option<unsafe extern "C" fn(ParamHandle, *mut c_uint) -> Status>,
    /// Reads the time of the nth key.
    pub get_key_time: Option<unsafe extern "C" fn(ParamHandle, c_uint, *mut f64) -> Status>,
    /// Finds a key at, before (< 0) or after (> 0) a time; -1: none.
    pub get_key_index: Option<unsafe extern "C" fn(ParamHandle, f64, c_int, *mut c_int) -> Status>,
    /// Removes the key at a time.
    pub delete_key: Option<unsafe extern "C" fn(ParamHandle, f64) -> Status>,
    /// Removes all keys.
    pub delete_all_keys: Option<unsafe extern "C" fn(ParamHandle) -> Status>,
    /// Copies one parameter (the second) to another, with its keys.
    pub copy: Option<unsafe extern "C" fn(ParamHandle, ParamHandle, f64, *const RangeD) -> Status>,
    /// Begins a change that is undone in one step.
    pub edit_begin: Option<unsafe extern "C" fn(ParamSetHandle, *const c_char) -> Status>,
    /// Ends it.
    pub edit_end: Option<unsafe extern "C" fn(ParamSetHandle) -> Status>,
}

/// A message: effect (may be null), kind, id (may be null), format as of `printf`, its arguments.
pub type Message =
    Option<unsafe extern "C" fn(*mut c_void, *const c_char, *const c_char, *const c_char, ...) -> Status>;

/// Words for the user.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct MessageSuiteV1 {
    /// Shows a message.
    pub message: Message,
}

/// Words for the user, and such as stay at the effect until they are cleared. Some hosts end the program when asked for it.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct MessageSuiteV2 {
    /// Shows a message.
    pub message: Message,
    /// Leaves a message at an instance.
    pub set_persistent_message: Message,
    /// Removes it.
    pub clear_persistent_message: Option<unsafe extern "C" fn(*mut c_void) -> Status>,
}

/// Memory of the host.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct MemorySuiteV1 {
    /// Takes memory: effect (may be null), bytes, where the address goes.
    pub alloc: Option<unsafe extern "C" fn(*mut c_void, usize, *mut *mut c_void) -> Status>,
    /// Gives it back.
    pub free: Option<unsafe extern "C" fn(*mut c_void) -> Status>,
}

/// Overlays.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct InteractSuiteV1 {
    /// Swaps the OpenGL buffers (custom parameter widgets only).
    pub swap_buffers: Option<unsafe extern "C" fn(InteractHandle) -> Status>,
    /// Asks for a draw action.
    pub redraw: Option<unsafe extern "C" fn(InteractHandle) -> Status>,
    /// Properties of an overlay.
    pub get_property_set: Option<unsafe extern "C" fn(InteractHandle, *mut PropertySet) -> Status>,
}

/// Drawing without OpenGL (API 1.5).
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct DrawSuiteV1 {
    /// Reads a colour of the host's own (see [`super::names::draw`]).
    pub get_colour: Option<unsafe extern "C" fn(DrawContextHandle, c_int, *mut RgbaColour) -> Status>,
    /// Sets the colour of what follows.
    pub set_colour: Option<unsafe extern "C" fn(DrawContextHandle, *const RgbaColour) -> Status>,
    /// Sets the width of lines in pixels of the screen; 0: as thin as they come.
    pub set_line_width: Option<unsafe extern "C" fn(DrawContextHandle, f32) -> Status>,
    /// Sets the dashing of lines.
    pub set_line_stipple: Option<unsafe extern "C" fn(DrawContextHandle, c_int) -> Status>,
    /// Draws a figure: its kind, its points (canonical), how many.
    pub draw: Option<unsafe extern "C" fn(DrawContextHandle, c_int, *const PointD, c_int) -> Status>,
    /// Draws text at a point, aligned.
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
