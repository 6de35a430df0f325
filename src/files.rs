//! Reads whole files, with checks: regular files only, up to a size limit.
//!
//! In: a path and the maximum number of bytes. Out: the text, or an error before the reader blocks or allocates memory.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Name and version of this program, stored in every file it writes.
pub(crate) const GENERATOR: &str = concat!("pinwarp ", env!("CARGO_PKG_VERSION"));

/// Maximum size of a shot file, bytes; a hundred thousand keys take ten million.
pub(crate) const SHOT_BYTES: u64 = 64 << 20;

/// Maximum size of tables written by people and programs (landmarks, manifests), bytes.
pub(crate) const TABLE_BYTES: u64 = 256 << 20;

/// Maximum size of lattice files and problem files, bytes.
pub(crate) const LATTICE_BYTES: u64 = 4 << 30;

/// Reads a text file.
///
/// # Errors
/// Returns [`Error`] if the path is a pipe, device or socket, or if the file is longer than `max_bytes` or not UTF-8.
pub(crate) fn read_text(path: &Path, max_bytes: u64) -> Result<String> {
    check_regular(path)?;
    let file = File::open(path)?;
    let mut text = String::new();
    let length = file.metadata()?.len();
    if length <= max_bytes && file.take(max_bytes + 1).read_to_string(&mut text)? as u64 <= max_bytes {
        return Ok(text);
    }
    let [length, most] = [length, max_bytes].map(|bytes| bytes.div_ceil(1 << 20));
    Err(Error::new(ErrorKind::FileTooLarge, format!("the file has {length} MB, at most {most} MB are read")))
}

/// Refuses pipes, devices and sockets, which could block a reader indefinitely; all other problems are left to the reader.
///
/// # Errors
/// Returns [`Error`] of kind `InvalidInput` if the path is a pipe, device or socket.
pub(crate) fn check_regular(path: &Path) -> Result<()> {
    match path.metadata() {
        Ok(there) if !there.is_file() && !there.is_dir() => {
            Err(Error::new(ErrorKind::InvalidInput, "it is a pipe, device or socket, not a regular file"))
        }
        _ => Ok(()),
    }
}

/// Returns the path of a file, which need not exist, in its folder as the file system knows it.
#[cfg(feature = "editor")]
pub(crate) fn located(file: &Path) -> std::path::PathBuf {
    let folder = file.parent().map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    let folder = folder.and_then(|folder| folder.canonicalize().ok());
    folder.zip(file.file_name()).map_or_else(|| file.to_owned(), |(folder, name)| folder.join(name))
}

/// Whether two paths lead to one file.
#[cfg(feature = "editor")]
pub(crate) fn is_same_file(one: &Path, other: &Path) -> bool {
    one == other || one.canonicalize().is_ok_and(|one| other.canonicalize().is_ok_and(|other| one == other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_up_to_the_limit() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        std::fs::write(&path, "12345").expect("written");
        assert_eq!(read_text(&path, 5).expect("as long as the limit"), "12345");
        assert_eq!(read_text(&path, 4).expect_err("longer").kind(), ErrorKind::FileTooLarge);
        std::fs::write(&path, [0xff]).expect("written");
        assert_eq!(read_text(&path, 5).expect_err("no text").kind(), ErrorKind::InvalidData);
        assert_eq!(read_text(&folder.path().join("b"), 5).expect_err("nothing").kind(), ErrorKind::NotFound);
        assert!(read_text(folder.path(), 5).is_err(), "a folder");
    }
}
