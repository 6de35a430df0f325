//! The part of the OpenFX C API that this plugin and its test host use: handles, struct layouts, names and status codes.
//!
//! In: nothing. Out: declarations only; no code runs here. Written by hand from the OpenFX headers 1.4 and 1.5 (The Open Effects
//! Association and contributors, BSD-3-Clause, <https://github.com/AcademySoftwareFoundation/openfx>): names, values and layouts are
//! theirs. The test host includes these files, as it knows the plugin by its C functions only.

mod handle;
pub(crate) mod names;
mod plugin;
mod status;
mod suites;

pub(crate) use handle::{
    ClipHandle, DrawContextHandle, EffectHandle, InteractHandle, MemoryHandle, ParamHandle, ParamSetHandle, PropertySet,
};
pub(crate) use plugin::{EntryPoint, Host, Plugin, PointD, RangeD, RectD, RectI, RgbaColour};
pub(crate) use status::Status;
pub(crate) use suites::{
    DrawSuiteV1, ImageEffectSuiteV1, InteractSuiteV1, Message, MessageSuiteV1, MessageSuiteV2, ParameterSuiteV1,
    PropertySuiteV1,
};
