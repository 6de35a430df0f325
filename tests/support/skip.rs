//! What a test run leaves out, said where everybody sees it, and counted.
//!
//! Assets that are not part of the package lie in `../shared` or where `PINWARP_SHARED` says. With `PINWARP_REQUIRE_SHARED=1`
//! a test that misses one fails. `PINWARP_SKIPPED` names a file that collects a line for each skip of all test programs.

use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

static SKIPS: AtomicUsize = AtomicUsize::new(0);

/// Says what is not tested. Test harnesses capture what macros print, so this goes past them.
pub(crate) fn skip(what: &str) {
    let count = SKIPS.fetch_add(1, Ordering::Relaxed) + 1;
    let _ = writeln!(std::io::stderr().lock(), "SKIPPED ({count} in this program): {what}");
    if let Some(path) = std::env::var_os("PINWARP_SKIPPED") {
        let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
        let written = file.and_then(|mut file| file.write_all(format!("{what}\n").as_bytes()));
        written.expect("PINWARP_SKIPPED names a file that can be written");
    }
}

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
    skip(&format!("{file} is not at hand; set PINWARP_SHARED"));
    None
}
