//! Which share of every pixel of a plate a layer takes along.
//!
//! In: a [`Matte`], the channels of a plate, a view and a window. Out: shares from 0 to 1, or an error that names what
//! the plate lacks and what it has.

use super::contents::{Contents, Entry, Place};
use super::meaning::ChannelName;
use super::{Matte, Meaning, PlateError};
use crate::image::Storage;
use crate::image::cryptomatte::{Manifest, MatteId, MatteLayer};
use crate::space::PixelRect;
use crate::spelling;
use std::borrow::Cow;
use std::collections::BTreeSet;

/// Where a matte is wanted: pixels of one view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ground<'a> {
    pub(super) view: Option<&'a str>,
    /// Measured from the upper left corner of the display window.
    pub(super) window: PixelRect,
}

/// What a layer takes along.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Share {
    /// #pixels of the window, 0 to 1; `None`: everything.
    pub(super) pixels: Option<Vec<f32>>,
    /// Where a Cryptomatte picks it: the name of its layer, and the ids.
    pub(super) picked: Option<(String, BTreeSet<MatteId>)>,
    /// Names that the plate does not know beside others that it knows; in words.
    pub(super) warning: Option<String>,
}

/// What names pick from a Cryptomatte.
struct Picked {
    matte: MatteLayer<Place>,
    ids: BTreeSet<MatteId>,
    /// Names that it does not know, in words.
    unknown: Vec<String>,
}

impl Contents<'_> {
    /// The share of a layer of the shot, for messages called `layer`.
    pub(super) fn share(&self, layer: &str, matte: &Matte, ground: Ground) -> Result<Share, PlateError> {
        let of_channel = |name: &str, share: &dyn Fn(f32, Storage) -> f32| {
            let place = self.find(layer, name, ground.view)?;
            let storage = self.channel(place).storage;
            let samples = self.over(place, ground.window, 0.0);
            Ok(samples.iter().map(|&sample| share(sample, storage)).collect())
        };
        let pixels = match matte {
            Matte::Alpha => return Ok(Share::default()),
            Matte::Drawn(coverage) => self.of_picture(coverage.over(ground.window, self.plate.frame_size()), ground),
            Matte::Channel(name) => of_channel(name, &|sample, _| sample.clamp(0.0, 1.0).max(0.0))?,
            Matte::Id { channel, values } => {
                of_channel(channel, &|sample, storage| f32::from(u8::from(values.contains(&id_of(sample, storage)))))?
            }
            Matte::Cryptomatte { layer: wanted, names } => {
                return self.cryptomatte_share(layer, (wanted.as_deref(), names), ground);
            }
        };
        Ok(Share { pixels: Some(pixels), ..Share::default() })
    }

    /// Samples of a channel over another window; `outside` where it has none.
    pub(super) fn over(&self, place: Place, window: PixelRect, outside: f32) -> Cow<'_, [f32]> {
        let (own, samples) = (self.window(place), &self.channel(place).samples);
        if own == window { Cow::Borrowed(samples) } else { Cow::Owned(own.over(samples, window, outside)) }
    }

    /// A channel by the name that the shot gives: in this view, else in the first that has it.
    fn find(&self, layer: &str, name: &str, view: Option<&str>) -> Result<Place, PlateError> {
        let is_meant = |entry: &&Entry| entry.name.full == name || entry.name.with_all_of_part() == name;
        let named: Vec<&Entry> = self.entries.iter().filter(is_meant).collect();
        let Some(first) = named.first() else {
            let names = self.entries.iter().map(|entry| entry.name.full.as_str());
            let hint = spelling::hint(name, names);
            return Err(PlateError::NoMatteChannel { layer: layer.into(), channel: name.into(), hint });
        };
        // `mask.left.A` was meant for the view `left`; other views have their own.
        let is_twin = |other: &ChannelName| {
            other.view.as_deref() == view
                && other.segments == first.name.segments
                && other.component == first.name.component
        };
        let twin = self.entries.iter().find(|entry| is_twin(&entry.name));
        Ok(twin.unwrap_or(first).place)
    }

    /// Checks what names alone tell: that the plate has what a matte asks for. No samples are needed.
    pub(super) fn check_matte(&self, layer: &str, matte: &Matte) -> Result<(), PlateError> {
        let view = self.entries.first().and_then(|entry| entry.name.view.as_deref());
        match matte {
            Matte::Alpha | Matte::Drawn(_) => Ok(()),
            Matte::Channel(channel) | Matte::Id { channel, .. } => self.find(layer, channel, view).map(drop),
            Matte::Cryptomatte { layer: wanted, names } => {
                self.picked(layer, (wanted.as_deref(), names), view).map(drop)
            }
        }
    }

    /// The share of what a pixel shows, where its coverage is known: what covers 0.3 of a pixel whose alpha is 0.3 is all of it.
    fn of_picture(&self, mut coverage: Vec<f32>, ground: Ground) -> Vec<f32> {
        let of_view = self.entries.iter().filter(|entry| entry.name.view.as_deref() == ground.view);
        let mut colors = of_view.filter(|entry| entry.known.meaning == Meaning::Color);
        if let Some(alpha) = colors.find_map(|entry| entry.alpha) {
            let alpha = self.over(alpha, ground.window, 0.0);
            let pixels = coverage.iter_mut().zip(alpha.iter()).filter(|(_, alpha)| **alpha > 0.0);
            pixels.for_each(|(coverage, alpha)| *coverage = (*coverage / alpha).min(1.0));
        }
        coverage
    }

    fn cryptomatte_share(
        &self,
        layer: &str,
        wanted: (Option<&str>, &[String]),
        ground: Ground,
    ) -> Result<Share, PlateError> {
        let Picked { matte, ids, unknown } = self.picked(layer, wanted, ground.view)?;
        let missing = format!("layer \"{layer}\": not in {}: {}", matte.name, unknown.join("; "));
        Ok(Share {
            pixels: Some(self.of_picture(self.covered_by(&matte, &ids, ground.window), ground)),
            picked: Some((matte.name, ids)),
            warning: (!unknown.is_empty()).then_some(missing),
        })
    }

    /// The Cryptomatte that knows most of the names.
    fn picked(
        &self,
        layer: &str,
        (wanted, names): (Option<&str>, &[String]),
        view: Option<&str>,
    ) -> Result<Picked, PlateError> {
        let all = self.matte_layers_of_view(view);
        let known = |name: &str| self.mattes.iter().find(|matte| matte.name == name).map(|matte| &matte.manifest);
        let empty = Manifest::default();
        let candidates = all.iter().filter(|matte| wanted.is_none_or(|wanted| is_named(&matte.name, wanted)));
        let mut best: Option<Picked> = None;
        for matte in candidates {
            let selection = known(&matte.name).unwrap_or(&empty).select(names.iter().map(String::as_str));
            if best.as_ref().is_none_or(|best| selection.unknown.len() < best.unknown.len()) {
                best = Some(Picked { matte: matte.clone(), ids: selection.ids, unknown: selection.unknown });
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

    fn matte_layers_of_view(&self, view: Option<&str>) -> Vec<MatteLayer<Place>> {
        let of_view = |view: Option<&str>| {
            self.matte_layers(self.entries.iter().filter(|entry| entry.name.view.as_deref() == view))
        };
        let own = of_view(view);
        if !own.is_empty() {
            return own;
        }
        let first = self.entries.iter().find(|entry| entry.known.meaning == Meaning::Cryptomatte);
        first.map_or_else(Vec::new, |entry| of_view(entry.name.view.as_deref()))
    }

    /// Coverage of ids, all ranks together.
    fn covered_by(&self, matte: &MatteLayer<Place>, ids: &BTreeSet<MatteId>, window: PixelRect) -> Vec<f32> {
        let mut sum = vec![0.0; window.area()];
        for rank in &matte.ranks {
            let (found, coverage) = (self.over(rank.id, window, 0.0), self.over(rank.coverage, window, 0.0));
            for ((sum, &id), &coverage) in sum.iter_mut().zip(found.iter()).zip(coverage.iter()) {
                if coverage > 0.0 && ids.contains(&MatteId::from_sample(id)) {
                    *sum += coverage;
                }
            }
        }
        sum.iter_mut().for_each(|sum| *sum = sum.min(1.0));
        sum
    }
}

/// `CryptoObject` is also `ViewLayer.CryptoObject`.
fn is_named(name: &str, wanted: &str) -> bool {
    name == wanted || name.rsplit_once('.').is_some_and(|(_, last)| last == wanted)
}

/// Ids are bits of integers, or whole numbers as floats.
fn id_of(sample: f32, storage: Storage) -> u32 {
    if storage == Storage::Uint { sample.to_bits() } else { sample.round() as u32 }
}
