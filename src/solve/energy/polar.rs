//! Nearest rotations of four 3D gradients at once.
//!
//! In: four 3 × 3 gradients, one per lane. Out: their nearest rotations. N. J. Higham, "Computing the Polar Decomposition—with
//! Applications", 1986: Newton's iteration X ← ½ (γ X + X⁻ᵀ/γ), which converges to the rotation of a gradient with a positive
//! determinant. Gradients with a determinant that is negative or near zero are left to [`nearest_rotation`].

use crate::solve::linalg::simd::{LANES, Lanes, lane_of, load, multiply_add, store};
use crate::solve::linalg::small_matrix::{SquareMatrix, determinant, identity, nearest_rotation};
use pulp::Simd;

/// Smallest determinant, relative to the cube of the Frobenius norm, for which the iteration is used; it then needs at most seven
/// steps.
const MIN_DET: f64 = 1e-4;

/// Maximum number of steps.
const STEPS: usize = 12;

/// The iteration ends when the squared length of a step is below this. As convergence is quadratic, only rounding errors remain.
const SETTLED: f64 = 1e-17;

/// Four matrices, one per lane.
pub(super) type LaneMatrix<S, const D: usize> = [[<S as Simd>::f64s; D]; D];

/// Returns the rotations nearest to four 3D gradients.
#[inline(always)]
pub(super) fn nearest_rotations<S: Simd, const D: usize>(simd: S, gradients: &LaneMatrix<S, D>) -> LaneMatrix<S, D> {
    let given = gradients.map(|row| row.map(|x| store::<S>(x)));
    let mut start = given;
    let mut others = [None; LANES];
    for (lane, other) in others.iter_mut().enumerate() {
        let gradient = lane_of(&given, lane);
        let square: f64 = gradient.iter().flatten().map(|x| x * x).sum();
        if determinant(&gradient) <= MIN_DET * square * square.sqrt() || !square.is_finite() {
            *other = Some(nearest_rotation(&gradient));
            set_lane(&mut start, lane, &identity());
        }
    }
    let mut x = start.map(|row| row.map(|lanes| load::<S>(&lanes)));
    for _ in 0..STEPS {
        let next = step(simd, &x);
        let zero = simd.splat_f64s(0.0);
        let mut change = zero;
        for (a, b) in next.iter().flatten().zip(x.iter().flatten()) {
            let gap = simd.sub_f64s(*a, *b);
            change = multiply_add(simd, gap, gap, change);
        }
        x = next;
        if store::<S>(change).iter().all(|&change| change <= SETTLED) {
            break;
        }
    }
    if others.iter().all(Option::is_none) {
        return x;
    }
    let mut rotations = x.map(|row| row.map(|x| store::<S>(x)));
    for (lane, other) in others.iter().enumerate() {
        if let Some(rotation) = other {
            set_lane(&mut rotations, lane, rotation);
        }
    }
    rotations.map(|row| row.map(|lanes| load::<S>(&lanes)))
}

/// Takes a step of the iteration: ½ (γ X + X⁻ᵀ/γ), γ² = ‖X⁻¹‖/‖X‖.
#[inline(always)]
fn step<S: Simd, const D: usize>(simd: S, x: &LaneMatrix<S, D>) -> LaneMatrix<S, D> {
    let (cofactors, det) = cofactors(simd, x);
    let square =
        |m: &LaneMatrix<S, D>| m.iter().flatten().fold(simd.splat_f64s(0.0), |sum, &x| multiply_add(simd, x, x, sum));
    // ‖X⁻¹‖²/‖X‖² = ‖cof X‖²/(det² ‖X‖²).
    let share = simd.div_f64s(square(&cofactors), simd.mul_f64s(simd.mul_f64s(det, det), square(x)));
    let scale = simd.sqrt_f64s(simd.sqrt_f64s(share));
    let half = simd.splat_f64s(0.5);
    let own = simd.mul_f64s(half, scale);
    let other = simd.div_f64s(half, simd.mul_f64s(scale, det));
    let mut next = *x;
    for (slots, cofactors) in next.iter_mut().zip(&cofactors) {
        for (slot, &cofactor) in slots.iter_mut().zip(cofactors) {
            *slot = multiply_add(simd, own, *slot, simd.mul_f64s(other, cofactor));
        }
    }
    next
}

/// Returns the cofactors and determinants of four 3 × 3 matrices; X⁻ᵀ = cof X/det X.
#[inline(always)]
pub(super) fn cofactors<S: Simd, const D: usize>(simd: S, x: &LaneMatrix<S, D>) -> (LaneMatrix<S, D>, S::f64s) {
    let mut cofactors = *x;
    for (row, slots) in cofactors.iter_mut().enumerate() {
        let (next, last) = (&x[(row + 1) % 3], &x[(row + 2) % 3]);
        for (column, slot) in slots.iter_mut().enumerate() {
            let (a, b) = ((column + 1) % 3, (column + 2) % 3);
            *slot = simd.sub_f64s(simd.mul_f64s(next[a], last[b]), simd.mul_f64s(next[b], last[a]));
        }
    }
    let first = x[0].iter().zip(&cofactors[0]);
    let det = first.fold(simd.splat_f64s(0.0), |sum, (&x, &cofactor)| multiply_add(simd, x, cofactor, sum));
    (cofactors, det)
}

fn set_lane<const D: usize>(values: &mut [[Lanes; D]; D], lane: usize, matrix: &SquareMatrix<D>) {
    for (slots, row) in values.iter_mut().zip(matrix) {
        slots.iter_mut().zip(row).for_each(|(slot, &x)| slot[lane] = x);
    }
}
