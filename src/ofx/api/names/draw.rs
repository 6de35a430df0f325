//! Enumeration values of the Draw suite.
//!
//! In: nothing. Out: integer constants.

use std::ffi::c_int;

/// Colour: the overlay's background.
pub const COLOUR_BACKGROUND: c_int = 0;
/// Colour: an element that is being dragged.
pub const COLOUR_ACTIVE: c_int = 1;
/// Colour: a selected element.
pub const COLOUR_SELECTED: c_int = 2;
/// Colour: an element that is not selected.
pub const COLOUR_DESELECTED: c_int = 3;
/// Stipple: solid.
pub const STIPPLE_SOLID: c_int = 0;
/// Stipple: dashed.
pub const STIPPLE_DASH: c_int = 2;
/// Primitive: separate lines, one per pair of points.
pub const LINES: c_int = 0;
/// Primitive: an open polyline.
pub const LINE_STRIP: c_int = 1;
/// Primitive: a closed polyline.
pub const LINE_LOOP: c_int = 2;
/// Primitive: a rectangle, given by two opposite corners.
pub const RECTANGLE: c_int = 3;
/// Primitive: a filled polygon.
pub const POLYGON: c_int = 4;
/// Primitive: an ellipse, given by two opposite corners of its bounding box.
pub const ELLIPSE: c_int = 5;
