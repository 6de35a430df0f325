//! Conversion of a rendered frame to arrays.
//!
//! In: a [`Frame`]. Out: `pinwarp.Frame`, a dict of channels by their names in EXR files; samples are moved, not
//! copied.

use super::image::channel_array;
use crate::image::Frame;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Converts a frame to `pinwarp.Frame`, which is defined in `src/python/pinwarp/_frame.py`.
pub(super) fn rendered(py: Python<'_>, frame: Frame, number: i32) -> PyResult<Bound<'_, PyAny>> {
    let Frame { display, data_window, pixel_aspect, channels } = frame;
    let shape = [data_window.height as usize, data_window.width as usize];
    let arrays = PyDict::new(py);
    for channel in channels {
        arrays.set_item(channel.name.clone(), channel_array(py, channel, shape)?)?;
    }
    let window = data_window.relative_to(display);
    let window = (window.x, window.y, window.width, window.height);
    let size = (display.width, display.height);
    py.import("pinwarp._frame")?.getattr("Frame")?.call1((arrays, number, size, window, pixel_aspect))
}
