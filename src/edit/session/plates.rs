//! Plates that another program writes while they are shown.
//!
//! In: the frames that changed. Out: requests to draw them again.

use super::{Purpose, Session};

impl Session {
    /// Draws frames again whose plates changed on disk: from first to last, both included.
    pub(super) fn plates_changed(&mut self, changed: &[[i32; 2]]) {
        let has_changed = |frame: i32| changed.iter().any(|[first, last]| (*first..=*last).contains(&frame));
        self.pictures.retain(|frame, _| !has_changed(*frame));
        self.before = self.before.take().filter(|picture| !has_changed(picture.frame));
        self.say("The plates changed on disk and are drawn again.");
        // A drag draws its frames again as it ends.
        if self.dragged.is_none() {
            (self.revision, self.fault) = (self.revision + 1, None);
            self.refresh(Purpose::Look);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plates_that_changed_clear_a_fault_and_are_drawn_again() {
        let mut session = Session::of_text(
            "plate = 'a.####.exr'\nsize = [96, 54]\nframes = { first = 1, last = 24 }\n[[layer]]\nname = 'all'\n",
        );
        let revision = session.revision;
        session.fault = Some("the plate is missing".into());
        session.plates_changed(&[[3, 3]]);
        assert!(session.fault().is_none() && session.revision > revision && !session.is_idle());
    }
}
