//! What the window shows and how it is laid out, remembered between sessions.
//!
//! In: a JSON file beside that of the user's keys. Out: plain settings; a file that cannot be read means the usual ones.

use super::EditError;
use super::session::Shown;
use crate::files::{TABLE_BYTES, read_text};
use crate::image::replace_text;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Minimum and maximum size of a panel, in points.
const PANEL_SIZES: [f32; 2] = [100.0, 520.0];

/// Brightness of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Brightness {
    Dark,
    Light,
    /// That of the desktop.
    #[default]
    System,
}

/// Sizes of the panels in points; `None`: a share of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct PanelSizes {
    /// Height of the timeline.
    pub(crate) timeline: Option<f32>,
    /// Width of the layers.
    pub(crate) layers: Option<f32>,
    /// Width of the pin's numbers.
    pub(crate) inspector: Option<f32>,
}

/// The remembered settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct ViewSettings {
    pub(crate) theme: Brightness,
    pub(crate) shown: Shown,
    pub(crate) panels: PanelSizes,
}

impl ViewSettings {
    /// Reads the file; the usual settings if it does not exist or is broken, and then a message.
    pub(crate) fn read(path: &Path) -> (Self, Option<String>) {
        if !path.exists() {
            return (Self::default(), None);
        }
        let text = read_text(path, TABLE_BYTES).map_err(|error| error.to_string());
        let read = text.and_then(|text| serde_json::from_str::<Self>(&text).map_err(|error| error.to_string()));
        match read {
            Ok(settings) => (settings.within_limits(), None),
            Err(error) => {
                let what =
                    format!("{}: {error}; the view is as usual, and the next change replaces it", path.display());
                (Self::default(), Some(what))
            }
        }
    }

    /// Writes the file.
    ///
    /// # Errors
    /// [`EditError`] if it cannot be written.
    pub(crate) fn write(&self, path: &Path) -> Result<(), EditError> {
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        Ok(replace_text(path, &text)?)
    }

    /// Limits the numbers of a file that somebody edited.
    fn within_limits(mut self) -> Self {
        let onion = &mut self.shown.onion;
        (onion.count, onion.every, onion.opacity) =
            (onion.count.min(5), onion.every.min(24), onion.opacity.clamp(0.05, 1.0));
        let panels = &mut self.panels;
        for size in [&mut panels.timeline, &mut panels.layers, &mut panels.inspector].into_iter().flatten() {
            *size = size.clamp(PANEL_SIZES[0], PANEL_SIZES[1]);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (ViewSettings, Option<String>) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("view.json");
        std::fs::write(&path, text).expect("written");
        ViewSettings::read(&path)
    }

    #[test]
    fn what_is_written_is_read_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("state/view.json");
        assert_eq!(ViewSettings::read(&path), (ViewSettings::default(), None));
        let mut settings = ViewSettings { theme: Brightness::Light, ..ViewSettings::default() };
        (settings.shown.safe_areas, settings.shown.onion.count) = (true, 3);
        settings.panels.timeline = Some(300.0);
        settings.write(&path).expect("writable");
        assert_eq!(ViewSettings::read(&path), (settings, None));
    }

    #[test]
    fn broken_files_mean_the_usual_settings_and_strange_ones_are_limited() {
        for text in ["", "{", "7", "{\"theme\": 7}", "{\"shown\": {\"onion\": \"yes\"}}", "\u{0}\u{1}"] {
            let (settings, fault) = read(text);
            assert_eq!(settings, ViewSettings::default(), "{text}");
            assert!(fault.is_some_and(|fault| fault.contains("view.json")), "{text}");
        }
        let text = "{\"of_the_future\": 1, \"shown\": {\"onion\": {\"count\": 4000000000, \"opacity\": -9}}, \"panels\": {\"layers\": 1e30}}";
        let (settings, fault) = read(text);
        assert_eq!((settings.shown.onion.count, settings.shown.onion.opacity, fault), (5, 0.05, None));
        assert_eq!((settings.panels.layers, settings.panels.timeline), (Some(520.0), None));
    }
}
