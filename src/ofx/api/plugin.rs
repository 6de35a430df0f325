//! The two structures through which host and plugin introduce themselves, and the plain structures they exchange.
//!
//! In: nothing. Out: layouts as C compilers for 64-bit systems produce them, checked by assertions.

use super::{EffectHandle, PropertySet, Status};
use std::ffi::{c_char, c_int, c_uint, c_void};
use std::mem::offset_of;

/// The structure that the host passes to [`Plugin::set_host`]: its properties and access to its suites.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Host {
    /// Properties of the host: name, version, capabilities.
    pub(crate) properties: PropertySet,
    /// Fetches a suite by name and version; null if the host does not have it.
    pub(crate) fetch_suite: Option<unsafe extern "C" fn(PropertySet, *const c_char, c_int) -> *const c_void>,
}

/// The entry point for actions. Arguments: the action's name, its handle (null for load and unload), its in and out
/// arguments (either may be null).
pub(crate) type EntryPoint = unsafe extern "C" fn(*const c_char, *const c_void, PropertySet, PropertySet) -> Status;

/// What a plugin declares about itself before any action is called.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Plugin {
    /// The name of its API: [`super::names::IMAGE_EFFECT_API`].
    pub(crate) api: *const c_char,
    /// Version of that API: 1.
    pub(crate) api_version: c_int,
    /// The identifier under which hosts and project files refer to it; never changes.
    pub(crate) identifier: *const c_char,
    /// Major version: raised when existing projects would render differently.
    pub(crate) version_major: c_uint,
    /// Minor version: raised by compatible changes.
    pub(crate) version_minor: c_uint,
    /// Receives the host structure; called before any action.
    pub(crate) set_host: Option<unsafe extern "C" fn(*const Host)>,
    /// Receives all actions.
    pub(crate) main_entry: Option<EntryPoint>,
}

/// A rectangle of integer pixels, y up: `x1 <= x < x2`, `y1 <= y < y2`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub(crate) struct RectI {
    /// The left column.
    pub x1: c_int,
    /// The bottom row.
    pub y1: c_int,
    /// One past the right column.
    pub x2: c_int,
    /// One past the top row.
    pub y2: c_int,
}

/// A rectangle in canonical coordinates (y up, square pixels at full size).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub(crate) struct RectD {
    /// Left edge.
    pub x1: f64,
    /// Lower edge.
    pub y1: f64,
    /// Right edge.
    pub x2: f64,
    /// Upper edge.
    pub y2: f64,
}

/// A point in canonical coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub(crate) struct PointD {
    /// The x coordinate, to the right.
    pub x: f64,
    /// The y coordinate, upwards.
    pub y: f64,
}

/// A range of times or values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub(crate) struct RangeD {
    /// The lower end.
    pub min: f64,
    /// The upper end.
    pub max: f64,
}

/// A colour of the Draw suite, each component 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub(crate) struct RgbaColour {
    /// Red.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
    /// Opacity.
    pub a: f32,
}

#[cfg(target_pointer_width = "64")]
const _: () = {
    assert!(size_of::<Host>() == 16 && offset_of!(Host, fetch_suite) == 8);
    assert!(size_of::<Plugin>() == 48);
    assert!(offset_of!(Plugin, api_version) == 8 && offset_of!(Plugin, identifier) == 16);
    assert!(offset_of!(Plugin, version_major) == 24 && offset_of!(Plugin, version_minor) == 28);
    assert!(offset_of!(Plugin, set_host) == 32 && offset_of!(Plugin, main_entry) == 40);
    assert!(size_of::<RectI>() == 16 && size_of::<RectD>() == 32 && size_of::<PointD>() == 16);
    assert!(size_of::<RangeD>() == 16 && size_of::<RgbaColour>() == 16 && size_of::<EffectHandle>() == 8);
};
