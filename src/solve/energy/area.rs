//! Energy `area`: 2 Σ_q a_q ‖J_q − R_q‖², J_q = Σ_h P_h ∇W_h(x_q)ᵀ, the lattice's own gradient at sample points.
//!
//! In: samples (place, area). It does not know the mesh, so neither its density nor its flaws matter.

use super::{Distortion, Quality};
use crate::lattice::Grid;
use crate::solve::matrix::Normal;
use crate::solve::packs::{LANES, Lanes, PackValues, Packs, add_sums, gather, local_handles, scatter};
use crate::solve::samples::Sample;
use crate::solve::small::{Square, best_rotation};

/// The energy at fixed samples.
#[derive(Debug)]
pub(crate) struct Area<const D: usize> {
    /// Rows of ∇W.
    gradients: Packs<D>,
    /// Area of each lane's sample; 0 where a lane has none.
    areas: Vec<Lanes>,
    total: f64,
}

impl<const D: usize> Area<D> {
    pub(crate) fn new(grid: &Grid<D>, samples: &[Sample<D>]) -> Self {
        let points: Vec<[f64; D]> = samples.iter().map(|sample| sample.at).collect();
        let gradients = Packs::new(grid, &points, |_, gradient| *gradient);
        let area_of = |row: usize| samples.get(row).map_or(0.0, |sample| sample.area);
        let areas: Vec<Lanes> = gradients.order.iter().map(|rows| rows.map(area_of)).collect();
        Self { gradients, areas, total: samples.iter().map(|sample| sample.area).sum() }
    }

    /// Calls `visit(pack, gradients of eight samples)` for all packs.
    fn each_pack(&self, handles: &[[f64; D]], mut visit: impl FnMut(usize, &PackValues<D, D>)) {
        let mut local = Vec::new();
        for block in &self.gradients.blocks {
            local_handles(block, handles, &mut local);
            for pack in block.packs.clone() {
                visit(pack, &gather(self.gradients.pack(block, pack), &local));
            }
        }
    }

    /// Gram blocks entry by entry; for local bases.
    fn add_sparse_normal(&self, scale: f64, normal: &mut Normal) {
        for block in &self.gradients.blocks {
            let count = block.handles.len();
            let mut sums = vec![[0.0; LANES]; count * count];
            for pack in block.packs.clone() {
                add_gram(self.gradients.pack(block, pack), &self.areas[pack], &mut sums);
            }
            for a in 0..count {
                for b in 0..=a {
                    let sum: f64 = sums[a * count + b].iter().sum();
                    normal.add(block.handles[a], block.handles[b], scale * sum);
                }
            }
        }
    }

    /// One large product; for bases in which all handles meet.
    fn add_dense_normal(&self, scale: f64, normal: &mut Normal) {
        for block in &self.gradients.blocks {
            let rows = block.packs.len() * LANES * D;
            let mut scaled = vec![0.0; rows * block.handles.len()];
            for (number, pack) in block.packs.clone().enumerate() {
                let roots = self.areas[pack].map(f64::sqrt);
                for (k, coefficients) in self.gradients.pack(block, pack).iter().enumerate() {
                    let slots = &mut scaled[k * rows + number * LANES * D..][..LANES * D];
                    for (slot, lanes) in slots.chunks_exact_mut(LANES).zip(coefficients) {
                        (0..LANES).for_each(|lane| slot[lane] = lanes[lane] * roots[lane]);
                    }
                }
            }
            normal.add_product(scale, &scaled, &scaled);
        }
    }
}

/// Adds area · ∇W_a · ∇W_b for all pairs a ≥ b of a block's handles.
fn add_gram<const D: usize>(pack: &[[Lanes; D]], areas: &Lanes, sums: &mut [Lanes]) {
    let count = pack.len();
    for a in 0..count {
        let mut scaled = pack[a];
        scaled.iter_mut().flat_map(|lanes| lanes.iter_mut().zip(areas)).for_each(|(x, area)| *x *= area);
        for (b, other) in pack[..=a].iter().enumerate() {
            let sum = &mut sums[a * count + b];
            for axis in 0..D {
                (0..LANES).for_each(|lane| sum[lane] += scaled[axis][lane] * other[axis][lane]);
            }
        }
    }
}

impl<const D: usize> Distortion<D> for Area<D> {
    fn rotation_count(&self) -> usize {
        self.areas.len() * LANES
    }

    fn mass(&self) -> f64 {
        2.0 * self.total
    }

    fn reach(&self) -> usize {
        self.gradients.reach()
    }

    fn add_normal(&self, scale: f64, normal: &mut Normal) {
        if normal.is_dense() && self.gradients.blocks.len() == 1 {
            self.add_dense_normal(2.0 * scale, normal);
        } else {
            self.add_sparse_normal(2.0 * scale, normal);
        }
    }

    fn local_step(
        &self,
        handles: &[[f64; D]],
        scale: f64,
        rotations: &mut [Square<D>],
        right_side: &mut [[f64; D]],
    ) -> f64 {
        let (mut local, mut sums) = (Vec::new(), Vec::new());
        let mut energy = 0.0;
        for block in &self.gradients.blocks {
            local_handles(block, handles, &mut local);
            sums.clear();
            sums.resize(block.handles.len(), [[0.0; LANES]; D]);
            for pack in block.packs.clone() {
                let coefficients = self.gradients.pack(block, pack);
                let mut values = gather(coefficients, &local);
                let slots = &mut rotations[pack * LANES..(pack + 1) * LANES];
                energy += fit_pack(&mut values, &self.areas[pack], slots);
                scatter(coefficients, &values, &mut sums);
            }
            add_sums(block, &sums, 2.0 * scale, right_side);
        }
        2.0 * energy
    }

    fn energy(&self, handles: &[[f64; D]], rotations: &[Square<D>]) -> f64 {
        let mut energy = 0.0;
        self.each_pack(handles, |pack, gradients| {
            for lane in 0..LANES {
                let (gradient, rotation) = (lane_of(gradients, lane), &rotations[pack * LANES + lane]);
                energy += self.areas[pack][lane] * squared_distance(&gradient, rotation);
            }
        });
        2.0 * energy
    }

    fn quality(&self, handles: &[[f64; D]]) -> Quality {
        let mut quality = Quality::new();
        self.each_pack(handles, |pack, gradients| {
            for lane in 0..LANES {
                if self.areas[pack][lane] > 0.0 {
                    quality.add(self.areas[pack][lane], &lane_of(gradients, lane));
                }
            }
        });
        quality
    }
}

/// Replaces eight gradients by their area-weighted rotations; gives Σ a ‖J − R‖².
#[inline(always)]
fn fit_pack<const D: usize>(values: &mut PackValues<D, D>, areas: &Lanes, rotations: &mut [Square<D>]) -> f64 {
    let mut energy = 0.0;
    for lane in 0..LANES {
        let gradient = lane_of(values, lane);
        // S = Σ (axis)(image of the axis)ᵀ = Jᵀ.
        let rotation = best_rotation(&transpose(&gradient));
        energy += areas[lane] * squared_distance(&gradient, &rotation);
        rotations[lane] = rotation;
        for d in 0..D {
            (0..D).for_each(|c| values[d][c][lane] = areas[lane] * rotation[d][c]);
        }
    }
    energy
}

fn lane_of<const D: usize>(values: &PackValues<D, D>, lane: usize) -> Square<D> {
    std::array::from_fn(|d| std::array::from_fn(|c| values[d][c][lane]))
}

fn transpose<const D: usize>(m: &Square<D>) -> Square<D> {
    std::array::from_fn(|row| std::array::from_fn(|column| m[column][row]))
}

fn squared_distance<const D: usize>(a: &Square<D>, b: &Square<D>) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y) * (x - y)).sum()
}
