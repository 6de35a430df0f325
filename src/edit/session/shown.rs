//! Display options of the viewport.
//!
//! In: user commands. Out: plain switches, unaffected by other operations.

/// Display options of the viewport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// Lattice lines.
    pub lattice: bool,
    /// Draggable handles.
    pub handles: bool,
    /// Pins.
    pub pins: bool,
    /// Names next to pins.
    pub names: bool,
    /// Rest positions of pinned points.
    pub rest: bool,
    /// Lattice lines coloured by stretch.
    pub distortion: bool,
    /// Folded cells, in red.
    pub folds: bool,
    /// Title-safe and action-safe areas.
    pub safe_areas: bool,
    /// Motion trails of pins.
    pub trails: bool,
    /// Onion skins.
    pub onion: Onion,
    /// Comparison with the unwarped frame.
    pub wipe: Wipe,
    /// Whether all overlays are hidden temporarily.
    pub is_hidden: bool,
}

/// Onion skins: neighbouring frames behind the current one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Onion {
    /// Number of frames on either side; 0: off.
    pub count: u32,
    /// Step between them in frames; 0: the keys of the selected pins.
    pub every: u32,
    /// Opacity of the nearest.
    pub opacity: f32,
}

/// Comparison with the unwarped frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Wipe {
    /// Off.
    #[default]
    Off,
    /// Only the unwarped frame is shown.
    Before,
    /// The unwarped frame is shown left of this fraction of the width.
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
    /// Sets the comparison, and requests the unwarped frame if it is missing.
    pub fn set_wipe(&mut self, wipe: Wipe) {
        let is_new = self.shown.wipe == Wipe::Off && wipe != Wipe::Off;
        self.shown.wipe = wipe;
        if is_new && self.before().is_none() {
            self.refresh(super::Purpose::Look);
        }
    }
}
