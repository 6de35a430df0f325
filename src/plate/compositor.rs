//! Context shared by all channels of a composite: source samples, hole filling and working memory.
//!
//! In: the plate's channels, settings. Out: [`PlateCompositor`] and [`AlphaGroup`]; samples of channels that are copied
//! rather than blended.

use super::channel_table::{ChannelEntry, ChannelIndex, ChannelTable};
use super::composite::Composite;
use super::disjoint_over::Occlusion;
use super::hole_filling::{HoleFilling, seen};
use super::moving_layer::MovingLayer;
use super::resampler::{ResampleContext, Resampling};
use super::visible_samples::{VisibleSample, copied};
use super::{Filter, Planes, Semantic, WarpSettings};
use crate::image::EMPTY_DEPTH;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Output samples by channel.
pub(super) type OutputPlanes = BTreeMap<ChannelIndex, Vec<f32>>;

/// The inputs and settings of compositing.
pub(super) struct PlateCompositor<'a> {
    pub(super) table: &'a ChannelTable<'a>,
    pub(super) settings: &'a WarpSettings,
    /// `None` if only a map is known.
    pub(super) moving_layers: Option<&'a [MovingLayer<'a>]>,
    pub(super) filling: Option<HoleFilling<'a>>,
    pub(super) context: &'a ResampleContext,
}

/// The channels of a composite that share an alpha and therefore their occlusion.
pub(super) struct AlphaGroup<'a> {
    pub(super) entries: Vec<&'a ChannelEntry>,
    pub(super) occlusion: Occlusion,
    /// #pixels of the composite; empty if no channel is copied.
    pub(super) visible: Vec<VisibleSample>,
}

impl PlateCompositor<'_> {
    /// Returns the alpha of a composite's colour. If the picture moves as a whole, an alpha of 0 everywhere is ignored.
    pub(super) fn alpha(&self, index: ChannelIndex, composite: &Composite) -> Option<Cow<'_, [f32]>> {
        let alpha = self.table.over(index, composite.source, 0.0);
        let has_mattes = !composite.matted_layers().is_empty();
        (has_mattes || alpha.iter().any(|alpha| *alpha > 0.0)).then_some(alpha)
    }

    /// Returns resampling with the given filter.
    pub(super) fn by(&self, filter: Filter) -> Resampling<'_> {
        Resampling { context: self.context, filter }
    }

    /// Returns the samples that fill the holes of a channel.
    pub(super) fn fill(&self, entry: &ChannelEntry, composite: &Composite, filter: Filter) -> Option<Vec<f32>> {
        let filling = self.filling.as_ref()?;
        Some(filling.seen(filling.find(entry)?.index, composite, self.by(filter)))
    }

    /// As [`Self::fill`], with other samples of the clean plate's channel.
    pub(super) fn fill_by(
        &self,
        entry: &ChannelEntry,
        (composite, samples): (&Composite, &[f32]),
        filter: Filter,
    ) -> Option<Vec<f32>> {
        let filling = self.filling.as_ref()?;
        let (_, window) = filling.samples(filling.find(entry)?.index);
        Some(seen(&Planes { window, planes: vec![samples] }, composite, self.by(filter)))
    }

    /// Copies the visible samples of several channels together, so that each pixel shows the same source sample in all of them.
    pub(super) fn copy(
        &self,
        entries: &[&ChannelEntry],
        (composite, group): (&Composite, &AlphaGroup),
        planes: &mut OutputPlanes,
    ) {
        let empty = |entry: &ChannelEntry| if entry.class.semantic == Semantic::Depth { EMPTY_DEPTH } else { 0.0 };
        let source = |entry: &&ChannelEntry| (&self.table.channel(entry.index).samples[..], empty(entry));
        let sources: Vec<(&[f32], f32)> = entries.iter().map(source).collect();
        let mut copies: Vec<_> = entries.iter().map(|_| self.context.plane(group.visible.len())).collect();
        copied(&group.visible, composite.window.width as usize, &sources, &mut copies);
        for (entry, mut plane) in entries.iter().zip(copies) {
            self.fill_copied(entry, composite, group, &mut plane);
            planes.insert(entry.index, plane);
        }
    }

    /// Fills the holes of a channel that is copied rather than blended. Vectors in unknown units are not filled.
    fn fill_copied(&self, entry: &ChannelEntry, composite: &Composite, group: &AlphaGroup, plane: &mut [f32]) {
        let Some(filling) = &self.filling else { return };
        let Some(behind) = filling.find(entry) else { return };
        let is_motion = matches!(entry.class.semantic, Semantic::Forward | Semantic::Backward);
        if is_motion && !filling.is_stored_alike(behind, entry) {
            return;
        }
        let storage = self.table.channel(entry.index).storage;
        let samples = plane.iter_mut().zip(&group.visible).enumerate();
        samples.filter(|(_, (_, seen))| **seen == VisibleSample::Hole).for_each(|(at, (sample, _))| {
            *sample = filling.nearest(behind.index, (composite, at), storage).unwrap_or(*sample);
        });
    }
}

impl<'a> AlphaGroup<'a> {
    /// Returns the group's channels with one of the given semantics.
    pub(super) fn of(&self, semantics: &[Semantic]) -> Vec<&'a ChannelEntry> {
        self.entries.iter().copied().filter(|entry| semantics.contains(&entry.class.semantic)).collect()
    }
}
