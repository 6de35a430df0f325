//! Motion vectors of a warped picture.
//!
//! In: vectors of the unwarped plate, the fields of this frame and its neighbours. Out: vectors after the warp.
//!
//! A point at x that moves by u lies at φ_t(x) in this frame's result and at φ_t+1(x + u) in the next one's, so
//! u'(φ_t(x)) = φ_t+1(x + u) − φ_t(x): with d = φ − x it is u + d_t+1(x + u) − d_t(x). Where a warp is undone, d = φ⁻¹ − x.

use super::canvas::{Canvas, Mover};
use super::map_view::{Direction, corner, extent};
use super::nearest::Pick;
use super::over::BATCH;
use super::{Field, Meaning, MotionRule, WarpMap};
use crate::space::{FrameSize, ImagePoint, PixelRect};
use glam::DVec2;
use rayon::prelude::*;

/// A difference that counts, in pixels: below it the vectors keep their bits. Maps are no finer than this.
const LEAST: f64 = 5e-4;

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
        let ways = movers.iter().map(|mover| Ways::of(mover, vectors.direction, (frame, self.source)));
        let ways: Vec<Ways> = ways.collect();
        let warped = |pick: &Pick| -> (f32, f32) {
            match *pick {
                Pick::Sample { sheet, index } => {
                    let index = index as usize;
                    let ways = &ways[self.sheets[usize::from(sheet)].mover];
                    vectors.warped(index, self.source_pixel(index), ways).into()
                }
                _ => (0.0, 0.0),
            }
        };
        picks.par_iter().with_min_len(BATCH / 16).map(warped).unzip().into()
    }
}

/// Vectors of what fills holes.
pub(super) struct Behind<'a> {
    pub(super) vectors: Vectors<'a>,
    /// The pixels they tell of.
    pub(super) window: PixelRect,
    /// What carries the back of the picture.
    pub(super) mover: &'a Mover<'a>,
}

impl Canvas<'_> {
    /// Puts the vectors of what lies behind into holes, carried by the warp and stored by the rule of the plate.
    pub(super) fn fill_motion(
        &self,
        behind: &Behind,
        picks: &[Pick],
        (frame, rule): (FrameSize, MotionRule),
        planes: &mut [Vec<f32>; 2],
    ) {
        if !picks.contains(&Pick::Hole) {
            return;
        }
        let Behind { vectors, window, mover } = *behind;
        let ways = Ways::of(mover, vectors.direction, (frame, window));
        let factors = [0, 1].map(|axis| (vectors.rule.pixels_per_unit[axis] / rule.pixels_per_unit[axis]) as f32);
        let [us, vs] = planes;
        let holes = us.par_iter_mut().zip(vs).zip(picks).enumerate().filter(|(_, (_, pick))| **pick == Pick::Hole);
        holes.for_each(|(at, ((u, v), _))| {
            let Some(pixel) = self.pixel_behind(at) else { return };
            let Some(index) = window.place_of(pixel) else { return };
            let [x, y] = vectors.warped(index, pixel, &ways);
            (*u, *v) = (x * factors[0], y * factors[1]);
        });
    }
}

impl Vectors<'_> {
    fn warped(self, index: usize, [x, y]: [i32; 2], ways: &Ways) -> [f32; 2] {
        let stored = self.uv.map(|channel| channel[index]);
        let per_unit = DVec2::from_array(self.rule.pixels_per_unit);
        let pixels = DVec2::new(f64::from(stored[0]), f64::from(stored[1])) * per_unit;
        if !pixels.is_finite() || pixels.length() > MOST {
            return stored;
        }
        let there = DVec2::new(f64::from(x) + 0.5 + pixels.x, f64::from(y) + 0.5 - pixels.y);
        let change = ways.there(there) - ways.here(index);
        if !change.is_finite() || change.length() < LEAST {
            return stored;
        }
        // Vectors count up, maps down.
        let warped = (pixels + DVec2::new(change.x, -change.y)) / per_unit;
        if warped.is_finite() { warped.as_vec2().to_array() } else { stored }
    }
}

/// How far the points of a mover move in this frame and in the one that vectors point to, in pixels, y down.
///
/// Fields are asked for every pixel once, by blocks; asking them for each vector took three times as long as all else.
struct Ways<'a> {
    now: WarpMap,
    other: WarpMap,
    /// What `other` was made of.
    field: &'a Field,
    course: Direction,
}

impl<'a> Ways<'a> {
    fn of(mover: &'a Mover, direction: Meaning, (frame, window): (FrameSize, PixelRect)) -> Self {
        let field = if direction == Meaning::Backward { &mover.previous } else { &mover.next };
        let [now, other] = [&mover.now, field].map(|field| match mover.course {
            Direction::Forward => WarpMap::forward_alone(field, frame, window),
            Direction::Backward => WarpMap::backward(field, frame, window),
        });
        Self { now, other, field, course: mover.course }
    }

    /// At the centre of a pixel, in this frame.
    fn here(&self, index: usize) -> DVec2 {
        offset(&self.now, index)
    }

    /// At any place, in the other frame: Catmull-Rom between pixels, the field itself around the picture.
    fn there(&self, at: DVec2) -> DVec2 {
        between(&self.other, at).unwrap_or_else(|| {
            let frame = self.other.frame;
            let from = frame.screen_from_image(ImagePoint(at));
            let goes = match self.course {
                Direction::Forward => Some(self.field.carry(from)),
                Direction::Backward => self.field.inverse(from, from),
            };
            goes.map_or(DVec2::NAN, |goes| frame.image_from_screen(goes).0 - at)
        })
    }
}

/// The offset of a map at a place; `None` where it does not tell of all pixels around.
fn between(map: &WarpMap, at: DVec2) -> Option<DVec2> {
    let place = at - corner(map.window) - 0.5;
    let whole = place.floor();
    if !(whole.cmpge(DVec2::ONE).all() && whole.cmple(extent(map.window) - 3.0).all()) {
        return None;
    }
    let width = map.window.width as usize;
    let first = (whole.y as usize - 1) * width + whole.x as usize - 1;
    let [across, down] = [place.x - whole.x, place.y - whole.y].map(catmull_rom);
    let row = |start: usize| (0..4).map(|i| offset(map, start + i) * across[i]).sum::<DVec2>();
    Some((0..4).map(|j| row(first + j * width) * down[j]).sum())
}

fn offset(map: &WarpMap, index: usize) -> DVec2 {
    let [x, y] = map.offsets[index];
    DVec2::new(x.into(), y.into())
}

/// Weights of four neighbours, a share `t` of the way from the second to the third (Keys 1981, a = -1/2).
fn catmull_rom(t: f64) -> [f64; 4] {
    let (a, b) = (t * t, t * t * t);
    [-0.5 * t + a - 0.5 * b, 1.0 - 2.5 * a + 1.5 * b, 0.5 * t + 2.0 * a - 1.5 * b, 0.5 * (b - a)]
}
