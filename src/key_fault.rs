//! What is wrong with a value in a file or a shot.
//!
//! In: the key, the fault, the remedy. Out: a [`KeyFault`], which the reader of the file turns into its own error.

/// A fault of the value at a key.
#[derive(Debug)]
pub(crate) struct KeyFault {
    /// The key, or the line: `layers[0].frames[3].handles`, `ids.file`, `line 4`.
    pub(crate) key: String,
    /// What is wrong.
    pub(crate) what: String,
    /// How to fix it.
    pub(crate) hint: String,
}

impl KeyFault {
    /// Creates the fault.
    pub(crate) fn new(key: impl Into<String>, what: impl Into<String>, hint: impl Into<String>) -> Self {
        Self { key: key.into(), what: what.into(), hint: hint.into() }
    }
}
