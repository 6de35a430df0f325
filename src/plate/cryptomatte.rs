//! Ranks of a Cryptomatte after a warp: coverage is gathered an id at a time, ids are never mixed.
//!
//! In: a canvas with maps, ranks of the source, factors for what lies below each sheet. Out: ranks.
//!
//! What is seen of an id is the sum, over the samples below the pixel's footprint, of weight · share · coverage,
//! sheet over sheet as colour (Friedman and Jones, "Fully automatic ID mattes", SIGGRAPH 2015 posters).

use super::canvas::{Canvas, Sheet};
use super::footprint;
use super::over::Overlay;
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

/// Memory that a thread uses again for every pixel.
#[derive(Default)]
struct Scratch {
    taps: Vec<(usize, f32)>,
    coverage: Coverage,
    ranks: Vec<f32>,
}

impl Canvas<'_> {
    /// Ranks after the warp: for each id and coverage, #pixels of the canvas.
    pub(super) fn matted(&self, matte: &Ranks, overlay: &Overlay) -> Vec<[Vec<f32>; 2]> {
        let width = self.window.width as usize;
        let count = matte.ranks.len();
        let mut rows = vec![0.0; self.window.area() * 2 * count];
        let work = |scratch: &mut Scratch, (row, ranks): (usize, &mut [f32])| {
            let y = self.window.y + row as i32;
            for (ranks, x) in ranks.chunks_exact_mut(2 * count).zip(self.window.x..) {
                self.gather(matte, overlay, [x, y], scratch);
                ranks.copy_from_slice(&scratch.ranks);
            }
        };
        rows.par_chunks_mut(width * 2 * count).enumerate().for_each_init(Scratch::default, work);
        let plane = |offset: usize| rows.par_iter().skip(offset).step_by(2 * count).copied().collect();
        (0..count).map(|rank| [plane(2 * rank), plane(2 * rank + 1)]).collect()
    }

    /// Leaves the ranks of one pixel in `scratch`.
    fn gather(&self, matte: &Ranks, overlay: &Overlay, at: [i32; 2], scratch: &mut Scratch) {
        scratch.ranks.clear();
        scratch.ranks.resize(2 * matte.ranks.len(), 0.0);
        scratch.coverage.clear();
        let mut visible = 1.0;
        for (sheet, below) in self.sheets.iter().zip(&overlay.below).rev() {
            let Some(place) = sheet.window.place_of(at) else { continue };
            self.find_taps(sheet, place, at, &mut scratch.taps);
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

    /// Samples below a pixel of a sheet.
    fn find_taps(&self, sheet: &Sheet, place: usize, at: [i32; 2], taps: &mut Vec<(usize, f32)>) {
        match &sheet.map {
            Some(map) => footprint(map, place, self.source, taps),
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
        let layers = &canvas.sheets[1..];
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
