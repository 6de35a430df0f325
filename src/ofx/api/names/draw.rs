//! Numbers of the Draw suite.
//!
//! In: nothing. Out: values of its enumerations.

use std::ffi::c_int;

/// Colour: what is behind an overlay.
pub const COLOUR_BACKGROUND: c_int = 0;
/// Colour: what is being dragged.
pub const COLOUR_ACTIVE: c_int = 1;
/// Colour: what is selected.
pub const COLOUR_SELECTED: c_int = 2;
/// Colour: what is not.
pub const COLOUR_DESELECTED: c_int = 3;
/// Line: unbroken.
pub const STIPPLE_SOLID: c_int = 0;
/// Line: dashes.
pub const STIPPLE_DASH: c_int = 2;
/// Figure: pairs of points.
pub const LINES: c_int = 0;
/// Figure: points in a row.
pub const LINE_STRIP: c_int = 1;
/// Figure: the same, closed.
pub const LINE_LOOP: c_int = 2;
/// Figure: a rectangle, by two corners.
pub const RECTANGLE: c_int = 3;
/// Figure: a filled polygon.
pub const POLYGON: c_int = 4;
/// Figure: an ellipse, by two corners of its box.
pub const ELLIPSE: c_int = 5;
