//! Digests of the files from which frames are made, so that a frame is rendered again if one of them has changed.
//!
//! In: paths. Out: 32 hexadecimal digits over all their bytes: XXH3 with 128 bits (github.com/Cyan4973/xxHash,
//! doc/xxhash_spec.md), independent of the platform.

use crate::image::SequencePath;
use crate::pipeline::PreparedShot;
use rayon::prelude::*;
use std::collections::HashMap;
use std::fs::File;
use std::io::{ErrorKind, Read, Result};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use twox_hash::XxHash3_128;

/// Size of a read buffer, bytes.
const CHUNK: usize = 1 << 20;

/// Digests of files; each file is read once per run.
#[derive(Debug, Default)]
pub(crate) struct Contents {
    known: Mutex<HashMap<PathBuf, u128>>,
}

impl Contents {
    /// Returns the digest of the files in the given order. An unreadable file counts as empty; the stage that needs it reports why.
    pub(crate) fn digest(&self, files: &[&Path]) -> String {
        let each: Vec<u8> = files.par_iter().flat_map_iter(|file| self.of_file(file).to_le_bytes()).collect();
        format!("{:032x}", XxHash3_128::oneshot(&each))
    }

    fn of_file(&self, file: &Path) -> u128 {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(&digest) = known().get(file) {
            return digest;
        }
        let digest = digest_of(file).unwrap_or_default();
        known().insert(file.to_owned(), digest);
        digest
    }
}

/// Digests of frames that share settings and files and also have files of their own.
#[derive(Debug)]
pub(in crate::pipeline) struct FrameDigests {
    settings: String,
    shared: Vec<PathBuf>,
    sequences: Vec<SequencePath>,
    contents: Contents,
}

impl FrameDigests {
    /// Creates the digests from `shared`, the files of all frames, and `sequences`, which have one file per frame.
    pub(in crate::pipeline) fn new<'a>(
        settings: String,
        shared: &[&Path],
        sequences: impl Iterator<Item = &'a SequencePath>,
    ) -> Self {
        let shared = shared.iter().map(|path| path.to_path_buf()).collect();
        Self { settings, shared, sequences: sequences.cloned().collect(), contents: Contents::default() }
    }

    /// Returns the digest of a frame: its settings and the contents of its files, which are read on first use.
    pub(in crate::pipeline) fn of(&self, frame: i32) -> String {
        let own: Vec<PathBuf> = self.sequences.iter().map(|sequence| sequence.path_of(frame)).collect();
        let files: Vec<&Path> = self.shared.iter().chain(&own).map(PathBuf::as_path).collect();
        digest_with(&self.settings, &self.contents.digest(&files))
    }
}

impl PreparedShot {
    /// Returns the files that the shot reads: scene or pictures, files beside the scene, and lattices. The shot file
    /// itself is represented by its settings.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        self.shot.files().chain(&self.scene.files_beside).map(PathBuf::as_path)
    }

    /// Returns the digest of the contents of those files.
    pub(crate) fn contents_digest(&self) -> String {
        Contents::default().digest(&self.files().collect::<Vec<_>>())
    }

    /// Returns the digest of the shot and of the contents of its files.
    pub(crate) fn digest(&self) -> String {
        digest_with(&self.shot.hash(), &self.contents_digest())
    }
}

/// Joins the digests of settings and contents, so that it can be told which of them changed.
pub(crate) fn digest_with(settings: &str, contents: &str) -> String {
    format!("{settings}.{contents}")
}

fn digest_of(path: &Path) -> Result<u128> {
    let mut file = File::open(path)?;
    if !file.metadata()?.is_file() {
        return Err(ErrorKind::InvalidInput.into());
    }
    let (mut hasher, mut chunk) = (XxHash3_128::new(), vec![0; CHUNK]);
    loop {
        match file.read(&mut chunk) {
            Ok(0) => return Ok(hasher.finish_128()),
            Ok(count) => hasher.write(&chunk[..count]),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_of_every_file_counts() {
        let folder = tempfile::tempdir().expect("a folder");
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        let digest = |first: &[u8], second: &[u8]| {
            std::fs::write(&a, first).expect("written");
            std::fs::write(&b, second).expect("written");
            Contents::default().digest(&[&a, &b])
        };
        let long = vec![7; 3 * CHUNK / 2];
        let changed = [&long[..CHUNK + 5], &[8], &long[CHUNK + 6..]].concat();
        let digests = [digest(b"", b"x"), digest(b"x", b""), digest(&long, b""), digest(&changed, b"")];
        assert!((0..4).all(|k| !digests[..k].contains(&digests[k])), "{digests:?}");
        assert_eq!(digest(&long, b""), digests[2]);
        // The published digest of empty input, so that a new version of the crate cannot change it unnoticed.
        std::fs::write(&a, b"").expect("written");
        assert_eq!(digest_of(&a).expect("read"), 0x99aa_06d3_0147_98d8_6001_c324_468d_497f);
    }
}
