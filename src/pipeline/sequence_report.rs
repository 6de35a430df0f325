//! The state of a sequence on the disk: which frames are there and whole, and the worst figures that they say of themselves.
//!
//! In: the path of a sequence, and its frames. Out: [`SequenceReport`].

use super::frame_record::{FrameRecord, LayerRecord};
use crate::image::{Depth, Redo, SequencePath, read_whole};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;

/// What is known of a sequence.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct SequenceReport {
    /// Frames that are there and whole.
    pub(crate) frames: usize,
    /// Frames that are not there.
    pub(crate) missing: Vec<i32>,
    /// Frames whose file is damaged, or was not written by pinwarp, and why.
    pub(crate) damaged: Vec<DamagedFrame>,
    /// Frames that different states of the shot, versions or classes of device made: more than one is a mix. Made from, number of frames.
    pub(crate) states: BTreeMap<String, usize>,
    /// The worst figures of each layer, in the order of their names.
    pub(crate) layers: Vec<LayerPeaks>,
    /// The frame of a warped plate with most uncovered pixels.
    pub(crate) hole_pixels: Option<Peak>,
    /// The frame of a warped plate with most folded pixels.
    pub(crate) folded_pixels: Option<Peak>,
    /// Frames and what they warn of.
    pub(crate) warnings: Vec<(i32, String)>,
}

/// A frame that cannot be used.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct DamagedFrame {
    /// Its number.
    pub(crate) frame: i32,
    /// Why, in words.
    pub(crate) reason: String,
}

/// The worst value of a figure, and in which frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Peak {
    /// The value.
    pub(crate) value: f64,
    /// The first frame that has it.
    pub(crate) frame: i32,
}

/// The worst figures of one layer.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct LayerPeaks {
    /// Layer name.
    pub(crate) layer: String,
    /// Greatest distance of a pin from its target, pixels.
    pub(crate) pin_error_px: Option<Peak>,
    /// Least determinant of the warp's gradient.
    pub(crate) min_det: Option<Peak>,
    /// Most cells that fold.
    pub(crate) folded_cells: Option<Peak>,
    /// Frames in which a cell folds.
    pub(crate) folded_frames: usize,
    /// Greatest angular distortion.
    pub(crate) angular: Option<Peak>,
    /// Greatest area distortion.
    pub(crate) area: Option<Peak>,
    /// Greatest jerk of the warp, pixels.
    pub(crate) jerk_px: Option<Peak>,
    /// Frames whose solve did not converge.
    pub(crate) unconverged_frames: usize,
}

impl SequenceReport {
    /// Reads the heads of all frames, and with `reads_pixels` the files to their ends for the checksums.
    pub(crate) fn read(path: &SequencePath, frames: &[i32], reads_pixels: bool) -> Self {
        let depth = if reads_pixels { Depth::Pixels } else { Depth::Head };
        let found: Vec<_> = frames.par_iter().map(|&frame| (frame, read_whole(&path.path_of(frame), depth))).collect();
        let mut report = Self::default();
        let mut layers: BTreeMap<String, LayerPeaks> = BTreeMap::new();
        for (frame, outcome) in found {
            let metadata = match outcome {
                Ok(metadata) if metadata.frame == frame => metadata,
                Ok(metadata) => {
                    report.damage(frame, &Redo::OtherFrame(metadata.frame));
                    continue;
                }
                Err(Redo::Missing) => {
                    report.missing.push(frame);
                    continue;
                }
                Err(reason) => {
                    report.damage(frame, &reason);
                    continue;
                }
            };
            report.frames += 1;
            // Settings, without what each frame reads for itself.
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

    fn damage(&mut self, frame: i32, reason: &Redo) {
        self.damaged.push(DamagedFrame { frame, reason: reason.to_string() });
    }

    /// The frames in which some figure is worst, increasing.
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

/// Keeps the greater of two values, the first of equal ones.
fn greatest(peak: &mut Option<Peak>, frame: i32, value: Option<f64>) {
    if let Some(value) = value
        && peak.is_none_or(|greatest| value > greatest.value)
    {
        *peak = Some(Peak { value, frame });
    }
}
