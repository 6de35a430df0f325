//! Stores trajectories in files beside the frames, so that later runs, also of other machines, need not solve them again.
//!
//! In: a folder, a key, bytes. Out: the same bytes, or nothing. Files are replaced atomically, and concurrent writers
//! write the same bytes, so they cannot disturb each other. A checksum detects damaged files, which count as missing.

use crate::image::{ImageError, replace_bytes};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use twox_hash::XxHash3_128;

/// Name of the folder beside the frames.
const FOLDER: &str = ".pinwarp-trajectories";

/// Extension of the files.
const ENDING: &str = ".trajectory";

/// First bytes of a file; the number is the version of the format.
const HEAD: &[u8; 16] = b"pinwarp track 3\n";

/// Length of the checksum, bytes.
const CHECKSUM: usize = 16;

/// Number of files kept per layer; those written longest ago are removed.
const KEPT: usize = 4;

/// Whether a run reads or also writes stored trajectories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Keeping {
    /// Reads existing trajectories.
    #[cfg_attr(
        not(any(test, feature = "cli")),
        expect(dead_code, reason = "only the command line stores trajectories")
    )]
    Read,
    /// Also writes missing ones.
    Write,
}

/// The folders in which trajectories are stored.
#[derive(Clone, Debug)]
pub(in crate::pipeline) struct TrajectoryFiles {
    /// All are read; the first is written.
    folders: Vec<PathBuf>,
    keeping: Keeping,
}

/// The key of a file: the layer, and a digest of all inputs of its trajectory.
#[derive(Clone, Debug)]
pub(in crate::pipeline) struct FileKey {
    /// Names shot and layer, for users and for removing old files.
    pub(in crate::pipeline) prefix: String,
    /// 32 hexadecimal digits.
    pub(in crate::pipeline) digest: String,
}

impl FileKey {
    fn file_name(&self) -> String {
        format!("{}.{}{ENDING}", self.prefix, self.digest)
    }
}

impl TrajectoryFiles {
    /// Creates the store beside frames given by their path patterns.
    pub(in crate::pipeline) fn beside<'a>(outputs: impl IntoIterator<Item = &'a Path>, keeping: Keeping) -> Self {
        let folder = |output: &Path| {
            let parent = output.parent().filter(|parent| !parent.as_os_str().is_empty());
            parent.unwrap_or(Path::new(".")).join(FOLDER)
        };
        let mut folders: Vec<PathBuf> = outputs.into_iter().map(folder).collect();
        folders.dedup();
        Self { folders, keeping }
    }

    /// Returns the bytes stored under a key, and the file.
    pub(in crate::pipeline) fn read(&self, key: &FileKey) -> Option<(Vec<u8>, PathBuf)> {
        let paths = self.folders.iter().map(|folder| folder.join(key.file_name()));
        paths.into_iter().find_map(|path| {
            let file = fs::read(&path).ok()?;
            let content = content(&file, key);
            if content.is_none() {
                tracing::warn!("{} is damaged: it is computed again", path.display());
            }
            content.map(|content| (content.to_vec(), path))
        })
    }

    /// Stores bytes under a key, and returns the file; `None` if the run may not write.
    ///
    /// # Errors
    /// [`ImageError`] if the file cannot be written.
    pub(in crate::pipeline) fn write(&self, key: &FileKey, bytes: &[u8]) -> Result<Option<PathBuf>, ImageError> {
        let Some(folder) = self.folders.first().filter(|_| self.keeping == Keeping::Write) else { return Ok(None) };
        let path = folder.join(key.file_name());
        let mut file = HEAD.to_vec();
        file.extend(key.digest.as_bytes());
        file.extend(bytes);
        file.extend(XxHash3_128::oneshot(&file).to_le_bytes());
        replace_bytes(&path, &file)?;
        tidy(folder, key);
        Ok(Some(path))
    }
}

/// Returns the contents of an undamaged file written under a key.
fn content<'a>(file: &'a [u8], key: &FileKey) -> Option<&'a [u8]> {
    let (body, checksum) = file.split_last_chunk::<CHECKSUM>()?;
    if XxHash3_128::oneshot(body).to_le_bytes() != *checksum {
        return None;
    }
    body.strip_prefix(HEAD)?.strip_prefix(key.digest.as_bytes())
}

/// Removes all but the newest files of a layer. Runs that have read an older one hold it in memory.
fn tidy(folder: &Path, key: &FileKey) {
    let prefix = format!("{}.", key.prefix);
    let is_own = |name: &str| {
        let digest = name.strip_prefix(&prefix).and_then(|rest| rest.strip_suffix(ENDING));
        digest.is_some_and(|digest| digest.len() == key.digest.len() && !digest.contains('.'))
    };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let own = entries.filter(|entry| entry.file_name().to_str().is_some_and(is_own)).map(|entry| {
        let written = entry.metadata().and_then(|data| data.modified()).unwrap_or(SystemTime::UNIX_EPOCH);
        (written, entry.path())
    });
    let mut own: Vec<_> = own.collect();
    own.sort();
    own.iter().rev().skip(KEPT).for_each(|(_, path)| _ = fs::remove_file(path));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(digest: char) -> FileKey {
        FileKey { prefix: "shot.0".to_owned(), digest: digest.to_string().repeat(32) }
    }

    #[test]
    fn a_file_is_read_as_it_was_written_and_a_damaged_one_counts_as_missing() {
        let folder = tempfile::tempdir().expect("a folder");
        let files = TrajectoryFiles::beside([folder.path().join("f.####.exr").as_path()], Keeping::Write);
        assert!(files.read(&key('a')).is_none());
        let bytes: Vec<u8> = (0..=255).collect();
        let path = files.write(&key('a'), &bytes).expect("it is written").expect("it may be");
        assert_eq!(files.read(&key('a')), Some((bytes.clone(), path.clone())));
        let whole = fs::read(&path).expect("it is there");
        for place in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[place] ^= 4;
            assert_eq!(content(&damaged, &key('a')), None, "byte {place}");
            assert_eq!(content(&whole[..place], &key('a')), None, "cut off at {place}");
        }
        fs::copy(&path, path.with_file_name(key('b').file_name())).expect("copied");
        assert!(files.read(&key('b')).is_none(), "another's file under this name");
    }

    #[test]
    fn only_the_youngest_files_of_a_layer_stay_and_those_of_others() {
        let folder = tempfile::tempdir().expect("a folder");
        let output = folder.path().join("f.####.exr");
        let files = TrajectoryFiles::beside([output.as_path()], Keeping::Write);
        let other = FileKey { prefix: "shot.01".to_owned(), ..key('f') };
        let path = files.write(&other, b"other").expect("it is written").expect("it may be");
        let stranger = path.with_file_name("shot.0.notes.txt");
        fs::write(&stranger, "mine").expect("written");
        for digest in '0'..='9' {
            files.write(&key(digest), b"own").expect("it is written");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        let left: String = ('0'..='9').filter(|&digest| files.read(&key(digest)).is_some()).collect();
        assert_eq!(left, "6789");
        assert!(files.read(&other).is_some() && stranger.exists());
        let reader = TrajectoryFiles::beside([output.as_path()], Keeping::Read);
        assert!(
            reader.write(&key('x'), b"no").expect("nothing is tried").is_none() && reader.read(&key('x')).is_none()
        );
    }
}
