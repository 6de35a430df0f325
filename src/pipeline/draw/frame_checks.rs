//! Solves frames and reports what a render of them would, without drawing them.
//!
//! In: a [`PreparedShot`] and frame numbers. Out: a [`FrameReport`] per frame.

use super::jerk::JerkMeter;
use super::report::report_of_layers;
use crate::pipeline::{FrameReport, PipelineError, PreparedShot};

/// Reports the frames of a shot in order.
#[derive(Default)]
pub(crate) struct FrameChecks {
    jerk: JerkMeter,
}

impl FrameChecks {
    /// Returns the report of a frame, restricted to the layers for which `includes_layer` is true.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] if a layer cannot be solved.
    pub(crate) fn report(
        &mut self,
        prepared: &PreparedShot,
        frame: i32,
        includes_layer: impl Fn(usize) -> bool,
    ) -> Result<FrameReport, PipelineError> {
        let sample = prepared.mid_exposure(frame)?;
        let mut report = report_of_layers(prepared, (frame, &sample), includes_layer);
        self.jerk.watch(prepared, &sample, &mut report);
        Ok(report)
    }
}
