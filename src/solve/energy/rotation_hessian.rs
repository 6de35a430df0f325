//! The rotation Hessian of energy `area` in 2D: because the best rotations follow the handles, the second derivative is smaller
//! than the constant matrix, by one rank-one term per sample.
//!
//! In: ∇W at the samples, handles. Out: the matrix of all coordinates minus these terms.
//! With along = J00 + J11, across = J10 − J01 and ρ = ‖(along, across)‖ = s1 + s2, the rotation R changes by
//! dθ = (cos·d across − sin·d along)/ρ, and the second derivative of ‖J − R‖² is 2‖dJ‖² − 2ρ dθ².

use super::distortion::RotationHessian;
use crate::solve::blocked_weights::{Block, BlockedWeights, gather, local_handles};
use crate::solve::cancel::Cancel;
use crate::solve::linalg::gram_matrix::GramMatrix;
use crate::solve::linalg::normal_matrix::NormalMatrix;
use crate::solve::linalg::simd::{LANES, Lanes, load, multiply_add, store};
use crate::solve::linalg::small_matrix::SquareMatrix;
use crate::solve::linalg::syrk::SyrkRows;
use pulp::{Simd, WithSimd};

/// Returns the sine and cosine of the rotation nearest to a 2D gradient, both divided by √ρ, with 1/ρ limited to `limit`.
pub(super) fn rotation_differential<const D: usize>(gradient: &SquareMatrix<D>, limit: f64) -> [f64; 2] {
    let (along, across) = (gradient[0][0] + gradient[1][1], gradient[1][0] - gradient[0][1]);
    let spread = (along * along + across * across).sqrt();
    // A zero vector has no rotation.
    let inverse = if spread > 0.0 { 1.0 / spread } else { 0.0 };
    let factor = inverse * inverse.min(limit).sqrt();
    [across * factor, along * factor]
}

/// Returns the coefficients of √ρ·dθ for the two coordinates of a handle whose ∇W is (x, y).
#[inline(always)]
pub(super) fn differential_row([sin, cos]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    [-sin * x - cos * y, cos * x - sin * y]
}

/// Kernel that subtracts the rank-one terms of all samples from the matrix.
pub(super) struct SubtractRotationHessian<'a, const D: usize> {
    pub(super) gradients: &'a BlockedWeights<D>,
    /// Area times stiffness of the sample in each lane.
    pub(super) areas: &'a [Lanes],
    pub(super) handles: &'a [[f64; D]],
    pub(super) hessian: RotationHessian,
    pub(super) normal: &'a mut NormalMatrix,
    pub(super) cancel: &'a Cancel<'a>,
}

impl<const D: usize> WithSimd for SubtractRotationHessian<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { gradients, areas, handles, hessian, normal, cancel } = self;
        let mut meter = cancel.meter();
        let (mut gram, mut local, mut rows) = (GramMatrix::default(), Vec::new(), Vec::new());
        for block in &gradients.blocks {
            local_handles(block, handles, &mut local);
            rows.clear();
            rows.extend(block.handles.iter().flat_map(|&handle| [2 * handle, 2 * handle + 1]));
            if normal.is_full(rows.len()) {
                let differential = |(coefficients, areas)| {
                    let values = gather(simd, coefficients, &local);
                    let [sin, cos] = rotation_differential_lanes(simd, &values, (load::<S>(areas), hessian.limit));
                    [store::<S>(sin), store::<S>(cos)]
                };
                let packets = gradients.packets(block).zip(&areas[block.packets.clone()]);
                let differentials = packets.map(differential).collect();
                normal.add_syrk(
                    -2.0 * hessian.scale,
                    &mut DifferentialRows { gradients, block, differentials },
                    cancel,
                );
                continue;
            }
            if meter.count_and_poll(LANES * block.packets.len() * rows.len() * rows.len() / 2) {
                return;
            }
            gram.clear(rows.len());
            for (coefficients, areas) in gradients.packets(block).zip(&areas[block.packets.clone()]) {
                let values = gather(simd, coefficients, &local);
                let differential = rotation_differential_lanes(simd, &values, (load::<S>(areas), hessian.limit));
                push_rows(simd, coefficients, differential, gram.push_packet());
            }
            gram.sum(simd);
            normal.add_gram(-2.0 * hessian.scale, &rows, &gram);
        }
    }
}

/// [`differential_row`] of every handle for each sample, as both factors of the product, for bases of global support.
struct DifferentialRows<'a, const D: usize> {
    gradients: &'a BlockedWeights<D>,
    block: &'a Block,
    /// Sine and cosine per packet, see [`rotation_differential_lanes`].
    differentials: Vec<[Lanes; 2]>,
}

impl<const D: usize> SyrkRows for DifferentialRows<'_, D> {
    fn count(&self) -> usize {
        self.differentials.len() * LANES
    }

    #[inline(always)]
    fn write<S: Simd>(&mut self, _: S, row: usize, [a, b]: [&mut [f64]; 2]) {
        let (packet, lane) = (row / LANES, row % LANES);
        let differential = self.differentials[packet].map(|lanes| lanes[lane]);
        let coefficients = self.gradients.packet(self.block, self.block.packets.start + packet);
        for (slots, handle) in a.as_chunks_mut::<2>().0.iter_mut().zip(coefficients) {
            *slots = differential_row(differential, [handle[0][lane], handle[1][lane]]);
        }
        b.copy_from_slice(a);
    }
}

/// [`rotation_differential`] for four samples, multiplied by the square roots of their areas.
#[inline(always)]
fn rotation_differential_lanes<S: Simd, const D: usize>(
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

/// Writes [`differential_row`] of every handle for four samples, one row per sample.
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
