//! What is drawn over the picture.
//!
//! In: what the person asks for. Out: plain switches; they stay as they are whatever else is done.

/// Switches of the viewport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// Lines of lattices.
    pub lattice: bool,
    /// Handles, to be dragged.
    pub handles: bool,
    /// Pins.
    pub pins: bool,
    /// Names beside pins.
    pub names: bool,
    /// Where pinned points are at rest.
    pub rest: bool,
    /// Lines in the colour of how far they are stretched.
    pub distortion: bool,
    /// Cells that fold, in red.
    pub folds: bool,
    /// Frames within which titles and action are safe.
    pub safe_areas: bool,
    /// Ways of pins over time.
    pub trails: bool,
    /// Neighbouring frames.
    pub onion: Onion,
    /// The unwarped frame.
    pub wipe: Wipe,
    /// Nothing is drawn over the picture for now.
    pub is_hidden: bool,
}

/// Neighbouring frames behind the one that is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Onion {
    /// Frames on either side; 0: none.
    pub count: u32,
    /// Frames between them; 0: the keys of chosen pins.
    pub every: u32,
    /// Of the nearest.
    pub opacity: f32,
}

/// How the unwarped frame is compared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Wipe {
    /// It is not.
    #[default]
    Off,
    /// It alone is seen.
    Before,
    /// It is seen left of this share of the picture.
    At(f32),
}

impl Default for Shown {
    fn default() -> Self {
        Self {
            lattice: true,
            handles: false,
            pins: true,
            names: true,
            rest: true,
            distortion: false,
            folds: true,
            safe_areas: false,
            trails: false,
            onion: Onion { count: 0, every: 2, opacity: 0.4 },
            wipe: Wipe::Off,
            is_hidden: false,
        }
    }
}

impl super::Session {
    /// Compares with the unwarped frame, or no more.
    pub fn set_wipe(&mut self, wipe: Wipe) {
        let is_new = self.shown.wipe == Wipe::Off && wipe != Wipe::Off;
        self.shown.wipe = wipe;
        if is_new && self.before().is_none() {
            self.refresh(super::Purpose::Look);
        }
    }
}
