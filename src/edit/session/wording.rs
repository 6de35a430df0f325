//! Words for what is edited: a model, a drawing or a picture.
//!
//! In: the shot's source. Out: nouns for hints and messages.

use super::Session;
use crate::shot::{Shot, Source};

impl Session {
    /// Returns the noun for what pins are placed on.
    #[must_use]
    pub(crate) const fn subject(&self) -> &'static str {
        match self.document.shot().source {
            Source::Scene(_) => "model",
            Source::Images(_) => "drawing",
            Source::Frame => "picture",
        }
    }
}

/// Returns what a new pin is named after: the part of a model that it holds. A drawing has no parts with names of their own.
pub(super) const fn pin_noun<'a>(shot: &Shot, node: &'a str) -> &'a str {
    match shot.source {
        Source::Scene(_) => node,
        Source::Images(_) | Source::Frame => "pin",
    }
}
