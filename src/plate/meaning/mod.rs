//! What the channels of a plate mean, told by their names as renderers write them.
//!
//! In: names of parts and channels, storage, the shot's patterns. Out: a [`Meaning`] each, and how it is known.
//! The table stands in docs/PLATES.md.

mod name;
mod words;

pub(super) use name::ChannelName;

use super::{Meaning, MeaningReason};
use crate::image::Storage;
use crate::spelling;
use words::{COLOR_WORDS, LAYER_WORDS, NAME_WORDS};

/// A meaning and how it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Known {
    pub(super) meaning: Meaning,
    pub(super) reason: MeaningReason,
}

impl ChannelName {
    /// What the channel means, where it is no rank of a Cryptomatte.
    pub(super) fn meaning(&self, storage: Storage, patterns: &[(String, Meaning)]) -> Known {
        let told = |meaning, reason| Known { meaning, reason };
        if let Some((_, meaning)) = patterns.iter().find(|(pattern, _)| self.fits(pattern)) {
            return told(*meaning, MeaningReason::Shot);
        }
        match meaning_by_name(self, storage) {
            Some(meaning) => told(meaning, MeaningReason::Name),
            None => told(guess(self, storage), MeaningReason::Guess),
        }
    }
}

fn meaning_by_name(name: &ChannelName, storage: Storage) -> Option<Meaning> {
    if storage == Storage::Uint {
        return Some(Meaning::Id);
    }
    // Ids or coverage of which the other half is missing.
    let is_rank = |word: &str| word.contains("crypto") && word.ends_with(|letter: char| letter.is_ascii_digit());
    if name.layer_word().is_some_and(is_rank) {
        return Some(Meaning::Data);
    }
    let component = name.component.as_str();
    if let Some(meaning) = name.layer_word().and_then(|word| meaning_of_layer(word, component)) {
        return Some(meaning);
    }
    let whole = name.segments.is_empty().then(|| word_of(component));
    if let Some(meaning) = whole.and_then(|word| found(NAME_WORDS, &word)) {
        return Some(meaning);
    }
    match component.to_ascii_lowercase().as_str() {
        "a" | "alpha" => Some(Meaning::Alpha),
        "z" | "zback" if !name.has_sibling("y") => Some(Meaning::Depth),
        "id" | "objectid" => Some(Meaning::Id),
        "r" | "g" | "b" | "y" | "ry" | "by" if name.segments.is_empty() && name.part.is_none() => Some(Meaning::Color),
        _ => None,
    }
}

/// Colour is what a half float holds; 32 bits are for colour where the channels are called so, and for data elsewhere.
fn guess(name: &ChannelName, storage: Storage) -> Meaning {
    let component = name.component.to_ascii_lowercase();
    let is_vector = matches!(component.as_str(), "x" | "y" | "z" | "w" | "u" | "v") && name.has_vector_siblings();
    match storage {
        _ if is_vector => Meaning::Data,
        Storage::Half => Meaning::Color,
        _ if matches!(component.as_str(), "r" | "g" | "b" | "y" | "v") => Meaning::Color,
        _ => Meaning::Data,
    }
}

/// What a layer of that name holds in one of its components.
fn meaning_of_layer(word: &str, component: &str) -> Option<Meaning> {
    let component = component.to_ascii_lowercase();
    if matches!(component.as_str(), "a" | "alpha") {
        return Some(Meaning::Alpha);
    }
    if word == "vector" {
        return meaning_in_blender(&component);
    }
    match found(LAYER_WORDS, word) {
        // The third component of a vector of the screen says nothing; Arnold and V-Ray write one.
        Some(Meaning::Forward | Meaning::Backward) if matches!(component.as_str(), "b" | "z" | "w") => {
            Some(Meaning::Data)
        }
        None => is_color(word).then_some(Meaning::Color),
        known => known,
    }
}

/// Blender's `Vector`: X and Y lead to the previous frame, Z and W come from the next
/// (`primitive_motion_vector` in Cycles' kernel/geom/primitive.h).
fn meaning_in_blender(component: &str) -> Option<Meaning> {
    match component {
        "z" | "w" | "b" => Some(Meaning::Forward),
        _ => Some(Meaning::Backward),
    }
}

fn is_color(word: &str) -> bool {
    COLOR_WORDS.iter().any(|start| word.starts_with(start)) || ["mask", "matte"].iter().any(|end| word.ends_with(end))
}

fn found(words: &[(Meaning, &[&str])], word: &str) -> Option<Meaning> {
    words.iter().find(|(_, words)| words.contains(&word)).map(|(meaning, _)| *meaning)
}

/// A name without what people put between its words: `world_normal` is `worldnormal`.
fn word_of(segment: &str) -> String {
    segment.chars().filter(|c| c.is_alphanumeric()).collect::<String>().to_lowercase()
}

impl ChannelName {
    /// Whether a pattern of a shot means this channel: by its full name, or by its part's and its own.
    pub(super) fn fits(&self, pattern: &str) -> bool {
        spelling::fits(pattern, &self.full) || spelling::fits(pattern, &self.with_all_of_part())
    }
}
