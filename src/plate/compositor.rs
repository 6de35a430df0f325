//! What every channel of a composite is made with: samples of the plate, what fills holes, memory.
//!
//! In: the plate's channels, settings. Out: [`PlateCompositor`] and [`AlphaGroup`]; channels that are copied, not blended.

use super::channel_table::{ChannelEntry, ChannelIndex, ChannelTable};
use super::composite::Composite;
use super::disjoint_over::Occlusion;
use super::hole_filling::HoleFilling;
use super::moving_layer::MovingLayer;
use super::resampler::{ResampleContext, Resampling};
use super::visible_samples::{VisibleSample, copied};
use super::{Filter, Semantic, WarpSettings};
use crate::image::EMPTY_DEPTH;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Samples of channels of the result.
pub(super) type OutputPlanes = BTreeMap<ChannelIndex, Vec<f32>>;

/// What is composited, and how.
pub(super) struct PlateCompositor<'a> {
    pub(super) table: &'a ChannelTable<'a>,
    pub(super) settings: &'a WarpSettings,
    /// `None` where a map alone is known.
    pub(super) moving_layers: Option<&'a [MovingLayer<'a>]>,
    pub(super) filling: Option<HoleFilling<'a>>,
    pub(super) context: &'a ResampleContext,
}

/// Channels of a composite that have one alpha, and so the same occlusion.
pub(super) struct AlphaGroup<'a> {
    pub(super) entries: Vec<&'a ChannelEntry>,
    pub(super) occlusion: Occlusion,
    /// #pixels of the composite; empty where no channel is copied.
    pub(super) visible: Vec<VisibleSample>,
}

impl PlateCompositor<'_> {
    /// The alpha of a composite's colour. One that is 0 everywhere says nothing where the picture moves as a whole.
    pub(super) fn alpha(&self, index: ChannelIndex, composite: &Composite) -> Option<Cow<'_, [f32]>> {
        let alpha = self.table.over(index, composite.source, 0.0);
        let has_mattes = !composite.matted_layers().is_empty();
        (has_mattes || alpha.iter().any(|alpha| *alpha > 0.0)).then_some(alpha)
    }

    /// Resamples with a filter.
    pub(super) fn by(&self, filter: Filter) -> Resampling<'_> {
        Resampling { context: self.context, filter }
    }

    /// What fills holes in a channel.
    pub(super) fn fill(&self, entry: &ChannelEntry, composite: &Composite, filter: Filter) -> Option<Vec<f32>> {
        let filling = self.filling.as_ref()?;
        Some(filling.seen(filling.find(entry)?.index, composite, self.by(filter)))
    }

    /// Copies the visible samples of channels, all together: what a pixel shows is the same in all of them.
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

    /// Puts what fills holes into a channel that is never blended. Vectors in unknown units are left out.
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
    /// Its channels with one of these semantics.
    pub(super) fn of(&self, semantics: &[Semantic]) -> Vec<&'a ChannelEntry> {
        self.entries.iter().copied().filter(|entry| semantics.contains(&entry.class.semantic)).collect()
    }
}
