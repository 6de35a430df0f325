//! Status values: what suite functions and plugin actions answer.
//!
//! In: integers. Out: a type whose values have names.

use std::ffi::c_int;

/// The answer of a suite function or of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Status(pub c_int);

impl Status {
    /// All went well; as an action's answer: it was handled.
    pub const OK: Self = Self(0);
    /// It did not work; no other value says why.
    pub const FAILED: Self = Self(1);
    /// The program cannot go on.
    pub const ERR_FATAL: Self = Self(2);
    /// There is no such object.
    pub const ERR_UNKNOWN: Self = Self(3);
    /// The host lacks something that the plugin needs.
    pub const ERR_MISSING_HOST_FEATURE: Self = Self(4);
    /// Known, but not offered.
    pub const ERR_UNSUPPORTED: Self = Self(5);
    /// There already is such an object.
    pub const ERR_EXISTS: Self = Self(6);
    /// The format is not right.
    pub const ERR_FORMAT: Self = Self(7);
    /// There is not enough memory.
    pub const ERR_MEMORY: Self = Self(8);
    /// The handle is none, or of something else.
    pub const ERR_BAD_HANDLE: Self = Self(9);
    /// There is nothing at that index.
    pub const ERR_BAD_INDEX: Self = Self(10);
    /// The value is not allowed.
    pub const ERR_VALUE: Self = Self(11);
    /// A question was answered with yes.
    pub const REPLY_YES: Self = Self(12);
    /// A question was answered with no; progress: the user wants to stop.
    pub const REPLY_NO: Self = Self(13);
    /// The action was not handled: the host does what it does by default.
    pub const REPLY_DEFAULT: Self = Self(14);
    /// The image's format cannot be handled (image effect API).
    pub const ERR_IMAGE_FORMAT: Self = Self(1000);

    /// Whether this is [`Self::OK`].
    #[must_use]
    pub fn is_ok(self) -> bool {
        self == Self::OK
    }
}

const _: () = assert!(size_of::<Status>() == 4);
