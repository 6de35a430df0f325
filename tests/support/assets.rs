//! Real files of other programs, where they are at hand.

#[path = "shared.rs"]
mod shared;

use std::path::PathBuf;

/// A file below the folder of shared assets; `None`, and a skip that everybody sees, where it is not there.
pub(crate) fn asset(file: &str) -> Option<PathBuf> {
    shared::shared(&format!("assets/{file}"))
}
