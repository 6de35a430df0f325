//! The lines of the keys of a shot file.
//!
//! In: key paths like `layer[0].pin[2].anchor`. Out: lines, for messages of later stages.

use std::collections::HashMap;

/// One-based lines of keys and list items, by their paths.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct KeyLines(HashMap<String, usize>);

impl KeyLines {
    /// Returns the line of a key; if the key is missing, that of the table that should contain it, else 1.
    #[must_use]
    pub(crate) fn of(&self, key: &str) -> usize {
        let mut known = key;
        loop {
            if let Some(&line) = self.0.get(known) {
                return line;
            }
            match known.rfind(['.', '[']) {
                Some(end) => known = &known[..end],
                None => return 1,
            }
        }
    }

    /// Returns whether the file contains this key (or list item).
    #[must_use]
    pub(crate) fn has(&self, key: &str) -> bool {
        self.0.contains_key(key)
    }

    pub(super) fn insert(&mut self, key: String, line: usize) {
        self.0.insert(key, line);
    }
}
