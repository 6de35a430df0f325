//! Condenses notes on layers, which recur in every frame: the first of each layer is printed.
//!
//! In: notes, frame by frame. Out: lines.

use crate::pipeline::LayerNote;
use std::collections::BTreeSet;

/// The layers of which a note was printed.
#[derive(Debug, Default)]
pub(super) struct LayerNotes(BTreeSet<String>);

impl LayerNotes {
    /// Returns the lines of those notes whose layers had none before.
    pub(super) fn new_lines(&mut self, notes: &[LayerNote]) -> Vec<String> {
        let new = notes.iter().filter(|note| self.0.insert(note.layer.clone()));
        new.map(|note| format!("note: {}", note.text)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_note_of_each_layer_is_printed() {
        let note = |layer: &str, text: &str| LayerNote { layer: layer.into(), text: text.into() };
        let mut notes = LayerNotes::default();
        let first = [note("arm", "crosses"), note("arm", "crosses twice"), note("leg", "crosses")];
        assert_eq!(notes.new_lines(&first), ["note: crosses", "note: crosses"]);
        assert_eq!(notes.new_lines(&[note("leg", "crosses less"), note("hand", "turns")]), ["note: turns"]);
    }
}
