//! The two structures by which host and plugin meet, and the plain values they exchange.
//!
//! In: nothing. Out: layouts as C compilers on 64-bit systems lay them out, held by asserts.

use super::{EffectHandle, PropertySet, Status};
use std::ffi::{c_char, c_int, c_uint, c_void};
use std::mem::offset_of;

/// What the host gives to [`Plugin::set_host`]: its properties and the way to its suites.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Host {
    /// Properties of the host: name, version, abilities.
    pub properties: PropertySet,
    /// Finds the suite of a name and version; null where the host has none.
    pub fetch_suite: Option<unsafe extern "C" fn(PropertySet, *const c_char, c_int) -> *const c_void>,
}

/// An action: its name, what it is about (null for loading), its arguments and where answers go (either may be null).
pub type EntryPoint = unsafe extern "C" fn(*const c_char, *const c_void, PropertySet, PropertySet) -> Status;

/// What a plugin tells about itself before anything is loaded.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Plugin {
    /// The API it speaks: [`super::names::IMAGE_EFFECT_API`].
    pub api: *const c_char,
    /// Version of that API: 1.
    pub api_version: c_int,
    /// Name under which hosts and their projects know it; never changes.
    pub identifier: *const c_char,
    /// Raised where old projects would look different.
    pub version_major: c_uint,
    /// Raised where they would not.
    pub version_minor: c_uint,
    /// Takes the host; called before any action.
    pub set_host: Option<unsafe extern "C" fn(*const Host)>,
    /// Takes all actions.
    pub main_entry: Option<EntryPoint>,
}

/// A rectangle of whole pixels, y up: `x1 <= x < x2`, `y1 <= y < y2`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct RectI {
    /// Left column.
    pub x1: c_int,
    /// Lowest row.
    pub y1: c_int,
    /// Column after the last.
    pub x2: c_int,
    /// Row after the highest.
    pub y2: c_int,
}

/// A rectangle of the canonical plane (y up, square pixels at full size).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct RectD {
    /// Left edge.
    pub x1: f64,
    /// Lower edge.
    pub y1: f64,
    /// Right edge.
    pub x2: f64,
    /// Upper edge.
    pub y2: f64,
}

/// A point of the canonical plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct PointD {
    /// To the right.
    pub x: f64,
    /// Upwards.
    pub y: f64,
}

/// A stretch of time or of numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct RangeD {
    /// Where it begins.
    pub min: f64,
    /// Where it ends.
    pub max: f64,
}

/// A colour of the Draw suite, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct RgbaColour {
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
