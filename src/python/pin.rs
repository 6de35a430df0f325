//! Conversion of pins from Python.
//!
//! In: an array (K, 4) or a list of [`Pin`]s, in screen units or pixels. Out: pins of the library.

use super::arrays;
use super::failure::Failure;
use crate::live;
use crate::space::{FrameSize, ImagePoint, ScreenPoint};
use pyo3::prelude::*;

/// A pin: a point of the picture and its target.
///
/// at, to: (x, y), in the units of the function that takes the pin.
/// rotate: rotation that the pin holds, in degrees, counter-clockwise as seen; None leaves it free.
/// scale: scale that the pin holds, above 0; None leaves it free.
/// weight: 0 to 1, how firmly the pin holds its point; 1 holds it exactly.
#[pyclass(frozen, from_py_object, module = "pinwarp", get_all)]
#[derive(Clone, Debug)]
pub(super) struct Pin {
    at: [f64; 2],
    to: [f64; 2],
    rotate: Option<f64>,
    scale: Option<f64>,
    weight: f64,
}

#[pymethods]
impl Pin {
    #[new]
    #[pyo3(signature = (at, to, *, rotate=None, scale=None, weight=1.0))]
    const fn new(at: [f64; 2], to: [f64; 2], rotate: Option<f64>, scale: Option<f64>, weight: f64) -> Self {
        Self { at, to, rotate, scale, weight }
    }

    fn __repr__(&self) -> String {
        let Self { at, to, rotate, scale, weight } = self;
        let optional =
            |name: &str, value: &Option<f64>| value.map_or_else(String::new, |value| format!(", {name}={value}"));
        let held = optional("rotate", rotate) + &optional("scale", scale);
        let weight = if *weight == 1.0 { String::new() } else { format!(", weight={weight}") };
        format!("Pin(({}, {}), ({}, {}){held}{weight})", at[0], at[1], to[0], to[1])
    }
}

impl Pin {
    /// Creates a pin from an array row: x, y and its target.
    const fn of_row([x, y, to_x, to_y]: [f64; 4]) -> Self {
        Self::new([x, y], [to_x, to_y], None, None, 1.0)
    }
}

/// Units of pin positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Units {
    /// Frame heights, x right, y up, from the lower left corner.
    Screen,
    /// Pixels, x right, y down, from the upper left corner; the first pixel's centre is (0.5, 0.5).
    Pixels,
}

impl Units {
    pub(super) fn of_name(name: &str) -> Result<Self, Failure> {
        match name {
            "screen" => Ok(Self::Screen),
            "pixels" => Ok(Self::Pixels),
            _ => Err(Failure::argument("units", format!("is {name:?}"), "give \"screen\" or \"pixels\"")),
        }
    }

    fn point(self, [x, y]: [f64; 2], frame: FrameSize) -> ScreenPoint {
        match self {
            Self::Screen => ScreenPoint::new(x, y),
            Self::Pixels => frame.screen_from_image(ImagePoint::new(x, y)),
        }
    }
}

/// Reads pins from an array (K, 4), or a list.
pub(super) fn pins(values: &Bound<'_, PyAny>) -> Result<Vec<Pin>, Failure> {
    if let Ok(pins) = values.extract::<Vec<Pin>>() {
        return Ok(pins);
    }
    let rows = arrays::points::<4>(values, "pins")?;
    Ok(rows.into_iter().map(Pin::of_row).collect())
}

/// Converts pins of a picture.
pub(super) fn pins_of_picture(pins: &[Pin], units: Units, frame: FrameSize) -> Vec<live::Pin> {
    let pin = |pin: &Pin| live::Pin {
        rotation: pin.rotate.map(f64::to_radians),
        scale: pin.scale,
        weight: pin.weight,
        ..live::Pin::new(units.point(pin.at, frame), units.point(pin.to, frame))
    };
    pins.iter().map(pin).collect()
}
