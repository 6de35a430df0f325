//! Infers the semantics of a plate's channels from the names that renderers use.
//!
//! In: names of parts and channels, storage types, the shot's patterns. Out: a [`Semantic`] each, and how it was
//! determined. docs/PLATES.md has the table.

mod channel_name;
mod vocabulary;

pub(super) use channel_name::{ChannelName, VECTOR_COMPONENTS, axis_of};

use super::{Semantic, SemanticReason};
use crate::image::Storage;
use crate::spelling;
use vocabulary::{COLOR_WORDS, LAYER_WORDS, NAME_WORDS};

/// A semantic and how it was determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Classified {
    pub(super) semantic: Semantic,
    pub(super) reason: SemanticReason,
}

impl ChannelName {
    /// Returns the semantic of a channel that is not a rank of a Cryptomatte.
    pub(super) fn semantic(&self, storage: Storage, patterns: &[(String, Semantic)]) -> Classified {
        let told = |semantic, reason| Classified { semantic, reason };
        if let Some((_, semantic)) = patterns.iter().find(|(pattern, _)| self.fits(pattern)) {
            return told(*semantic, SemanticReason::Shot);
        }
        match semantic_by_name(self, storage) {
            Some(semantic) => told(semantic, SemanticReason::Name),
            None => told(guess(self, storage), SemanticReason::Guess),
        }
    }
}

fn semantic_by_name(name: &ChannelName, storage: Storage) -> Option<Semantic> {
    if storage == Storage::Uint {
        return Some(Semantic::Id);
    }
    // A rank channel whose other half is missing.
    let is_rank = |word: &str| word.contains("crypto") && word.ends_with(|letter: char| letter.is_ascii_digit());
    if name.layer_word().is_some_and(is_rank) {
        return Some(Semantic::Data);
    }
    let component = name.component.as_str();
    if let Some(semantic) = name.layer_word().and_then(|word| semantic_of_layer(word, component)) {
        return Some(semantic);
    }
    let whole = name.segments.is_empty().then(|| word_of(component));
    if let Some(semantic) = whole.and_then(|word| found(NAME_WORDS, &word)) {
        return Some(semantic);
    }
    match component.to_ascii_lowercase().as_str() {
        "a" | "alpha" => Some(Semantic::Alpha),
        "z" | "zback" if !name.has_sibling("y") => Some(Semantic::Depth),
        "id" | "objectid" => Some(Semantic::Id),
        "r" | "g" | "b" | "y" | "ry" | "by" if name.segments.is_empty() && name.part.is_none() => Some(Semantic::Color),
        _ => None,
    }
}

/// Guesses from the storage type: half floats are colour; 32-bit floats are colour only if the component names are
/// those of colour, and data otherwise.
fn guess(name: &ChannelName, storage: Storage) -> Semantic {
    let component = name.component.to_ascii_lowercase();
    let is_vector = matches!(component.as_str(), "x" | "y" | "z" | "w" | "u" | "v") && name.has_vector_siblings();
    match storage {
        _ if is_vector => Semantic::Data,
        Storage::Half => Semantic::Color,
        _ if matches!(component.as_str(), "r" | "g" | "b" | "y" | "v") => Semantic::Color,
        _ => Semantic::Data,
    }
}

/// Returns the semantic of a component of a layer of this name.
fn semantic_of_layer(word: &str, component: &str) -> Option<Semantic> {
    let component = component.to_ascii_lowercase();
    if matches!(component.as_str(), "a" | "alpha") {
        return Some(Semantic::Alpha);
    }
    if word == "vector" {
        return semantic_in_blender(&component);
    }
    match found(LAYER_WORDS, word) {
        // The third component of a screen vector carries no information; Arnold and V-Ray write one.
        Some(Semantic::Forward | Semantic::Backward) if matches!(component.as_str(), "b" | "z" | "w") => {
            Some(Semantic::Data)
        }
        None => is_color(word).then_some(Semantic::Color),
        known => known,
    }
}

/// Blender's `Vector`: X and Y point to the previous frame, Z and W come from the next (`primitive_motion_vector` in
/// Cycles' kernel/geom/primitive.h).
fn semantic_in_blender(component: &str) -> Option<Semantic> {
    match component {
        "z" | "w" | "b" => Some(Semantic::Forward),
        _ => Some(Semantic::Backward),
    }
}

fn is_color(word: &str) -> bool {
    COLOR_WORDS.iter().any(|start| word.starts_with(start)) || ["mask", "matte"].iter().any(|end| word.ends_with(end))
}

fn found(words: &[(Semantic, &[&str])], word: &str) -> Option<Semantic> {
    words.iter().find(|(_, words)| words.contains(&word)).map(|(semantic, _)| *semantic)
}

/// Normalises a name by removing separators: `world_normal` becomes `worldnormal`.
fn word_of(segment: &str) -> String {
    segment.chars().filter(|c| c.is_alphanumeric()).collect::<String>().to_lowercase()
}

impl ChannelName {
    /// Whether a pattern of the shot matches this channel, by its full name or with the part's name as prefix.
    pub(super) fn fits(&self, pattern: &str) -> bool {
        spelling::matches_pattern(pattern, &self.full) || spelling::matches_pattern(pattern, &self.with_all_of_part())
    }
}
