//! Iteration over rendered frames.
//!
//! In: a shot and frames. Out: an iterator of frames in memory, each rendered on demand.

use super::drawer::Drawer;
use super::frame::rendered;
use super::work::away;
use crate::raster::DeviceChoice;
use pyo3::prelude::*;
use std::collections::VecDeque;
use std::sync::Arc;

/// An iterator over rendered Frames; each is rendered when it is requested.
#[pyclass(module = "pinwarp")]
pub(super) struct RenderedFrames {
    drawer: Arc<Drawer>,
    left: VecDeque<i32>,
    of: usize,
    device: DeviceChoice,
    progress: Option<Py<PyAny>>,
}

impl RenderedFrames {
    pub(super) fn new(
        drawer: Arc<Drawer>,
        frames: Vec<i32>,
        device: DeviceChoice,
        progress: Option<Py<PyAny>>,
    ) -> Self {
        Self { drawer, of: frames.len(), left: frames.into(), device, progress }
    }
}

#[pymethods]
impl RenderedFrames {
    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    /// Returns the number of frames left.
    fn __length_hint__(&self) -> usize {
        self.left.len()
    }

    fn __next__<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(frame) = self.left.pop_front() else { return Ok(None) };
        let Self { drawer, left, of, device, progress } = self;
        let done = *of - left.len() - 1;
        let drawn = away(py, progress.as_ref().map(|progress| progress.bind(py)), |watch| {
            watch.tell(done, *of);
            let drawn = drawer.draw(frame, device, watch)?;
            watch.tell(done + 1, *of);
            Ok(drawn)
        })?;
        rendered(py, drawn, frame).map(Some)
    }
}
