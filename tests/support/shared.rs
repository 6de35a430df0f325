//! Files that are not part of the package.
//!
//! They lie in `../shared` or where `PINWARP_SHARED` says. With `PINWARP_REQUIRE_SHARED=1` a test that misses one fails.

#[path = "skip.rs"]
mod skip;

use std::path::PathBuf;

/// A file below the folder of shared assets, e.g. `assets/kaykit/Knight.glb`; `None`, and a skip, where it is not there.
///
/// # Panics
/// Where it is not there, and `PINWARP_REQUIRE_SHARED` is 1.
pub(crate) fn shared(file: &str) -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared");
    let folder = std::env::var_os("PINWARP_SHARED").map_or_else(|| PathBuf::from(beside), PathBuf::from);
    let path = folder.join(file);
    if path.exists() {
        return Some(path);
    }
    let is_required = std::env::var_os("PINWARP_REQUIRE_SHARED").is_some_and(|value| value == "1");
    assert!(!is_required, "PINWARP_REQUIRE_SHARED is set, but {} is not there", path.display());
    skip::skip(&format!("{file} is not at hand; set PINWARP_SHARED"));
    None
}
