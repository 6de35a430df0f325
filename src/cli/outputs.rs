//! Single files that commands write. All of them pass one guard: no input, nothing special, nothing that is there already
//! unless it may be replaced.
//!
//! In: what a command reads, and a path. Out: leave to write.

use crate::image::{Existing, Inputs, remove_stale};
use anyhow::Context;
use std::path::{Path, PathBuf};

/// Asks whether a file may be written, and removes what runs that died left of it.
pub(super) fn allow(inputs: &Inputs, output: &Path, existing: impl Into<Existing>) -> anyhow::Result<()> {
    inputs.allow(output, existing.into())?;
    remove_stale([output.to_owned()]);
    Ok(())
}

/// As [`allow`], of a text: a file that holds it already may stay, whatever is asked.
pub(super) fn allow_text(
    inputs: &Inputs,
    (output, text): (&Path, &str),
    existing: impl Into<Existing>,
) -> anyhow::Result<()> {
    if holds_text(output, text) { Ok(inputs.refuse(output)?) } else { allow(inputs, output, existing) }
}

/// Whether a file holds that text already: then there is nothing to replace.
pub(super) fn holds_text(path: &Path, text: &str) -> bool {
    path.is_file() && std::fs::read(path).is_ok_and(|there| there == text.as_bytes())
}

/// The files that a command is given.
pub(super) fn inputs_of<'a>(paths: impl IntoIterator<Item = &'a PathBuf>) -> Inputs {
    let mut inputs = Inputs::default();
    paths.into_iter().for_each(|path| inputs.add(path));
    inputs
}

/// The text of a path that is written into another file.
pub(super) fn as_text(path: &Path) -> anyhow::Result<&str> {
    path.to_str().with_context(|| {
        format!("{}: the name is not valid Unicode and cannot be written into a file; rename it", path.display())
    })
}
