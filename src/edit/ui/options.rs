//! Options of the editor at start-up.

use crate::raster::DeviceChoice;
use crate::scene::FileAccess;
use std::path::PathBuf;

/// Options of the editor at start-up.
#[derive(Clone, Debug)]
pub(crate) struct EditorOptions {
    /// The rendering device.
    pub device: DeviceChoice,
    /// The files that scenes may refer to.
    pub access: FileAccess,
    /// The folder of journals, recent shots, the user's keys and view, and unpacked scenes.
    pub folder: PathBuf,
}

impl EditorOptions {
    /// Uses the system's folder for application state.
    #[must_use]
    pub(crate) fn new(device: DeviceChoice, access: FileAccess) -> Self {
        let given = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let state = given("XDG_STATE_HOME").or_else(|| Some(given("HOME")?.join(".local/state")));
        let state = state.or_else(|| given("LOCALAPPDATA")).unwrap_or_else(std::env::temp_dir);
        Self { device, access, folder: state.join("pinwarp") }
    }

    pub(super) fn journals(&self) -> PathBuf {
        self.folder.join("journals")
    }

    pub(super) fn keys(&self) -> PathBuf {
        self.folder.join("keys.json")
    }

    pub(super) fn recent(&self) -> PathBuf {
        self.folder.join("recent.json")
    }

    pub(super) fn view(&self) -> PathBuf {
        self.folder.join("view.json")
    }
}
