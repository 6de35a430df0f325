//! Real files of other programs, where they are at hand.

use std::path::PathBuf;

/// A file below the folder of shared assets; `None`, and a loud line, where it is not there.
pub(crate) fn asset(file: &str) -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared");
    let shared = std::env::var_os("PINWARP_SHARED").map_or_else(|| PathBuf::from(beside), PathBuf::from);
    let path = shared.join("assets").join(file);
    if path.exists() {
        return Some(path);
    }
    eprintln!("SKIPPED: {file} is not at hand (PINWARP_SHARED)");
    None
}
