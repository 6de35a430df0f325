//! Fills the holes that moved layers leave, from the channels of a clean plate.
//!
//! In: the clean plate, a composite, a channel name. Out: samples over the composite's window.

use super::channel_table::{ChannelEntry, ChannelIndex, ChannelTable};
use super::composite::Composite;
use super::disjoint_over::BATCH;
use super::resampler::Resampling;
use super::{Planes, PlateError};
use crate::image::cryptomatte::Manifest;
use crate::image::{Plate, Storage};
use crate::space::PixelRect;
use rayon::prelude::*;

/// Largest range of integers that a float represents exactly: 2^24.
const MAX_EXACT: u32 = 1 << 24;
/// The same for half floats.
const MAX_EXACT_HALF: u32 = 1 << 11;

/// A plate that fills holes.
pub(super) struct HoleFilling<'a> {
    table: ChannelTable<'a>,
}

/// Checks from the headers that a clean plate belongs to frames of the same size as a plate.
///
/// # Errors
/// [`PlateError::WrongFill`].
pub(crate) fn check_fill(fill: &Plate, plate: &Plate) -> Result<(), PlateError> {
    let [fill, plate] = [fill, plate].map(|picture| [picture.display.width, picture.display.height]);
    if fill == plate { Ok(()) } else { Err(PlateError::WrongFill { fill, plate }) }
}

impl<'a> HoleFilling<'a> {
    pub(super) fn of(fill: &'a Plate, plate: &Plate) -> Result<Self, PlateError> {
        check_fill(fill, plate)?;
        Ok(Self { table: ChannelTable::of(fill, &[]) })
    }

    /// Returns the channel of the same name, in the part of that name or else in the same view. Otherwise falls back to
    /// the beauty, depth and Cryptomattes of other programs, whatever their names.
    pub(super) fn find(&self, entry: &ChannelEntry) -> Option<&ChannelEntry> {
        let same = || self.table.entries.iter().filter(|other| other.name.full == entry.name.full);
        let in_part = same().find(|other| other.name.part == entry.name.part);
        let in_view = || same().find(|other| other.name.view == entry.name.view);
        let in_role = || self.table.entries.iter().find(|other| entry.has_role_of(other));
        in_part.or_else(in_view).or_else(in_role)
    }

    /// Returns the fill plate.
    pub(super) fn plate(&self) -> &Plate {
        self.table.plate
    }

    /// Whether a channel uses the same encoding as the plate's channel of the same name. Clean plates are assumed to
    /// come from the same renderer as the plate.
    pub(super) fn is_stored_alike(&self, behind: &ChannelEntry, entry: &ChannelEntry) -> bool {
        behind.name.full == entry.name.full && !self.table.plate.is_own_render()
    }

    /// Returns the samples of a channel and their window.
    pub(super) fn samples(&self, place: ChannelIndex) -> (&[f32], PixelRect) {
        (&self.table.channel(place).samples, self.table.window(place))
    }

    /// Adds the names in the fill plate's Cryptomatte manifests to those of the plate.
    pub(super) fn add_names(&self, plate: &mut Plate) {
        for part in &mut plate.parts {
            let texts = part.texts("cryptomatte/").into_iter();
            let mattes = texts.filter_map(|(key, name)| Some((key.strip_suffix("name")?.to_owned(), name)));
            for (key, name) in mattes.collect::<Vec<_>>() {
                let key = format!("{key}manifest");
                let behind = self.table.mattes.iter().find(|matte| is_same_matte(&matte.name, &name));
                let Some((own, behind)) = part.text(&key).zip(behind) else { continue };
                let own = Manifest::from_json(&own);
                let all = own.joined(&behind.manifest);
                if all != own {
                    part.set_text(&key, &all.to_json());
                }
            }
        }
    }

    /// Returns the nearest sample of a channel at a pixel of a composite (relative to its window), converted to another
    /// storage type; `None` outside its data window.
    pub(super) fn nearest(
        &self,
        place: ChannelIndex,
        (composite, at): (&Composite, usize),
        storage: Storage,
    ) -> Option<f32> {
        let channel = self.table.channel(place);
        let index = self.table.window(place).sample_index(composite.background_source(at)?)?;
        Some(restored(channel.samples[index], channel.storage, storage))
    }

    /// Resamples a channel as the back of a composite; 0 where it has no samples.
    pub(super) fn seen(&self, place: ChannelIndex, composite: &Composite, by: Resampling) -> Vec<f32> {
        let (samples, window) = self.samples(place);
        seen(&Planes { window, planes: vec![samples] }, composite, by)
    }
}

/// Resamples one plane as the back of a composite; 0 where it has no samples.
pub(super) fn seen(plane: &Planes, composite: &Composite, by: Resampling) -> Vec<f32> {
    match &composite.background().map {
        Some(map) => by.seen(map, plane).swap_remove(0),
        None => plane.window.resized_samples(plane.planes[0], composite.window, 0.0),
    }
}

/// Converts a number between storage types; unsigned integers are stored as bits. Ids that a float cannot represent
/// exactly become 0 (no object).
fn restored(sample: f32, from: Storage, to: Storage) -> f32 {
    match (from, to) {
        (Storage::Uint, Storage::Uint) => sample,
        (Storage::Uint, Storage::Half) if sample.to_bits() > MAX_EXACT_HALF => 0.0,
        (Storage::Uint, _) if sample.to_bits() > MAX_EXACT => 0.0,
        (Storage::Uint, _) => sample.to_bits() as f32,
        (_, Storage::Uint) => f32::from_bits(sample.round() as u32),
        _ => sample,
    }
}

/// Whether two names denote the same Cryptomatte: `ViewLayer.CryptoObject` and `CryptoObject` do.
fn is_same_matte(one: &str, other: &str) -> bool {
    let word = |name: &str| name.rsplit('.').next().map(str::to_lowercase);
    word(one) == word(other)
}

/// Adds the fill samples, weighted by the holes.
pub(super) fn add_behind(plane: &mut [f32], holes: &[f32], filling: &[f32]) {
    let samples = plane.par_iter_mut().zip(holes).zip(filling).with_min_len(BATCH);
    samples.for_each(|((sample, &hole), &filling)| {
        if hole > 0.0 {
            *sample += hole * filling;
        }
    });
}
