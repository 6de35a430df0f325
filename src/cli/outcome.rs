//! The outcome of a command, with its exit code and message.
//!
//! In: a result. Out: exit code 0 (success), 1 (some frames are missing, or the output was cut off), 2 (bad input or
//! usage).

use std::io;

/// The outcome of a command that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Everything was done.
    Complete,
    /// Some frames are missing.
    Partial,
}

impl Outcome {
    /// Returns the exit code.
    pub(super) const fn code(self) -> u8 {
        match self {
            Self::Complete => 0,
            Self::Partial => 1,
        }
    }
}

/// The work was done, but its report could not be written completely to standard output.
#[derive(Debug, thiserror::Error)]
#[error("cannot write to standard output: {0}")]
pub(super) struct OutputCutOff(#[source] pub(super) io::Error);

/// Returns the exit code of a command that failed.
pub(super) fn code_of(error: &anyhow::Error) -> u8 {
    if error.chain().any(|cause| cause.is::<OutputCutOff>()) { 1 } else { 2 }
}

/// Returns the message, followed by its causes unless it already contains them.
pub(super) fn in_words(error: &anyhow::Error) -> String {
    let causes = error.chain().skip(1).map(ToString::to_string);
    causes.fold(
        error.to_string(),
        |words, cause| if words.contains(&cause) { words } else { format!("{words}: {cause}") },
    )
}

/// Returns whether the reader closed the pipe, which is not a failure.
pub(super) fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let mut errors = error.chain().filter_map(|cause| cause.downcast_ref::<io::Error>());
    errors.any(|error| error.kind() == io::ErrorKind::BrokenPipe)
}
