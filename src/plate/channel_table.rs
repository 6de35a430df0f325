//! Table of all channels of a plate: their names, their semantics, and the alpha that each colour is associated with.
//!
//! In: a plate and the shot's channel patterns. Out: [`ChannelTable`], and warnings about channels whose name does not
//! identify their contents.

use super::semantics::{ChannelName, Classified, axis_of};
use super::{ChannelReport, PlateReport, Semantic, SemanticReason};
use crate::image::cryptomatte::{MatteHeader, MatteLayer, matte_layers};
use crate::image::{Channel, Plate};
use crate::space::PixelRect;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Index of a channel: its part, and its position among the channels of that part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ChannelIndex {
    pub(super) part: usize,
    pub(super) channel: usize,
}

/// A channel together with its parsed name and semantic.
#[derive(Clone, Debug)]
pub(super) struct ChannelEntry {
    pub(super) index: ChannelIndex,
    pub(super) name: ChannelName,
    pub(super) class: Classified,
    /// The alpha that premultiplies this channel, or that holds the coverage of its surface.
    pub(super) alpha: Option<ChannelIndex>,
}

/// A plate and the classification of its channels.
pub(super) struct ChannelTable<'a> {
    pub(super) plate: &'a Plate,
    /// Every channel of every part, in file order.
    pub(super) entries: Vec<ChannelEntry>,
    /// The Cryptomatte layers declared in the headers.
    pub(super) mattes: Vec<MatteHeader>,
}

/// Names of layers that hold the beauty; their alpha also applies to layers that have none of their own.
pub(super) const BEAUTY: [&str; 8] = ["combined", "rgba", "beauty", "rgb", "composite", "main", "image", "c"];

impl<'a> ChannelTable<'a> {
    pub(super) fn of(plate: &'a Plate, patterns: &[(String, Semantic)]) -> Self {
        let texts = plate.parts.iter().map(|part| part.texts("cryptomatte/"));
        let texts: BTreeMap<String, String> = texts.flatten().collect();
        let mattes = MatteHeader::from_attributes(texts.iter().map(|(name, text)| (name.as_str(), text.as_str())));
        let mut table = Self { plate, entries: Vec::new(), mattes };
        for (part, stored) in plate.parts.iter().enumerate() {
            let views = stored.views();
            let views: Vec<&str> = views.iter().map(String::as_str).collect();
            let names: Vec<&str> = stored.channels.iter().map(|channel| channel.name.as_str()).collect();
            let names = ChannelName::of_part(stored.name.as_deref(), &views, &names);
            let entries = names.into_iter().zip(&stored.channels).enumerate().map(|(channel, (name, stored))| {
                let class = name.semantic(stored.storage, patterns);
                ChannelEntry { index: ChannelIndex { part, channel }, name, class, alpha: None }
            });
            table.entries.extend(entries);
        }
        table.find_ranks();
        table.find_alphas();
        table
    }

    pub(super) fn channel(&self, index: ChannelIndex) -> &'a Channel {
        &self.plate.parts[index.part].channels[index.channel]
    }

    /// Returns the data window of a channel, relative to the upper left corner of the display window.
    pub(super) fn window(&self, index: ChannelIndex) -> PixelRect {
        self.plate.window_of(&self.plate.parts[index.part])
    }

    /// Returns the samples of a channel over another window, padded with `outside`.
    pub(super) fn over(&self, index: ChannelIndex, window: PixelRect, outside: f32) -> Cow<'_, [f32]> {
        let (own, samples) = (self.window(index), &self.channel(index).samples);
        if own == window { Cow::Borrowed(samples) } else { Cow::Owned(own.resized_samples(samples, window, outside)) }
    }

    /// Returns the Cryptomatte layers among the given channels.
    pub(super) fn matte_layers<'b>(
        &self,
        entries: impl Iterator<Item = &'b ChannelEntry>,
    ) -> Vec<MatteLayer<ChannelIndex>> {
        let ranks: Vec<(ChannelIndex, String)> = entries
            .filter(|entry| entry.class.semantic == Semantic::Cryptomatte)
            .map(|entry| (entry.index, entry.name.with_part()))
            .collect();
        let names: Vec<String> = ranks.iter().map(|(_, name)| layer_of_rank(name)).collect();
        matte_layers(ranks.iter().map(|(place, name)| (*place, name.as_str())), &names)
    }

    /// Classifies the rank channels of Cryptomattes, unless the shot assigns them another semantic.
    fn find_ranks(&mut self) {
        let names: Vec<String> = self.entries.iter().map(|entry| entry.name.with_part()).collect();
        let known: Vec<String> = self.mattes.iter().map(|matte| matte.name.clone()).collect();
        for layer in matte_layers(names.iter().map(String::as_str).enumerate(), &known) {
            let is_told = known.contains(&layer.name);
            let reason = if is_told { SemanticReason::Metadata } else { SemanticReason::Name };
            for rank in layer.ranks.iter().flat_map(|rank| [rank.id, rank.coverage]) {
                self.mark_rank(&names[rank], reason);
            }
        }
    }

    /// Marks every channel of this name as a rank; parts that hold different views share channel names.
    fn mark_rank(&mut self, name: &str, reason: SemanticReason) {
        for entry in self.entries.iter_mut().filter(|entry| entry.name.with_part() == name) {
            if entry.class.reason != SemanticReason::Shot {
                entry.class = Classified { semantic: Semantic::Cryptomatte, reason };
            }
        }
    }

    /// Assigns each channel the alpha of its own layer, or else the beauty alpha of the same view that is nearest by layer name.
    fn find_alphas(&mut self) {
        let alphas: Vec<usize> =
            (0..self.entries.len()).filter(|&index| self.entries[index].class.semantic == Semantic::Alpha).collect();
        for index in 0..self.entries.len() {
            let entry = &self.entries[index];
            let nearness = |&&alpha: &&usize| nearness(entry, &self.entries[alpha]);
            let best = alphas.iter().filter(|alpha| nearness(alpha) > 0).max_by_key(|alpha| nearness(alpha));
            self.entries[index].alpha = best.map(|&alpha| self.entries[alpha].index);
        }
    }

    /// Returns the shot's patterns that match no channel.
    pub(super) fn unmatched_patterns(&self, patterns: &[(String, Semantic)]) -> Vec<String> {
        let is_unmatched = |pattern: &&String| !self.entries.iter().any(|entry| entry.name.fits(pattern));
        patterns.iter().map(|(pattern, _)| pattern).filter(is_unmatched).cloned().collect()
    }

    /// Reports the semantic of every channel, and warns about channels whose semantic had to be guessed.
    pub(super) fn report(&self, report: &mut PlateReport) {
        report.channels = self.entries.iter().map(|entry| entry.report(self.plate)).collect();
        let mut guessed: BTreeMap<(String, &'static str), Vec<&str>> = BTreeMap::new();
        for entry in self.entries.iter().filter(|entry| entry.is_guessed(self)) {
            let treatment =
                if entry.class.semantic == Semantic::Color { "filtered as colour" } else { "copied as data" };
            guessed.entry((entry.name.segments.join("."), treatment)).or_default().push(&entry.name.full);
        }
        report.warnings.extend(guessed.into_iter().map(|((_, treatment), names)| {
            format!(
                "the contents of {} are unknown: {treatment}; if that is wrong, set them under [[warp.channels]]",
                names.join(", ")
            )
        }));
        let is_disparity = |entry: &&ChannelEntry| entry.name.full.to_lowercase().starts_with("disparity");
        if let Some(entry) = self.entries.iter().find(is_disparity) {
            let name = &entry.name.full;
            report
                .warnings
                .push(format!("{name}: values are kept, although the warp changes the disparity between the views"));
        }
    }
}

impl ChannelEntry {
    pub(super) fn report(&self, plate: &Plate) -> ChannelReport {
        ChannelReport {
            part: plate.parts[self.index.part].name.clone(),
            channel: self.name.full.clone(),
            semantic: self.class.semantic,
            reason: self.class.reason,
        }
    }

    /// Whether both channels play the same role in the same view: the same component (R, G, B or A) of the beauty,
    /// depth, the same component of motion, or the same half of a rank of Cryptomattes of one name.
    pub(super) fn has_role_of(&self, other: &Self) -> bool {
        let (own, theirs) = (&self.name, &other.name);
        let is_same = self.class.semantic == other.class.semantic && own.view == theirs.view;
        is_same
            && match self.class.semantic {
                Semantic::Depth => true,
                Semantic::Color | Semantic::Alpha => {
                    own.component.eq_ignore_ascii_case(&theirs.component) && own.is_beauty() && theirs.is_beauty()
                }
                Semantic::Forward | Semantic::Backward => {
                    axis_of(&own.component).is_some_and(|axis| axis_of(&theirs.component) == Some(axis))
                }
                Semantic::Cryptomatte => {
                    own.component.eq_ignore_ascii_case(&theirs.component) && own.layer_word() == theirs.layer_word()
                }
                _ => false,
            }
    }

    /// Whether the semantic is a guess that the user should be warned about. Half-float channels are safely taken to be colour.
    fn is_guessed(&self, table: &ChannelTable) -> bool {
        let is_half = table.channel(self.index).storage == crate::image::Storage::Half;
        self.class.reason == SemanticReason::Guess && !(is_half && self.class.semantic == Semantic::Color)
    }
}

impl ChannelName {
    /// Whether this channel belongs to the beauty.
    fn is_beauty(&self) -> bool {
        self.segments.last().is_none_or(|layer| BEAUTY.contains(&layer.to_lowercase().as_str()))
    }
}

/// Returns the layer of a rank channel: `CryptoObject` for `CryptoObject00.R`.
fn layer_of_rank(name: &str) -> String {
    let layer = name.rsplit_once('.').map_or(name, |(layer, _)| layer);
    layer.trim_end_matches(|letter: char| letter.is_ascii_digit()).to_owned()
}

/// Scores how well an alpha matches a channel; 0 if it does not apply to the channel at all.
fn nearness(entry: &ChannelEntry, alpha: &ChannelEntry) -> usize {
    let (own, other) = (&entry.name, &alpha.name);
    if own.view != other.view && !(own.view.is_none() || other.view.is_none()) {
        return 0;
    }
    let is_own_part = entry.index.part == alpha.index.part;
    if is_own_part && own.segments == other.segments {
        return 1000;
    }
    let shared = own.segments.iter().zip(&other.segments).take_while(|(a, b)| a == b).count();
    let rest = &other.segments[shared..];
    let is_beauty = match rest {
        [] => true,
        [layer] => BEAUTY.contains(&layer.to_lowercase().as_str()),
        _ => false,
    };
    if is_beauty { 1 + 10 * shared + usize::from(own.view == other.view) * 2 + usize::from(is_own_part) } else { 0 }
}
