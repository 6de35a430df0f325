//! Sheets laid over each other: what is left to see of what lies below, and colour.
//!
//! In: a canvas with maps, an alpha. Out: [`Overlay`]: factors for what lies below each sheet, and holes; planes of colour.
//!
//! Sheets of one picture meet at its soft edges: where a pixel belongs to one of them by 0.7, the rest has 0.3 of it.
//! So the first thing a sheet covers is the hole it left (Porter and Duff, "Compositing Digital Images", 1984, call such
//! coverage disjoint), and only what exceeds the hole hides what lies below. A layer that stays gives the picture back.

use super::Planes;
use super::canvas::{Canvas, Sheet};
use super::resampler::Resampling;
use rayon::prelude::*;
use std::borrow::Cow;

/// Pixels that a task takes.
pub(super) const BATCH: usize = 1 << 14;

/// Coverage above this is whole: weights of a filter sum to 1 but for rounding.
const WHOLE: f32 = 1.0 - 1e-5;

/// Planes that are weighted and filtered together.
const GROUP: usize = 8;

/// What is left to see of what lies below.
#[derive(Clone, Debug, Default)]
pub(super) struct Overlay {
    /// A sheet each: #pixels of the sheet's window, the factor for everything below it; empty for the lowest.
    pub(super) below: Vec<Vec<f32>>,
    /// #pixels of the canvas: how much of a pixel nothing covers though something was there; `None`: no layer left.
    pub(super) holes: Option<Vec<f32>>,
}

impl Canvas<'_> {
    /// `alpha`: #pixels of the source, the coverage of its colour; `None`: it covers where it is.
    pub(super) fn overlay(&self, alpha: Option<&[f32]>, by: Resampling) -> Overlay {
        let Some(carved) = &self.carved else {
            return self.overlay_uncarved(alpha, by);
        };
        let left = self.seen_from(self.base(), &[Cow::Borrowed(carved)], by).swap_remove(0);
        let mut filled: Vec<f32> = left.par_iter().map(|left| 1.0 - left.clamp(0.0, 1.0)).collect();
        let mut below = vec![Vec::new()];
        for (index, sheet) in self.folded_base().iter().enumerate() {
            let [mut share, cover] = self.coverage(sheet, alpha, by);
            self.each_row(sheet, &mut filled, &mut share, |_, filled, share| *filled = (*filled + *share).min(1.0));
            below.extend((index > 0).then(|| uncovered(cover)));
        }
        if below.len() <= self.folded_base().len() {
            below.push(uncovered(self.coverage(self.base(), alpha, by)[1].clone()));
        }
        below.extend(self.matted_sheets().iter().map(|sheet| {
            let [share, cover] = self.coverage(sheet, alpha, by);
            let mut factors = vec![1.0; sheet.window.area()];
            self.each_row(sheet, &mut filled, &mut factors, |at, filled, factor| {
                *factor = left_below(*filled, share[at], cover[at]);
                *filled = (*filled + share[at]).min(1.0);
            });
            factors
        }));
        let holes = filled.iter().map(|filled| 1.0 - filled).collect();
        Overlay { below, holes: Some(holes) }
    }

    fn overlay_uncarved(&self, alpha: Option<&[f32]>, by: Resampling) -> Overlay {
        let above = self.sheets.iter().skip(1);
        let factors = above.map(|sheet| {
            let [_, cover] = self.coverage(sheet, alpha, by);
            uncovered(cover)
        });
        Overlay { below: std::iter::once(Vec::new()).chain(factors).collect(), holes: None }
    }

    /// Where a sheet lands, and how much it covers there: #pixels of its window, 0 to 1.
    fn coverage(&self, sheet: &Sheet, alpha: Option<&[f32]>, by: Resampling) -> [Vec<f32>; 2] {
        let ones;
        let share = match &sheet.share.pixels {
            Some(share) => share,
            None => {
                ones = vec![1.0; self.source.area()];
                &ones
            }
        };
        let mut planes = vec![Cow::Borrowed(&share[..])];
        planes.extend(alpha.map(|alpha| Cow::Owned(product(alpha, share))));
        let mut seen = self.seen_from(sheet, &planes, by);
        seen.iter_mut().for_each(|plane| plane.iter_mut().for_each(|sample| *sample = sample.clamp(0.0, 1.0)));
        let cover = if alpha.is_some() { seen.swap_remove(1) } else { seen[0].clone() };
        [seen.swap_remove(0), cover]
    }

    /// Planes of colour, laid over each other: #pixels of the canvas's window each.
    pub(super) fn colors(&self, planes: &[Cow<[f32]>], overlay: &Overlay, by: Resampling) -> Vec<Vec<f32>> {
        let groups = planes.chunks(GROUP);
        groups.flat_map(|group| self.color_group(group, overlay, by)).collect()
    }

    fn color_group(&self, planes: &[Cow<[f32]>], overlay: &Overlay, by: Resampling) -> Vec<Vec<f32>> {
        let mut result: Option<Vec<Vec<f32>>> = None;
        for (sheet, below) in self.sheets.iter().zip(&overlay.below) {
            let weighted: Vec<Cow<[f32]>> = match &sheet.share.pixels {
                Some(share) => planes.iter().map(|plane| Cow::Owned(product(plane, share))).collect(),
                None => planes.iter().map(|plane| Cow::Borrowed(&plane[..])).collect(),
            };
            let seen = self.seen_from(sheet, &weighted, by);
            match &mut result {
                None if sheet.window == self.window => result = Some(seen),
                None => {
                    let spread = |plane: &Vec<f32>| sheet.window.over(plane, self.window, 0.0);
                    result = Some(seen.iter().map(spread).collect());
                }
                Some(result) => {
                    for (plane, mut seen) in result.iter_mut().zip(seen) {
                        self.each_row(sheet, plane, &mut seen, |at, under, over| {
                            *under = laid(*over, *under, below[at])
                        });
                    }
                }
            }
        }
        result.unwrap_or_default()
    }

    /// Planes of the source in a sheet's window.
    fn seen_from(&self, sheet: &Sheet, planes: &[Cow<[f32]>], by: Resampling) -> Vec<Vec<f32>> {
        let source = Planes { window: self.source, planes: planes.iter().map(|plane| &plane[..]).collect() };
        match &sheet.map {
            Some(map) => by.seen(map, &source),
            None => planes.iter().map(|plane| self.source.over(plane, sheet.window, 0.0)).collect(),
        }
    }

    /// Pixels of the canvas and of a sheet's window side by side: place in the sheet's window, both values.
    fn each_row(
        &self,
        sheet: &Sheet,
        canvas: &mut [f32],
        own: &mut [f32],
        work: impl Fn(usize, &mut f32, &mut f32) + Sync,
    ) {
        let (width, own_width) = (self.window.width as usize, sheet.window.width as usize);
        if sheet.window.area() == 0 {
            return;
        }
        let top = (sheet.window.y - self.window.y) as usize * width;
        let left = (sheet.window.x - self.window.x) as usize;
        let rows = canvas[top..].par_chunks_mut(width).zip(own.par_chunks_mut(own_width)).enumerate();
        rows.for_each(|(y, (row, own))| {
            for (x, (under, over)) in row[left..].iter_mut().zip(own).enumerate() {
                work(y * own_width + x, under, over);
            }
        });
    }
}

/// What coverage lets through; rounding of what covers wholly lets nothing through.
fn uncovered(mut cover: Vec<f32>) -> Vec<f32> {
    let left = |cover: f32| if cover > WHOLE { 0.0 } else { 1.0 - cover };
    cover.par_iter_mut().with_min_len(BATCH).for_each(|cover| *cover = left(*cover));
    cover
}

/// What is left to see of a pixel that is filled by `filled`, below a sheet that has `share` of it and covers `cover`.
pub(crate) fn left_below(filled: f32, share: f32, cover: f32) -> f32 {
    let shared = filled + share - 1.0;
    if shared <= 0.0 || filled <= 0.0 || share <= 0.0 {
        return 1.0;
    }
    (1.0 - shared / filled * (cover / share)).clamp(0.0, 1.0)
}

/// A sample over another. What cannot be seen does not count, whatever it is.
pub(crate) fn laid(over: f32, under: f32, below: f32) -> f32 {
    if below == 0.0 { over } else { over + under * below }
}

/// Shares of samples. What has no share does not count, whatever it is; so do numbers that are none.
fn product(samples: &[f32], share: &[f32]) -> Vec<f32> {
    let part = |(&sample, &share): (&f32, &f32)| if share == 0.0 { 0.0 } else { sample * share };
    samples.par_iter().zip(share).with_min_len(BATCH).map(part).collect()
}
