//! Data that must never be blended: which one source sample each pixel of the result shows.
//!
//! In: a canvas with maps, coverage. Out: a [`Pick`] a pixel; copies of samples.
//!
//! The sheet in front counts, as for colour, so depth and ids tell of the surface that is seen.

use super::WarpMap;
use super::canvas::{Canvas, Sheet};
use super::filter::{BAND, NOWHERE, bands, copy_samples, nearest_in_row};
use rayon::prelude::*;

/// Columns of a tile.
const TILE: usize = 64;

/// A sheet has a pixel if it covers at least this much of it.
pub(super) const HALF: f32 = 0.5;

/// Where a pixel's data come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pick {
    /// A sample of a sheet.
    Sample {
        /// Place among the canvas's sheets.
        sheet: u16,
        /// Place in the source window.
        index: u32,
    },
    /// Something was here and left.
    Hole,
    /// The picture does not reach here.
    Nothing,
}

impl Pick {
    /// Of a picture that is one sheet.
    fn alone(index: u32) -> Self {
        if index == NOWHERE { Self::Nothing } else { Self::Sample { sheet: 0, index } }
    }

    /// Place in the source window; [`NOWHERE`] where no sample is shown.
    fn sample(&self) -> u32 {
        if let Self::Sample { index, .. } = *self { index } else { NOWHERE }
    }
}

/// A sheet at one pixel.
struct Candidate {
    pick: Pick,
    /// How much of the source pixel the sheet has.
    share: f32,
    /// How much of the result it hides.
    cover: f32,
}

impl Canvas<'_> {
    /// For every pixel of the canvas: the sample it shows. `alpha`: #pixels of the source.
    pub(super) fn picks(&self, alpha: Option<&[f32]>) -> Vec<Pick> {
        let width = self.window.width as usize;
        let mut picks = vec![Pick::Nothing; self.window.area()];
        let alone = self.alone();
        picks.par_chunks_mut(width).enumerate().for_each_init(Vec::new, |samples, (row, picks)| {
            let y = self.window.y + row as i32;
            if let Some(map) = alone {
                samples.resize(width, NOWHERE);
                nearest_in_row(map, [0, row], self.source, samples);
                picks.iter_mut().zip(samples).for_each(|(pick, &mut index)| *pick = Pick::alone(index));
            } else {
                picks.iter_mut().zip(self.window.x..).for_each(|(pick, x)| *pick = self.pick([x, y], alpha));
            }
        });
        picks
    }

    /// The map of the only sheet, where it moves all of the picture and is as large as the canvas.
    fn alone(&self) -> Option<&WarpMap> {
        match &self.sheets[..] {
            [only] if only.share.pixels.is_none() && only.window == self.window => only.map.as_deref(),
            _ => None,
        }
    }

    fn pick(&self, at: [i32; 2], alpha: Option<&[f32]>) -> Pick {
        if let [only] = &self.sheets[..] {
            return self.candidate(0, only, at, None).map_or(Pick::Nothing, |candidate| candidate.pick);
        }
        let mut sum = 0.0;
        let (mut best, mut base): (Option<Candidate>, Option<Pick>) = (None, None);
        // From the front to the back.
        for (index, sheet) in self.sheets.iter().enumerate().rev() {
            let Some(candidate) = self.candidate(index, sheet, at, alpha) else { continue };
            if candidate.cover >= HALF {
                return candidate.pick;
            }
            // The background needs no coverage: its samples say what is there where nothing is.
            if sheet.mover == 0 && candidate.share >= HALF {
                base = base.or(Some(candidate.pick));
            }
            sum += candidate.share;
            if best.as_ref().is_none_or(|best| candidate.share > best.share) {
                best = Some(candidate);
            }
        }
        match best {
            _ if let Some(base) = base => base,
            Some(best) if sum >= HALF => best.pick,
            _ if self.is_carved_at(at) => Pick::Hole,
            _ => Pick::Nothing,
        }
    }

    fn candidate(&self, index: usize, sheet: &Sheet, at: [i32; 2], alpha: Option<&[f32]>) -> Option<Candidate> {
        let source = self.source_of(sheet, at)?;
        let share = sheet.share.pixels.as_ref().map_or(1.0, |share| share[source]);
        let cover = share * alpha.map_or(1.0, |alpha| alpha[source]);
        (share > 0.0).then_some(Candidate {
            pick: Pick::Sample { sheet: index as u16, index: source as u32 },
            share,
            cover,
        })
    }

    /// Place in the source of the sample nearest to where a pixel of a sheet comes from.
    pub(super) fn source_of(&self, sheet: &Sheet, [x, y]: [i32; 2]) -> Option<usize> {
        let own = sheet.window.place_of([x, y])?;
        let offset = sheet.map.as_ref().map_or([0.0; 2], |map| map.offsets[own]);
        self.source.place_of(nearest_source([x, y], offset)?)
    }

    /// The pixel of the source's frame that lies at the back of a pixel of the canvas, a place in its window.
    pub(super) fn pixel_behind(&self, at: usize) -> Option<[i32; 2]> {
        let offset = self.base().map.as_ref().map_or([0.0; 2], |map| map.offsets[at]);
        nearest_source(self.window.pixel_at(at), offset)
    }

    fn is_carved_at(&self, at: [i32; 2]) -> bool {
        let carved = self.carved.as_ref().zip(self.source_of(self.base(), at));
        carved.is_some_and(|(carved, index)| carved[index] > 0.0)
    }

    /// The pixel of the source at a place in it, from the upper left corner of the display window.
    pub(super) fn source_pixel(&self, index: usize) -> [i32; 2] {
        self.source.pixel_at(index)
    }
}

/// The pixel whose centre is nearest to where a pixel comes from; `None` where nothing is seen.
pub(super) fn nearest_source(pixel: [i32; 2], offset: [f32; 2]) -> Option<[i32; 2]> {
    let [x, y] = [0, 1].map(|axis| (f64::from(offset[axis]) + 0.5).floor() + f64::from(pixel[axis]));
    (x.abs() < 1e9 && y.abs() < 1e9).then_some([x as i32, y as i32])
}

/// The samples that the picks show, of several planes: (samples, what stands where there is none). Tiles of one plane
/// after the other stay in the cache and in the table of pages.
pub(super) fn copied(picks: &[Pick], width: usize, sources: &[(&[f32], f32)], copies: &mut [Vec<f32>]) {
    if picks.is_empty() || copies.is_empty() {
        return;
    }
    let bands = bands(copies, BAND * width);
    bands.into_par_iter().zip(picks.par_chunks(BAND * width)).for_each_init(Vec::new, |samples, (mut band, picks)| {
        for column in (0..width).step_by(TILE) {
            let columns = column..width.min(column + TILE);
            samples.clear();
            for picks in picks.chunks_exact(width) {
                samples.extend(picks[columns.clone()].iter().map(Pick::sample));
            }
            for (&(source, empty), copy) in sources.iter().zip(&mut band) {
                for (row, samples) in copy.chunks_exact_mut(width).zip(samples.chunks_exact(columns.len())) {
                    copy_samples(source, samples, empty, &mut row[columns.clone()]);
                }
            }
        }
    });
}
