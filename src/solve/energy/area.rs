//! Energy `area`: 2 Σ_q a_q ‖J_q − R_q‖², with J_q = Σ_h P_h ∇W_h(x_q)ᵀ, the gradient of the lattice at sample q, and R_q the
//! nearest rotation.
//!
//! In: samples (position, area, stiffness). Out: the terms of [`Distortion`]. The energy does not depend on density or defects of
//! the mesh.

use super::distortion::{Distortion, DistortionMetrics, Flops, RotationHessian, ScaledDirection};
use super::rotation_hessian::SubtractRotationHessian;
use super::rotation_response::RotationResponse;
use super::sample_tasks::tasks;
use crate::lattice::Grid;
use crate::simd::dispatch;
use crate::solve::blocked_weights::{Block, BlockValues, BlockedWeights, RowGroup, gather_group, local_handles};
use crate::solve::cancel::{Cancel, WorkMeter};
use crate::solve::linalg::gram_matrix::{GramMatrix, Sum};
use crate::solve::linalg::normal_matrix::NormalMatrix;
use crate::solve::linalg::simd::{LANES, Lanes, lane_of, load, multiply_add, store};
use crate::solve::linalg::small_matrix::{nearest_rotation, squared_distance};
use crate::solve::linalg::syrk::SyrkRows;
use crate::solve::samples::Sample;
use pulp::{Simd, WithSimd};

/// Energy `area` at fixed samples.
#[derive(Debug)]
pub(crate) struct Area<const D: usize> {
    /// Rows of ∇W, one per sample.
    pub(super) gradients: BlockedWeights<D>,
    /// Area times stiffness of the sample in each lane; 0 in unused lanes.
    pub(super) areas: Vec<Lanes>,
    /// Area of the sample in each lane.
    plain_areas: Vec<Lanes>,
    /// Sum of the areas.
    total: f64,
    /// Blocks grouped into the parallel tasks of a pass over the samples, in 3D; empty in 2D.
    pub(super) tasks: Vec<Vec<Block>>,
}

impl<const D: usize> Area<D> {
    pub(crate) fn new(grid: &Grid<D>, samples: &[Sample<D>], cancel: &Cancel) -> Self {
        let points: Vec<[f64; D]> = samples.iter().map(|sample| sample.at).collect();
        Self::of(BlockedWeights::new(grid, &points, |_, gradient| *gradient, cancel), samples)
    }

    /// The energy at samples in groups, each of which lies in one cell of a tensor basis and has its own unknowns in place of the cell's
    /// handles.
    pub(crate) fn over_groups(grid: &Grid<D>, samples: &[Sample<D>], groups: &[RowGroup], cancel: &Cancel) -> Self {
        let points: Vec<[f64; D]> = samples.iter().map(|sample| sample.at).collect();
        Self::of(BlockedWeights::grouped(grid, (&points, groups), |_, gradient| *gradient, cancel), samples)
    }

    fn of(gradients: BlockedWeights<D>, samples: &[Sample<D>]) -> Self {
        let lanes = |of: fn(&Sample<D>) -> f64| -> Vec<Lanes> {
            let of_row = |row: usize| samples.get(row).map_or(0.0, of);
            gradients.order.iter().map(|rows| rows.map(of_row)).collect()
        };
        let (areas, plain_areas) = (lanes(|sample| sample.area * sample.stiffness), lanes(|sample| sample.area));
        let total = samples.iter().map(|sample| sample.area).sum();
        let tasks = if D == 3 { tasks(&gradients.blocks) } else { Vec::new() };
        Self { gradients, areas, plain_areas, total, tasks }
    }

    /// Gradients at all samples, packet by packet, as [row][column][lane].
    fn gradients_at(&self, handles: &[[f64; D]]) -> Vec<[[Lanes; D]; D]> {
        self.gradients.gradients_at(handles)
    }

    /// Adds the Gram matrix of each block, for bases of local support.
    fn add_sparse_normal(&self, scale: f64, normal: &mut NormalMatrix) {
        let mut gram = GramMatrix::default();
        for block in &self.gradients.blocks {
            gram.clear(block.handles.len());
            for packet in block.packets.clone() {
                let coefficients = self.gradients.packet(block, packet);
                for lane in (0..LANES).filter(|&lane| self.areas[packet][lane] > 0.0) {
                    let root = self.areas[packet][lane].sqrt();
                    for axis in 0..D {
                        let row = gram.push().iter_mut().zip(coefficients);
                        row.for_each(|(slot, lanes)| *slot = root * lanes[axis][lane]);
                    }
                }
            }
            dispatch(Sum(&mut gram));
            normal.add_gram(scale, &block.handles, &gram);
        }
    }
}

/// Rows of √a ∇W of a block, as both factors of the product, for bases of global support.
struct GradientSquares<'a, const D: usize> {
    energy: &'a Area<D>,
    block: &'a Block,
}

impl<const D: usize> SyrkRows for GradientSquares<'_, D> {
    fn count(&self) -> usize {
        self.block.packets.len() * LANES * D
    }

    #[inline(always)]
    fn write<S: Simd>(&mut self, _: S, row: usize, [a, b]: [&mut [f64]; 2]) {
        let (packet, lane, axis) = (self.block.packets.start + row / (LANES * D), row % LANES, row / LANES % D);
        let root = self.energy.areas[packet][lane].sqrt();
        let coefficients = self.energy.gradients.packet(self.block, packet);
        a.iter_mut().zip(coefficients).for_each(|(slot, lanes)| *slot = root * lanes[axis][lane]);
        b.copy_from_slice(a);
    }
}

impl<const D: usize> Distortion<D> for Area<D> {
    fn mass(&self) -> f64 {
        2.0 * self.total
    }

    fn bandwidth(&self) -> usize {
        self.gradients.bandwidth()
    }

    fn add_normal(&self, scale: f64, normal: &mut NormalMatrix, cancel: &Cancel) {
        if let [block] = &self.gradients.blocks[..]
            && normal.is_full(block.handles.len())
        {
            normal.add_syrk(2.0 * scale, &mut GradientSquares { energy: self, block }, cancel);
        } else {
            self.add_sparse_normal(2.0 * scale, normal);
        }
    }

    fn local_step(&self, handles: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]], cancel: &Cancel) -> f64 {
        if D == 3 {
            return self.local_step_in_space(ScaledDirection { direction: handles, scale }, right_side, cancel);
        }
        dispatch(LocalStep { energy: self, handles, scale: 2.0 * scale, right_side, meter: cancel.meter() })
    }

    /// A local step uses each coefficient with D coordinates twice: to gather handles and to scatter values.
    fn flops(&self) -> Option<Flops> {
        let mut flops = Flops::default();
        for block in &self.gradients.blocks {
            let (numbers, samples) = ((D * block.handles.len()) as f64, (LANES * block.packets.len()) as f64);
            flops.local_step += 2.0 * D as f64 * samples * numbers;
            flops.rotation_hessian += 0.5 * samples * numbers * numbers;
        }
        (D == 2).then_some(flops)
    }

    fn subtract_rotation_hessian(
        &self,
        handles: &[[f64; D]],
        hessian: RotationHessian,
        normal: &mut NormalMatrix,
        cancel: &Cancel,
    ) {
        if D != 2 {
            return self.subtract_rotation_hessian_in_space(handles, hessian, normal, cancel);
        }
        let Self { gradients, areas, .. } = self;
        dispatch(SubtractRotationHessian { gradients, areas, handles, hessian, normal, cancel });
    }

    fn rotation_response(&self, handles: &[[f64; D]], limit: f64) -> Option<RotationResponse<D>> {
        (D == 3).then(|| self.response_in_space(handles, limit))
    }

    fn subtract_rotation_product(
        &self,
        response: &RotationResponse<D>,
        along: ScaledDirection<D>,
        product: &mut [[f64; D]],
        cancel: &Cancel,
    ) {
        self.subtract_turned(response, along, product, cancel);
    }

    fn energy(&self, handles: &[[f64; D]], rotations_at: &[[f64; D]]) -> f64 {
        let (gradients, turned) = (self.gradients_at(handles), self.gradients_at(rotations_at));
        let packets = self.areas.iter().zip(gradients.iter().zip(&turned));
        let lanes = packets.flat_map(|(areas, (gradients, turned))| {
            (0..LANES).map(|lane| {
                let rotation = nearest_rotation(&lane_of(turned, lane));
                areas[lane] * squared_distance(&lane_of(gradients, lane), &rotation)
            })
        });
        2.0 * lanes.sum::<f64>()
    }

    fn metrics(&self, handles: &[[f64; D]]) -> DistortionMetrics {
        let mut metrics = DistortionMetrics::new();
        for (gradients, areas) in self.gradients_at(handles).iter().zip(&self.plain_areas) {
            for lane in (0..LANES).filter(|&lane| areas[lane] > 0.0) {
                metrics.add(areas[lane], &lane_of(gradients, lane));
            }
        }
        metrics
    }
}

/// Kernel of the local step in 2D: rotations, right-hand side and energy in one pass.
struct LocalStep<'a, const D: usize> {
    energy: &'a Area<D>,
    handles: &'a [[f64; D]],
    scale: f64,
    right_side: &'a mut [[f64; D]],
    meter: WorkMeter<'a>,
}

impl<const D: usize> WithSimd for LocalStep<'_, D> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> f64 {
        let Area { gradients, areas, .. } = self.energy;
        let (mut local, mut turned) = (Vec::new(), Vec::new());
        let mut sums = vec![[[0.0; LANES]; D]; self.handles.len()];
        let mut energy = simd.splat_f64s(0.0);
        for block in &gradients.blocks {
            local_handles(block, self.handles, &mut local);
            turned.clear();
            for pair in areas[block.packets.clone()].chunks(2).zip(block.packets.clone().step_by(2)) {
                let (areas, first) = pair;
                if self.meter.count_and_poll(2 * LANES * D * D * local.len()) {
                    return 0.0;
                }
                let packets = [first, first + areas.len() - 1].map(|packet| gradients.packet(block, packet));
                for (areas, mut values) in areas.iter().zip(gather_group(simd, packets, &local)) {
                    let part = fit_plane(simd, &mut values, load::<S>(areas));
                    energy = simd.add_f64s(energy, part);
                    turned.push(values);
                }
            }
            if self.meter.is_stopped()
                || gradients.scatter_block(simd, BlockValues { block, values: &turned }, &mut sums, &mut self.meter)
            {
                return 0.0;
            }
        }
        for (slots, sum) in self.right_side.iter_mut().zip(&sums) {
            (0..D).for_each(|d| slots[d] += self.scale * sum[d].iter().sum::<f64>());
        }
        2.0 * store::<S>(energy).iter().sum::<f64>()
    }
}

/// Replaces four 2D gradients J by their area-weighted rotations. The first column of a rotation is the
/// unit vector of (J00 + J11, J10 − J01). Returns a ‖J − R‖².
#[inline(always)]
fn fit_plane<S: Simd, const D: usize>(simd: S, values: &mut [[S::f64s; D]; D], areas: S::f64s) -> S::f64s {
    let along = simd.add_f64s(values[0][0], values[1][1]);
    let across = simd.sub_f64s(values[1][0], values[0][1]);
    let square = multiply_add(simd, along, along, simd.mul_f64s(across, across));
    // A zero vector gives the identity, as in `best_rotation`.
    let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
    let is_turned = simd.greater_than_f64s(square, zero);
    let inverse = simd.div_f64s(one, simd.sqrt_f64s(square));
    let cos = simd.select_f64s(is_turned, simd.mul_f64s(along, inverse), one);
    let sin = simd.select_f64s(is_turned, simd.mul_f64s(across, inverse), zero);
    let residuals = [
        simd.sub_f64s(values[0][0], cos),
        simd.add_f64s(values[0][1], sin),
        simd.sub_f64s(values[1][0], sin),
        simd.sub_f64s(values[1][1], cos),
    ];
    let energy = residuals.iter().fold(zero, |sum, &residual| multiply_add(simd, residual, residual, sum));
    let (cos, sin) = (simd.mul_f64s(areas, cos), simd.mul_f64s(areas, sin));
    values[0][0] = cos;
    values[0][1] = simd.neg_f64s(sin);
    values[1][0] = sin;
    values[1][1] = cos;
    simd.mul_f64s(areas, energy)
}
