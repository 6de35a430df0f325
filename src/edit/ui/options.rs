//! What the editor is told when it starts.

use crate::raster::DeviceChoice;
use crate::scene::FileAccess;
use std::path::PathBuf;

/// What the editor is told when it starts.
#[derive(Clone, Debug)]
pub struct EditorOptions {
    /// What draws.
    pub device: DeviceChoice,
    /// What scenes may refer to.
    pub access: FileAccess,
    /// Where journals, own keys and unpacked scenes are.
    pub folder: PathBuf,
}

impl EditorOptions {
    /// With the folder that the system has for a program's state.
    #[must_use]
    pub fn new(device: DeviceChoice, access: FileAccess) -> Self {
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
}
