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
        let old = self.document.shot().size;
        self.document.read_files_again();
        if self.document.shot().size != old {
            return self.document_changed();
        }
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
    use crate::edit::worker::Reply;

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

    #[test]
    fn the_progress_of_a_solve_that_is_overtaken_is_not_shown() {
        let mut session = Session::of_text(
            "plate = 'a.####.exr'\nsize = [96, 54]\nframes = { first = 1, last = 24 }\n[[layer]]\nname = 'all'\n",
        );
        let overtaken = session.revision;
        session.take(Reply::Progress(overtaken, 0.4));
        assert_eq!(session.progress(), Some(0.4));
        session.plates_changed(&[[3, 3]]);
        assert_eq!(session.progress(), None);
        // What was sent before is read after it.
        session.take(Reply::Progress(overtaken, 0.5));
        assert_eq!(session.progress(), None);
        session.take(Reply::Progress(session.revision, 0.1));
        assert_eq!(session.progress(), Some(0.1));
        session.frames_changed();
        assert_eq!(session.progress(), None);
    }

    #[test]
    fn the_size_is_that_of_plates_that_appear() {
        let folder = tempfile::tempdir().expect("a folder");
        let text = "plate = 'a.##.png'\nframes = { first = 1, last = 24 }\n[[layer]]\nname = 'all'\n";
        let document = crate::edit::Document::new(&folder.path().join("shot.toml"), text.to_owned()).expect("a shot");
        let mut session = Session::new(document, crate::raster::DeviceChoice::Cpu, || ());
        assert_eq!(session.shot().size, crate::space::FrameSize::new(1920, 1080), "there is none yet");
        for (frame, width) in [(3, 96), (2, 48)] {
            let plate = crate::image::Preview::transparent(width, 27);
            crate::image::write_png(&folder.path().join(format!("a.{frame:02}.png")), &plate).expect("written");
            session.plates_changed(&[[frame, frame]]);
            assert_eq!(session.shot().size, crate::space::FrameSize::new(width, 27));
            assert!(session.message().is_some_and(|told| told.contains("drawn again")));
        }
    }
}
