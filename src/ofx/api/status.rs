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
    pub const OK: Self = Self(0);
    /// The call failed for an unspecified reason.
    pub const FAILED: Self = Self(1);
    /// A fatal error: the program cannot continue.
    pub const ERR_FATAL: Self = Self(2);
    /// The object is unknown.
    pub const ERR_UNKNOWN: Self = Self(3);
    /// The host lacks a feature that the plugin requires.
    pub const ERR_MISSING_HOST_FEATURE: Self = Self(4);
    /// The feature is known but not supported.
    pub const ERR_UNSUPPORTED: Self = Self(5);
    /// The object already exists.
    pub const ERR_EXISTS: Self = Self(6);
    /// The format is invalid.
    pub const ERR_FORMAT: Self = Self(7);
    /// Out of memory.
    pub const ERR_MEMORY: Self = Self(8);
    /// The handle is invalid or of the wrong type.
    pub const ERR_BAD_HANDLE: Self = Self(9);
    /// The index is out of range.
    pub const ERR_BAD_INDEX: Self = Self(10);
    /// The value is invalid.
    pub const ERR_VALUE: Self = Self(11);
    /// The answer to a question is yes.
    pub const REPLY_YES: Self = Self(12);
    /// The answer to a question is no; in progress reports: the user wants to cancel.
    pub const REPLY_NO: Self = Self(13);
    /// The action was not handled: the host takes its default.
    pub const REPLY_DEFAULT: Self = Self(14);
    /// The image's format is not supported (image effect API).
    pub const ERR_IMAGE_FORMAT: Self = Self(1000);

    /// Returns whether this is [`Self::OK`].
    #[must_use]
    pub fn is_ok(self) -> bool {
        self == Self::OK
    }
}

const _: () = assert!(size_of::<Status>() == 4);
