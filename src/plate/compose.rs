//! Composes a warped plate, treating every channel of every composite according to its semantic.
//!
//! In: a [`PlateCompositor`] and composites with their layers and maps. Out: the warped plate, and the rest of the report.

use super::channel_table::{ChannelEntry, ChannelIndex};
use super::composite::{Composite, MIN_VISIBLE};
use super::compositor::{AlphaGroup, OutputPlanes, PlateCompositor};
use super::cryptomatte::{CryptomatteRanks, RankAlpha, gathered_ranks};
use super::disjoint_over::{Occlusion, colors, occlusion};
use super::edge_split::{EdgeSplit, SplitSamples};
use super::hole_filling::add_behind;
use super::moving_layer::MovingLayer;
use super::pixel_field::PixelField;
use super::vectors::compose_vectors;
use super::visible_samples::visible_samples;
use super::{Filter, Planes, PlateReport, Semantic};
use crate::image::{Channel, Plate};
use crate::space::FrameWindow;
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

/// Composes the plate and completes the report.
pub(super) fn compose(compositor: &PlateCompositor, composites: &[Composite], report: &mut PlateReport) -> Plate {
    compositor.table.report(report);
    report.warnings.extend(composites.iter().find_map(|composite| composite.overlap.clone()));
    let mut planes = OutputPlanes::new();
    for composite in composites {
        report.warnings.extend(composite.layers.iter().filter_map(|layer| layer.matte.warning.clone()));
        if report.folded_pixels == 0 {
            report_folds(compositor, composite, report);
        }
        compose_channels(compositor, composite, &mut planes, report);
    }
    let mut seen = BTreeSet::new();
    report.warnings.retain(|warning| seen.insert(warning.clone()));
    assemble(compositor, composites, planes)
}

fn compose_channels(
    compositor: &PlateCompositor,
    composite: &Composite,
    planes: &mut OutputPlanes,
    report: &mut PlateReport,
) {
    let mut by_alpha: BTreeMap<Option<ChannelIndex>, Vec<&ChannelEntry>> = BTreeMap::new();
    for entry in &composite.entries {
        // With a single layer there is no occlusion, so the alpha is not needed.
        let alpha = entry.alpha.filter(|_| composite.layers.len() > 1);
        by_alpha.entry(alpha).or_default().push(entry);
    }
    for (index, entries) in by_alpha {
        let alpha = index.and_then(|index| compositor.alpha(index, composite));
        let is_copied = |entry: &&ChannelEntry| !matches!(entry.class.semantic, Semantic::Color | Semantic::Alpha);
        let has_copied = entries.iter().any(is_copied);
        let visible = if has_copied { visible_samples(composite, alpha.as_deref()) } else { Vec::new() };
        let occlusion = occlusion(composite, alpha.as_deref(), compositor.by(compositor.settings.filter));
        let known_alpha = index.zip(alpha.as_deref());
        let split = EdgeSplit::of(compositor, composite, known_alpha);
        let group = AlphaGroup { entries, occlusion, visible };
        report_holes(compositor, &group, report);
        compose_colors(compositor, ColorInputs { composite, group: &group, split }, planes, report);
        let data = group.of(&[Semantic::Depth, Semantic::Id, Semantic::Data, Semantic::Normal]);
        compositor.copy(&data, (composite, &group), planes);
        compose_cryptomattes(compositor, (composite, &group), planes);
        compose_vectors(compositor, composite, &group, planes, report);
    }
}

/// Counts the pixels of visible folds and reports the layers that fold.
fn report_folds(compositor: &PlateCompositor, composite: &Composite, report: &mut PlateReport) {
    let alpha = composite.entries.iter().find_map(|entry| entry.alpha);
    let alpha = alpha.and_then(|index| compositor.alpha(index, composite));
    let Some(moving_layers) = compositor.moving_layers else { return };
    let mut all = BTreeSet::new();
    // The parts of one layer are reported as one.
    let is_same = |(_, one): &(usize, &MovingLayer), (_, other): &(usize, &MovingLayer)| one.name == other.name;
    let numbered: Vec<(usize, &MovingLayer)> = moving_layers.iter().enumerate().collect();
    for same in numbered.chunk_by(is_same) {
        let frame = compositor.table.plate.frame_size();
        let of_part = |&(index, layer): &(usize, &MovingLayer)| {
            let field = PixelField { field: &layer.now, frame, direction: layer.direction };
            composite.folded_pixels((index, layer.matte.is_some()), field, alpha.as_deref())
        };
        let folded: BTreeSet<usize> = same.iter().flat_map(of_part).collect();
        let moving_layer = same[0].1;
        if !folded.is_empty() {
            report
                .warnings
                .push(moving_layer.fold_warning(folded.len(), FrameWindow { frame, window: composite.window }));
        }
        all.extend(folded);
    }
    report.folded_pixels = all.len();
}

/// Counts the holes of the first view that has any, and reports the channels that nothing fills.
fn report_holes(compositor: &PlateCompositor, group: &AlphaGroup, report: &mut PlateReport) {
    let holes = group.occlusion.holes.iter().flatten().filter(|hole| **hole > MIN_VISIBLE).count();
    if report.uncovered_pixels == 0 {
        report.uncovered_pixels = holes;
    }
    let filling = compositor.filling.as_ref().filter(|_| holes > 0);
    let Some(filling) = filling else { return };
    let missing = group.entries.iter().filter(|entry| filling.find(entry).is_none());
    let names: Vec<&str> = missing.map(|entry| entry.name.full.as_str()).collect();
    if !names.is_empty() {
        report.warnings.push(format!("the fill plate has no {}: holes in these channels stay empty", names.join(", ")));
    }
    let is_ours = filling.plate().is_own_render() && !compositor.table.plate.is_own_render();
    if is_ours && group.of(&[Semantic::Normal]).into_iter().any(|entry| filling.find(entry).is_some()) {
        report.warnings.push("normals that fill the holes are in scene space (y up), as stored in the scene".into());
    }
}

/// What colour is composed from.
struct ColorInputs<'a> {
    composite: &'a Composite<'a>,
    group: &'a AlphaGroup<'a>,
    /// The light of the layers in pixels that they share, if it is known.
    split: Option<EdgeSplit<'a>>,
}

fn compose_colors(
    compositor: &PlateCompositor,
    ColorInputs { composite, group, split }: ColorInputs,
    planes: &mut OutputPlanes,
    report: &mut PlateReport,
) {
    let filter = compositor.settings.filter;
    let entries = group.of(&[Semantic::Color, Semantic::Alpha]);
    if composite.layers.iter().any(|layer| layer.map.is_some()) {
        let samples = |entry: &&ChannelEntry| &compositor.table.channel(entry.index).samples[..];
        let bad = Planes { window: composite.source, planes: entries.iter().map(samples).collect() };
        let bad = bad.not_finite();
        report.contained_samples += bad.nan + bad.infinite;
    }
    let mut whole = Vec::new();
    let mut parted = Vec::new();
    for entry in entries {
        let samples = split.as_ref().and_then(|split| split.samples(compositor, entry));
        match samples {
            Some(SplitSamples { plate, behind }) => {
                let behind = compositor.fill_by(entry, (composite, &behind), filter);
                parted.push(ColorPlane { entry, samples: Cow::Owned(plate), behind });
            }
            None => {
                let samples = Cow::Borrowed(&compositor.table.channel(entry.index).samples[..]);
                whole.push(ColorPlane { entry, samples, behind: compositor.fill(entry, composite, filter) });
            }
        }
    }
    compose_planes(compositor, (composite, &group.occlusion), whole, planes);
    if let Some(split) = split {
        compose_planes(compositor, (&split.shares, &split.occlusion), parted, planes);
    }
}

/// A channel of colour or alpha.
struct ColorPlane<'a> {
    entry: &'a ChannelEntry,
    /// #pixels of the source.
    samples: Cow<'a, [f32]>,
    /// #pixels of the composite: what fills holes.
    behind: Option<Vec<f32>>,
}

/// Composites channels of colour and fills their holes.
fn compose_planes(
    compositor: &PlateCompositor,
    (composite, occlusion): (&Composite, &Occlusion),
    sources: Vec<ColorPlane>,
    planes: &mut OutputPlanes,
) {
    let filter = compositor.settings.filter;
    let alpha = sources.iter().position(|source| source.entry.class.semantic == Semantic::Alpha);
    let is_bounded = filter == Filter::Ewa && occlusion.has_parts();
    let most = alpha.filter(|_| is_bounded).map(|alpha| {
        let entry = sources[alpha].entry;
        (alpha, compositor.table.channel(entry.index).samples.iter().copied().fold(1.0, f32::max))
    });
    let (samples, rest): (Vec<_>, Vec<_>) =
        sources.into_iter().map(|source| (source.samples, (source.entry, source.behind))).unzip();
    let mut colors = colors(composite, &samples, occlusion, compositor.by(filter));
    if let Some((alpha, most)) = most {
        bound_alpha(&mut colors, alpha, most);
    }
    for ((entry, behind), mut color) in rest.into_iter().zip(colors) {
        if let Some((holes, behind)) = occlusion.holes.as_ref().zip(behind) {
            add_behind(&mut color, holes, &behind);
        }
        planes.insert(entry.index, color);
    }
}

/// Scales the pixels whose alpha exceeds `most`, the greatest of the source: parts of a layer that are pushed together cover soft pixels more than
/// once.
fn bound_alpha(colors: &mut [Vec<f32>], alpha: usize, most: f32) {
    let scale = |alpha: &f32| if *alpha > most { most / alpha } else { 1.0 };
    let scales: Vec<f32> = colors[alpha].par_iter().map(scale).collect();
    for color in colors {
        color
            .par_iter_mut()
            .zip(&scales)
            .filter(|(_, scale)| **scale < 1.0)
            .for_each(|(sample, scale)| *sample *= scale);
    }
}

fn compose_cryptomattes(
    compositor: &PlateCompositor,
    (composite, group): (&Composite, &AlphaGroup),
    planes: &mut OutputPlanes,
) {
    let entries = group.of(&[Semantic::Cryptomatte]);
    let Some(first) = entries.first() else { return };
    let alpha = rank_alpha(compositor, (composite, group), first.alpha, planes);
    let mut composed = OutputPlanes::new();
    for matte in compositor.table.matte_layers(entries.iter().copied()) {
        let samples = |index: ChannelIndex| &compositor.table.channel(index).samples[..];
        let entry = |index: ChannelIndex| entries.iter().find(|entry| entry.index == index);
        let filling = |index: ChannelIndex| compositor.fill(entry(index)?, composite, Filter::Nearest);
        let fillings = matte.ranks.iter().map(|rank| Some([filling(rank.id)?, filling(rank.coverage)?]));
        let has_holes = group.occlusion.holes.is_some();
        let ranks = CryptomatteRanks {
            name: &matte.name,
            ranks: matte.ranks.iter().map(|rank| [samples(rank.id), samples(rank.coverage)]).collect(),
            filling: if has_holes { fillings.flatten().collect() } else { Vec::new() },
            alpha: &alpha,
        };
        let gathered = gathered_ranks(composite, &ranks, &group.occlusion, compositor.context);
        for (rank, [ids, coverage]) in matte.ranks.iter().zip(gathered) {
            composed.insert(rank.id, ids);
            composed.insert(rank.coverage, coverage);
        }
    }
    planes.append(&mut composed);
    // Half a pair of rank channels cannot be decoded: treat it as data.
    let alone: Vec<&ChannelEntry> = entries.into_iter().filter(|entry| !planes.contains_key(&entry.index)).collect();
    compositor.copy(&alone, (composite, group), planes);
}

/// Returns the alpha that belongs to the Cryptomattes of a group; `index`: its channel.
fn rank_alpha<'a>(
    compositor: &'a PlateCompositor,
    (composite, group): (&Composite, &AlphaGroup),
    index: Option<ChannelIndex>,
    planes: &'a OutputPlanes,
) -> RankAlpha<'a> {
    let entry = composite.entries.iter().find(|entry| Some(entry.index) == index);
    let filling = entry.and_then(|entry| compositor.fill(entry, composite, Filter::Nearest));
    let source = index.and_then(|index| compositor.alpha(index, composite));
    let known = index.filter(|_| source.is_some()).and_then(|index| planes.get(&index));
    if let Some(composed) = known.filter(|plane| plane.len() == composite.window.area()) {
        return RankAlpha { source, filling, composed: Cow::Borrowed(composed) };
    }
    // A picture without alpha, or with its alpha in a part of another window.
    let plane = source.clone().unwrap_or_else(|| Cow::Owned(vec![1.0; composite.source.area()]));
    let by = compositor.by(compositor.settings.filter);
    let mut composed = colors(composite, &[plane], &group.occlusion, by).swap_remove(0);
    if let (Some(holes), Some(_)) = (&group.occlusion.holes, &compositor.filling) {
        let opaque = || Cow::Owned(vec![1.0; composite.window.area()]);
        add_behind(&mut composed, holes, &filling.as_deref().map_or_else(opaque, Cow::Borrowed));
    }
    RankAlpha { source, filling, composed: Cow::Owned(composed) }
}

/// Assembles the output planes into parts, in the plate's order.
fn assemble(compositor: &PlateCompositor, composites: &[Composite], mut planes: OutputPlanes) -> Plate {
    let plate = compositor.table.plate;
    let parts = plate.parts.iter().enumerate().map(|(part, stored)| {
        let source = plate.window_of(stored);
        let composite = composites.iter().find(|composite| composite.source == source);
        let window = composite.map_or(stored.data_window, |composite| composite.window.placed_in(plate.display));
        let channels = stored.channels.iter().enumerate().map(|(channel, stored)| Channel {
            name: stored.name.clone(),
            storage: stored.storage,
            samples: planes.remove(&ChannelIndex { part, channel }).expect("every semantic is composed"),
        });
        stored.with_channels(window, channels.collect())
    });
    plate.with_parts(parts.collect())
}
