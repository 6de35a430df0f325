//! The tour of two minutes for a first start: what to do next, and whether it is done.
//!
//! In: the state of a [`Session`]. Out: the step, and its words.

use super::Session;

/// The pin of the tour's scene that is dragged.
const HAND: &str = "near hand";

/// A step of the tour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TourStep {
    Drag,
    Frame,
    DragAgain,
    Play,
    Pin,
    Render,
    End,
}

impl TourStep {
    const ALL: [Self; 7] = [Self::Drag, Self::Frame, Self::DragAgain, Self::Play, Self::Pin, Self::Render, Self::End];

    /// Returns the title.
    const fn title(self) -> &'static str {
        match self {
            Self::Drag => "Drag a pin",
            Self::Frame => "Go to another frame",
            Self::DragAgain => "Drag the hand again",
            Self::Play => "Press play",
            Self::Pin => "Add a pin of your own",
            Self::Render => "Save and render",
            Self::End => "That is all",
        }
    }

    /// Returns the title, and what to do.
    fn words(self, session: &Session) -> [String; 2] {
        let text = match self {
            Self::Drag => "The orange dots are pins. Drag the one on the gnome's hand, in the two circles: its shape follows at \
                           once."
                .to_owned(),
            Self::Frame => "Click into the ruler below the picture. The drag set a key where you were.".to_owned(),
            Self::DragAgain => "Put it somewhere else in this frame. This sets another key. The gnome's layers move on twos, each \
                                drawing for two frames, so in an even frame such as 12 the key stands at the first of the two, 11."
                .to_owned(),
            Self::Play => "The space bar plays and stops. Between the two keys the hand moves along.".to_owned(),
            Self::Pin => "Click the model, not a pin: a pin holds the point of the surface under it.".to_owned(),
            Self::Render => format!(
                "Ctrl+S saves the shot. Ctrl+R, or Render above, writes the frames, and previews beside them, to {}. You can \
                 cancel it and go on later.",
                session.shot().output.path.parent().unwrap_or(&session.shot().output.path).display()
            ),
            Self::End => format!(
                "Ctrl+Z undoes everything, Ctrl+S saves to {}. F1 lists the keys; File, Open takes your own model.",
                session.document().path().display()
            ),
        };
        [self.title().to_owned(), text]
    }
}

/// The tour in progress.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Tour {
    step: TourStep,
    /// The frame when the step began.
    frame: i32,
    /// Number of moves in the history when the step began.
    moves: usize,
    /// Number of added pins then.
    pins: usize,
}

impl Tour {
    /// Begins the tour.
    #[must_use]
    pub(crate) fn begin(session: &Session) -> Self {
        Self::at(TourStep::Drag, session)
    }

    fn at(step: TourStep, session: &Session) -> Self {
        Self { step, frame: session.playhead.frame(), moves: count(session, "Move "), pins: count(session, "Add pin") }
    }

    /// Returns the title of the step, and what to do.
    #[must_use]
    pub(crate) fn words(&self, session: &Session) -> [String; 2] {
        self.step.words(session)
    }

    /// Returns the pin that the step is about.
    #[must_use]
    pub(crate) fn pin(&self, session: &Session) -> Option<[usize; 2]> {
        if !matches!(self.step, TourStep::Drag | TourStep::DragAgain) {
            return None;
        }
        let layers = session.shot().layers.iter().enumerate();
        { layers }.find_map(|(layer, own)| Some([layer, own.pins.iter().position(|pin| pin.name == HAND)?]))
    }

    /// Returns the number of the step, from 1, and the number of steps.
    #[must_use]
    pub(crate) fn place(&self) -> [usize; 2] {
        let place = TourStep::ALL.iter().position(|step| *step == self.step).unwrap_or(0);
        [place + 1, TourStep::ALL.len()]
    }

    /// Goes on to the next step if this one is done.
    pub(crate) fn follow(&mut self, session: &Session) {
        let is_done = match self.step {
            TourStep::Drag | TourStep::DragAgain => count(session, "Move ") > self.moves,
            TourStep::Frame => session.playhead.frame() != self.frame,
            TourStep::Play => session.playhead.is_playing(),
            TourStep::Pin => count(session, "Add pin") > self.pins,
            TourStep::Render => session.run().is_some(),
            TourStep::End => false,
        };
        if is_done {
            self.skip(session);
        }
    }

    /// Goes on to the next step.
    pub(crate) fn skip(&mut self, session: &Session) {
        let [place, _] = self.place();
        if let Some(&next) = TourStep::ALL.get(place) {
            *self = Self::at(next, session);
        }
    }
}

/// Number of changes with labels that begin like this.
fn count(session: &Session, label: &str) -> usize {
    session.document().history().labels().filter(|other| other.starts_with(label)).count()
}
