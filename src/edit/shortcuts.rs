//! All actions with keyboard shortcuts: one table for menus, the in-app list, the user's key file and the window.
//!
//! In: a JSON file `{"undo": "Ctrl+Z"}`. Out: chords by action. Key names are those of the list.

use super::EditError;
use crate::files::{TABLE_BYTES, read_text};
use crate::image::replace_text;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A key combination.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Chord {
    /// Ctrl, or Cmd on a Mac.
    pub(crate) command: bool,
    /// Shift.
    pub(crate) shift: bool,
    /// Alt.
    pub(crate) alt: bool,
    /// The key's name, "Z" or "Space".
    pub(crate) key: String,
}

impl Chord {
    /// Parses a chord such as "Ctrl+Shift+Z".
    #[must_use]
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let mut chord = Self::default();
        let mut parts: Vec<&str> = text.split('+').map(str::trim).collect();
        chord.key = parts.pop().filter(|key| !key.is_empty())?.to_owned();
        for part in parts {
            match part.to_lowercase().as_str() {
                "ctrl" | "cmd" => chord.command = true,
                "shift" => chord.shift = true,
                "alt" => chord.alt = true,
                _ => return None,
            }
        }
        Some(chord)
    }
}

impl std::fmt::Display for Chord {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (held, name) in [(self.command, "Ctrl+"), (self.shift, "Shift+"), (self.alt, "Alt+")] {
            if held {
                out.write_str(name)?;
            }
        }
        out.write_str(&self.key)
    }
}

/// Declares the actions: variant, id in files, description, default chord.
macro_rules! actions {
    ($($action:ident $id:literal $group:literal $words:literal $chord:literal,)*) => {
        /// An action that a key can trigger.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub(crate) enum Action {
            $(#[doc = $words] $action,)*
        }

        impl Action {
            /// All actions, in the order of the list.
            pub(crate) const ALL: &[Self] = &[$(Self::$action,)*];

            /// Returns the id used in files.
            #[must_use]
            pub(crate) const fn id(self) -> &'static str {
                match self { $(Self::$action => $id,)* }
            }

            /// Returns the group that the action is listed under.
            #[must_use]
            pub(crate) const fn group(self) -> &'static str {
                match self { $(Self::$action => $group,)* }
            }

            /// Returns the description shown to the user.
            #[must_use]
            pub(crate) const fn words(self) -> &'static str {
                match self { $(Self::$action => $words,)* }
            }

            const fn usual(self) -> &'static str {
                match self { $(Self::$action => $chord,)* }
            }
        }
    };
}

actions! {
    Start "start" "File" "New, from the start page" "Ctrl+N",
    Open "open" "File" "Open" "Ctrl+O",
    Save "save" "File" "Save" "Ctrl+S",
    SaveAs "save_as" "File" "Save as" "Ctrl+Shift+S",
    Render "render" "File" "Render" "Ctrl+R",
    RenderOptions "render_options" "File" "Render options" "Ctrl+Alt+R",
    Reference "reference" "File" "Reference picture" "Ctrl+Shift+R",
    Plate "plate" "File" "Choose plate" "Ctrl+P",
    Quit "quit" "File" "Quit" "Ctrl+Q",
    Undo "undo" "Edit" "Undo" "Ctrl+Z",
    Redo "redo" "Edit" "Redo" "Ctrl+Shift+Z",
    Copy "copy" "Edit" "Copy keys" "Ctrl+C",
    Paste "paste" "Edit" "Paste keys" "Ctrl+V",
    Delete "delete" "Edit" "Delete keys or pins" "Delete",
    Mute "mute" "Edit" "Mute pins" "M",
    Hard "hard" "Edit" "Hard or soft pins" "E",
    All "all" "Edit" "Select all pins" "Ctrl+A",
    Play "play" "Time" "Play or stop" "Space",
    Back "back" "Time" "Frame back" "Comma",
    Forward "forward" "Time" "Frame forward" "Period",
    KeyBack "key_back" "Time" "Previous key" "Shift+Comma",
    KeyForward "key_forward" "Time" "Next key" "Shift+Period",
    First "first" "Time" "First frame" "Home",
    Last "last" "Time" "Last frame" "End",
    Key "key" "Time" "Insert key" "K",
    RangeIn "range_in" "Time" "Play from here" "I",
    RangeOut "range_out" "Time" "Play to here" "O",
    RangeAll "range_all" "Time" "Play the whole shot" "Shift+O",
    Fit "fit" "View" "Fit the picture" "F",
    OneToOne "one_to_one" "View" "One to one" "1",
    ZoomIn "zoom_in" "View" "Zoom in" "Plus",
    ZoomOut "zoom_out" "View" "Zoom out" "Minus",
    Lattice "lattice" "View" "Lattice" "G",
    Handles "handles" "View" "Handles" "L",
    Pins "pins" "View" "Pins" "P",
    Distortion "distortion" "View" "Distortion" "D",
    Trails "trails" "View" "Motion trails" "T",
    Onion "onion" "View" "Onion skin" "N",
    SafeAreas "safe_areas" "View" "Safe areas" "A",
    Curves "curves" "View" "Curves of keys" "C",
    Mirror "mirror" "Edit" "Mirror edits" "X",
    MirrorPins "mirror_pins" "Edit" "Mirror pins" "Shift+X",
    Wipe "wipe" "View" "Wipe before and after" "W",
    Ghost "ghost" "View" "Ghost of the rest" "Shift+W",
    Painted "painted" "View" "Painted stiffness" "Shift+S",
    Pan "pan" "Hold" "Drag the picture; a tap plays" "Space",
    Hide "hide" "Hold" "Hide everything over the picture" "H",
    Before "before" "Hold" "Show the frame without the warp" "B",
    Region "region" "Hold" "Drag a pin's region, or the brush's radius" "R",
    Stiffness "stiffness" "Hold" "Drag a pin's stiffness, or paint it" "S",
    NudgeLeft "nudge_left" "Nudge" "Left by a pixel" "Left",
    NudgeRight "nudge_right" "Nudge" "Right by a pixel" "Right",
    NudgeUp "nudge_up" "Nudge" "Up by a pixel" "Up",
    NudgeDown "nudge_down" "Nudge" "Down by a pixel" "Down",
    NudgeFarLeft "nudge_far_left" "Nudge" "Left by ten" "Shift+Left",
    NudgeFarRight "nudge_far_right" "Nudge" "Right by ten" "Shift+Right",
    NudgeFarUp "nudge_far_up" "Nudge" "Up by ten" "Shift+Up",
    NudgeFarDown "nudge_far_down" "Nudge" "Down by ten" "Shift+Down",
    Tour "tour" "Help" "Tour of two minutes" "F2",
    Keys "keys" "Help" "List of keys" "F1",
}

impl Action {
    /// Returns whether two actions may have one key: that which pans while it is held plays when it is tapped.
    const fn shares_key_with(self, other: Self) -> bool {
        matches!((self, other), (Self::Play, Self::Pan) | (Self::Pan, Self::Play))
    }

    /// Returns whether it acts once for each press, however many come at once; others only once.
    #[must_use]
    pub(crate) const fn is_counted(self) -> bool {
        let is_step = matches!(self, Self::Back | Self::Forward | Self::KeyBack | Self::KeyForward);
        is_step || matches!(self, Self::Undo | Self::Redo | Self::ZoomIn | Self::ZoomOut) || self.nudge().is_some()
    }

    /// Returns what it moves the selection by, in pixels to the right and up; `None` for other actions.
    #[must_use]
    pub(crate) const fn nudge(self) -> Option<[f64; 2]> {
        Some(match self {
            Self::NudgeLeft => [-1.0, 0.0],
            Self::NudgeRight => [1.0, 0.0],
            Self::NudgeUp => [0.0, 1.0],
            Self::NudgeDown => [0.0, -1.0],
            Self::NudgeFarLeft => [-10.0, 0.0],
            Self::NudgeFarRight => [10.0, 0.0],
            Self::NudgeFarUp => [0.0, 10.0],
            Self::NudgeFarDown => [0.0, -10.0],
            _ => return None,
        })
    }
}

/// Chords by action.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Shortcuts(BTreeMap<Action, Chord>);

impl Default for Shortcuts {
    fn default() -> Self {
        let usual = |action: &Action| Some((*action, Chord::parse(action.usual())?));
        Self(Action::ALL.iter().filter_map(usual).collect())
    }
}

impl Shortcuts {
    /// Reads the default shortcuts with the overrides of a file. If the file does not exist, the defaults. `known`: the usual
    /// name of a key.
    ///
    /// # Errors
    /// [`EditError`] if the file cannot be read, or holds an unknown action, an invalid chord or a duplicate one.
    pub(crate) fn read(path: &Path, known: impl Fn(&str) -> Option<&'static str>) -> Result<Self, EditError> {
        if !path.exists() {
            return Ok(Self::default());
        }
        let text = read_text(path, TABLE_BYTES).map_err(|source| EditError::Io { path: path.to_owned(), source })?;
        Self::default()
            .with(&text, known)
            .map_err(|(what, hint)| EditError::Unusable { what: format!("{}: {what}", path.display()), hint })
    }

    /// Applies the overrides of a text. An action whose default chord they take is left without one.
    fn with(mut self, text: &str, known: impl Fn(&str) -> Option<&'static str>) -> Result<Self, (String, String)> {
        let own: BTreeMap<String, String> = serde_json::from_str(text)
            .map_err(|error| (error.to_string(), "write {\"undo\": \"Ctrl+Z\"}".to_owned()))?;
        let mut bound = BTreeSet::new();
        for (id, chord) in own {
            let action = Action::ALL.iter().find(|action| action.id() == id).ok_or_else(|| {
                let ids = Action::ALL.iter().map(|action| action.id());
                (format!("there is no action '{id}'"), crate::spelling::hint(&id, ids))
            })?;
            let hint = || "write it like Ctrl+Shift+Z, F1 or Space".to_owned();
            let parsed =
                Chord::parse(&chord).and_then(|parsed| Some(Chord { key: known(&parsed.key)?.to_owned(), ..parsed }));
            self.0.insert(*action, parsed.ok_or_else(|| (format!("'{chord}' is no key"), hint()))?);
            bound.insert(*action);
        }
        let own: Vec<(Action, Chord)> = self
            .0
            .iter()
            .filter(|(action, _)| bound.contains(*action))
            .map(|(action, chord)| (*action, chord.clone()))
            .collect();
        self.0.retain(|action, chord| {
            let is_taken = own.iter().any(|(other, taken)| taken == chord && !action.shares_key_with(*other));
            bound.contains(action) || !is_taken
        });
        match self.clash() {
            Some(what) => Err((what, "give one of them another key".into())),
            None => Ok(self),
        }
    }

    /// Returns a message if two actions share a chord that may not.
    fn clash(&self) -> Option<String> {
        self.0.iter().enumerate().find_map(|(place, (action, chord))| {
            let mut later = self.0.iter().skip(place + 1);
            let (other, _) = later.find(|(other, own)| *own == chord && !action.shares_key_with(**other))?;
            Some(format!("{chord} stands for both '{}' and '{}'", action.id(), other.id()))
        })
    }

    /// Gives an action another chord, and writes the file of the user's keys.
    ///
    /// # Errors
    /// [`EditError`] if another action has the chord, the key of a held action has modifiers, or the file cannot be written;
    /// the shortcuts are then unchanged.
    pub(crate) fn rebind(&mut self, action: Action, chord: Chord, path: &Path) -> Result<(), EditError> {
        let unusable = |what: String, hint: &str| EditError::Unusable { what, hint: hint.to_owned() };
        if action.group() == "Hold" && (chord.command || chord.shift || chord.alt) {
            return Err(unusable(format!("{chord} has more than one key"), "held keys stand alone: press one letter"));
        }
        let mut new = self.clone();
        new.0.insert(action, chord);
        if let Some(what) = new.clash() {
            return Err(unusable(what, "press another key"));
        }
        let usual = Self::default();
        let own = new.0.iter().filter(|(action, chord)| usual.of(**action) != Some(chord));
        let own: BTreeMap<&str, String> = own.map(|(action, chord)| (action.id(), chord.to_string())).collect();
        let text =
            serde_json::to_string_pretty(&own).map_err(|error| unusable(error.to_string(), "press another key"))?;
        replace_text(path, &text)?;
        *self = new;
        Ok(())
    }

    /// Returns the action of a chord.
    #[must_use]
    pub(crate) fn action_of(&self, chord: &Chord) -> Option<Action> {
        self.0.iter().find(|(_, other)| *other == chord).map(|(action, _)| *action)
    }

    /// Returns the chord of an action.
    #[must_use]
    pub(crate) fn of(&self, action: Action) -> Option<&Chord> {
        self.0.get(&action)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(key: &str) -> Option<&'static str> {
        ["U", "S"].into_iter().find(|name| name.eq_ignore_ascii_case(key))
    }

    #[test]
    fn every_action_has_a_key_of_its_own() {
        let usual = Shortcuts::default().with("{}", known).expect("the usual ones do not clash");
        assert_eq!(usual.0.len(), Action::ALL.len());
        for chord in usual.0.values() {
            assert_eq!(Chord::parse(&chord.to_string()).as_ref(), Some(chord));
        }
    }

    #[test]
    fn a_file_binds_keys_anew_and_its_faults_are_told() {
        let own = Shortcuts::default().with("{\"undo\": \"Alt+u\"}", known).expect("free");
        assert_eq!(own.of(Action::Undo).map(ToString::to_string).as_deref(), Some("Alt+U"));
        let fault = |text: &str| Shortcuts::default().with(text, known).expect_err(text).0;
        assert!(fault("{\"undoo\": \"U\"}").contains("no action 'undoo'"));
        assert!(fault("{\"undo\": \"Alt+Spaec\"}").contains("'Alt+Spaec' is no key"));
        assert!(fault("{\"undo\": \"Hyper+U\"}").contains("'Hyper+U' is no key"));
        assert!(fault("{\"undo\": \"Ctrl+S\", \"save\": \"Ctrl+S\"}").contains("both 'save' and 'undo'"));
        // Actions that later versions bring do not cost the keys that somebody chose.
        let own = Shortcuts::default().with("{\"undo\": \"S\", \"redo\": \"U\"}", known).expect("the user's keys win");
        assert_eq!(own.of(Action::Stiffness), None);
        assert_eq!(own.of(Action::Redo).map(ToString::to_string).as_deref(), Some("U"));
        assert!(fault("[]").contains("expected"));
    }

    #[test]
    fn keys_bound_in_the_window_are_kept_and_clashes_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("state/keys.json");
        let mut own = Shortcuts::default();
        let chord = |text: &str| Chord::parse(text).expect("a chord");
        own.rebind(Action::Undo, chord("Alt+U"), &path).expect("free");
        assert_eq!(Shortcuts::read(&path, known).expect("as written"), own);
        assert_eq!(std::fs::read_to_string(&path).expect("written"), "{\n  \"undo\": \"Alt+U\"\n}");
        let before = own.clone();
        let error = own.rebind(Action::Redo, chord("Ctrl+S"), &path).expect_err("taken");
        assert!(error.to_string().contains("both 'save' and 'redo'"), "{error}");
        let error = own.rebind(Action::Hide, chord("Ctrl+J"), &path).expect_err("two keys");
        assert!(error.to_string().contains("held keys"), "{error}");
        assert_eq!(own, before);
        // The key that pans may play, too, but not what is neither.
        own.rebind(Action::Pan, chord("V"), &path).expect("free");
        own.rebind(Action::Play, chord("V"), &path).expect("shared");
        own.rebind(Action::Mute, chord("V"), &path).expect_err("taken");
    }
}
