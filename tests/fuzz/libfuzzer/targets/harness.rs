//! Gives the bytes of a case to a reader, as a file in a folder of this process.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// Where the file of the current case lies; in memory where the system has such a folder.
static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let parent =
        Some(Path::new("/dev/shm")).filter(|path| path.is_dir()).map_or_else(std::env::temp_dir, Path::to_owned);
    let folder = parent.join(format!("pinwarp-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder can be made");
    folder
});

/// Reads `data` as a file with this ending.
pub(crate) fn read(data: &[u8], ending: &str, reader: fn(&Path) -> bool) {
    let path = FOLDER.join(format!("case.{ending}"));
    std::fs::write(&path, data).expect("the temporary folder can be written");
    reader(&path);
}
