//! Output folders, and the input files that must not be overwritten.
//!
//! In: paths, a [`PreparedShot`]. Out: a writable folder; the files that a shot reads.

use crate::image::{Inputs, SequencePath};
use crate::pipeline::{PipelineError, PreparedShot};
use crate::plate::Holes;
use std::path::Path;

/// Creates the folder of a frame and checks that files can be created in it.
pub(in crate::pipeline) fn prepare_folder(frame: &Path) -> Result<(), PipelineError> {
    let folder = frame.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let outcome = std::fs::create_dir_all(folder).and_then(|()| tempfile::tempfile_in(folder));
    outcome.map(drop).map_err(|source| PipelineError::Folder { path: folder.to_owned(), source })
}

/// Returns all files that a shot reads: the scene and files beside it, pictures, plates, clean plates, lattices, and
/// the shot file itself.
pub(crate) fn input_files(prepared: &PreparedShot) -> Result<Inputs, PipelineError> {
    let mut inputs = Inputs::default();
    let PreparedShot { shot, scene, .. } = prepared;
    let files = shot.files().chain(&scene.files_beside).chain([&shot.path]);
    files.for_each(|path| inputs.add(path));
    let clean = if let Holes::Plate(clean) = &shot.warp.holes { Some(clean) } else { None };
    for pattern in shot.plate.iter().chain(clean) {
        inputs.add_sequence(&SequencePath::of_input(pattern)?)?;
    }
    Ok(inputs)
}
