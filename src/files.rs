//! Files that are read whole: regular ones only, up to a limit.
//!
//! In: a path and the most bytes that make sense. Out: text; or an error before anything is waited for or taken into memory.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Most bytes of a shot file: a hundred thousand keys take ten million.
pub(crate) const SHOT_BYTES: u64 = 64 << 20;

/// Most bytes of tables that people and programs write: landmarks, manifests.
pub(crate) const TABLE_BYTES: u64 = 256 << 20;

/// Most bytes of lattices and problems.
pub(crate) const LATTICE_BYTES: u64 = 4 << 30;

/// Reads a text.
///
/// # Errors
/// [`Error`] where the path is a pipe, device or socket, the file is longer than `most_bytes`, or is not UTF-8.
pub(crate) fn read_text(path: &Path, most_bytes: u64) -> Result<String> {
    check_regular(path)?;
    let file = File::open(path)?;
    let mut text = String::new();
    let length = file.metadata()?.len();
    if length <= most_bytes && file.take(most_bytes + 1).read_to_string(&mut text)? as u64 <= most_bytes {
        return Ok(text);
    }
    let [length, most] = [length, most_bytes].map(|bytes| bytes.div_ceil(1 << 20));
    Err(Error::new(ErrorKind::FileTooLarge, format!("the file has {length} MB, at most {most} MB are read")))
}

/// Refuses pipes, devices and sockets, which may keep a reader waiting for ever. Everything else is left to the reader.
///
/// # Errors
/// [`Error`] that says so.
pub(crate) fn check_regular(path: &Path) -> Result<()> {
    match path.metadata() {
        Ok(there) if !there.is_file() && !there.is_dir() => {
            Err(Error::new(ErrorKind::InvalidInput, "it is a pipe, device or socket, not a regular file"))
        }
        _ => Ok(()),
    }
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
