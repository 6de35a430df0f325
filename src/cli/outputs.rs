//! Checks of single output files: a command never overwrites an input, a special file, or an existing file without
//! permission.
//!
//! In: the files that a command reads, and a path. Out: permission to write.

use crate::image::{Existing, Inputs, remove_stale};
use anyhow::Context;
use std::path::{Path, PathBuf};

/// Checks that a file may be written, and removes temporary files left by interrupted runs.
pub(super) fn allow(inputs: &Inputs, output: &Path, existing: impl Into<Existing>) -> anyhow::Result<()> {
    inputs.allow(output, existing.into())?;
    remove_stale([output.to_owned()]);
    Ok(())
}

/// As [`allow`], for a text: a file that already holds it is accepted in any case.
pub(super) fn allow_text(
    inputs: &Inputs,
    (output, text): (&Path, &str),
    existing: impl Into<Existing>,
) -> anyhow::Result<()> {
    if holds_text(output, text) { Ok(inputs.refuse(output)?) } else { allow(inputs, output, existing) }
}

/// Returns whether a file already holds this text.
pub(super) fn holds_text(path: &Path, text: &str) -> bool {
    path.is_file() && std::fs::read(path).is_ok_and(|there| there == text.as_bytes())
}

/// Returns a command's input files.
pub(super) fn inputs_of<'a>(paths: impl IntoIterator<Item = &'a PathBuf>) -> Inputs {
    let mut inputs = Inputs::default();
    paths.into_iter().for_each(|path| inputs.add(path));
    inputs
}

/// Returns a path as UTF-8 text, for writing it into another file.
pub(super) fn as_text(path: &Path) -> anyhow::Result<&str> {
    path.to_str().with_context(|| {
        format!("{}: the name is not valid Unicode and cannot be written into a file; rename it", path.display())
    })
}
