//! Mattes: the ids that cover each pixel, with their coverage, over all beauty passes.
//!
//! In: the visible surfaces of a pass in a tile. Out: the ranks of every Cryptomatte, as channels. A pixel keeps a list
//! of (ids, coverage), mostly one entry long: 24 bytes per covered pixel.

use super::bin::{TILE, Tiling};
use super::coverage::TILE_PIXELS;
use crate::image::cryptomatte::{IdCoverage, MatteId, USUAL_RANKS, rank_channel_names};
use crate::image::{Channel, Storage};
use crate::raster::{MATTE_LAYERS, RasterError};
use rayon::prelude::*;

/// End of a list.
const END: u32 = u32::MAX;

/// Values per pixel in the frame's channels: id and coverage of each rank of each Cryptomatte.
const PLANES: usize = MATTE_LAYERS.len() * 2 * USUAL_RANKS;

/// One id per Cryptomatte, for triangles drawn together.
pub(super) type Ids = [MatteId; MATTE_LAYERS.len()];

/// The ids that cover a tile's pixels.
#[derive(Debug, Default)]
pub(super) struct TileMattes {
    /// Index of each pixel's first entry.
    first: Vec<u32>,
    entries: Vec<Entry>,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    ids: Ids,
    coverage: f32,
    next: u32,
}

/// A blended surface in front of its pixel's opaque one; fragments are in drawing order, back to front.
#[derive(Clone, Copy, Debug)]
pub(super) struct TransparentFragment {
    pub(super) place: usize,
    pub(super) ids: Ids,
    pub(super) alpha: f32,
}

impl TileMattes {
    /// Clears the previous frame.
    pub(super) fn reset(&mut self) {
        self.first.clear();
        self.entries.clear();
    }

    /// Adds a pass with a weight: its transparent fragments, and the opaque surface of each pixel, if any. A fragment's
    /// transmittance weights the coverage of what lies behind it, so that coverage sums to the alpha of beauty.
    pub(super) fn add_pass(
        &mut self,
        weight: f32,
        fragments: &[TransparentFragment],
        opaque: impl Iterator<Item = (usize, Ids)>,
    ) {
        self.first.resize(TILE_PIXELS, END);
        // The remaining weight of the pass behind the fragments; empty if there are none.
        let mut rest = if fragments.is_empty() { Vec::new() } else { vec![weight; TILE_PIXELS] };
        for fragment in fragments.iter().rev() {
            let rest = &mut rest[fragment.place];
            self.add(fragment.place, fragment.ids, *rest * fragment.alpha);
            *rest *= 1.0 - fragment.alpha;
        }
        for (place, ids) in opaque {
            self.add(place, ids, rest.get(place).copied().unwrap_or(weight));
        }
    }

    fn add(&mut self, place: usize, ids: Ids, coverage: f32) {
        if coverage <= 0.0 {
            return;
        }
        let mut at = self.first[place];
        while let Some(entry) = self.entries.get_mut(at as usize) {
            if entry.ids == ids {
                entry.coverage += coverage;
                return;
            }
            at = entry.next;
        }
        self.entries.push(Entry { ids, coverage, next: self.first[place] });
        self.first[place] = self.entries.len() as u32 - 1;
    }

    /// Returns the entries of a pixel.
    fn of(&self, place: usize) -> impl Iterator<Item = &Entry> {
        let mut at = self.first.get(place).copied().unwrap_or(END);
        std::iter::from_fn(move || {
            let entry = self.entries.get(at as usize)?;
            at = entry.next;
            Some(entry)
        })
    }
}

/// Returns the channels of all Cryptomattes from the mattes of a window's tiles.
pub(super) fn gather_mattes(tiling: Tiling, tiles: &[&TileMattes]) -> Result<Vec<Channel>, RasterError> {
    let (width, height) = (tiling.size.x as usize, tiling.size.y as usize);
    let area = width * height;
    let is_room = Vec::<f32>::new().try_reserve_exact(area * PLANES).is_ok();
    if !is_room {
        return Err(RasterError::OutOfMemory { what: format!("{PLANES} matte channels of {area} pixels") });
    }
    let names = MATTE_LAYERS.iter().flat_map(|layer| rank_channel_names(layer, USUAL_RANKS));
    // The system provides zeroed pages lazily: ranks that no pixel needs take no memory.
    let channel = |name| Channel { name, storage: Storage::Float, samples: vec![0.0; area] };
    let mut channels: Vec<Channel> = names.map(channel).collect();
    let side = TILE as usize;
    let mut bands: Vec<Vec<&mut [f32]>> = (0..height.div_ceil(side)).map(|_| Vec::with_capacity(PLANES)).collect();
    for channel in &mut channels {
        let parts = channel.samples.chunks_mut(width * side);
        bands.iter_mut().zip(parts).for_each(|(band, part)| band.push(part));
    }
    bands.into_par_iter().zip(tiles.par_chunks(tiling.columns().max(1))).for_each_init(
        IdCoverage::default,
        |coverage, (mut band, tiles)| {
            for (column, tile) in tiles.iter().enumerate() {
                rank_tile(coverage, tile, (&mut band, width, column * side));
            }
        },
    );
    Ok(channels)
}

/// Ranks the pixels of a tile that starts at column `left` of a band of rows with this width.
fn rank_tile(coverage: &mut IdCoverage, mattes: &TileMattes, (band, width, left): (&mut [&mut [f32]], usize, usize)) {
    if mattes.entries.is_empty() {
        return;
    }
    let side = TILE as usize;
    let rows = band.first().map_or(0, |plane| plane.len() / width);
    for (y, x) in (0..rows).flat_map(|y| (0..side.min(width - left)).map(move |x| (y, x))) {
        for (layer, planes) in band.chunks_exact_mut(2 * USUAL_RANKS).enumerate() {
            coverage.clear();
            mattes.of(y * side + x).for_each(|entry| coverage.add(entry.ids[layer], entry.coverage));
            for (rank, &(id, covered)) in planes.chunks_exact_mut(2).zip(coverage.ranked()) {
                rank[0][y * width + left + x] = id.sample();
                // The sum of rounded weights may slightly exceed 1.
                rank[1][y * width + left + x] = covered.min(1.0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transparent_fragments_take_coverage_from_what_lies_behind_them() {
        let [wall, near, far] = ["wall", "near", "far"].map(|name| [MatteId::of_name(name); 3]);
        let mut mattes = TileMattes::default();
        let fragment = |ids, alpha| TransparentFragment { place: 5, ids, alpha };
        mattes.add_pass(0.5, &[fragment(far, 0.5), fragment(near, 0.25)], [(5, wall), (6, wall)].into_iter());
        mattes.add_pass(0.5, &[], [(5, near)].into_iter());
        let share =
            |place, ids| mattes.of(place).filter(|entry| entry.ids == ids).map(|entry| entry.coverage).sum::<f32>();
        assert_eq!([share(5, near), share(5, far), share(5, wall)], [0.625, 0.1875, 0.1875]);
        assert_eq!([share(6, wall), share(7, wall)], [0.5, 0.0]);
    }
}
