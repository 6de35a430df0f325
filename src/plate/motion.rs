//! Motion vectors of a warped picture.
//!
//! In: vectors of the unwarped plate, the fields of this frame and its neighbours. Out: vectors after the warp.
//!
//! A point at x that moves by u lies at φ_t(x) in this frame's result and at φ_t+1(x + u) in the next one's, so
//! u'(φ_t(x)) = φ_t+1(x + u) − φ_t(x): with d = φ − x it is u + d_t+1(x + u) − d_t(x).

use super::canvas::{Canvas, Mover};
use super::nearest::Pick;
use super::over::BATCH;
use super::{Meaning, MotionRule};
use crate::space::{FrameSize, ImagePoint, ScreenPoint, ScreenVector};
use glam::DVec2;
use rayon::prelude::*;

/// A difference that counts, in pixels: below it the vectors keep their bits.
const LEAST: f64 = 1e-6;

/// Longer vectors, in pixels, are marks for "no motion known", not motion.
const MOST: f64 = 1e6;

/// Two channels with a vector, and how it is stored.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vectors<'a> {
    /// #pixels of the source each.
    pub(super) uv: [&'a [f32]; 2],
    /// [`Meaning::Forward`] or [`Meaning::Backward`].
    pub(super) direction: Meaning,
    /// Pixels a unit is, x right, y up.
    pub(super) rule: MotionRule,
}

impl Canvas<'_> {
    /// The vectors after the warp: #pixels of the canvas each; 0 where nothing is.
    pub(super) fn motion(&self, vectors: Vectors, picks: &[Pick], movers: &[Mover], frame: FrameSize) -> [Vec<f32>; 2] {
        let warped = |pick: &Pick| -> (f32, f32) {
            match *pick {
                Pick::Sample { sheet, index } => {
                    let index = index as usize;
                    let mover = &movers[self.sheets[usize::from(sheet)].mover];
                    vectors.warped(index, self.source_pixel(index), mover, frame).into()
                }
                _ => (0.0, 0.0),
            }
        };
        picks.par_iter().with_min_len(BATCH / 16).map(warped).unzip().into()
    }
}

impl Vectors<'_> {
    fn warped(self, index: usize, [x, y]: [i32; 2], mover: &Mover, frame: FrameSize) -> [f32; 2] {
        let stored = self.uv.map(|channel| channel[index]);
        let per_unit = DVec2::from_array(self.rule.pixels_per_unit);
        let pixels = DVec2::new(f64::from(stored[0]), f64::from(stored[1])) * per_unit;
        if !pixels.is_finite() || pixels.length() > MOST {
            return stored;
        }
        let other = if self.direction == Meaning::Backward { &mover.previous } else { &mover.next };
        let here = frame.screen_from_image(ImagePoint::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let there =
            frame.screen_from_image(ImagePoint::new(f64::from(x) + 0.5 + pixels.x, f64::from(y) + 0.5 - pixels.y));
        let displaced = |field: &super::Field, point: ScreenPoint| (field.carry(point) - point).0;
        let change = displaced(other, there) - displaced(&mover.now, here);
        let change = frame.pixels_from_screen(ScreenVector(change));
        if change.length() < LEAST {
            return stored;
        }
        let warped = (pixels + change) / per_unit;
        if warped.is_finite() { warped.as_vec2().to_array() } else { stored }
    }
}
