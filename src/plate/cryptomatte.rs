//! Ranks of a Cryptomatte after a warp: coverage is gathered an id at a time, ids are never mixed.
//!
//! In: a canvas with maps, ranks of the source, factors for what lies below each sheet. Out: ranks.
//!
//! What is seen of an id is the sum, over the samples below the pixel's footprint, of weight · share · coverage,
//! sheet over sheet as colour (Friedman and Jones, "Fully automatic ID mattes", SIGGRAPH 2015 posters).

use super::alike::Alike;
use super::canvas::{Canvas, Sheet};
use super::filter::{BAND, bands, footprint_bounds, footprint_taps};
use super::over::Overlay;
use super::resampler::Tools;
use crate::image::cryptomatte::{Coverage, MatteId};
use rayon::prelude::*;

/// One rank of the source: ids and coverage, #pixels each.
pub(super) type Rank<'a> = [&'a [f32]; 2];

/// What of a Cryptomatte's ranks each pixel holds.
pub(super) struct Ranks<'a> {
    /// Its name, to know the picks of mattes that come from it.
    pub(super) name: &'a str,
    pub(super) ranks: Vec<Rank<'a>>,
    /// Ranks of what fills holes, over the canvas's window; empty where nothing does.
    pub(super) filling: Vec<[Vec<f32>; 2]>,
}

/// What the pixels of a canvas are gathered from.
struct Seen<'a> {
    matte: &'a Ranks<'a>,
    overlay: &'a Overlay,
    alike: &'a Alike,
}

/// Memory that a thread uses again for every pixel.
#[derive(Default)]
struct Scratch {
    taps: Vec<(usize, f32)>,
    coverage: Coverage,
    ranks: Vec<f32>,
}

impl Canvas<'_> {
    /// Ranks after the warp: for each id and coverage, #pixels of the canvas.
    pub(super) fn matted(&self, matte: &Ranks, overlay: &Overlay, tools: &Tools) -> Vec<[Vec<f32>; 2]> {
        let width = self.window.width as usize;
        let mut planes: Vec<_> = (0..2 * matte.ranks.len()).map(|_| tools.plane(self.window.area())).collect();
        let alike = self.alike(matte);
        let work = |scratch: &mut Scratch, (band, planes): (usize, &mut Vec<&mut [f32]>)| {
            for place in 0..planes[0].len() {
                let (x, y) = (place % width, band * BAND + place / width);
                self.gather(
                    &Seen { matte, overlay, alike: &alike },
                    [self.window.x + x as i32, self.window.y + y as i32],
                    scratch,
                );
                planes.iter_mut().zip(&scratch.ranks).for_each(|(plane, rank)| plane[place] = *rank);
            }
        };
        bands(&mut planes, BAND * width).par_iter_mut().enumerate().for_each_init(Scratch::default, work);
        let mut planes = planes.into_iter();
        std::iter::from_fn(|| planes.next().zip(planes.next()).map(<[Vec<f32>; 2]>::from)).collect()
    }

    /// Where ranks and the shares of all sheets are the same in neighbouring samples.
    fn alike(&self, matte: &Ranks) -> Alike {
        let shares = self.sheets.iter().filter_map(|sheet| sheet.share.pixels.as_deref());
        Alike::of(self.source, &matte.ranks.as_flattened().iter().copied().chain(shares).collect::<Vec<_>>())
    }

    /// Leaves the ranks of one pixel in `scratch`.
    fn gather(&self, seen: &Seen, at: [i32; 2], scratch: &mut Scratch) {
        let Seen { matte, overlay, .. } = *seen;
        scratch.ranks.clear();
        scratch.ranks.resize(2 * matte.ranks.len(), 0.0);
        scratch.coverage.clear();
        let mut visible = 1.0;
        for (sheet, below) in self.sheets.iter().zip(&overlay.below).rev() {
            let Some(place) = sheet.window.place_of(at) else { continue };
            self.find_taps(seen.alike, sheet, (place, at), &mut scratch.taps);
            if let [(index, 1.0)] = scratch.taps[..]
                && self.sheets.len() == 1
            {
                matte.copy(index, &mut scratch.ranks);
                return;
            }
            for &(index, weight) in &scratch.taps {
                matte.add(self, sheet, (index, weight * visible), &mut scratch.coverage);
            }
            visible *= below.get(place).copied().unwrap_or(0.0);
            if visible <= 0.0 {
                break;
            }
        }
        if let Some(holes) = &overlay.holes {
            let place = self.window.place_of(at).expect("pixels of the canvas lie in its window");
            matte.fill(place, holes[place], &mut scratch.coverage);
        }
        scratch.coverage.write(&mut scratch.ranks);
        limit(&mut scratch.ranks);
    }

    /// Samples below a pixel of a sheet. Where all hold the same, one of them stands for all: shares of 1 that sum to
    /// 0.9999999 would leave noise in every matte.
    fn find_taps(&self, alike: &Alike, sheet: &Sheet, (place, at): (usize, [i32; 2]), taps: &mut Vec<(usize, f32)>) {
        match &sheet.map {
            Some(map) => {
                let one = footprint_bounds(map, place, self.source).and_then(|ends| alike.one_of(ends));
                match one {
                    Some(sample) => {
                        taps.clear();
                        taps.push((sample, 1.0));
                    }
                    None => footprint_taps(map, place, self.source, taps),
                }
            }
            None => {
                taps.clear();
                taps.extend(self.source.place_of(at).map(|index| (index, 1.0)));
            }
        }
    }
}

impl Ranks<'_> {
    fn copy(&self, index: usize, ranks: &mut [f32]) {
        for (rank, source) in ranks.chunks_exact_mut(2).zip(&self.ranks) {
            rank.copy_from_slice(&source.map(|channel| channel[index]));
        }
    }

    /// Adds the ranks of a sample, as far as they belong to a sheet.
    fn add(&self, canvas: &Canvas, sheet: &Sheet, (index, weight): (usize, f32), coverage: &mut Coverage) {
        let share = sheet.share.pixels.as_ref().map_or(1.0, |share| share[index]);
        for [ids, shares] in &self.ranks {
            let id = MatteId::from_sample(ids[index]);
            let part = self.part_by_id(canvas, sheet, id).unwrap_or(share);
            coverage.add(id, shares[index] * weight * part);
        }
    }

    /// Where mattes are picked from this very Cryptomatte it is known which ids go and which stay.
    fn part_by_id(&self, canvas: &Canvas, sheet: &Sheet, id: MatteId) -> Option<f32> {
        let holds = |sheet: &Sheet| {
            let (name, ids) = sheet.share.picked.as_ref()?;
            (name == self.name).then(|| ids.contains(&id))
        };
        if sheet.mover > 0 {
            return holds(sheet).map(|holds| f32::from(u8::from(holds)));
        }
        let layers = canvas.matted_sheets();
        let taken: Option<Vec<bool>> = layers.iter().map(holds).collect();
        taken.filter(|taken| !taken.is_empty()).map(|taken| f32::from(u8::from(!taken.contains(&true))))
    }

    fn fill(&self, place: usize, share: f32, coverage: &mut Coverage) {
        if share <= 0.0 {
            return;
        }
        for [ids, shares] in &self.filling {
            coverage.add(MatteId::from_sample(ids[place]), shares[place] * share);
        }
    }
}

/// Keeps the sum of coverage at 1 or below: weights are rounded.
fn limit(ranks: &mut [f32]) {
    let sum: f32 = ranks.iter().skip(1).step_by(2).sum();
    if sum > 1.0 {
        ranks.iter_mut().skip(1).step_by(2).for_each(|coverage| *coverage /= sum);
    }
}
