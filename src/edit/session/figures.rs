//! Figures of frames, and the worst frame of the played range by each.
//!
//! In: the reports of frames. Out: numbers, frames to go to.

use super::{Purpose, Session};
use crate::edit::frame_runs::{FrameRuns, length};
use crate::pipeline::{FrameReport, LayerReport};
use std::cmp::Ordering;
use std::collections::{BTreeMap, VecDeque};

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

    /// Returns what it means, when it deserves a look, and what to do then.
    #[must_use]
    pub(crate) const fn explanation(self) -> &'static str {
        match self {
            Self::PinError => {
                "How far the worst pin is from where it was put, in pixels. Above 0.05 pins contradict each other, or are soft: move \
                 one of them, delete it, or make it hard."
            }
            Self::LeastDet => {
                "How much the most squeezed cell of the lattice keeps of its area: 1 is all of it, below 0 it is folded over. Below 0.1 \
                 look for creases: pull pins apart, or add one between them."
            }
            Self::Distortion => {
                "How much circles become ellipses, on average over the layer: 0: not at all, 0.5: twice as long as wide. Above 1 the \
                 shape looks sheared: spread the bend with a pin beside it, or turn the pin by its ring."
            }
            Self::Jerk => {
                "How abruptly the warp changes its speed here, in pixels. Above 40 the motion pops: ease the keys around this frame, \
                 or put one between them."
            }
        }
    }

    /// Returns the order of frames with values, the worst last; of equals the first frame is the worst.
    fn worse(self) -> impl Fn(&(i32, f64), &(i32, f64)) -> Ordering {
        move |a, b| (self.sign() * a.1).total_cmp(&(self.sign() * b.1)).then(b.0.cmp(&a.0))
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

/// The figures of the frames as rendered, of those that were not drawn, too. The worst frames of one range are kept, so that a window
/// need not look for them in every pass.
#[derive(Debug, Default)]
pub(super) struct Figures {
    /// All figures of each frame, in the order of [`Figure::ALL`].
    known: BTreeMap<i32, [Option<f64>; Figure::ALL.len()]>,
    frames: FrameRuns,
    /// The range that is followed.
    range: [i32; 2],
    /// Its worst frame by each figure.
    worst: [Option<(i32, f64)>; Figure::ALL.len()],
}

impl Figures {
    /// Takes the figures of a frame, in place of those that it had.
    pub(super) fn insert(&mut self, frame: i32, report: &FrameReport) {
        let new = Figure::ALL.map(|figure| figure.of(report));
        let old = self.known.insert(frame, new);
        self.frames.insert(frame);
        if old == Some(new) || !(self.range[0]..=self.range[1]).contains(&frame) {
            return;
        }
        let was_worst = self.worst.iter().flatten().any(|(worst, _)| *worst == frame);
        if was_worst {
            return self.find_worst();
        }
        for ((figure, worst), value) in Figure::ALL.into_iter().zip(&mut self.worst).zip(new) {
            *worst = [*worst, value.map(|value| (frame, value))].into_iter().flatten().max_by(figure.worse());
        }
    }

    /// Forgets all frames.
    pub(super) fn clear(&mut self) {
        self.known.clear();
        self.frames.clear();
        self.worst = Default::default();
    }

    /// Follows a range.
    pub(super) fn follow(&mut self, range: [i32; 2]) {
        if self.range != range {
            self.range = range;
            self.find_worst();
        }
    }

    fn find_worst(&mut self) {
        self.worst = Figure::ALL.map(|figure| self.worst_within(self.range, figure));
    }

    fn worst_within(&self, [first, last]: [i32; 2], figure: Figure) -> Option<(i32, f64)> {
        let known = self.known.range(first..=last.max(first));
        known.filter_map(|(&frame, all)| Some((frame, all[figure as usize]?))).max_by(figure.worse())
    }

    /// Returns the worst known frame of a range by a figure, with its value; of equals the first.
    fn worst(&self, range: [i32; 2], figure: Figure) -> Option<(i32, f64)> {
        if range == self.range { self.worst[figure as usize] } else { self.worst_within(range, figure) }
    }
}

impl Session {
    /// Returns the worst frame of the played range by a figure, of the frames that are known, with its value.
    #[must_use]
    pub(crate) fn worst(&self, figure: Figure) -> Option<(i32, f64)> {
        self.figures.worst(self.playhead.range(), figure)
    }

    /// Takes the figures of a frame as rendered.
    pub(super) fn take_figures(&mut self, frame: i32, report: &FrameReport) {
        self.figures.follow(self.playhead.range());
        self.figures.insert(frame, report);
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
        let range = self.playhead.range();
        [self.figures.frames.count(range), length(range)]
    }

    /// Returns the runs of frames of the played range without a report, in playback order.
    pub(super) fn frames_without_report(&self) -> VecDeque<[i32; 2]> {
        let [first, last] = self.playhead.range();
        let here = self.playhead.frame().clamp(first, last.max(first));
        let mut runs = self.figures.frames.gaps([here, last]);
        if first < here {
            runs.append(&mut self.figures.frames.gaps([first, here - 1]));
        }
        runs
    }

    /// Restricts playback to a range; `None`: the whole shot.
    pub(crate) fn set_range(&mut self, range: Option<[i32; 2]>) {
        self.playhead.set_range(range);
        self.figures.follow(self.playhead.range());
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
        assert_eq!((session.reported(), session.frames_without_report()), ([0, 1000], [[1, 1000]].into()));
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
        let missing = [[901, 949], [951, 1000], [1, 1], [4, 899]];
        assert_eq!(session.frames_without_report(), missing, "what is played next comes first");
        session.set_range(Some([1, 10]));
        assert_eq!((session.reported(), session.worst(Figure::PinError)), ([2, 10], Some((2, 1.0))));
        session.frames_changed();
        assert_eq!((session.reported(), session.worst(Figure::PinError)), ([0, 10], None));
    }

    #[test]
    fn the_worst_frame_is_followed_as_frames_become_known_better_and_worse() {
        let mut figures = Figures::default();
        figures.follow([10, 20]);
        let worst = |figures: &Figures| figures.worst([10, 20], Figure::PinError);
        // Outside, first, equal but later, equal and earlier, worse, better, gone.
        let steps = [
            ((9, 9.0), None),
            ((15, 1.0), Some((15, 1.0))),
            ((16, 1.0), Some((15, 1.0))),
            ((14, 1.0), Some((14, 1.0))),
            ((20, 2.0), Some((20, 2.0))),
            ((20, 0.5), Some((14, 1.0))),
            ((14, f64::NAN), Some((15, 1.0))),
        ];
        for ((frame, error), expected) in steps {
            figures.insert(frame, &report(frame, error));
            assert_eq!(worst(&figures), expected, "frame {frame}: {error}");
            assert_eq!(figures.worst([10, 20], Figure::PinError), figures.worst_within([10, 20], Figure::PinError));
        }
        assert_eq!(figures.worst([1, 20], Figure::PinError), Some((9, 9.0)), "another range");
        figures.follow([1, 20]);
        assert_eq!(figures.worst([1, 20], Figure::PinError), Some((9, 9.0)));
        figures.clear();
        assert_eq!(figures.worst([1, 20], Figure::PinError), None);
    }

    #[test]
    fn a_least_determinant_is_bad_where_it_is_low() {
        assert!(Figure::LeastDet.is_bad(-1.0) && Figure::LeastDet.is_bad(0.05) && !Figure::LeastDet.is_bad(0.5));
        assert!(Figure::Jerk.is_bad(50.0) && !Figure::Jerk.is_bad(0.5));
    }
}
