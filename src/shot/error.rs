//! Errors of reading and editing shot files.

use std::path::PathBuf;

/// A shot that cannot be used. Each message names file, line, key and remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShotError {
    /// The file cannot be read.
    #[error("cannot read {path}: {source}; {}", remedy(source.kind()))]
    Io {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// The file is not TOML.
    #[error("{path}:{line}:{column}: not valid TOML: {what}; check quotes, brackets and `=` here")]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, one-based.
        line: usize,
        /// Column in characters, one-based.
        column: usize,
        /// The parser's message.
        what: String,
    },
    /// A key is unknown, missing, of the wrong type or out of range.
    #[error("{path}:{line}: {key}: {what}; {hint}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Line, one-based.
        line: usize,
        /// The key as a path: `layer[0].pin[2].keys[1].ease`.
        key: String,
        /// What is wrong.
        what: String,
        /// How to fix it.
        hint: String,
    },
    /// Several independent faults, in the order of the file.
    #[error("{}", joined(.0))]
    Many(Vec<ShotError>),
    /// A pin cannot be written into the text of a shot.
    #[error("cannot write pin {pin:?}: {what}; {hint}")]
    Edit {
        /// The pin's name.
        pin: String,
        /// What is wrong.
        what: String,
        /// How to fix it.
        hint: String,
    },
}

impl ShotError {
    /// Returns the individual faults: the parts of [`ShotError::Many`], else the error itself.
    #[cfg(feature = "python")]
    #[must_use]
    pub(crate) fn each(&self) -> &[Self] {
        match self {
            Self::Many(errors) => errors,
            single => std::slice::from_ref(single),
        }
    }

    /// Combines faults, sorted by line; `None` if there are none.
    pub(super) fn from_faults(mut faults: Vec<Self>) -> Option<Self> {
        faults.sort_by_key(Self::line);
        if faults.len() > 1 { Some(Self::Many(faults)) } else { faults.pop() }
    }

    fn line(&self) -> usize {
        match self {
            Self::Syntax { line, .. } | Self::Invalid { line, .. } => *line,
            _ => 0,
        }
    }
}

/// Returns what the user can do about a file that cannot be read.
fn remedy(kind: std::io::ErrorKind) -> &'static str {
    match kind {
        std::io::ErrorKind::InvalidData => {
            "a shot is UTF-8 text (.toml); `pinwarp new` makes one for a scene or picture"
        }
        std::io::ErrorKind::InvalidInput | std::io::ErrorKind::FileTooLarge => "give a shot file (.toml)",
        _ => "check the path and its permissions",
    }
}

/// Maximum number of faults shown: more than fit on a screen do not help.
const SHOWN_FAULTS: usize = 25;

fn joined(errors: &[ShotError]) -> String {
    let mut lines: Vec<String> = errors.iter().take(SHOWN_FAULTS).map(ToString::to_string).collect();
    if errors.len() > SHOWN_FAULTS {
        lines.push(format!("... and {} more", errors.len() - SHOWN_FAULTS));
    }
    lines.join("\n")
}
