//! Files that appear whole or not at all.
//!
//! In: a path and a function that writes. Out: the finished file under that path, or the old one untouched.

use super::ImageError;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use tempfile::Builder;

/// Writes under a temporary name in the same folder (made where it is missing), then renames. On any error the
/// temporary file is removed and what stood at `path` stays as it was.
pub(super) fn replace_file(
    path: &Path,
    write: impl FnOnce(&mut File) -> Result<(), ImageError>,
) -> Result<(), ImageError> {
    let Some(name) = path.file_name() else {
        return Err(ImageError::frame(path, "the path does not end in a file name"));
    };
    let io = |source| ImageError::writing(path, source);
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(io)?;

    let mut prefix = std::ffi::OsString::from(".");
    prefix.push(name);
    let mut builder = Builder::new();
    builder.prefix(&prefix).suffix(".tmp");
    set_permissions(&mut builder);
    let mut partial = builder.tempfile_in(folder).map_err(io)?;
    write(partial.as_file_mut())?;
    partial.persist(path).map_err(|failed| io(failed.error))?;
    Ok(())
}

/// Puts a text into a file, whole or not at all.
///
/// # Errors
/// [`ImageError::Io`] where the disk is full or the folder cannot be written.
pub fn replace_text(path: &Path, text: &str) -> Result<(), ImageError> {
    replace_bytes(path, text.as_bytes())
}

/// Puts bytes into a file, whole or not at all.
///
/// # Errors
/// [`ImageError::Io`] where the disk is full or the folder cannot be written.
pub fn replace_bytes(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    replace_file(path, |file| file.write_all(bytes).map_err(|source| ImageError::writing(path, source)))
}

/// Temporary files are private by default; a frame is for everybody whom the umask lets in.
#[cfg(unix)]
fn set_permissions(builder: &mut Builder) {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(fs::Permissions::from_mode(0o666));
}

#[cfg(not(unix))]
fn set_permissions(_builder: &mut Builder) {}
