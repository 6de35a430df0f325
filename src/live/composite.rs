//! Composites the moved part of the picture over the part at rest, and over the background.
//!
//! In: the pictures of a [`Render`], the maps of a tile. Out: planes of a window of that tile, with the alpha mode of the source.
//! Transmittances are those of plates (disjoint over, `src/plate/disjoint_over.rs`): a layer covers first the hole that it left.

use super::picture::{Alpha, Associated, products};
use super::regions::{reach, rect};
use super::{Render, Warp, take_planes};
use crate::plate::{Coverage, Field, Filter, OPAQUE_COVERAGE, Planes, WarpMap, over, resample_part, transmittance};
use crate::space::PixelRect;
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::Arc;

/// Samples per parallel task.
const BATCH: usize = 1 << 12;

/// Alpha below this counts as 0, since dividing by it is meaningless.
const MIN_ALPHA: f32 = 1e-6;

/// The pictures of a render, prepared for drawing.
pub(super) struct Compositor<'a> {
    job: &'a Render<'a>,
    /// The source, premultiplied.
    source: Associated<'a>,
    /// The filtered planes: the moving part of the source, its share, and colours hidden by alpha.
    moved: Vec<Cow<'a, [f32]>>,
    /// The share of every pixel that moves, if it is not all: #pixels of the source.
    share: Option<Cow<'a, [f32]>>,
    background: Option<Associated<'a>>,
    /// Whether the output has straight colour.
    is_straight: bool,
    /// Whether the alpha of the source is not 0 everywhere, so that it can be trusted.
    has_coverage: bool,
    /// Field and share of the parts of the picture, from back to front; empty if it moves as one.
    parts: &'a [(Field, Coverage)],
}

/// The parts that are drawn so far, over a window.
struct DrawnParts {
    planes: Vec<Vec<f32>>,
    /// Coverage of all of them.
    filled: Vec<f32>,
}

impl<'a> Compositor<'a> {
    /// Returns `None` if nothing moves and there is no background.
    pub(super) fn of(warp: &'a Warp, job: &'a Render<'a>) -> Option<Self> {
        if warp.is_identity() && job.background.is_none() {
            return None;
        }
        let is_one = job.mask.is_none() && job.background.is_none() && warp.parts.is_empty();
        let is_blended = job.filter != Filter::Nearest || !is_one;
        let is_straight = job.source.alpha == Alpha::Straight && is_blended;
        let plain = || job.source.planes.iter().map(|plane| Cow::Borrowed(*plane)).collect();
        let window = job.source.window;
        let source = if is_straight { job.source.associated() } else { Associated { window, planes: plain() } };
        let share: Option<Cow<[f32]>> =
            match (job.mask.and_then(|mask| Some((mask, mask.planes.first()?))), job.background) {
                (Some((mask, plane)), _) => {
                    let mut share = mask.window.resized_samples(plane, window, 0.0);
                    share
                        .par_iter_mut()
                        .for_each(|share| *share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) });
                    Some(Cow::Owned(share))
                }
                (None, Some(_)) => Some(Cow::Owned(vec![1.0; window.area()])),
                (None, None) => None,
            };
        let mut moved: Vec<Cow<[f32]>> = match &share {
            Some(share) if job.mask.is_some() => {
                source.planes.iter().map(|plane| Cow::Owned(products(plane, share))).collect()
            }
            _ => source.planes.clone(),
        };
        moved.extend(share.clone());
        if is_straight && job.source.has_hidden_color() {
            let colors = job.source.planes.len() - 1;
            moved.extend(job.source.planes[..colors].iter().map(|plane| Cow::Borrowed(*plane)));
        }
        let background = job.background.map(|background| background.associated());
        let alpha = job.source.coverage().map(|alpha| job.source.planes[alpha]);
        let has_coverage = alpha.is_some_and(|alpha| alpha.iter().any(|alpha| *alpha > 0.0));
        Some(Self { job, source, moved, share, background, is_straight, has_coverage, parts: &warp.parts })
    }

    /// Draws the pixels of a window within a tile, given the maps of each part, front first. Where the warp folds,
    /// transparent pixels in front do not hide what lies behind. Returns as many planes as the source has, each
    /// `window.area()` samples, followed by auxiliary planes.
    pub(super) fn draw(&self, maps: &[Arc<Vec<WarpMap>>], window: PixelRect) -> Vec<Vec<f32>> {
        let mut drawn = match (self.parts, maps) {
            ([], [only]) => self.whole(only, window),
            _ => self.of_parts(maps, window),
        };
        let (seen, others) = drawn.split_at_mut(self.job.source.planes.len());
        let hidden = match &self.share {
            Some(share) => {
                let (landed, hidden) = others.split_first_mut().expect("the share is resampled after the planes");
                self.lay(seen, (share, landed), window);
                self.keep_resting(hidden, landed, window);
                hidden
            }
            None => others,
        };
        if self.is_straight {
            self.divide(seen, hidden, window);
        }
        drawn
    }

    /// Draws a picture that moves as one.
    fn whole(&self, maps: &[WarpMap], window: PixelRect) -> Vec<Vec<f32>> {
        let mut maps = maps.iter().map(|map| self.resampled(map, window));
        let mut drawn = maps.next().unwrap_or_default();
        if let Some(alpha) = self.job.source.coverage().filter(|_| self.has_coverage) {
            maps.for_each(|behind| self.put_behind(&mut drawn, &behind, alpha));
        }
        drawn
    }

    /// Draws the parts, each over those behind it. Where they are connected their shares sum to 1, so that no seam shows.
    fn of_parts(&self, maps: &[Arc<Vec<WarpMap>>], window: PixelRect) -> Vec<Vec<f32>> {
        let planes = vec![vec![0.0; window.area()]; self.moved.len()];
        let mut drawn = DrawnParts { planes, filled: vec![0.0; window.area()] };
        for ((_, share), maps) in self.parts.iter().zip(maps) {
            for map in maps.iter().rev() {
                self.lay_part(share, map, window, &mut drawn);
            }
        }
        drawn.planes
    }

    /// Composites what a map shows of a part over the planes drawn so far.
    fn lay_part(&self, share: &Coverage, map: &WarpMap, window: PixelRect, drawn: &mut DrawnParts) {
        let DrawnParts { planes: drawn, filled } = drawn;
        let Some(read) = reach(map, window, self.job.filter) else { return };
        let read = rect(read).intersection(self.source.window);
        if read.area() == 0 {
            return;
        }
        let share = share.over(read, self.job.frame);
        if share.iter().all(|share| *share == 0.0) {
            return;
        }
        let part = |plane: &[f32]| products(&self.source.window.resized_samples(plane, read, 0.0), &share);
        let mut planes: Vec<Vec<f32>> = self.moved.iter().map(|plane| part(plane)).collect();
        let count = self.job.source.planes.len();
        planes.push(if self.share.is_some() { planes[count].clone() } else { share.clone() });
        let mut seen = take_planes(planes.len(), window.area());
        let planes = Planes { window: read, planes: planes.iter().map(|plane| &plane[..]).collect() };
        resample_part(map, window, &planes, self.job.filter, &mut seen);
        let alpha = self.job.source.coverage().filter(|_| self.has_coverage);
        let is_associated = self.is_straight || self.job.source.alpha == Alpha::Premultiplied;
        let Some(landed) = seen.pop() else { return };
        let opacity = alpha.filter(|_| is_associated).map_or(&landed, |alpha| &seen[alpha]);
        let below: Vec<f32> = (filled.iter().zip(&landed).zip(opacity))
            .map(|((filled, landed), opacity)| transmittance(*filled, landed.clamp(0.0, 1.0), opacity.clamp(0.0, 1.0)))
            .collect();
        for (index, (behind, front)) in drawn.iter_mut().zip(&seen).enumerate() {
            // The share plane is its own coverage, independent of what lies below.
            let is_share = self.share.is_some() && index == count;
            for ((behind, front), below) in behind.iter_mut().zip(front).zip(&below) {
                *behind = if is_share { (*behind + front).min(1.0) } else { over(*front, *behind, *below) };
            }
        }
        filled
            .iter_mut()
            .zip(&landed)
            .for_each(|(filled, landed)| *filled = (*filled + landed.clamp(0.0, 1.0)).min(1.0));
    }

    /// Resamples the moving planes through a map.
    fn resampled(&self, map: &WarpMap, window: PixelRect) -> Vec<Vec<f32>> {
        let planes: Vec<&[f32]> = self.moved.iter().map(|plane| &plane[..]).collect();
        let mut drawn = take_planes(planes.len(), window.area());
        resample_part(map, window, &Planes { window: self.source.window, planes }, self.job.filter, &mut drawn);
        drawn
    }

    /// Composites the front of a fold over what lies behind it. Colours hidden by alpha keep their front value.
    fn put_behind(&self, drawn: &mut [Vec<f32>], behind: &[Vec<f32>], alpha: usize) {
        let is_associated = self.is_straight || self.job.source.alpha == Alpha::Premultiplied;
        let left = |cover: f32| match cover.clamp(0.0, 1.0) {
            cover if cover > OPAQUE_COVERAGE => 0.0,
            cover if is_associated => 1.0 - cover,
            cover => f32::from(u8::from(cover < MIN_ALPHA)),
        };
        let covers = drawn[alpha].par_iter().zip(&behind[alpha]).with_min_len(BATCH);
        let left: Vec<f32> = covers.map(|(cover, behind)| if *behind > 0.0 { left(*cover) } else { 0.0 }).collect();
        let count = self.job.source.planes.len();
        for (index, (front, behind)) in drawn.iter_mut().zip(behind).enumerate().take(count + 1) {
            let samples = front.par_iter_mut().zip(behind).zip(&left).with_min_len(BATCH);
            match (index < count, is_associated) {
                (true, true) => samples.for_each(|((front, behind), left)| *front = over(*front, *behind, *left)),
                (true, false) => {
                    samples.filter(|(_, left)| **left > 0.0).for_each(|((front, behind), _)| *front = *behind)
                }
                (false, _) if self.share.is_some() => {
                    samples.for_each(|((front, behind), _)| *front = (*front + behind).min(1.0));
                }
                (false, _) => {}
            }
        }
    }

    /// Composites the moved part over the part at rest, and both over the background.
    fn lay(&self, seen: &mut [Vec<f32>], (share, landed): (&[f32], &[f32]), window: PixelRect) {
        let filled = self.filled(share, window);
        let cover = match self.job.source.coverage() {
            Some(alpha) => seen[alpha].clone(),
            None => landed.to_vec(),
        };
        let factor = |((filled, share), cover): ((&f32, &f32), &f32)| {
            let (share, cover) = (share.clamp(0.0, 1.0), cover.clamp(0.0, 1.0));
            (transmittance(*filled, share, cover), 1.0 - (filled + share).min(1.0))
        };
        let all = filled.par_iter().zip(landed).zip(&cover).with_min_len(BATCH);
        let (below, holes): (Vec<f32>, Vec<f32>) = all.map(factor).unzip();
        for (index, plane) in seen.iter_mut().enumerate() {
            if self.job.mask.is_some() {
                let rest = self.source.window.resized_samples(&self.source.planes[index], window, 0.0);
                let rests = products(&rest, &filled);
                let samples = plane.par_iter_mut().zip(rests).zip(&below).with_min_len(BATCH);
                samples.for_each(|((sample, rest), below)| *sample = over(*sample, rest, *below));
            }
            if let Some(background) = &self.background {
                let behind =
                    products(&background.window.resized_samples(&background.planes[index], window, 0.0), &holes);
                let samples = plane.par_iter_mut().zip(behind).with_min_len(BATCH);
                samples.for_each(|(sample, behind)| *sample += behind);
            }
        }
    }

    /// Keeps the hidden colours of the part at rest where nothing landed on it.
    fn keep_resting(&self, hidden: &mut [Vec<f32>], landed: &[f32], window: PixelRect) {
        for (hidden, own) in hidden.iter_mut().zip(&self.job.source.planes) {
            let own = self.source.window.resized_samples(own, window, 0.0);
            let samples = hidden.iter_mut().zip(own).zip(landed);
            samples.filter(|(_, landed)| **landed == 0.0).for_each(|((hidden, own), _)| *hidden = own);
        }
    }

    /// Returns the fraction of every pixel of a window that stays at rest; 0 where the source has no samples.
    fn filled(&self, share: &[f32], window: PixelRect) -> Vec<f32> {
        let mut left = self.source.window.resized_samples(share, window, 1.0);
        left.iter_mut().for_each(|share| *share = 1.0 - *share);
        left
    }

    /// Converts to straight colour. Samples that equal their input stay bit-exact.
    fn divide(&self, seen: &mut [Vec<f32>], hidden: &[Vec<f32>], window: PixelRect) {
        let Some((alpha, colors)) = seen.split_last_mut() else { return };
        let of = |plane: &[f32]| self.source.window.resized_samples(plane, window, 0.0);
        let Some(source_alpha) = self.job.source.planes.last().map(|plane| of(plane)) else { return };
        for (index, color) in colors.iter_mut().enumerate() {
            let (multiplied, straight) = (of(&self.source.planes[index]), of(self.job.source.planes[index]));
            let hidden = hidden.get(index);
            color.par_iter_mut().enumerate().with_min_len(BATCH).for_each(|(k, sample)| {
                let is_kept =
                    sample.to_bits() == multiplied[k].to_bits() && alpha[k].to_bits() == source_alpha[k].to_bits();
                *sample = match alpha[k] {
                    _ if is_kept && (alpha[k] != 0.0 || hidden.is_none_or(|hidden| hidden[k] == straight[k])) => {
                        straight[k]
                    }
                    alpha if alpha.abs() < MIN_ALPHA => hidden.map_or(0.0, |hidden| hidden[k]),
                    alpha => *sample / alpha,
                };
            });
        }
    }
}
