//! Evaluates mattes: the fraction of every pixel of a plate that a layer moves.
//!
//! In: a [`Matte`], the channels of a plate, a view and a window. Out: coverage from 0 to 1, or an error that names
//! what is missing and what is available.

use super::channel_table::{ChannelEntry, ChannelIndex, ChannelTable};
use super::semantics::ChannelName;
use super::{Matte, PlateError, Semantic};
use crate::image::Storage;
use crate::image::cryptomatte::{Manifest, MatteId, MatteLayer};
use crate::space::PixelRect;
use crate::spelling;
use std::borrow::Cow;
use std::collections::BTreeSet;

/// The pixels of one view at which a matte is evaluated.
#[derive(Clone, Copy, Debug)]
pub(super) struct MatteRegion<'a> {
    pub(super) view: Option<&'a str>,
    /// Relative to the upper left corner of the display window.
    pub(super) window: PixelRect,
}

/// The part of a plate that a layer moves.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct MatteCoverage {
    /// #pixels of the window, 0 to 1; `None`: everything.
    pub(super) coverage: Option<Vec<f32>>,
    /// The share of it that belongs to one part of a layer, #pixels of the window; `None`: all.
    pub(super) share: Option<Vec<f32>>,
    /// For mattes selected by Cryptomatte names: the name of the Cryptomatte, and the ids.
    pub(super) selection: Option<(String, BTreeSet<MatteId>)>,
    /// Message about names that the plate does not contain, if it contains others.
    pub(super) warning: Option<String>,
}

/// A selection of names from a Cryptomatte.
pub(super) struct Selection {
    pub(super) matte: MatteLayer<ChannelIndex>,
    pub(super) ids: BTreeSet<MatteId>,
    /// Names that are not in the manifest, for messages.
    pub(super) unknown: Vec<String>,
}

/// Computes the coverage of a layer's matte; the name in `layer` is for messages.
pub(super) fn matte_coverage(
    table: &ChannelTable,
    (layer, matte): (&str, &Matte),
    region: MatteRegion,
) -> Result<MatteCoverage, PlateError> {
    let of_channel = |name: &str, coverage: &dyn Fn(f32, Storage) -> f32| {
        let index = find(table, layer, name, region.view)?;
        let storage = table.channel(index).storage;
        let samples = table.over(index, region.window, 0.0);
        Ok(samples.iter().map(|&sample| coverage(sample, storage)).collect())
    };
    let coverage = match matte {
        Matte::Alpha => return Ok(MatteCoverage::default()),
        Matte::Drawn(drawn) => of_picture(table, drawn.over(region.window, table.plate.frame_size()), region),
        Matte::Channel(name) => of_channel(name, &|sample, _| sample.clamp(0.0, 1.0).max(0.0))?,
        Matte::Id { channel, values } => {
            of_channel(channel, &|sample, storage| f32::from(u8::from(values.contains(&id_of(sample, storage)))))?
        }
        Matte::Cryptomatte { layer: wanted, names } => {
            return cryptomatte_coverage(table, layer, (wanted.as_deref(), names), region);
        }
        Matte::Part { of, share } => {
            let whole = matte_coverage(table, (layer, of), region)?;
            let share = share.over(region.window, table.plate.frame_size());
            let coverage = match whole.coverage {
                Some(coverage) => coverage.iter().zip(&share).map(|(coverage, share)| coverage * share).collect(),
                None => share.clone(),
            };
            return Ok(MatteCoverage { coverage: Some(coverage), share: Some(share), ..whole });
        }
    };
    Ok(MatteCoverage { coverage: Some(coverage), ..MatteCoverage::default() })
}

/// Finds a channel by the name given in the shot: in this view, or else in the first view that has it.
pub(super) fn find(
    table: &ChannelTable,
    layer: &str,
    name: &str,
    view: Option<&str>,
) -> Result<ChannelIndex, PlateError> {
    let is_meant = |entry: &&ChannelEntry| entry.name.full == name || entry.name.with_all_of_part() == name;
    let named: Vec<&ChannelEntry> = table.entries.iter().filter(is_meant).collect();
    let Some(first) = named.first() else {
        let names = table.entries.iter().map(|entry| entry.name.full.as_str());
        let hint = spelling::hint(name, names);
        return Err(PlateError::NoMatteChannel { layer: layer.into(), channel: name.into(), hint });
    };
    // `mask.left.A` names the view `left`; other views use their own counterpart.
    let is_twin = |other: &ChannelName| {
        other.view.as_deref() == view
            && other.segments == first.name.segments
            && other.component == first.name.component
    };
    let twin = table.entries.iter().find(|entry| is_twin(&entry.name));
    Ok(twin.unwrap_or(first).index)
}

/// Checks from the channel names alone that the plate has what a matte refers to; needs no samples.
pub(super) fn check_matte(table: &ChannelTable, layer: &str, matte: &Matte) -> Result<(), PlateError> {
    let view = table.entries.first().and_then(|entry| entry.name.view.as_deref());
    match matte {
        Matte::Alpha | Matte::Drawn(_) => Ok(()),
        Matte::Part { of, .. } => check_matte(table, layer, of),
        Matte::Channel(channel) | Matte::Id { channel, .. } => find(table, layer, channel, view).map(drop),
        Matte::Cryptomatte { layer: wanted, names } => select(table, layer, (wanted.as_deref(), names), view).map(drop),
    }
}

/// Returns the alpha of the picture, #pixels of the window; `None` if it has none.
pub(super) fn alpha_of_picture<'a>(table: &'a ChannelTable, region: MatteRegion) -> Option<Cow<'a, [f32]>> {
    let of_view = || table.entries.iter().filter(|entry| entry.name.view.as_deref() == region.view);
    let of_color = of_view().filter(|entry| entry.class.semantic == Semantic::Color).find_map(|entry| entry.alpha);
    let index = of_color.or_else(|| of_view().find_map(|entry| entry.alpha))?;
    Some(table.over(index, region.window, 0.0))
}

/// Divides by the alpha of the picture where it is known: coverage 0.3 of a pixel whose alpha is 0.3 is all of the pixel.
fn of_picture(table: &ChannelTable, mut coverage: Vec<f32>, region: MatteRegion) -> Vec<f32> {
    if let Some(alpha) = alpha_of_picture(table, region) {
        let pixels = coverage.iter_mut().zip(alpha.iter()).filter(|(_, alpha)| **alpha > 0.0);
        pixels.for_each(|(coverage, alpha)| *coverage = (*coverage / alpha).min(1.0));
    }
    coverage
}

fn cryptomatte_coverage(
    table: &ChannelTable,
    layer: &str,
    wanted: (Option<&str>, &[String]),
    region: MatteRegion,
) -> Result<MatteCoverage, PlateError> {
    let Selection { matte, ids, unknown } = select(table, layer, wanted, region.view)?;
    let missing = format!("layer \"{layer}\": not in {}: {}", matte.name, unknown.join("; "));
    Ok(MatteCoverage {
        coverage: Some(of_picture(
            table,
            summed_coverage(table, &matte, |id| ids.contains(&id), region.window),
            region,
        )),
        share: None,
        selection: Some((matte.name, ids)),
        warning: (!unknown.is_empty()).then_some(missing),
    })
}

/// Selects the Cryptomatte that contains most of the names.
pub(super) fn select(
    table: &ChannelTable,
    layer: &str,
    (wanted, names): (Option<&str>, &[String]),
    view: Option<&str>,
) -> Result<Selection, PlateError> {
    let all = matte_layers_of_view(table, view);
    let known = |name: &str| table.mattes.iter().find(|matte| matte.name == name).map(|matte| &matte.manifest);
    let empty = Manifest::default();
    let candidates = all.iter().filter(|matte| wanted.is_none_or(|wanted| is_named(&matte.name, wanted)));
    let mut best: Option<Selection> = None;
    for matte in candidates {
        let selection = known(&matte.name).unwrap_or(&empty).select(names.iter().map(String::as_str));
        if best.as_ref().is_none_or(|best| selection.unknown.len() < best.unknown.len()) {
            best = Some(Selection { matte: matte.clone(), ids: selection.ids, unknown: selection.unknown });
        }
    }
    let refused = |wanted: String, hint: String| PlateError::NoCryptomatte { layer: layer.into(), wanted, hint };
    let best = best.ok_or_else(|| {
        let hint = match all.as_slice() {
            [] => "it has no Cryptomatte".to_owned(),
            all => format!("of Cryptomattes {}", spelling::list(all.iter().map(|matte| matte.name.as_str()))),
        };
        refused(wanted.map_or_else(|| names.join(", "), |wanted| format!("\"{wanted}\"")), hint)
    })?;
    if best.ids.is_empty() {
        let missing = format!("in {}: {}", best.matte.name, best.unknown.join("; "));
        return Err(refused(names.join(", "), missing));
    }
    Ok(best)
}

pub(super) fn matte_layers_of_view(table: &ChannelTable, view: Option<&str>) -> Vec<MatteLayer<ChannelIndex>> {
    let of_view = |view: Option<&str>| {
        table.matte_layers(table.entries.iter().filter(|entry| entry.name.view.as_deref() == view))
    };
    let own = of_view(view);
    if !own.is_empty() {
        return own;
    }
    let first = table.entries.iter().find(|entry| entry.class.semantic == Semantic::Cryptomatte);
    first.map_or_else(Vec::new, |entry| of_view(entry.name.view.as_deref()))
}

/// Sums the coverage of some ids over all ranks.
pub(super) fn summed_coverage(
    table: &ChannelTable,
    matte: &MatteLayer<ChannelIndex>,
    is_in: impl Fn(MatteId) -> bool,
    window: PixelRect,
) -> Vec<f32> {
    let mut sum = vec![0.0; window.area()];
    for rank in &matte.ranks {
        let (found, coverage) = (table.over(rank.id, window, 0.0), table.over(rank.coverage, window, 0.0));
        for ((sum, &id), &coverage) in sum.iter_mut().zip(found.iter()).zip(coverage.iter()) {
            if coverage > 0.0 && is_in(MatteId::from_sample(id)) {
                *sum += coverage;
            }
        }
    }
    sum.iter_mut().for_each(|sum| *sum = sum.min(1.0));
    sum
}

/// Whether a layer has the wanted name, with or without its prefix: `CryptoObject` also matches `ViewLayer.CryptoObject`.
pub(super) fn is_named(name: &str, wanted: &str) -> bool {
    name == wanted || name.rsplit_once('.').is_some_and(|(_, last)| last == wanted)
}

/// Decodes an id, stored as the bits of an integer or as a whole number in a float.
pub(super) fn id_of(sample: f32, storage: Storage) -> u32 {
    if storage == Storage::Uint { sample.to_bits() } else { sample.round() as u32 }
}
