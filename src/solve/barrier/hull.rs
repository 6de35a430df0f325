//! Lower bounds of det J over whole cells, which spare most cells the evaluation of their points.
//!
//! In: the handles of cells. Out: a bound per cell. In a cell of a basis that is a tensor product of B-splines, the derivative along
//! an axis is a convex combination of the differences of handles that are neighbours along this axis, and det J is linear in each
//! derivative. In 2D the smallest cross product of two differences is therefore a bound, however the cell is rotated.

use crate::lattice::{Grid, Support, rough_determinant};
use crate::simd::dispatch;
use crate::solve::linalg::simd::{LANES, Lanes, load, multiply_add, store};
use crate::solve::linalg::small_matrix::dot;
use pulp::{Simd, WithSimd};

/// Differences of neighbouring handles in a cell.
#[derive(Clone, Debug)]
pub(super) struct DifferenceHull<const D: usize> {
    /// Neighbours along each axis, as indices into the handles of a cell.
    pairs: [Vec<[usize; 2]>; D],
    /// Reciprocals of the distances of neighbours at rest.
    per_spacing: [f64; D],
}

impl<const D: usize> DifferenceHull<D> {
    /// The differences in any cell of a grid; `None` if its basis is not a tensor product of B-splines.
    pub(super) fn new(grid: &Grid<D>) -> Option<Self> {
        let Support::Tensor { width } = grid.basis.support() else { return None };
        let pairs = std::array::from_fn(|axis| {
            let step = width.pow(axis as u32);
            let ahead = (0..width.pow(D as u32)).filter(|number| number / step % width + 1 < width);
            ahead.map(|number| [number, number + step]).collect()
        });
        Some(Self { pairs, per_spacing: std::array::from_fn(|axis| 1.0 / grid.spacing(axis)) })
    }

    /// Returns a lower bound of det J for each cell, given by its handles.
    pub(super) fn bounds<'a>(&self, cells: impl Iterator<Item = &'a [usize]>, handles: &[[f64; D]]) -> Vec<f64> {
        if !is_finite(handles) {
            return vec![f64::NEG_INFINITY; cells.count()];
        }
        if D == 2 {
            return dispatch(CrossProducts { hull: self, cells, handles });
        }
        cells.map(|cell| self.rough_bound(cell, [handles; 2])).collect()
    }

    /// Returns a lower bound of det J for each cell over all states on the straight way between two.
    pub(super) fn bounds_between<'a>(
        &self,
        cells: impl Iterator<Item = &'a [usize]> + Clone,
        ends @ [from, to]: [&[[f64; D]]; 2],
    ) -> Vec<f64> {
        if !ends.into_iter().all(is_finite) {
            return vec![f64::NEG_INFINITY; cells.count()];
        }
        if D != 2 {
            return cells.map(|cell| self.rough_bound(cell, ends)).collect();
        }
        let by: Vec<[f64; D]> = from.iter().zip(to).map(|(a, b)| std::array::from_fn(|d| b[d] - a[d])).collect();
        let at_ends = ends.map(|handles| self.bounds(cells.clone(), handles));
        // The cross product of two differences that change by α and β lies at most |α| |β| / 4 below the line between its ends.
        let sag = |cell: &[usize]| {
            let squares = [0, 1].map(|axis| {
                let mut most = 0.0_f64;
                self.for_each(axis, (cell, &by), |change| most = most.max(dot(&change, &change)));
                most
            });
            0.25 * (squares[0] * squares[1]).sqrt()
        };
        cells.zip(at_ends[0].iter().zip(&at_ends[1])).map(|(cell, (a, b))| a.min(*b) - sag(cell)).collect()
    }

    /// Calls `visit` with the differences along an axis.
    #[inline(always)]
    fn for_each(&self, axis: usize, (cell, handles): (&[usize], &[[f64; D]]), mut visit: impl FnMut([f64; D])) {
        for pair in &self.pairs[axis] {
            let [from, to] = pair.map(|number| &handles[cell[number]]);
            visit(std::array::from_fn(|d| (to[d] - from[d]) * self.per_spacing[axis]));
        }
    }

    /// A bound from the ranges of the entries of J at both ends of a way.
    fn rough_bound(&self, cell: &[usize], ends: [&[[f64; D]]; 2]) -> f64 {
        let mut ranges = [[[f64::INFINITY, f64::NEG_INFINITY]; D]; D];
        for axis in 0..D {
            for handles in ends {
                self.for_each(axis, (cell, handles), |slope| {
                    for (range, slope) in ranges.iter_mut().zip(slope) {
                        let [low, high] = &mut range[axis];
                        (*low, *high) = (low.min(slope), high.max(slope));
                    }
                });
            }
        }
        rough_determinant(&ranges)
    }
}

fn is_finite<const D: usize>(handles: &[[f64; D]]) -> bool {
    handles.as_flattened().iter().all(|x| x.is_finite())
}

/// Kernel of [`DifferenceHull::bounds`] in 2D: the smallest cross product of a difference along the first axis and one along the
/// second.
struct CrossProducts<'a, const D: usize, I> {
    hull: &'a DifferenceHull<D>,
    cells: I,
    handles: &'a [[f64; D]],
}

impl<'a, const D: usize, I: Iterator<Item = &'a [usize]>> WithSimd for CrossProducts<'_, D, I> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<f64> {
        let Self { hull, cells, handles } = self;
        // Differences along the second axis, by coordinate; the last register is filled up with the last difference.
        let mut second: Vec<[Lanes; 2]> = Vec::new();
        let mut bounds = Vec::new();
        for cell in cells {
            second.clear();
            let mut count = 0;
            hull.for_each(1, (cell, handles), |slope| {
                if count % LANES == 0 {
                    second.push([[slope[0]; LANES], [slope[1]; LANES]]);
                }
                let last = &mut second[count / LANES];
                (0..2).for_each(|d| last[d][count % LANES..].fill(slope[d]));
                count += 1;
            });
            let mut least = simd.splat_f64s(f64::INFINITY);
            for pair in &hull.pairs[0] {
                let [from, to] = pair.map(|number| &handles[cell[number]]);
                let slope = [0, 1].map(|d| simd.splat_f64s((to[d] - from[d]) * hull.per_spacing[0]));
                for [x, y] in &second {
                    let minus = simd.mul_f64s(simd.neg_f64s(slope[1]), load::<S>(x));
                    least = simd.min_f64s(least, multiply_add(simd, slope[0], load::<S>(y), minus));
                }
            }
            bounds.push(store::<S>(least).into_iter().fold(f64::INFINITY, f64::min));
        }
        bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;
    use crate::solve::linalg::small_matrix::determinant;

    /// The bound of every cell of a shaken grid, and the smallest det J at many points of it.
    fn check<const D: usize>(grid: &Grid<D>, amount: f64) {
        let hull = DifferenceHull::new(grid).expect("a tensor product");
        let rest = grid.rest_handles();
        let shaken = |seed: f64| -> Vec<[f64; D]> {
            let mut handles = rest.clone();
            for (k, x) in handles.as_flattened_mut().iter_mut().enumerate() {
                *x += amount * grid.spacing(k % D) * (12.9898 * k as f64 + seed).sin();
            }
            handles
        };
        let (from, to) = (shaken(0.0), shaken(1.0));
        let point = |cell: usize, k: usize| -> [f64; D] {
            let corner = grid.cell_coords(cell);
            std::array::from_fn(|axis| {
                let within = [0.01, 0.3, 0.6, 0.99][k / 4_usize.pow(axis as u32) % 4];
                grid.lo[axis] + (corner[axis] as f64 + within) * grid.spacing(axis)
            })
        };
        let cells: Vec<Vec<usize>> = (0..grid.cell_count())
            .map(|cell| {
                let mut handles = Vec::new();
                grid.for_each_weight(point(cell, 0), |term| handles.push(term.handle));
                handles
            })
            .collect();
        let bounds = hull.bounds(cells.iter().map(|cell| &cell[..]), &from);
        let between = hull.bounds_between(cells.iter().map(|cell| &cell[..]), [&from, &to]);
        let mut closest = f64::INFINITY;
        for cell in 0..cells.len() {
            for step in 0..=4 {
                let t = f64::from(step) / 4.0;
                let handles = from.iter().zip(&to).map(|(a, b)| std::array::from_fn(|d| a[d] * (1.0 - t) + b[d] * t));
                let lattice = crate::lattice::Lattice { grid: grid.clone(), handles: handles.collect() };
                for k in 0..4_usize.pow(D as u32) {
                    let det = determinant(&lattice.evaluate_with_gradient(point(cell, k)).gradient);
                    assert!(between[cell] <= det + 1e-9, "{cell} {t}: {} {det}", between[cell]);
                    assert!(step > 0 || bounds[cell] <= det + 1e-9, "{cell}: {} {det}", bounds[cell]);
                    closest = closest.min(det - bounds[cell]);
                }
            }
        }
        assert!(closest < 1.0, "{closest}");
        let mut broken = from;
        broken[0][0] = f64::NAN;
        assert!(hull.bounds(cells.iter().map(|cell| &cell[..]), &broken).iter().all(|bound| *bound < 0.0));
    }

    #[test]
    fn det_j_is_nowhere_below_the_bound_of_its_cell() {
        for basis in [Basis::Bspline, Basis::Bilinear] {
            let flat = Grid { dims: [7, 6], basis, lo: [-1.0, 0.0], hi: [1.0, 1.5], angle: 0.0 };
            check(&flat, 0.1);
            check(&flat, 0.5);
            check(&Grid { dims: [5, 4, 4], basis, lo: [0.0; 3], hi: [1.0, 2.0, 1.0], angle: 0.0 }, 0.1);
        }
    }

    #[test]
    fn rotations_leave_the_bound_at_one() {
        let grid = Grid { dims: [7, 6], basis: Basis::Bspline, lo: [-1.0, 0.0], hi: [1.0, 1.5], angle: 0.0 };
        let rotated: Vec<[f64; 2]> =
            grid.rest_handles().iter().map(|[x, y]| [0.6 * x - 0.8 * y, 0.8 * x + 0.6 * y]).collect();
        let hull = DifferenceHull::new(&grid).expect("a tensor product");
        let mut cell = Vec::new();
        grid.for_each_weight([0.0, 0.7], |term| cell.push(term.handle));
        let [bound] = hull.bounds([&cell[..]].into_iter(), &rotated)[..] else { panic!("one cell") };
        assert!((bound - 1.0).abs() < 1e-9, "{bound}");
    }
}
