//! Four edge sets at a time: their points and rotations in vector registers, one set per lane.
//!
//! In: indices of points and sets. Out: one register per coordinate or matrix entry; best rotations of four sets.

use crate::solve::linalg::simd::{LANES, Lanes, add_multiple, load, multiply_add, store};
use crate::solve::linalg::small_matrix::{SquareMatrix, best_rotation};
use pulp::Simd;

/// Indices of four vertices or sets.
pub(super) type Ids = [u32; LANES];

/// Returns the first slot of every group of four sets, and the end of the last group. A group has as many slots as its largest
/// set has edges, given in `sizes`.
pub(super) fn slot_starts(sizes: &[usize]) -> Vec<usize> {
    let ends = sizes.chunks(LANES).scan(0, |end, sizes| {
        *end += sizes.iter().copied().max().unwrap_or(0);
        Some(*end)
    });
    std::iter::once(0).chain(ends).collect()
}

/// Adds the outer products edge (to − from)ᵀ to the sums of four sets, and returns ‖to − from‖².
#[inline(always)]
pub(super) fn add_edge<S: Simd, const D: usize>(
    simd: S,
    edge: &[Lanes; D],
    [from, mut to]: [[S::f64s; D]; 2],
    sums: &mut [[S::f64s; D]; D],
) -> S::f64s {
    let mut square = simd.splat_f64s(0.0);
    for (now, from) in to.iter_mut().zip(from) {
        *now = simd.sub_f64s(*now, from);
        square = multiply_add(simd, *now, *now, square);
    }
    for (sums, edge) in sums.iter_mut().zip(edge) {
        add_multiple(simd, load::<S>(edge), &to, sums);
    }
    square
}

/// Loads four points, one register per coordinate.
#[inline(always)]
pub(super) fn points_of<S: Simd, const D: usize>(simd: S, points: &[[f64; D]], ids: &Ids) -> [S::f64s; D] {
    let mut lanes = [[0.0; LANES]; D];
    for lane in 0..LANES {
        let point = &points[ids[lane] as usize];
        for d in 0..D {
            lanes[d][lane] = point[d];
        }
    }
    let mut registers = [simd.splat_f64s(0.0); D];
    for d in 0..D {
        registers[d] = load::<S>(&lanes[d]);
    }
    registers
}

/// Loads four rotations, one register per matrix entry.
#[inline(always)]
pub(super) fn rotations_of<S: Simd, const D: usize>(
    simd: S,
    rotations: &[SquareMatrix<D>],
    ids: &Ids,
) -> [[S::f64s; D]; D] {
    let mut rows = [[simd.splat_f64s(0.0); D]; D];
    // In 2D the second row follows from the first.
    for (row, registers) in rows.iter_mut().enumerate().take(if D == 2 { 1 } else { D }) {
        let mut lanes = [[0.0; LANES]; D];
        for lane in 0..LANES {
            let rotation = &rotations[ids[lane] as usize];
            (0..D).for_each(|column| lanes[column][lane] = rotation[row][column]);
        }
        for (register, lanes) in registers.iter_mut().zip(&lanes) {
            *register = load::<S>(lanes);
        }
    }
    if D == 2 {
        (rows[1][0], rows[1][1]) = (simd.neg_f64s(rows[0][1]), rows[0][0]);
    }
    rows
}

/// Finds the rotations R that maximise tr(R S) for four matrices S, and returns the sum of these traces.
#[inline(always)]
pub(super) fn best_rotations<S: Simd, const D: usize>(
    simd: S,
    sums: &[[S::f64s; D]; D],
    rotations: &mut [SquareMatrix<D>],
) -> f64 {
    if D == 2 {
        return rotate_in_plane(simd, sums, rotations);
    }
    let mut lanes = [[[0.0; LANES]; D]; D];
    for a in 0..D {
        for b in 0..D {
            lanes[a][b] = store::<S>(sums[a][b]);
        }
    }
    let mut gain = 0.0;
    for (lane, rotation) in rotations.iter_mut().enumerate() {
        let matrix = lanes.map(|row| row.map(|entry| entry[lane]));
        *rotation = best_rotation(&matrix);
        gain += (0..D).map(|a| (0..D).map(|b| rotation[a][b] * matrix[b][a]).sum::<f64>()).sum::<f64>();
    }
    gain
}

/// [`best_rotation`] in 2D: the angle is atan2(Σ w e × e', Σ w e · e'), the trace is the length of that vector.
#[inline(always)]
fn rotate_in_plane<S: Simd, const D: usize>(
    simd: S,
    sums: &[[S::f64s; D]; D],
    rotations: &mut [SquareMatrix<D>],
) -> f64 {
    let along = simd.add_f64s(sums[0][0], sums[1][1]);
    let across = simd.sub_f64s(sums[0][1], sums[1][0]);
    let length = simd.sqrt_f64s(multiply_add(simd, along, along, simd.mul_f64s(across, across)));
    let lengths = store::<S>(length);
    let (cos, sin) = (store::<S>(simd.div_f64s(along, length)), store::<S>(simd.div_f64s(across, length)));
    let mut gain = 0.0;
    for (lane, rotation) in rotations.iter_mut().enumerate() {
        let is_known = lengths[lane] > 0.0 && lengths[lane].is_finite();
        let (cos, sin) = if is_known { (cos[lane], sin[lane]) } else { (1.0, 0.0) };
        (rotation[0][0], rotation[0][1], rotation[1][0], rotation[1][1]) = (cos, -sin, sin, cos);
        gain += lengths[lane];
    }
    gain
}
