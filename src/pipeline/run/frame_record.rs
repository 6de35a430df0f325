//! The record of a frame's report that is stored in its file: figures and warnings, without paths and times, so that
//! the same shot gives the same bytes everywhere.
//!
//! In: a [`FrameReport`] or [`WarpReport`]. Out: a [`FrameRecord`], converted to and from the JSON in the file's metadata.

#[cfg(any(feature = "cli", test))]
use crate::image::FrameMetadata;
use crate::pipeline::{FrameReport, Jerk, LayerReport, WarpReport};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Figures of a frame that was written.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub(in crate::pipeline) struct FrameRecord {
    /// One per solved layer; empty for frames warped by lattice files or STMaps.
    pub(in crate::pipeline) layers: Vec<LayerRecord>,
    /// Number of pixels of a warped plate that a layer uncovered and no other layer covers, including those filled afterwards.
    pub(in crate::pipeline) hole_pixels: usize,
    /// Number of pixels of a warped plate where a layer overlaps itself.
    pub(in crate::pipeline) folded_pixels: usize,
    /// Number of colour samples of a plate that were NaN or infinite.
    pub(in crate::pipeline) contained_samples: usize,
    /// Warnings about the frame.
    pub(in crate::pipeline) warnings: Vec<String>,
}

/// Figures of one layer in one frame. `None`: not measured, as for lattices from a file.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(in crate::pipeline) struct LayerRecord {
    /// Layer name.
    pub(in crate::pipeline) layer: String,
    /// Largest distance of a pin from its target, pixels.
    pub(in crate::pipeline) pin_error_px: Option<f64>,
    /// Smallest determinant of the warp's gradient over the cells that contain part of the model.
    pub(in crate::pipeline) min_det: Option<f64>,
    /// Number of folded cells that contain part of the model.
    pub(in crate::pipeline) folded_cells: usize,
    /// Angular distortion: mean over area of s1/s2 + s2/s1 − 2.
    pub(in crate::pipeline) angular: Option<f64>,
    /// Area distortion: mean over area of s1·s2 + 1/(s1·s2) − 2.
    pub(in crate::pipeline) area: Option<f64>,
    /// Unevenness of the motion.
    pub(in crate::pipeline) jerk: Option<Jerk>,
    /// Whether the last step of the solve was below the tolerance.
    pub(in crate::pipeline) is_converged: bool,
}

impl FrameRecord {
    pub(in crate::pipeline) fn of_render(report: &FrameReport) -> Self {
        Self {
            layers: report.layers.iter().map(LayerRecord::of).collect(),
            warnings: report.warnings.clone(),
            ..Self::default()
        }
    }

    pub(in crate::pipeline) fn of_warp(report: &WarpReport) -> Self {
        Self {
            layers: Vec::new(),
            hole_pixels: report.hole_pixels,
            folded_pixels: report.folded_pixels,
            contained_samples: report.contained_samples,
            warnings: report.warnings.clone(),
        }
    }

    /// Converts the record to the JSON stored in a file.
    pub(in crate::pipeline) fn to_json(&self) -> Value {
        serde_json::to_value(self).expect("numbers, texts and lists are always JSON")
    }

    /// Reads the record from a file's metadata; `None` if it holds none.
    #[cfg(any(feature = "cli", test))]
    pub(in crate::pipeline) fn from_metadata(metadata: &FrameMetadata) -> Option<Self> {
        serde_json::from_value(metadata.report.clone()).ok()
    }
}

impl LayerRecord {
    fn of(report: &LayerReport) -> Self {
        let solve = &report.solve;
        let measured = |value: f64| value.is_finite().then_some(value);
        Self {
            layer: report.layer.clone(),
            pin_error_px: measured(report.pin_error_px),
            min_det: measured(solve.min_cell_det),
            folded_cells: solve.folded_model_cells,
            angular: measured(solve.angular),
            area: measured(solve.area),
            jerk: report.jerk.filter(|jerk| jerk.warp_px.is_finite() && jerk.input_px.is_finite()),
            is_converged: solve.is_converged,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::SolveReport;

    #[test]
    fn records_survive_a_file_without_times() {
        let solve =
            SolveReport { angular: f64::NAN, min_cell_det: -0.25, folded_model_cells: 2, ..SolveReport::default() };
        let layer = LayerReport { layer: "arm".into(), pin_error_px: 0.1, solve, ..LayerReport::default() };
        let report = FrameReport { layers: vec![layer], warnings: vec!["it folds".into()], ..FrameReport::default() };
        let record = FrameRecord::of_render(&report);
        let later = FrameReport { geometry_ms: 7.0, path: "elsewhere".into(), ..report };
        assert_eq!(FrameRecord::of_render(&later), record);
        let metadata = FrameMetadata { report: record.to_json(), ..FrameMetadata::default() };
        assert_eq!(FrameRecord::from_metadata(&metadata), Some(record.clone()));
        assert_eq!((record.layers[0].angular, record.layers[0].min_det), (None, Some(-0.25)));
        assert_eq!(FrameRecord::from_metadata(&FrameMetadata::default()), None);
    }
}
