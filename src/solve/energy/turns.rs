//! What rotations that follow take off the second derivative of energy `area` in the plane: a square a sample.
//!
//! In: gradients of samples, handles. Out: Gram blocks taken off the matrix of all coordinates.
//! With along = J00 + J11, across = J10 − J01 and ρ = ‖(along, across)‖ = s1 + s2, R turns by
//! dθ = (cos·d across − sin·d along)/ρ, and the second derivative of ‖J − R‖² is 2‖dJ‖² − 2ρ dθ².

use super::Turns;
use crate::solve::gram::Gram;
use crate::solve::matrix::Normal;
use crate::solve::packs::{LANES, Lanes, Packs, gather, load, local_handles, multiply_add, store};
use crate::solve::small::Square;
use pulp::{Simd, WithSimd};

/// Sine and cosine of the turn nearest to a plane gradient, over √ρ; 1/ρ is at most `limit`.
pub(super) fn turn<const D: usize>(gradient: &Square<D>, limit: f64) -> [f64; 2] {
    let (along, across) = (gradient[0][0] + gradient[1][1], gradient[1][0] - gradient[0][1]);
    let spread = (along * along + across * across).sqrt();
    // Without a direction there is nothing that could turn.
    let inverse = if spread > 0.0 { 1.0 / spread } else { 0.0 };
    let factor = inverse * inverse.min(limit).sqrt();
    [across * factor, along * factor]
}

/// What a handle with gradient (x, y) adds to √ρ·dθ, a coordinate of it each.
#[inline(always)]
pub(super) fn turned_row([sin, cos]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    [-sin * x - cos * y, cos * x - sin * y]
}

/// Kernel that takes the squares of all samples off the matrix.
pub(super) struct SubtractTurns<'a, const D: usize> {
    pub(super) gradients: &'a Packs<D>,
    /// Area times stiffness of each lane's sample.
    pub(super) areas: &'a [Lanes],
    pub(super) handles: &'a [[f64; D]],
    pub(super) turns: Turns,
    pub(super) normal: &'a mut Normal,
}

impl<const D: usize> WithSimd for SubtractTurns<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { gradients, areas, handles, turns, normal } = self;
        let (mut gram, mut local, mut rows) = (Gram::default(), Vec::new(), Vec::new());
        for block in &gradients.blocks {
            local_handles(block, handles, &mut local);
            rows.clear();
            rows.extend(block.handles.iter().flat_map(|&handle| [2 * handle, 2 * handle + 1]));
            gram.clear(rows.len());
            for (coefficients, areas) in gradients.packs(block).zip(&areas[block.packs.clone()]) {
                let values = gather(simd, coefficients, &local);
                let turn = turn_lanes(simd, &values, (load::<S>(areas), turns.limit));
                push_rows(simd, coefficients, turn, gram.push_pack());
            }
            gram.sum(simd);
            normal.add_gram(-2.0 * turns.scale, &rows, &gram);
        }
    }
}

/// [`turn`] for four samples, times the roots of their areas.
#[inline(always)]
fn turn_lanes<S: Simd, const D: usize>(
    simd: S,
    gradient: &[[S::f64s; D]; D],
    (areas, limit): (S::f64s, f64),
) -> [S::f64s; 2] {
    let along = simd.add_f64s(gradient[0][0], gradient[1][1]);
    let across = simd.sub_f64s(gradient[1][0], gradient[0][1]);
    let square = multiply_add(simd, along, along, simd.mul_f64s(across, across));
    let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
    let inverse = simd.div_f64s(one, simd.sqrt_f64s(square));
    let inverse = simd.select_f64s(simd.greater_than_f64s(square, zero), inverse, zero);
    let limit = simd.splat_f64s(limit);
    let limited = simd.select_f64s(simd.greater_than_f64s(inverse, limit), limit, inverse);
    let factor = simd.mul_f64s(inverse, simd.sqrt_f64s(simd.mul_f64s(limited, areas)));
    [simd.mul_f64s(across, factor), simd.mul_f64s(along, factor)]
}

/// [`turned_row`] of all handles for four samples: one row each.
#[inline(always)]
fn push_rows<S: Simd, const D: usize>(
    simd: S,
    coefficients: &[[Lanes; D]],
    [sin, cos]: [S::f64s; 2],
    rows: [&mut [f64]; LANES],
) {
    let mut rows = rows.map(|row| row.as_chunks_mut::<2>().0.iter_mut());
    for handle in coefficients {
        let [x, y] = [load::<S>(&handle[0]), load::<S>(&handle[1])];
        let first = store::<S>(simd.neg_f64s(multiply_add(simd, sin, x, simd.mul_f64s(cos, y))));
        let second = store::<S>(multiply_add(simd, cos, x, simd.neg_f64s(simd.mul_f64s(sin, y))));
        for (lane, row) in rows.iter_mut().enumerate() {
            if let Some(slots) = row.next() {
                *slots = [first[lane], second[lane]];
            }
        }
    }
}
