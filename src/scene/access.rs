//! Reads the files that a scene refers to: only regular files of bounded size, and by default only below the scene's
//! folder.
//!
//! In: paths. Out: bytes, or the reason for refusal. Scenes come from elsewhere; the paths in them are not trusted.

use super::SceneError;
use crate::files::check_regular;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Which files a scene may refer to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum FileAccess {
    /// Files in or below the scene's folder; symbolic links that lead out of it count as outside.
    #[default]
    SceneFolder,
    /// Any file.
    Anywhere,
}

/// Maximum size of a file in bytes: what the size field of a .glb can express.
const MAX_BYTES: u64 = 1 << 32;

/// Reads the scene's own file.
pub(super) fn read_scene_file(path: &Path) -> Result<Vec<u8>, SceneError> {
    read_file(path).map_err(|source| SceneError::Io { path: path.to_owned(), source })
}

/// Reads a regular file. Pipes and devices are rejected before they are opened, since opening them may block.
pub(super) fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    check_regular(path)?;
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    check_size(&metadata, MAX_BYTES)?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(metadata.len() as usize)?;
    // A file that grows while it is read is truncated.
    file.take(metadata.len()).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn check_size(metadata: &std::fs::Metadata, max_bytes: u64) -> io::Result<()> {
    if metadata.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
    }
    if metadata.len() > max_bytes {
        let what = format!("it has {} bytes, at most {max_bytes} are read", metadata.len());
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, what));
    }
    Ok(())
}

/// Returns whether a file is in or below a folder, after resolving symbolic links. Missing files count as inside: the
/// error of reading them is more useful.
pub(super) fn is_inside(folder: &Path, path: &Path) -> bool {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    match (folder.canonicalize(), path.canonicalize()) {
        (Ok(folder), Ok(path)) => path.starts_with(folder),
        (_, Err(error)) => error.kind() == io::ErrorKind::NotFound,
        (Err(_), Ok(_)) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_beyond_the_limit_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a");
        std::fs::write(&path, [0; 9]).expect("written");
        let metadata = std::fs::metadata(&path).expect("there");
        assert!(check_size(&metadata, 9).is_ok());
        let error = check_size(&metadata, 8).expect_err("too large").to_string();
        assert!(error.contains("9 bytes") && error.contains("at most 8"), "{error}");
    }
}
