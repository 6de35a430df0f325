//! Status codes returned by suite functions and plugin actions.
//!
//! In: integers. Out: a type with named values.

use std::ffi::c_int;

/// The return value of a suite function or an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Status(pub c_int);

impl Status {
    /// Success; from an action: it was handled.
    pub(crate) const OK: Self = Self(0);
    /// The call failed for an unspecified reason.
    pub(crate) const FAILED: Self = Self(1);
    /// The object is unknown.
    pub(crate) const ERR_UNKNOWN: Self = Self(3);
    /// The host lacks a feature that the plugin requires.
    pub(crate) const ERR_MISSING_HOST_FEATURE: Self = Self(4);
    /// The feature is known but not supported.
    pub(crate) const ERR_UNSUPPORTED: Self = Self(5);
    /// The object already exists.
    pub(crate) const ERR_EXISTS: Self = Self(6);
    /// Out of memory.
    pub(crate) const ERR_MEMORY: Self = Self(8);
    /// The handle is invalid or of the wrong type.
    pub(crate) const ERR_BAD_HANDLE: Self = Self(9);
    /// The index is out of range.
    pub(crate) const ERR_BAD_INDEX: Self = Self(10);
    /// The value is invalid.
    pub(crate) const ERR_VALUE: Self = Self(11);
    /// The action was not handled: the host takes its default.
    pub(crate) const REPLY_DEFAULT: Self = Self(14);
    /// The image's format is not supported (image effect API).
    pub(crate) const ERR_IMAGE_FORMAT: Self = Self(1000);

    /// Returns whether this is [`Self::OK`].
    #[must_use]
    pub(crate) fn is_ok(self) -> bool {
        self == Self::OK
    }
}

const _: () = assert!(size_of::<Status>() == 4);
