//! Atomic file writes.
//!
//! In: a destination and a function that writes. Out: the complete file under that path, or the previous one unchanged.
//! Method: write a locked temporary file in the same directory, then rename it.

use super::ImageError;
use std::collections::{HashMap, HashSet};
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use tempfile::Builder;

/// Extension of temporary files.
const ENDING: &str = ".tmp";

/// Longest file name that is embedded in a temporary name, in bytes: file systems allow 255; the rest is for prefix and extension.
const LONGEST_NAME: usize = 200;

/// Endings of exported files.
#[cfg(feature = "editor")]
const OUTPUTS: [&str; 8] = [".exr", ".png", ".json", ".nk", ".py", ".glb", ".txt", ".jsx"];

/// Random characters in a temporary name.
const RANDOM_CHARS: usize = 6;

/// Path and durability of a file to be written.
#[derive(Clone, Copy, Debug)]
pub struct Destination<'a> {
    /// Path of the file.
    pub path: &'a Path,
    /// Durability of the write.
    pub durability: Durability,
}

/// When a file counts as written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Durability {
    /// As soon as the operating system has accepted it.
    #[default]
    Cached,
    /// When it is on disk: file and directory are synchronised, so it survives a power failure.
    Synced,
}

impl<'a> From<&'a Path> for Destination<'a> {
    fn from(path: &'a Path) -> Self {
        Self { path, durability: Durability::Cached }
    }
}

impl<'a> From<&'a PathBuf> for Destination<'a> {
    fn from(path: &'a PathBuf) -> Self {
        Self::from(path.as_path())
    }
}

/// Writes under a temporary name in the same directory (created if missing), then renames.
///
/// On error the temporary file is removed and any previous file is unchanged. A symbolic link is kept, and its target is replaced. The
/// temporary file is locked while it is written, so that [`remove_stale`] can tell whether its writer is alive.
pub(super) fn replace_file(
    to: Destination,
    write: impl FnOnce(&mut File) -> Result<(), ImageError>,
) -> Result<(), ImageError> {
    let path = to.path;
    let io = |source| ImageError::writing(path, source);
    check_replaceable(path)?;
    let is_link = fs::symlink_metadata(path).is_ok_and(|there| there.is_symlink());
    let target = if is_link { path.canonicalize().ok() } else { None }.unwrap_or_else(|| path.to_owned());
    let Some(name) = target.file_name() else {
        return Err(ImageError::frame(path, "the path does not end in a file name"));
    };
    let folder = folder_of(&target);
    fs::create_dir_all(folder).map_err(io)?;

    let prefix = temporary_prefix(name);
    let mut builder = Builder::new();
    builder.prefix(&prefix).suffix(ENDING).rand_bytes(RANDOM_CHARS);
    set_permissions(&mut builder);
    let mut partial = builder.tempfile_in(folder).map_err(io)?;
    // Some network file systems have no locks; write the file anyway.
    let _ = partial.as_file().try_lock();
    write(partial.as_file_mut())?;
    if to.durability == Durability::Synced {
        partial.as_file().sync_all().map_err(io)?;
    }
    partial.persist(&target).map_err(|failed| io(failed.error))?;
    if to.durability == Durability::Synced { sync_folder(folder).map_err(io) } else { Ok(()) }
}

/// Refuses devices, pipes and sockets; regular files may be replaced. Directories fail at the rename.
pub(super) fn check_replaceable(path: &Path) -> Result<(), ImageError> {
    match fs::metadata(path) {
        Ok(there) if !there.is_file() && !there.is_dir() => Err(ImageError::Refused {
            path: path.to_owned(),
            what: "is a device, pipe or socket, not a regular file".to_owned(),
            hint: "give the path of a file (-o)".to_owned(),
        }),
        _ => Ok(()),
    }
}

/// Writes a text file atomically.
///
/// # Errors
/// [`ImageError::Io`] if the disk is full or the directory is not writable.
pub(crate) fn replace_text(path: &Path, text: &str) -> Result<(), ImageError> {
    replace_bytes(path, text.as_bytes())
}

/// Writes bytes to a file atomically.
///
/// # Errors
/// [`ImageError::Io`] if the disk is full or the directory is not writable.
pub(crate) fn replace_bytes<'a>(to: impl Into<Destination<'a>>, bytes: &[u8]) -> Result<(), ImageError> {
    let to = to.into();
    replace_file(to, |file| file.write_all(bytes).map_err(|source| ImageError::writing(to.path, source)))
}

/// Removes the temporary files of these paths whose writers have died; living writers hold a lock. Returns how many
/// were removed, and ignores what cannot be listed or removed.
pub(crate) fn remove_stale(paths: impl IntoIterator<Item = PathBuf>) -> usize {
    let mut prefixes: HashMap<PathBuf, HashSet<OsString>> = HashMap::new();
    for path in paths {
        let Some(name) = path.file_name() else { continue };
        prefixes.entry(folder_of(&path).to_owned()).or_default().insert(temporary_prefix(name));
    }
    let stale_in = |(folder, prefixes): (&PathBuf, &HashSet<OsString>)| {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        let temporary = entries.filter(|entry| is_temporary(&entry.file_name(), prefixes)).map(|entry| entry.path());
        temporary.filter(|path| remove_unlocked(path)).count()
    };
    prefixes.iter().map(stale_in).sum()
}

/// Removes the temporary files that a dead writer left in the folder of an output: those of outputs whose names begin like this one, up
/// to its first dot or frame counter. Ignores what cannot be listed or removed.
#[cfg(feature = "editor")]
pub(crate) fn remove_unfinished(output: &Path) {
    let Some(name) = output.file_name().and_then(OsStr::to_str) else { return };
    let start = format!(".{}", name.split(['.', '#', '%']).next().unwrap_or(name));
    let is_unfinished = |name: &OsStr| {
        let stem = name.to_str().and_then(|name| name.strip_suffix(ENDING));
        let own = stem.and_then(|stem| stem.get(..stem.len().checked_sub(RANDOM_CHARS)?));
        own.is_some_and(|own| own.starts_with(&start) && OUTPUTS.iter().any(|ending| own.ends_with(ending)))
    };
    let entries = fs::read_dir(folder_of(output)).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| is_unfinished(&entry.file_name())) {
        remove_unlocked(&entry.path());
    }
}

/// Matches `PREFIX.tmp` and `PREFIXabc123.tmp`.
fn is_temporary(name: &OsStr, prefixes: &HashSet<OsString>) -> bool {
    let Some(stem) = name.to_str().and_then(|name| name.strip_suffix(ENDING)) else { return false };
    let without_random = stem.len().checked_sub(RANDOM_CHARS).and_then(|end| stem.get(..end)).unwrap_or_default();
    [stem, without_random].iter().any(|stem| prefixes.contains(OsStr::new(stem)))
}

fn remove_unlocked(path: &Path) -> bool {
    let is_file = fs::symlink_metadata(path).is_ok_and(|there| there.is_file());
    is_file && File::open(path).is_ok_and(|file| file.try_lock().is_ok()) && fs::remove_file(path).is_ok()
}

/// Returns the prefix of a file's temporary names: `.frame.0001.exr`. Long names are replaced by their checksum.
fn temporary_prefix(name: &OsStr) -> OsString {
    let mut prefix = OsString::from(".");
    if name.len() <= LONGEST_NAME && name.to_str().is_some() {
        prefix.push(name);
    } else {
        prefix.push(format!("pinwarp-{:08x}", crc32fast::hash(name.as_encoded_bytes())));
    }
    prefix
}

/// Returns the parent directory of a file.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Temporary files are private by default, but frames should have the permissions that the umask allows.
#[cfg(unix)]
fn set_permissions(builder: &mut Builder) {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(fs::Permissions::from_mode(0o666));
}

#[cfg(not(unix))]
fn set_permissions(_builder: &mut Builder) {}

/// Synchronises a directory, so that a rename in it is durable.
#[cfg(unix)]
fn sync_folder(folder: &Path) -> std::io::Result<()> {
    File::open(folder)?.sync_all()
}

/// Directories cannot be synchronised on other systems.
#[cfg(not(unix))]
fn sync_folder(_folder: &Path) -> std::io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stale_files_go_and_those_of_living_writers_and_strangers_stay() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let long = format!("{}.exr", "ä".repeat(110));
        let long_prefix = temporary_prefix(OsStr::new(&long)).into_string().expect("text");
        let long_stale = format!("{long_prefix}abcdef.tmp");
        let stale = [".f.0001.exr.tmp", ".f.0001.exrAb12Cd.tmp", ".f.0001.pngAb12Cd.tmp", &long_stale];
        let others =
            [".f.0003.exrAb12Cd.tmp", ".other.tmp", "f.0001.exr.tmp", ".f.0001.exrAb12Cd", ".f.0002.exrlonger1.tmp"];
        for name in stale.iter().chain(&others) {
            fs::write(at(name), "part").expect("written");
        }
        let living = File::create(at(".f.0002.exrAb12Cd.tmp")).expect("made");
        living.lock().expect("locked");
        let paths = ["f.0001.exr", "f.0001.png", "f.0002.exr", &long].map(at);
        assert_eq!(remove_stale(paths), stale.len());
        for name in stale {
            assert!(!at(name).exists(), "{name}");
        }
        for name in others.iter().chain(&[".f.0002.exrAb12Cd.tmp"]) {
            assert!(at(name).exists(), "{name}");
        }
    }

    #[test]
    #[cfg(feature = "editor")]
    fn what_a_killed_export_leaves_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let left = [".hero.stmap.0003.exrAb12Cd.tmp", ".hero.nkAb12Cd.tmp", ".hero.warped.glbxyz123.tmp"];
        let others = ["hero.toml", ".hero.cache.tmp", ".other.stmap.0003.exrAb12Cd.tmp", "hero.stmap.0002.exr"];
        for name in left.iter().chain(&others) {
            fs::write(at(name), "part").expect("written");
        }
        remove_unfinished(&at("hero.toml"));
        assert!(left.iter().all(|name| !at(name).exists()) && others.iter().all(|name| at(name).exists()));
        fs::write(at(".frame_0001.exrAb12Cd.tmp"), "part").expect("written");
        remove_unfinished(&at("frame_####.exr"));
        assert!(!at(".frame_0001.exrAb12Cd.tmp").exists());
    }

    #[test]
    fn names_as_long_as_the_file_system_allows() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["n".repeat(255), "ä".repeat(127)] {
            let path = folder.path().join(&name);
            for durability in [Durability::Cached, Durability::Synced] {
                replace_bytes(Destination { path: &path, durability }, b"all of it").expect("written");
            }
            assert_eq!(fs::read(&path).expect("read"), b"all of it");
        }
        assert_eq!(fs::read_dir(folder.path()).expect("listed").count(), 2, "nothing temporary is left");
    }

    #[test]
    #[cfg(unix)]
    fn links_are_followed_and_stay() {
        let folder = tempfile::tempdir().expect("a folder");
        let [real, link] = ["real.txt", "link.txt"].map(|name| folder.path().join(name));
        fs::write(&real, "old").expect("written");
        std::os::unix::fs::symlink(&real, &link).expect("linked");
        replace_text(&link, "new").expect("written");
        assert_eq!(fs::read_to_string(&real).expect("read"), "new");
        assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
    }
}
