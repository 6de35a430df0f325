//! Which frames have to be made, and where they go.
//!
//! In: frame numbers, a sequence, what may become of files that are there. Out: frames to make, frames to keep.

use super::{Existing, PipelineError, Setup};
use crate::image::{SequencePath, read_metadata};
use crate::plate::Holes;
use crate::spelling::counted;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Says so where kept frames were made from another state of the shot (other pins, another size).
pub(super) fn stale_note(kept: &[PathBuf], shot_hash: &str) -> Option<String> {
    stale_words(kept.iter().filter(|path| is_stale(path, shot_hash)).count())
}

/// Whether a frame of ours was made from something else than what has that digest.
pub(crate) fn is_stale(path: &Path, digest: &str) -> bool {
    let metadata = read_metadata(path).ok().flatten();
    metadata.is_some_and(|metadata| metadata.shot_hash != digest)
}

/// Says how many kept frames are stale; `None`: none.
pub(crate) fn stale_words(stale: usize) -> Option<String> {
    (stale > 0).then(|| {
        let stale = counted(stale, "of the kept frames was", "of the kept frames were");
        format!("{stale} rendered from another state of the shot; --overwrite renders anew")
    })
}

/// Makes the folder of a frame and tries whether files can be made in it.
pub(super) fn prepare_folder(frame: &Path) -> Result<(), PipelineError> {
    let folder = frame.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let outcome = std::fs::create_dir_all(folder).and_then(|()| tempfile::tempfile_in(folder));
    outcome.map(drop).map_err(|source| PipelineError::Folder { path: folder.to_owned(), source })
}

/// The frames that have to be made, and those that stay as they are because they are done.
pub(super) fn frames_to_do(
    wanted: Vec<i32>,
    output: &SequencePath,
    (existing, is_done): (Existing, &dyn Fn(&Path) -> bool),
) -> Result<(Vec<i32>, Vec<i32>), PipelineError> {
    let is_there = |frame: &&i32| output.path_of(**frame).exists();
    match existing {
        Existing::Overwrite => Ok((wanted, Vec::new())),
        Existing::Resume => Ok(wanted.into_iter().partition(|&frame| !is_done(&output.path_of(frame)))),
        Existing::Refuse => match wanted.iter().find(is_there) {
            None => Ok((wanted, Vec::new())),
            Some(&first) => Err(PipelineError::Exists {
                count: wanted.iter().filter(is_there).count(),
                first: output.path_of(first),
            }),
        },
    }
}

/// Everything that something is made of, so that nothing of it is written over.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inputs {
    /// As they are named, and where they really lie.
    paths: BTreeSet<PathBuf>,
}

impl Inputs {
    /// Adds a file.
    pub(crate) fn add(&mut self, path: &Path) {
        self.paths.extend(path.canonicalize());
        self.paths.insert(path.to_owned());
    }

    /// Adds all frames of a sequence that are there.
    pub(crate) fn add_sequence(&mut self, sequence: &SequencePath) -> Result<(), PipelineError> {
        match sequence.frames_on_disk()? {
            Some(frames) => frames.into_iter().for_each(|frame| self.add(&sequence.path_of(frame))),
            None => self.add(&sequence.path_of(0)),
        }
        Ok(())
    }

    /// Refuses a file that would be written over one of them, by whatever path that is named.
    pub(crate) fn refuse(&self, output: &Path) -> Result<(), PipelineError> {
        let is_input =
            self.paths.contains(output) || output.canonicalize().is_ok_and(|path| self.paths.contains(&path));
        if !is_input {
            return Ok(());
        }
        Err(PipelineError::Unusable {
            what: format!("{} would be written over what it is made of", output.display()),
            hint: "give another output path (-o)".to_owned(),
        })
    }
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
