//! The state of a sequence on disk: which frames are complete, and the worst figures that they record.
//!
//! In: the path of a sequence and its frames. Out: a [`SequenceReport`].

use super::frame_record::{FrameRecord, LayerRecord};
use crate::image::{Depth, SequencePath, StaleReason, read_whole};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;

/// The state of a sequence.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct SequenceReport {
    /// Number of complete frames.
    pub(crate) frames: usize,
    /// Frames that do not exist.
    pub(crate) missing: Vec<i32>,
    /// Frames whose file is damaged or was not written by pinwarp, with the reason.
    pub(crate) damaged: Vec<DamagedFrame>,
    /// Number of frames by the settings and device class that made them; more than one entry means that the sequence is mixed.
    pub(crate) states: BTreeMap<String, usize>,
    /// The worst figures of each layer, ordered by layer name.
    pub(crate) layers: Vec<LayerPeaks>,
    /// The frame of a warped plate with the most uncovered pixels.
    pub(crate) hole_pixels: Option<Peak>,
    /// The frame of a warped plate with the most folded pixels.
    pub(crate) folded_pixels: Option<Peak>,
    /// Frames and their warnings.
    pub(crate) warnings: Vec<(i32, String)>,
}

/// A frame that cannot be used.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct DamagedFrame {
    /// Frame number.
    pub(crate) frame: i32,
    /// The reason.
    pub(crate) reason: String,
}

/// The worst value of a figure, and its frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Peak {
    /// The value.
    pub(crate) value: f64,
    /// The first frame with that value.
    pub(crate) frame: i32,
}

/// The worst figures of one layer.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct LayerPeaks {
    /// Layer name.
    pub(crate) layer: String,
    /// Largest distance of a pin from its target, pixels.
    pub(crate) pin_error_px: Option<Peak>,
    /// Smallest determinant of the warp's gradient.
    pub(crate) min_det: Option<Peak>,
    /// Largest number of folded cells.
    pub(crate) folded_cells: Option<Peak>,
    /// Number of frames with a folded cell.
    pub(crate) folded_frames: usize,
    /// Largest angular distortion.
    pub(crate) angular: Option<Peak>,
    /// Largest area distortion.
    pub(crate) area: Option<Peak>,
    /// Largest jerk of the warp, pixels.
    pub(crate) jerk_px: Option<Peak>,
    /// Number of frames whose solve did not converge.
    pub(crate) unconverged_frames: usize,
}

impl SequenceReport {
    /// Reads the headers of all frames, and with `reads_pixels` the complete files, to verify their checksums.
    pub(crate) fn read(path: &SequencePath, frames: &[i32], reads_pixels: bool) -> Self {
        let depth = if reads_pixels { Depth::Pixels } else { Depth::Head };
        let found: Vec<_> = frames.par_iter().map(|&frame| (frame, read_whole(&path.path_of(frame), depth))).collect();
        let mut report = Self::default();
        let mut layers: BTreeMap<String, LayerPeaks> = BTreeMap::new();
        for (frame, outcome) in found {
            let metadata = match outcome {
                Ok(metadata) if metadata.frame == frame => metadata,
                Ok(metadata) => {
                    report.damage(frame, &StaleReason::OtherFrame(metadata.frame));
                    continue;
                }
                Err(StaleReason::Missing) => {
                    report.missing.push(frame);
                    continue;
                }
                Err(reason) => {
                    report.damage(frame, &reason);
                    continue;
                }
            };
            report.frames += 1;
            // The settings part of the digest, without the contents of the files.
            let settings = metadata.shot_hash.split('.').next().unwrap_or_default();
            *report.states.entry(format!("{settings} on {}", metadata.device)).or_default() += 1;
            let record = FrameRecord::from_metadata(&metadata).unwrap_or_default();
            for layer in &record.layers {
                layers.entry(layer.layer.clone()).or_default().add(frame, layer);
            }
            greatest(&mut report.hole_pixels, frame, Some(record.hole_pixels as f64).filter(|&count| count > 0.0));
            greatest(&mut report.folded_pixels, frame, Some(record.folded_pixels as f64).filter(|&count| count > 0.0));
            report.warnings.extend(record.warnings.into_iter().map(|warning| (frame, warning)));
        }
        report.layers = layers.into_iter().map(|(layer, peaks)| LayerPeaks { layer, ..peaks }).collect();
        report
    }

    fn damage(&mut self, frame: i32, reason: &StaleReason) {
        self.damaged.push(DamagedFrame { frame, reason: reason.to_string() });
    }

    /// Returns the frames in which some figure is worst, in increasing order.
    pub(crate) fn worst_frames(&self) -> Vec<i32> {
        let of_layer = |layer: &LayerPeaks| [layer.pin_error_px, layer.folded_cells, layer.min_det, layer.jerk_px];
        let peaks = self.layers.iter().flat_map(of_layer).chain([self.hole_pixels, self.folded_pixels]);
        let mut frames: Vec<i32> = peaks.flatten().map(|peak| peak.frame).collect();
        frames.sort_unstable();
        frames.dedup();
        frames
    }
}

impl LayerPeaks {
    fn add(&mut self, frame: i32, layer: &LayerRecord) {
        greatest(&mut self.pin_error_px, frame, layer.pin_error_px);
        greatest(&mut self.angular, frame, layer.angular);
        greatest(&mut self.area, frame, layer.area);
        greatest(&mut self.jerk_px, frame, layer.jerk.map(|jerk| jerk.warp_px));
        greatest(&mut self.folded_cells, frame, Some(layer.folded_cells as f64).filter(|&count| count > 0.0));
        if let Some(det) = layer.min_det
            && self.min_det.is_none_or(|least| det < least.value)
        {
            self.min_det = Some(Peak { value: det, frame });
        }
        self.folded_frames += usize::from(layer.folded_cells > 0);
        self.unconverged_frames += usize::from(!layer.is_converged);
    }
}

/// Keeps the larger of two values, and the first of equal ones.
fn greatest(peak: &mut Option<Peak>, frame: i32, value: Option<f64>) {
    if let Some(value) = value
        && peak.is_none_or(|greatest| value > greatest.value)
    {
        *peak = Some(Peak { value, frame });
    }
}
