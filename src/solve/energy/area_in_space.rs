//! Energy `area` in 3D: rotations of four samples at once, and products of the second derivative with directions.
//!
//! In: ∇W at the samples, handles, directions of the handles. Out: weighted rotations, their responses, products.

use super::area::Area;
use super::distortion::ScaledDirection;
use super::polar::{LaneMatrix, nearest_rotations};
use super::rotation_response::{PacketResponse, RotationResponse};
use crate::simd::dispatch;
use crate::solve::blocked_weights::{Block, BlockValues, gather, gather_group, local_handles};
use crate::solve::cancel::Cancel;
use crate::solve::linalg::simd::{LANES, Lanes, load, multiply_add, store};
use pulp::{Simd, WithSimd};
use rayon::prelude::*;

/// Number of tasks between two polls of the cancellation hook.
const ROUND: usize = 16;

/// Transform that a pass applies to the gradients of a packet of four samples.
trait Transform<const D: usize>: Sync {
    /// Replaces the gradients; returns one energy per sample.
    fn apply<S: Simd>(&self, simd: S, packet: usize, gradients: &mut LaneMatrix<S, D>) -> S::f64s;
}

/// Transform of gradients into their nearest rotations.
struct Rotations;

impl<const D: usize> Transform<D> for Rotations {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, _: usize, gradients: &mut LaneMatrix<S, D>) -> S::f64s {
        let rotations = nearest_rotations(simd, gradients);
        let mut energy = simd.splat_f64s(0.0);
        for (row, wanted) in gradients.iter_mut().zip(&rotations) {
            for (x, &wanted) in row.iter_mut().zip(wanted) {
                let residual = simd.sub_f64s(*x, wanted);
                energy = multiply_add(simd, residual, residual, energy);
                *x = wanted;
            }
        }
        energy
    }
}

/// Transform of a change of the gradients into the change of their rotations.
struct RotationChange<'a, const D: usize>(&'a RotationResponse<D>);

impl<const D: usize> Transform<D> for RotationChange<'_, D> {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, packet: usize, change: &mut LaneMatrix<S, D>) -> S::f64s {
        *change = self.0.packets[packet].turned(simd, change);
        simd.splat_f64s(0.0)
    }
}

impl<const D: usize> Area<D> {
    /// Local step: adds 2 scale Σ a R ∇W to the right-hand side; returns the energy.
    pub(super) fn local_step_in_space(
        &self,
        at: ScaledDirection<D>,
        right_side: &mut [[f64; D]],
        cancel: &Cancel,
    ) -> f64 {
        2.0 * self.pass(ScaledDirection { scale: 2.0 * at.scale, ..at }, &Rotations, right_side, cancel)
    }

    /// Computes the derivative of the rotations at `handles`, see [`RotationResponse`].
    pub(super) fn response_in_space(&self, handles: &[[f64; D]], limit: f64) -> RotationResponse<D> {
        let of = |blocks: &[Block]| dispatch(Responses { energy: self, blocks, handles, limit });
        let parts: Vec<_> = self.tasks.par_iter().map(|blocks| of(blocks)).collect();
        RotationResponse { packets: parts.concat(), regions: Vec::new() }
    }

    /// Subtracts 2 scale Σ a dR ∇W, where dR is the change of the rotations along a direction of the handles.
    pub(super) fn subtract_turned(
        &self,
        response: &RotationResponse<D>,
        along: ScaledDirection<D>,
        product: &mut [[f64; D]],
        cancel: &Cancel,
    ) {
        let along = ScaledDirection { scale: -2.0 * along.scale, ..along };
        self.pass(along, &RotationChange(response), product, cancel);
    }

    /// Adds scale Σ a T(J) ∇W, with T the transform, and returns Σ a times the energies of T.
    fn pass(
        &self,
        ScaledDirection { direction: handles, scale }: ScaledDirection<D>,
        transform: &impl Transform<D>,
        sums: &mut [[f64; D]],
        cancel: &Cancel,
    ) -> f64 {
        let of = |blocks: &[Block]| dispatch(Pass { energy: self, blocks, handles, transform });
        let mut energy = 0.0;
        for tasks in self.tasks.chunks(ROUND) {
            if cancel.is_requested() {
                return 0.0;
            }
            let parts: Vec<_> = tasks.par_iter().map(|blocks| of(blocks)).collect();
            for (part, own) in &parts {
                sums.iter_mut().zip(part).for_each(|(slots, x)| (0..D).for_each(|d| slots[d] += scale * x[d]));
                energy += own;
            }
        }
        energy
    }
}

/// Kernel of [`Area::response_in_space`].
struct Responses<'a, const D: usize> {
    energy: &'a Area<D>,
    blocks: &'a [Block],
    handles: &'a [[f64; D]],
    limit: f64,
}

impl<const D: usize> WithSimd for Responses<'_, D> {
    type Output = Vec<PacketResponse<D>>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let gradients = &self.energy.gradients;
        let (mut responses, mut local) = (Vec::new(), Vec::new());
        for block in self.blocks {
            local_handles(block, self.handles, &mut local);
            for coefficients in gradients.packets(block) {
                responses.push(PacketResponse::at(simd, &gather(simd, coefficients, &local), self.limit));
            }
        }
        responses
    }
}

/// Kernel of [`Area::pass`].
struct Pass<'a, T, const D: usize> {
    energy: &'a Area<D>,
    blocks: &'a [Block],
    handles: &'a [[f64; D]],
    transform: &'a T,
}

impl<T: Transform<D>, const D: usize> WithSimd for Pass<'_, T, D> {
    type Output = (Vec<[f64; D]>, f64);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Area { gradients, areas, .. } = self.energy;
        let (mut local, mut values) = (Vec::new(), Vec::new());
        let mut sums: Vec<[Lanes; D]> = vec![[[0.0; LANES]; D]; self.handles.len()];
        let mut energy = simd.splat_f64s(0.0);
        let never = Cancel::never();
        for block in self.blocks {
            local_handles(block, self.handles, &mut local);
            values.clear();
            for (packet, coefficients) in block.packets.clone().zip(gradients.packets(block)) {
                let [mut gathered] = gather_group(simd, [coefficients], &local);
                let areas = load::<S>(&areas[packet]);
                let part = self.transform.apply(simd, packet, &mut gathered);
                energy = multiply_add(simd, areas, part, energy);
                values.push(gathered.map(|row| row.map(|x| simd.mul_f64s(areas, x))));
            }
            let _ =
                gradients.scatter_block(simd, BlockValues { block, values: &values }, &mut sums, &mut never.meter());
        }
        let sums = sums.iter().map(|sum| std::array::from_fn(|d| sum[d].iter().sum())).collect();
        (sums, store::<S>(energy).iter().sum())
    }
}
