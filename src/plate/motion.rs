//! Warps motion vectors.
//!
//! In: vectors of the unwarped plate, the fields of this frame and its neighbours. Out: vectors after the warp.
//!
//! A point at x that moves by u lies at φ_t(x) in this frame's result and at φ_t+1(x + u) in the next one's, so
//! u'(φ_t(x)) = φ_t+1(x + u) − φ_t(x): with d = φ − x it is u + d_t+1(x + u) − d_t(x). To undo a warp, d = φ⁻¹ − x.

use super::composite::Composite;
use super::disjoint_over::BATCH;
use super::moving_layer::MovingLayer;
use super::pixel_field::{Direction, corner, extent};
use super::visible_samples::VisibleSample;
use super::{Field, MotionEncoding, Semantic, WarpMap};
use crate::space::{FrameSize, FrameWindow, ImagePoint};
use glam::DVec2;
use rayon::prelude::*;

/// Changes below this, in pixels, leave the vectors bit-exact. Maps are no more accurate than this.
const MIN_CHANGE: f64 = 5e-4;

/// Longer vectors, in pixels, are markers for unknown motion.
const MAX_LENGTH: f64 = 1e6;

/// Two channels that hold a vector, and their encoding.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotionVectors<'a> {
    /// #pixels of the source each.
    pub(super) uv: [&'a [f32]; 2],
    /// [`Semantic::Forward`] or [`Semantic::Backward`].
    pub(super) semantic: Semantic,
    /// Pixels per unit, x right, y up.
    pub(super) encoding: MotionEncoding,
}

/// Returns the warped vectors: #pixels of the composite each; 0 where nothing is visible.
pub(super) fn warped_motion(
    composite: &Composite,
    vectors: MotionVectors,
    (visible, moving_layers): (&[VisibleSample], &[MovingLayer]),
    frame: FrameSize,
) -> [Vec<f32>; 2] {
    let of_layer = |(index, layer)| {
        let window = composite.reach(index);
        Displacements::of(layer, vectors.semantic, FrameWindow { frame, window })
    };
    let displacements: Vec<Displacements> = moving_layers.iter().enumerate().map(of_layer).collect();
    let warped = |seen: &VisibleSample| -> (f32, f32) {
        match *seen {
            VisibleSample::Sample { layer, index } => {
                let index = index as usize;
                let displacements = &displacements[composite.layers[usize::from(layer)].moving_layer];
                vectors.warped(index, composite.source.pixel_at(index), displacements).into()
            }
            _ => (0.0, 0.0),
        }
    };
    visible.par_iter().with_min_len(BATCH / 16).map(warped).unzip().into()
}

/// Motion vectors of the fill plate.
pub(super) struct HoleVectors<'a> {
    pub(super) vectors: MotionVectors<'a>,
    /// Frame of the plate, and window of the vectors.
    pub(super) place: FrameWindow,
    /// The background layer, which moves them.
    pub(super) background: &'a MovingLayer<'a>,
}

/// Fills the holes of a composite with vectors, warped and converted to an encoding, that of the plate.
pub(super) fn fill_motion(
    composite: &Composite,
    behind: &HoleVectors,
    visible: &[VisibleSample],
    encoding: MotionEncoding,
    planes: &mut [Vec<f32>; 2],
) {
    if !visible.contains(&VisibleSample::Hole) {
        return;
    }
    let HoleVectors { vectors, place, background } = *behind;
    let displacements = Displacements::of(background, vectors.semantic, place);
    let factors = [0, 1].map(|axis| (vectors.encoding.pixels_per_unit[axis] / encoding.pixels_per_unit[axis]) as f32);
    let [us, vs] = planes;
    let pixels = us.par_iter_mut().zip(vs).zip(visible).enumerate();
    pixels.filter(|(_, (_, seen))| **seen == VisibleSample::Hole).for_each(|(at, ((u, v), _))| {
        let Some(pixel) = composite.background_source(at) else { return };
        let Some(index) = place.window.sample_index(pixel) else { return };
        let [x, y] = vectors.warped(index, pixel, &displacements);
        (*u, *v) = (x * factors[0], y * factors[1]);
    });
}

impl MotionVectors<'_> {
    fn warped(self, index: usize, [x, y]: [i32; 2], displacements: &Displacements) -> [f32; 2] {
        let stored = self.uv.map(|channel| channel[index]);
        let per_unit = DVec2::from_array(self.encoding.pixels_per_unit);
        let pixels = DVec2::new(f64::from(stored[0]), f64::from(stored[1])) * per_unit;
        if !pixels.is_finite() || pixels.length() > MAX_LENGTH {
            return stored;
        }
        let there = DVec2::new(f64::from(x) + 0.5 + pixels.x, f64::from(y) + 0.5 - pixels.y);
        let change = displacements.there(there) - displacements.here([x, y]);
        if !change.is_finite() || change.length() < MIN_CHANGE {
            return stored;
        }
        // Vectors have y up, maps y down.
        let warped = (pixels + DVec2::new(change.x, -change.y)) / per_unit;
        if warped.is_finite() { warped.as_vec2().to_array() } else { stored }
    }
}

/// Displacements of a moving layer in this frame and in the frame that the vectors point to, in pixels, y down.
///
/// Fields are evaluated once per pixel, by blocks; evaluating them per vector took three times as long as everything else.
struct Displacements<'a> {
    now: WarpMap,
    other: WarpMap,
    /// The field from which `other` was computed.
    field: &'a Field,
    direction: Direction,
}

impl<'a> Displacements<'a> {
    fn of(moving_layer: &'a MovingLayer, semantic: Semantic, FrameWindow { frame, window }: FrameWindow) -> Self {
        let field = if semantic == Semantic::Backward { &moving_layer.previous } else { &moving_layer.next };
        let [now, other] = [&moving_layer.now, field].map(|field| match moving_layer.direction {
            Direction::Forward => WarpMap::forward_alone(field, frame, window),
            Direction::Backward => WarpMap::backward(field, frame, window),
        });
        Self { now, other, field, direction: moving_layer.direction }
    }

    /// Returns the displacement in this frame at the centre of a pixel.
    fn here(&self, pixel: [i32; 2]) -> DVec2 {
        self.now.window.sample_index(pixel).map_or(DVec2::NAN, |index| offset(&self.now, index))
    }

    /// Returns the displacement in the other frame at any position: Catmull-Rom between pixels, evaluated from the
    /// field outside the picture and at the outline of surfaces.
    fn there(&self, at: DVec2) -> DVec2 {
        between(&self.other, at).filter(|offset| offset.is_finite()).unwrap_or_else(|| {
            let frame = self.other.frame;
            let from = frame.screen_from_image(ImagePoint(at));
            let goes = match self.direction {
                Direction::Forward => Some(self.field.carry(from)),
                Direction::Backward => self.field.inverse(from, from),
            };
            goes.map_or(DVec2::NAN, |goes| frame.image_from_screen(goes).0 - at)
        })
    }
}

/// Interpolates the offset of a map at a position; `None` unless all surrounding pixels are known.
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

/// Returns the Catmull-Rom weights of four neighbours at `t` between the second and the third (Keys 1981, a = -1/2).
fn catmull_rom(t: f64) -> [f64; 4] {
    let (a, b) = (t * t, t * t * t);
    [-0.5 * t + a - 0.5 * b, 1.0 - 2.5 * a + 1.5 * b, 0.5 * t + 2.0 * a - 1.5 * b, 0.5 * (b - a)]
}
