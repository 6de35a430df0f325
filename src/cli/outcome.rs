//! How a command ends, and which exit code and words that gives.
//!
//! In: a result. Out: exit code 0 (all done), 1 (some frames are missing, or the output was cut off), 2 (bad input or usage).

use std::io;

/// What a command ends with, when it does not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Everything asked for was done.
    Complete,
    /// Some frames are missing.
    Partial,
}

impl Outcome {
    /// Its exit code.
    pub(super) const fn code(self) -> u8 {
        match self {
            Self::Complete => 0,
            Self::Partial => 1,
        }
    }
}

/// What was asked for was done, but standard output did not take all that was said about it.
#[derive(Debug, thiserror::Error)]
#[error("cannot write to standard output: {0}")]
pub(super) struct OutputCutOff(#[source] pub(super) io::Error);

/// The exit code of a command that failed.
pub(super) fn code_of(error: &anyhow::Error) -> u8 {
    if error.chain().any(|cause| cause.is::<OutputCutOff>()) { 1 } else { 2 }
}

/// The message, and its causes as far as it does not say them itself.
pub(super) fn in_words(error: &anyhow::Error) -> String {
    let causes = error.chain().skip(1).map(ToString::to_string);
    causes.fold(
        error.to_string(),
        |words, cause| if words.contains(&cause) { words } else { format!("{words}: {cause}") },
    )
}

/// Whoever read our output has seen enough: no failure.
pub(super) fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let mut errors = error.chain().filter_map(|cause| cause.downcast_ref::<io::Error>());
    errors.any(|error| error.kind() == io::ErrorKind::BrokenPipe)
}
