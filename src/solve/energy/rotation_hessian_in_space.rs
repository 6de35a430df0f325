//! The rotation Hessian of energy `area` in 3D as a matrix, for the factorisations of the barrier.
//!
//! In: ∇W at the samples, handles. Out: the matrix of all coordinates minus three rank-one terms per sample. With R and M as in
//! [`super::rotation_response`], the second derivative of ‖J − R‖² is 2 ‖dJ‖² − 2 axial · M⁻¹ axial, axial = axial(RᵀdJ).

use super::Area;
use super::distortion::RotationHessian;
use super::rotation_response::SampleResponse;
use crate::simd::dispatch;
use crate::solve::blocked_weights::Block;
use crate::solve::cancel::Cancel;
use crate::solve::linalg::gram_matrix::{GramMatrix, Sum};
use crate::solve::linalg::normal_matrix::NormalMatrix;
use crate::solve::linalg::simd::{LANES, Lanes, lane_of};
use crate::solve::linalg::small_matrix::SquareMatrix;
use rayon::prelude::*;

/// Number of blocks whose terms are computed in parallel between two polls of the cancellation hook.
const ROUND: usize = 16;

impl<const D: usize> Area<D> {
    /// Subtracts the rank-one terms of all samples; the row of a coordinate is D·handle + coordinate.
    pub(super) fn subtract_rotation_hessian_in_space(
        &self,
        handles: &[[f64; D]],
        hessian: RotationHessian,
        normal: &mut NormalMatrix,
        cancel: &Cancel,
    ) {
        let at_samples = self.gradients.gradients_at(handles);
        for round in self.gradients.blocks.chunks(ROUND) {
            if cancel.is_requested() {
                return;
            }
            let of_block = |block: &Block| self.rotation_terms(block, &at_samples, hessian.limit);
            let terms: Vec<GramMatrix> = round.par_iter().map(of_block).collect();
            for (block, gram) in round.iter().zip(&terms) {
                let rows = block.handles.iter().flat_map(|&handle| (0..D).map(move |d| D * handle + d));
                normal.add_gram(-2.0 * hessian.scale, &rows.collect::<Vec<usize>>(), gram);
            }
        }
    }

    /// Returns the sum of the rank-one terms of the samples in a block, over the coordinates of its handles.
    fn rotation_terms(&self, block: &Block, at_samples: &[[[Lanes; D]; D]], limit: f64) -> GramMatrix {
        let mut gram = GramMatrix::default();
        gram.clear(D * block.handles.len());
        for packet in block.packets.clone() {
            let coefficients = self.gradients.packet(block, packet);
            for lane in (0..LANES).filter(|&lane| self.areas[packet][lane] > 0.0) {
                let response = SampleResponse::at(&lane_of(&at_samples[packet], lane), limit);
                let squares = response.squares(self.areas[packet][lane]);
                squares.iter().for_each(|square| write_row(gram.push(), square, (coefficients, lane)));
            }
        }
        dispatch(Sum(&mut gram));
        gram
    }
}

/// Writes one rank-one term as a row over the coordinates of the handles of a block, for the sample in the given lane of
/// `coefficients`.
fn write_row<const D: usize>(row: &mut [f64], square: &SquareMatrix<D>, (coefficients, lane): (&[[Lanes; D]], usize)) {
    for (slots, lanes) in row.chunks_exact_mut(D).zip(coefficients) {
        let along = lanes.map(|x| x[lane]);
        slots.iter_mut().zip(square).for_each(|(slot, row)| *slot = row.iter().zip(&along).map(|(x, y)| x * y).sum());
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Distortion, ScaledDirection};
    use super::*;
    use crate::lattice::{Basis, Grid};
    use crate::solve::samples::Sample;

    #[test]
    fn the_matrix_gives_the_products_of_directions() {
        let grid = Grid { dims: [5, 4, 4], basis: Basis::Bspline, lo: [0.0; 3], hi: [1.0, 0.8, 0.6], angle: 0.0 };
        let wave = |k: usize| (12.9898 * k as f64).sin();
        let at = |k: usize| std::array::from_fn(|d| grid.hi[d] * (0.5 + 0.45 * wave(3 * k + d)));
        let samples: Vec<Sample<3>> =
            (0..30).map(|k| Sample { at: at(k), area: 1.0 + 0.5 * wave(k), stiffness: 1.0 }).collect();
        let never = Cancel::never();
        let area = Area::new(&grid, &samples, &never);
        let mut handles = grid.rest_handles();
        handles.iter_mut().enumerate().for_each(|(k, x)| (0..3).for_each(|d| x[d] += 0.06 * wave(7 * k + d)));
        let along: Vec<[f64; 3]> =
            (0..handles.len()).map(|k| std::array::from_fn(|d| wave(11 * k + 5 * d + 1))).collect();
        for limit in [f64::INFINITY, 0.75, 0.5] {
            let mut normal = NormalMatrix::zero(3 * handles.len(), 3 * handles.len() - 1);
            let hessian = RotationHessian { scale: 1.7, limit };
            area.subtract_rotation_hessian_in_space(&handles, hessian, &mut normal, &never);
            let mut found = vec![[0.0; 3]; handles.len()];
            let flat = along.as_flattened().as_chunks::<1>().0;
            normal.subtract_matvec(flat, found.as_flattened_mut().as_chunks_mut::<1>().0);
            let response = area.rotation_response(&handles, limit).expect("of space");
            let mut wanted = vec![[0.0; 3]; handles.len()];
            let scaled = ScaledDirection { direction: &along, scale: 1.7 };
            area.subtract_rotation_product(&response, scaled, &mut wanted, &never);
            for (found, wanted) in found.as_flattened().iter().zip(wanted.as_flattened()) {
                assert!((found + wanted).abs() < 1e-9, "{limit}: {found} {wanted}");
            }
            assert!(wanted.as_flattened().iter().any(|x| x.abs() > 1.0));
        }
    }
}
