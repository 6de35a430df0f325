//! Figures of frames, and the worst frame of the played range by each.
//!
//! In: the reports of frames. Out: numbers, frames to go to.

use super::{Purpose, Session};
use crate::pipeline::{FrameReport, LayerReport};

/// A figure of a frame's report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Figure {
    /// The largest distance of a pin from its target.
    PinError,
    /// The least determinant of a cell; below 0 it folds.
    LeastDet,
    /// The angular distortion.
    Distortion,
    /// The jerk of the warp.
    Jerk,
}

impl Figure {
    /// All figures, in the order of the table.
    pub(crate) const ALL: [Self; 4] = [Self::PinError, Self::LeastDet, Self::Distortion, Self::Jerk];

    /// Returns the display name.
    #[must_use]
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::PinError => "Pin error, px",
            Self::LeastDet => "Least det J",
            Self::Distortion => "Distortion",
            Self::Jerk => "Jerk, px",
        }
    }

    /// Returns 1 if higher is worse, -1 if lower is.
    const fn sign(self) -> f64 {
        match self {
            Self::PinError | Self::Distortion | Self::Jerk => 1.0,
            Self::LeastDet => -1.0,
        }
    }

    fn of_layer(self, layer: &LayerReport) -> Option<f64> {
        match self {
            Self::PinError => Some(layer.pin_error_px),
            Self::LeastDet => Some(layer.solve.min_cell_det),
            Self::Distortion => Some(layer.solve.angular),
            Self::Jerk => Some(layer.jerk?.warp_px),
        }
    }

    /// Returns the worst value over all layers of a frame; `None` if there is none.
    #[must_use]
    pub(crate) fn of(self, report: &FrameReport) -> Option<f64> {
        let known = report.layers.iter().filter_map(|layer| self.of_layer(layer)).filter(|value| value.is_finite());
        known.max_by(|a, b| (self.sign() * a).total_cmp(&(self.sign() * b)))
    }

    /// Returns whether a value deserves a look.
    #[must_use]
    pub(crate) fn is_bad(self, value: f64) -> bool {
        let limit = match self {
            Self::PinError => 0.05,
            Self::LeastDet => 0.1,
            Self::Distortion => 1.0,
            Self::Jerk => 40.0,
        };
        self.sign() * value > self.sign() * limit
    }
}

impl Session {
    /// Returns the worst frame of the played range by a figure, of the frames that are known, with its value.
    #[must_use]
    pub(crate) fn worst(&self, figure: Figure) -> Option<(i32, f64)> {
        let [first, last] = self.playhead.range();
        let known = self.reports.range(first..=last.max(first));
        let known = known.filter_map(|(&frame, report)| Some((frame, figure.of(report)?)));
        // Of equals the first is the worst.
        known.rev().max_by(|a, b| (figure.sign() * a.1).total_cmp(&(figure.sign() * b.1)))
    }

    /// Goes to the worst frame of the played range by a figure, of the frames that are known.
    pub(crate) fn go_to_worst(&mut self, figure: Figure) {
        if let Some((frame, _)) = self.worst(figure) {
            self.go(frame);
        }
    }

    /// Returns of how many frames of the played range figures are known, and how many frames it has.
    #[must_use]
    pub(crate) fn reported(&self) -> [usize; 2] {
        let [first, last] = self.playhead.range();
        let count = usize::try_from(i64::from(last) - i64::from(first) + 1).unwrap_or(0);
        [self.reports.range(first..=last.max(first)).count(), count]
    }

    /// Returns the frames of the played range without a report, in playback order.
    pub(super) fn frames_without_report(&self) -> Vec<i32> {
        let [first, last] = self.playhead.range();
        let here = self.playhead.frame().clamp(first, last.max(first));
        (here..=last).chain(first..here).filter(|frame| !self.reports.contains_key(frame)).collect()
    }

    /// Restricts playback to a range; `None`: the whole shot.
    pub(crate) fn set_range(&mut self, range: Option<[i32; 2]>) {
        self.playhead.set_range(range);
        // Frames may be missing that were not in the range before.
        self.refresh(if self.playhead.is_playing() { Purpose::Play } else { Purpose::Look });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edit::worker::Reply;

    fn report(frame: i32, error: f64) -> FrameReport {
        let layer = LayerReport { pin_error_px: error, ..LayerReport::default() };
        FrameReport { frame, layers: vec![layer], ..FrameReport::default() }
    }

    #[test]
    fn frames_that_were_not_drawn_count_within_the_played_range() {
        let mut session = Session::of_text("scene = 'a.glb'\nframes = { first = 1, last = 1000 }\n");
        assert_eq!((session.reported(), session.frames_without_report().len()), ([0, 1000], 1000));
        let told = |session: &mut Session, revision, frame, error| {
            session.take(Reply::Reported(revision, frame, Box::new(report(frame, error))));
        };
        let revision = session.revision;
        for (frame, error) in [(2, 1.0), (900, 3.0), (950, 3.0), (3, f64::NAN)] {
            told(&mut session, revision, frame, error);
        }
        told(&mut session, revision - 1, 5, 99.0);
        assert_eq!((session.reported(), session.worst(Figure::PinError)), ([4, 1000], Some((900, 3.0))));
        session.go_to_worst(Figure::PinError);
        assert_eq!(session.playhead.frame(), 900);
        assert_eq!(session.frames_without_report()[..2], [901, 902], "what is played next comes first");
        session.set_range(Some([1, 10]));
        assert_eq!((session.reported(), session.worst(Figure::PinError)), ([2, 10], Some((2, 1.0))));
        session.frames_changed();
        assert_eq!((session.reported(), session.worst(Figure::PinError)), ([0, 10], None));
    }

    #[test]
    fn a_least_determinant_is_bad_where_it_is_low() {
        assert!(Figure::LeastDet.is_bad(-1.0) && Figure::LeastDet.is_bad(0.05) && !Figure::LeastDet.is_bad(0.5));
        assert!(Figure::Jerk.is_bad(50.0) && !Figure::Jerk.is_bad(0.5));
    }
}
