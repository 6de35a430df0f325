//! The footprint of an output pixel in the source: the amount and direction in which the warp minifies.
//!
//! In: the offsets around a pixel. Out: the linear map from source distances to filter distances. A round pixel becomes an
//! ellipse (P. Heckbert, "Fundamentals of Texture Mapping and Image Warping", 1989, chapter 3).

use super::simd::LANES;
use crate::plate::WarpMap;

/// Greatest minification that is fully filtered; the footprint is at most 4 times (on diagonals 4.9 times) as many samples wide.
const SHRINK_LIMIT: f32 = 16.0;
/// Minification up to this factor is ignored, so that rounding of maps does not widen the filter.
const MIN_MINIFICATION: f32 = 1.02;

/// Offsets that change by less than this per pixel are on one surface, and so are those whose change differs by less than this fraction
/// of the next one. At a tear, where one surface ends over another, the offset changes by any amount.
const TEAR: f32 = 0.5;

/// The linear map from source distances to filter distances.
///
/// The ellipse of a pixel is J Jᵀ, with J = d source / d output. Its axes are clamped to 1 or more, so that magnified samples are
/// interpolated, not blurred: H = max(1, √(J Jᵀ)) by eigenvalues, and the filter is evaluated at H⁻¹ (source − position). H = 1 for
/// rotation, translation and magnification.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Footprint {
    /// H⁻¹: xx, xy = yx, yy.
    pub(super) filter_from_source: [f32; 3],
    /// Half extents along x and y, in the source, of the filter's square of "radius" 1.
    pub(super) half_extent: [f32; 2],
}

impl Footprint {
    /// No minification.
    pub(super) const UNIT: Self = Self { filter_from_source: [1.0, 0.0, 1.0], half_extent: [1.0, 1.0] };

    /// Whether the unwidened filter applies.
    #[inline(always)]
    pub(super) fn is_unit(&self) -> bool {
        self.half_extent == Self::UNIT.half_extent
    }

    /// Computes the footprint of a pixel of the map.
    #[inline(always)]
    pub(super) fn at(map: &WarpMap, column: usize, row: usize) -> Self {
        let (width, height) = (map.window.width as usize, map.window.height as usize);
        let index = row * width + column;
        let across = steepness(&map.offsets, index, 1, (column, width));
        let down = steepness(&map.offsets, index, width, (row, height));
        Self::of_jacobian(jacobian(across, down))
    }

    /// Computes the footprints of adjacent pixels, none of them at the border of the map.
    #[inline(always)]
    pub(super) fn of_inner(map: &WarpMap, column: usize, row: usize) -> [Self; LANES] {
        let width = map.window.width as usize;
        let index = row * width + column;
        let step = |k: usize, stride: usize| {
            let here = map.offsets[index + k];
            let before = difference(here, map.offsets[index + k - stride]);
            smaller(before, difference(map.offsets[index + k + stride], here))
        };
        // Minification is tested for all pixels at once, in SIMD registers; few footprints then remain to be computed.
        let steps: [_; LANES] = std::array::from_fn(|k| [step(k, 1), step(k, width)]);
        let longest = steps.map(|[across, down]| Ellipse::of_jacobian(jacobian(across, down)).longest());
        std::array::from_fn(|k| {
            let [across, down] = steps[k];
            if is_steep(across) | is_steep(down) {
                Self::at(map, column + k, row)
            } else if shrinks(longest[k]) {
                Self::of_jacobian(jacobian(across, down))
            } else {
                Self::UNIT
            }
        })
    }

    /// Computes the footprint for J in row-major order.
    #[inline(always)]
    fn of_jacobian(jacobian: [f32; 4]) -> Self {
        let ellipse = Ellipse::of_jacobian(jacobian);
        let longest = ellipse.longest();
        if !shrinks(longest) {
            return Self::UNIT;
        }
        let Ellipse { mean, half, b, radius } = ellipse;
        let (long, short) = (clamped_scale(longest), clamped_scale(mean - radius));
        // The unit matrix and the traceless part of J Jᵀ, scaled to eigenvalues ±1, span all functions of J Jᵀ.
        let scale = if radius > 0.0 { 1.0 / radius } else { 0.0 };
        let (along, aside) = (half * scale, b * scale);
        let (p, q) = (0.5 * (1.0 / long + 1.0 / short), 0.5 * (1.0 / long - 1.0 / short));
        let (s, t) = (0.5 * (long + short), 0.5 * (long - short));
        let corner = (t * aside).abs();
        Self {
            filter_from_source: [p + q * along, q * aside, p - q * along],
            half_extent: [s + t * along + corner, s - t * along + corner],
        }
    }
}

/// The eigenvalues of J Jᵀ, mean ± radius.
#[derive(Clone, Copy)]
struct Ellipse {
    mean: f32,
    /// Half the difference of the elements xx and yy.
    half: f32,
    /// The element xy.
    b: f32,
    radius: f32,
}

impl Ellipse {
    /// Computes J Jᵀ from J in row-major order.
    #[inline(always)]
    fn of_jacobian([xx, xy, yx, yy]: [f32; 4]) -> Self {
        let (a, b, c) = (xx * xx + xy * xy, xx * yx + xy * yy, yx * yx + yy * yy);
        let (mean, half) = (0.5 * (a + c), 0.5 * (a - c));
        Self { mean, half, b, radius: (half * half + b * b).sqrt() }
    }

    #[inline(always)]
    fn longest(self) -> f32 {
        self.mean + self.radius
    }
}

/// Returns J, row-major, from the changes of the offsets to the right and down.
#[inline(always)]
fn jacobian(across: [f32; 2], down: [f32; 2]) -> [f32; 4] {
    [1.0 + across[0], down[0], across[1], 1.0 + down[1]]
}

/// Whether the larger eigenvalue of J Jᵀ widens the footprint.
#[inline(always)]
fn shrinks(longest: f32) -> bool {
    longest > MIN_MINIFICATION * MIN_MINIFICATION && longest < f32::INFINITY
}

/// Returns a clamped half axis of the footprint from an eigenvalue of J Jᵀ.
#[inline(always)]
fn clamped_scale(squared: f32) -> f32 {
    (squared.max(0.0).sqrt() / MIN_MINIFICATION).clamp(1.0, SHRINK_LIMIT)
}

/// Returns the change of the offset per pixel along an axis: the smaller of the differences on both sides, since the
/// other may cross a fold or a hole. Where both cross one, as on the last pixels of a thin part, or if there is none, it is 0. At the
/// border of the map the next difference stands for the missing one.
/// `stride`: to the next of `count` pixels, `place`: of this pixel among them.
///
/// [`WarpMap::jacobian`] differs: it takes the mean of both sides where they agree, as a derivative should. A footprint takes the
/// smaller side everywhere, since too wide a filter blurs, and compares nothing where the smaller side is not steep, which is nearly
/// everywhere.
#[inline(always)]
fn steepness(offsets: &[[f32; 2]], index: usize, stride: usize, (place, count): (usize, usize)) -> [f32; 2] {
    let step = |from: usize| difference(offsets[from + stride], offsets[from]);
    let before = match (place, count) {
        (1.., _) => step(index - stride),
        (0, 3..) => step(index + stride),
        (0, _) => [f32::NAN; 2],
    };
    let after = match count - place {
        2.. => step(index),
        _ if place >= 2 => step(index - 2 * stride),
        _ => [f32::NAN; 2],
    };
    let least = smaller(before, after);
    if !is_steep(least) {
        return least;
    }
    let [before_next, after_next] = [
        if place >= 2 { step(index - 2 * stride) } else { [f32::NAN; 2] },
        if count - place >= 3 { step(index + stride) } else { [f32::NAN; 2] },
    ];
    let on_surface = |by: [f32; 2], next: [f32; 2]| if is_torn(by, next) { [f32::NAN; 2] } else { by };
    smaller(on_surface(before, before_next), on_surface(after, after_next))
}

/// Whether a change of the offset per pixel may be that across a tear.
#[inline(always)]
fn is_steep([x, y]: [f32; 2]) -> bool {
    x * x + y * y > TEAR * TEAR
}

/// Whether a steep change of the offset per pixel is that across a tear, given the next change on the same side.
#[inline(always)]
fn is_torn(by: [f32; 2], next: [f32; 2]) -> bool {
    let square = |[x, y]: [f32; 2]| x * x + y * y;
    square(by) > TEAR * TEAR && square(difference(by, next)) > TEAR * TEAR * square(next).max(1.0)
}

/// Returns the smaller difference; the other if one is NaN, 0 if both are.
#[inline(always)]
fn smaller(before: [f32; 2], after: [f32; 2]) -> [f32; 2] {
    let first = before[0] * before[0] + before[1] * before[1];
    let second = after[0] * after[0] + after[1] * after[1];
    let is_before = second.is_nan() | (first <= second);
    let is_nothing = first.is_nan() & second.is_nan();
    [0, 1].map(|axis| {
        let step = if is_before { before[axis] } else { after[axis] };
        if is_nothing { 0.0 } else { step }
    })
}

#[inline(always)]
fn difference(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0] - b[0], a[1] - b[1]]
}
