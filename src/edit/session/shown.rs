//! Display options of the viewport.
//!
//! In: user commands. Out: plain switches, unaffected by other operations.

use serde::{Deserialize, Serialize};

/// Display options of the viewport.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Shown {
    /// Lattice lines.
    pub(crate) lattice: bool,
    /// Draggable handles.
    pub handles: bool,
    /// Pins.
    pub(crate) pins: bool,
    /// Names next to pins.
    pub(crate) names: bool,
    /// Rest positions of pinned points.
    pub(crate) rest: bool,
    /// The lattice on the screen, filled with the colours of its distortion.
    pub(crate) distortion: bool,
    /// Painted stiffness.
    pub(crate) painted: bool,
    /// Folded cells, in red.
    pub(crate) folds: bool,
    /// Title-safe and action-safe areas.
    pub(crate) safe_areas: bool,
    /// Motion trails of pins.
    pub(crate) trails: bool,
    /// Onion skins.
    pub(crate) onion: Onion,
    /// Comparison with the unwarped frame.
    #[serde(skip)]
    pub(crate) wipe: Wipe,
    /// Whether only the unwarped frame is shown, temporarily.
    #[serde(skip)]
    pub(crate) is_before: bool,
    /// Whether all overlays are hidden temporarily.
    #[serde(skip)]
    pub(crate) is_hidden: bool,
    /// The pin that the tour points at.
    #[serde(skip)]
    pub(crate) pointed: Option<[usize; 2]>,
}

/// Onion skins: neighbouring frames behind the current one, or over it if it is opaque.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Onion {
    /// Number of frames on either side; 0: off.
    pub(crate) count: u32,
    /// Step between them in frames; 0: the keys of the selected pins and handles.
    pub(crate) every: u32,
    /// Opacity of the nearest.
    pub(crate) opacity: f32,
    /// Tints of frames before and after: red, green, blue.
    pub(crate) tints: [[u8; 3]; 2],
}

/// Comparison with the unwarped frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Wipe {
    /// Off.
    #[default]
    Off,
    /// The unwarped frame is shown left of this fraction of the width.
    At(f32),
    /// The unwarped frame is shown over the warped one, with this opacity.
    Ghost(f32),
}

impl Wipe {
    /// Returns the fraction of the width at which the frame is divided.
    pub(super) const fn share(self) -> Option<f32> {
        if let Self::At(share) = self { Some(share) } else { None }
    }
}

impl Default for Onion {
    fn default() -> Self {
        Self { count: 0, every: 2, opacity: 0.4, tints: [[255, 150, 130], [130, 190, 255]] }
    }
}

impl Shown {
    /// Returns what holds in the next session, too: no comparison, nothing hidden.
    #[must_use]
    pub(crate) const fn lasting(self) -> Self {
        Self { wipe: Wipe::Off, is_before: false, is_hidden: false, pointed: None, ..self }
    }

    /// Whether pins are seen.
    pub(crate) const fn shows_pins(&self) -> bool {
        self.pins && !self.is_hidden
    }

    /// Whether handles are seen.
    pub(super) const fn shows_handles(&self) -> bool {
        self.handles && !self.is_hidden
    }
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
            painted: false,
            folds: true,
            safe_areas: false,
            trails: false,
            onion: Onion::default(),
            wipe: Wipe::Off,
            is_before: false,
            is_hidden: false,
            pointed: None,
        }
    }
}

impl super::Session {
    /// Sets the comparison, and requests the unwarped frame if it is missing.
    pub(crate) fn set_wipe(&mut self, wipe: Wipe) {
        let was_wanted = self.wants_before();
        self.shown.wipe = wipe;
        self.request_before(was_wanted);
    }

    /// Shows the unwarped frame alone, whatever the comparison is, or ends that.
    pub(crate) fn show_before(&mut self, is_before: bool) {
        let was_wanted = self.wants_before();
        self.shown.is_before = is_before;
        self.request_before(was_wanted);
    }

    /// Returns whether the unwarped frame is shown.
    pub(super) fn wants_before(&self) -> bool {
        self.shown.is_before || self.shown.wipe != Wipe::Off
    }

    fn request_before(&mut self, was_wanted: bool) {
        if !was_wanted && self.wants_before() && self.before().is_none() {
            self.refresh(super::Purpose::Look);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edit::Session;

    #[test]
    fn the_unwarped_frame_is_shown_for_a_while_and_the_comparison_stays() {
        let mut session = Session::of_text("scene = 'a.glb'\nframes = { first = 1, last = 24 }\n");
        session.set_wipe(Wipe::At(0.25));
        session.show_before(true);
        assert!(session.shown.is_before && session.wants_before());
        session.show_before(false);
        assert_eq!((session.shown.wipe, session.shown.is_before), (Wipe::At(0.25), false));
        session.show_before(true);
        assert!(!session.shown.lasting().is_before);
    }
}
