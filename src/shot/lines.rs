//! Where the keys of a shot file stand.
//!
//! In: key paths like `layer[0].pin[2].anchor`. Out: lines, for messages of later stages.

use std::collections::HashMap;

/// Lines of keys and list items, from 1, by their paths.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct KeyLines(HashMap<String, usize>);

impl KeyLines {
    /// The line of a key; where it is absent, that of the table that should hold it, else 1.
    #[must_use]
    pub fn of(&self, key: &str) -> usize {
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

    /// The file has this key (or list item).
    #[must_use]
    pub fn has(&self, key: &str) -> bool {
        self.0.contains_key(key)
    }

    pub(super) fn insert(&mut self, key: String, line: usize) {
        self.0.insert(key, line);
    }
}
