//! Notes about frames outside a shot's range: valid, but often a mistake.
//!
//! In: a [`Shot`]. Out: notes for the user.

use super::{Anchor, Cut, FrameRange, Layer, Pin, Shot};
use crate::spelling::pluralised;

impl Shot {
    /// Returns one note for each layer with keys outside the frames of the shot, for each pin anchored in a frame outside, and
    /// for each stroke drawn over one.
    #[must_use]
    pub(crate) fn range_notes(&self) -> Vec<String> {
        self.layers.iter().flat_map(|layer| notes_of(layer, self.frames)).collect()
    }
}

fn notes_of(layer: &Layer, frames: FrameRange) -> Vec<String> {
    let FrameRange { first, last, .. } = frames;
    let mut notes = Vec::new();
    for pin in &layer.pins {
        if let Anchor::Screen { frame: Some(frame), .. } = pin.anchor
            && !(first..=last).contains(&frame)
        {
            notes.push(format!(
                "layer '{}': pin '{}' is anchored in frame {frame}, outside the shot's frames {first} to {last}",
                layer.name, pin.name
            ));
        }
    }
    for (number, cut) in layer.connectivity.cuts.iter().enumerate() {
        if let Cut::SceneStroke { frame, .. } = cut
            && !(first..=last).contains(frame)
        {
            notes.push(format!(
                "layer '{}': the stroke of cuts[{number}] is drawn over frame {frame}, outside the shot's frames {first} to {last}",
                layer.name
            ));
        }
    }
    let pins = layer.pins.iter().filter(|pin| !pin.rests()).flat_map(Pin::key_frames);
    let handles = layer.handles.iter().filter(|handle| !handle.rests());
    let keys = pins.chain(handles.flat_map(|handle| &handle.keys).map(|key| key.frame));
    let outside: Vec<f64> = keys.filter(|&key| key < f64::from(first) || key > f64::from(last)).collect();
    if let Some(example) = outside.first() {
        notes.push(format!(
            "layer '{}': {} outside the shot's frames {first} to {last}, for example in frame {example}",
            layer.name,
            pluralised(outside.len(), "key lies", "keys lie")
        ));
    }
    notes
}
