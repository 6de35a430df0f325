//! Enumeration values of the Draw suite.
//!
//! In: nothing. Out: integer constants.

use std::ffi::c_int;

/// Primitive: an open polyline.
pub(crate) const LINE_STRIP: c_int = 1;
