//! Where frames go, and what must not be written over.
//!
//! In: paths, a [`Setup`]. Out: a folder that can be written to; the files that a shot reads.

use super::{PipelineError, Setup};
use crate::image::{Inputs, SequencePath};
use crate::plate::Holes;
use std::path::Path;

/// Makes the folder of a frame and tries whether files can be made in it.
pub(super) fn prepare_folder(frame: &Path) -> Result<(), PipelineError> {
    let folder = frame.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let outcome = std::fs::create_dir_all(folder).and_then(|()| tempfile::tempfile_in(folder));
    outcome.map(drop).map_err(|source| PipelineError::Folder { path: folder.to_owned(), source })
}

impl Setup {
    /// All files that the shot reads: scene and what lies beside it, pictures, plates, clean plates, lattices.
    pub(crate) fn inputs(&self) -> Result<Inputs, PipelineError> {
        let mut inputs = Inputs::default();
        let files = self.shot.files().chain(&self.scene.files_beside).chain([&self.shot.path]);
        files.for_each(|path| inputs.add(path));
        let clean = if let Holes::Plate(clean) = &self.shot.warp.holes { Some(clean) } else { None };
        for pattern in self.shot.plate.iter().chain(clean) {
            inputs.add_sequence(&SequencePath::parse(pattern)?)?;
        }
        Ok(inputs)
    }
}
