//! Data that must never be blended: which one source sample each pixel of the result shows.
//!
//! In: a canvas with maps, coverage. Out: a [`Pick`] a pixel; copies of samples.
//!
//! The sheet in front counts, as for colour, so depth and ids tell of the surface that is seen.

use super::canvas::{Canvas, Sheet};
use super::over::BATCH;
use rayon::prelude::*;

/// A sheet has a pixel if it covers at least this much of it.
const HALF: f32 = 0.5;

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
        picks.par_chunks_mut(width).enumerate().for_each(|(row, picks)| {
            let y = self.window.y + row as i32;
            picks.iter_mut().zip(self.window.x..).for_each(|(pick, x)| *pick = self.pick([x, y], alpha));
        });
        picks
    }

    fn pick(&self, at: [i32; 2], alpha: Option<&[f32]>) -> Pick {
        if let [only] = &self.sheets[..] {
            return self.candidate(0, only, at, None).map_or(Pick::Nothing, |candidate| candidate.pick);
        }
        let mut sum = 0.0;
        let mut best: Option<Candidate> = None;
        // From the front to the back.
        for (index, sheet) in self.sheets.iter().enumerate().rev() {
            let Some(candidate) = self.candidate(index, sheet, at, alpha) else { continue };
            // What lies at the back has no coverage of its own to ask for: its samples tell what nothing is.
            let weight = if sheet.mover == 0 { candidate.share } else { candidate.cover };
            if weight >= HALF {
                return candidate.pick;
            }
            sum += candidate.share;
            if best.as_ref().is_none_or(|best| candidate.share > best.share) {
                best = Some(candidate);
            }
        }
        match best {
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

/// The samples that the picks show; `empty` where there is none.
pub(super) fn copied(picks: &[Pick], samples: &[f32], empty: f32) -> Vec<f32> {
    let sample = |pick: &Pick| match *pick {
        Pick::Sample { index, .. } => samples[index as usize],
        Pick::Hole | Pick::Nothing => empty,
    };
    picks.par_iter().with_min_len(BATCH).map(sample).collect()
}
