//! The state of the picture in words, for its corner.
//!
//! In: the picture, the solve and the frame that are shown. Out: lines of text.

use super::Session;
use crate::edit::Quality;
use crate::pipeline::LayerShift;

/// Movement that is told, pixels.
const SHIFTED: f64 = 5.0;

/// The words for a frame that is solved without the others.
const PROVISIONAL: &str = "provisional: solved alone, may change";

/// The words for a picture of the shot before the last change.
const OUTDATED: &str = "older than the pins";

impl Session {
    /// Returns how the picture was made, and what the frame that is asked for still waits for. A frame in which a jump is spread
    /// says so first.
    #[must_use]
    pub(crate) fn corner(&self) -> String {
        let here = self.playhead.frame();
        if self.fault().is_some() {
            return "cannot be drawn".to_owned();
        }
        if self.shows_rendered() {
            return "file of the render".to_owned();
        }
        let Some(picture) = self.picture() else { return "loading".to_owned() };
        let solving = self.progress().map(|part| format!("solving over time: {:.0} %", 100.0 * part));
        if picture.frame != here {
            let shown = format!("frame {} shown", picture.frame);
            return match solving {
                Some(solving) => format!("{solving}   {shown}"),
                None => shown,
            };
        }
        if picture.revision != self.revision {
            let state = solving.unwrap_or_else(|| "being drawn".to_owned());
            return format!("{OUTDATED}: {state}");
        }
        if self.is_dragging() {
            return PROVISIONAL.to_owned();
        }
        let quality = match (solving, picture.quality) {
            (Some(solving), _) => format!("{solving}, solved alone until then, may change"),
            (None, Quality::Provisional) => PROVISIONAL.to_owned(),
            (None, Quality::Draft) => "draft".to_owned(),
            (None, Quality::Final) => match self.solo() {
                Some(solo) => format!("as rendered, but for the solo of '{solo}'"),
                None => "as rendered".to_owned(),
            },
        };
        let jump = self.jump().map(|[first, last]| {
            format!("The pose jumps near here: spread over frames {first} to {last}.\nA pin where it bends keeps it.\n")
        });
        [jump.unwrap_or_default(), self.shift().unwrap_or_default(), quality].concat()
    }

    /// Returns what to do where the frame is not what was shown before it was solved over time, as a line.
    fn shift(&self) -> Option<String> {
        let (_, shifts) = self.shifts.as_ref().filter(|(frame, _)| *frame == self.playhead.frame())?;
        let LayerShift { layer, node, pixels } = shifts.first().filter(|shift| shift.pixels > SHIFTED)?;
        Some(format!(
            "'{node}' moved by {pixels:.0} px when solved over time: pin it where it should stay, or lower Over time of '{layer}'.\n"
        ))
    }

    /// Returns the frames over which a jump is spread, if this frame is among them.
    fn jump(&self) -> Option<[f64; 2]> {
        let solve = self.solve().filter(|solve| solve.is_final && solve.frame == self.playhead.frame())?;
        solve.report.spreads.first().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edit::Picture;
    use crate::edit::worker::{Reply, SolvedFrame};
    use crate::pipeline::{FrameReport, LayerMarks};
    use std::sync::Arc;

    fn drawn(session: &mut Session, frame: i32, quality: Quality) {
        let picture = Picture { frame, revision: session.revision, size: [1, 1], rgba: vec![0; 4], quality };
        session.take(Reply::Drawn(Arc::new(picture)));
    }

    fn solved(session: &mut Session, frame: i32, spreads: Vec<[f64; 2]>) {
        let report = FrameReport { frame, spreads, ..FrameReport::default() };
        let (revision, marks, is_final) = (session.revision, vec![LayerMarks::default()], !report.spreads.is_empty());
        session.take(Reply::Solved(Arc::new(SolvedFrame { frame, revision, marks, report, is_final })));
    }

    #[test]
    fn the_corner_says_which_frame_is_seen_and_whether_it_may_change() {
        let mut session = Session::of_text("scene = 'a.glb'\nframes = { first = 1, last = 24 }\n");
        session.fault = None;
        assert_eq!(session.corner(), "loading");
        solved(&mut session, 1, Vec::new());
        drawn(&mut session, 1, Quality::Provisional);
        assert_eq!(session.corner(), "provisional: solved alone, may change");
        session.take(Reply::Progress(session.revision, 0.4));
        assert!(session.corner().starts_with("solving over time: 40 %, solved alone"), "{}", session.corner());
        session.frames_changed();
        assert_eq!(session.corner(), "older than the pins: being drawn");
        session.take(Reply::Progress(session.revision, 0.4));
        assert_eq!(session.corner(), "older than the pins: solving over time: 40 %");
        session.go(12);
        assert_eq!(session.corner(), "solving over time: 40 %   frame 1 shown");
        session.take(Reply::Progress(session.revision, 1.0));
        assert_eq!(session.corner(), "frame 1 shown");
        solved(&mut session, 12, vec![[11.0, 21.0]]);
        drawn(&mut session, 12, Quality::Final);
        let told = session.corner();
        assert!(
            told.starts_with("The pose jumps near here: spread over frames 11 to 21.")
                && told.ends_with("\nas rendered")
        );
        let shift = |pixels| LayerShift { layer: "all".into(), node: "Sword".into(), pixels };
        session.take(Reply::Shifted(session.revision, 12, vec![shift(4.0)]));
        assert_eq!(session.corner(), told, "less than can be seen");
        session.take(Reply::Shifted(session.revision, 12, vec![shift(38.4), shift(7.0)]));
        assert!(
            session.corner().contains("\n'Sword' moved by 38 px when solved over time: pin it"),
            "{}",
            session.corner()
        );
        session.go(11);
        assert!(!session.corner().contains("Sword"));
        session.frames_changed();
        session.go(12);
        assert!(!session.corner().contains("Sword"));
    }

    #[test]
    fn pins_of_one_frame_are_not_drawn_over_the_picture_of_another_while_a_third_is_asked_for() {
        let mut session = Session::of_text("scene = 'a.glb'\nframes = { first = 1, last = 24 }\n");
        solved(&mut session, 1, Vec::new());
        drawn(&mut session, 1, Quality::Draft);
        session.go(2);
        assert_eq!(session.marks().len(), 1, "pins and picture are of one frame");
        solved(&mut session, 2, Vec::new());
        assert_eq!(session.marks().len(), 1, "they are of the frame that is edited");
        session.go(3);
        assert_eq!(session.marks().len(), 0);
    }
}
