//! Fits lattices to a warp: with other dims, with another basis, or to an arbitrary map.
//!
//! In: a grid at rest and a map of points. Out: handles, and the largest distance of the lattice from the map. The fit
//! is exact where the new functions include the old ones: Bernstein with more handles (degree elevation; G. Farin,
//! "Curves and Surfaces for CAGD", section 5.1), and B-splines and cells whose spans are divided evenly.

use super::axis::AxisTerms;
use super::basis::{Basis, Support};
use super::error::LatticeError;
use super::grid::{Grid, Lattice};
use faer::Mat;
use faer::linalg::solvers::SolveLstsq;

/// Number of sites per handle and axis at which a map is sampled.
const SITES: usize = 6;
/// Maximum number of probes per handle and axis at which a lattice is compared with its map.
const PROBES: usize = 3;
/// Maximum number of probes in total; 3D lattices have fewer per axis.
const MAX_PROBES: usize = 40_000;
/// Weight of the regularisation of Bernstein handles towards rest. Polynomials of high degree are nearly linearly
/// dependent; without it handles would move far away for little gain in accuracy.
const PULL: f64 = 1e-5;

/// A lattice fitted to a map.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fitted<const D: usize> {
    /// The lattice.
    pub lattice: Lattice<D>,
    /// Largest distance between the images of a point under lattice and map, over probes in the whole box, in units of the space.
    pub error: f64,
}

impl<const D: usize> Lattice<D> {
    /// Returns the same warp with other dims and basis over the same box: exact where the new functions include the old
    /// ones, least squares otherwise.
    ///
    /// # Errors
    /// [`LatticeError`] if the dims are invalid for the basis.
    pub(crate) fn resized(&self, dims: [usize; D], basis: Basis) -> Result<Fitted<D>, LatticeError> {
        let grid = Grid { dims, basis, ..self.grid.clone() };
        grid.check()?;
        let is_raised = (0..D).all(|axis| dims[axis] >= self.grid.dims[axis]);
        if is_raised && basis == self.grid.basis && basis.support() == Support::Global {
            let handles = elevate(&self.handles, self.grid.dims, dims);
            return Ok(Lattice { grid, handles }.compared(&|point| self.evaluate(point)));
        }
        Ok(grid.fitted(|point| self.evaluate(point)))
    }

    /// Returns the lattice with its distance from a map.
    fn compared(self, map: &impl Fn([f64; D]) -> [f64; D]) -> Fitted<D> {
        let grid = &self.grid;
        let counts = probe_counts(grid.dims);
        let miss = |number: usize| {
            let place = place(number, counts);
            let unit = std::array::from_fn(|axis| (place[axis] as f64 + 0.5) / counts[axis] as f64);
            let point = grid.point_from_unit(unit);
            let (found, wanted) = (self.evaluate(point), map(point));
            (0..D).map(|axis| (found[axis] - wanted[axis]).powi(2)).sum::<f64>()
        };
        let error = (0..counts.iter().product()).map(miss).fold(0.0, f64::max).sqrt();
        Fitted { lattice: self, error }
    }
}

impl<const D: usize> Grid<D> {
    /// Returns the lattice over this grid that best approximates a map of points. Piecewise linear bases interpolate
    /// the map at the handles; smooth ones fit it by least squares, axis by axis.
    #[must_use]
    pub(crate) fn fitted(&self, map: impl Fn([f64; D]) -> [f64; D]) -> Fitted<D> {
        let lattice = if self.basis.is_piecewise_linear() {
            Lattice { grid: self.clone(), handles: self.rest_handles().into_iter().map(&map).collect() }
        } else {
            self.least_squares(&map)
        };
        lattice.compared(&map)
    }

    /// Contracts displacements at a grid of sites by the least-squares operator of each axis.
    fn least_squares(&self, map: &impl Fn([f64; D]) -> [f64; D]) -> Lattice<D> {
        let mut counts = self.dims.map(|count| SITES * count);
        let displacement = |number: usize| {
            let place = place(number, counts);
            let point = self.point_from_unit(std::array::from_fn(|axis| site(place[axis], counts[axis])));
            let image = map(point);
            std::array::from_fn(|axis| image[axis] - point[axis])
        };
        let mut values: Vec<[f64; D]> = (0..counts.iter().product()).map(displacement).collect();
        for axis in 0..D {
            values = contract(&values, &mut counts, axis, &fit_operator(self.basis, self.dims[axis]));
        }
        let handles = self.rest_handles();
        let moved = handles.iter().zip(&values).map(|(rest, by)| std::array::from_fn(|axis| rest[axis] + by[axis]));
        Lattice { grid: self.clone(), handles: moved.collect() }
    }
}

/// Returns the number of probes along each axis.
fn probe_counts<const D: usize>(dims: [usize; D]) -> [usize; D] {
    let counts = |probes: usize| dims.map(|count| probes * count + 1);
    let fits = |probes: &usize| counts(*probes).iter().product::<usize>() <= MAX_PROBES;
    counts((1..=PROBES).rev().find(fits).unwrap_or(1))
}

/// Returns a Chebyshev site; sites are denser towards the ends, as polynomials of high degree require.
fn site(index: usize, count: usize) -> f64 {
    0.5 - 0.5 * (std::f64::consts::PI * (index as f64 + 0.5) / count as f64).cos()
}

/// Returns the operator from values at sites to handles of one axis: #handles × #sites.
fn fit_operator(basis: Basis, handles: usize) -> Mat<f64> {
    let sites = SITES * handles;
    let mut functions = Mat::zeros(sites + handles, handles);
    for row in 0..sites {
        let terms: AxisTerms = AxisTerms::at(basis, handles, site(row, sites));
        terms.values().iter().enumerate().for_each(|(k, value)| functions[(row, terms.first + k)] = *value);
    }
    if basis.support() == Support::Global {
        (0..handles).for_each(|handle| functions[(sites + handle, handle)] = PULL);
    }
    let wanted = Mat::from_fn(sites + handles, sites, |row, column| if row == column { 1.0 } else { 0.0 });
    functions.qr().solve_lstsq(wanted)
}

/// Applies a matrix (new × old) along one axis of an array; `counts` takes the new size.
fn contract<const D: usize>(
    values: &[[f64; D]],
    counts: &mut [usize; D],
    axis: usize,
    matrix: &Mat<f64>,
) -> Vec<[f64; D]> {
    let stride: usize = counts[..axis].iter().product();
    let (old, new) = (counts[axis], matrix.nrows());
    let slabs = values.chunks_exact(stride * old);
    counts[axis] = new;
    let mut contracted = Vec::with_capacity(values.len() / old * new);
    for slab in slabs {
        for row in 0..new {
            contracted.extend((0..stride).map(|start| {
                let mut sum = [0.0; D];
                for column in 0..old {
                    let value = slab[start + stride * column];
                    (0..D).for_each(|d| sum[d] += matrix[(row, column)] * value[d]);
                }
                sum
            }));
        }
    }
    contracted
}

/// Elevates the degree of every axis, one by one: Q_i = i/n P_{i−1} + (1 − i/n) P_i.
fn elevate<const D: usize>(handles: &[[f64; D]], mut counts: [usize; D], wanted: [usize; D]) -> Vec<[f64; D]> {
    let mut values = handles.to_vec();
    for axis in 0..D {
        while counts[axis] < wanted[axis] {
            let old = counts[axis];
            let share = |row: usize, column: usize| match row - column.min(row) {
                0 if row == column => 1.0 - row as f64 / old as f64,
                1 => row as f64 / old as f64,
                _ => 0.0,
            };
            values = contract(&values, &mut counts, axis, &Mat::from_fn(old + 1, old, share));
        }
    }
    values
}

/// Converts a flat index to a multi-index, first axis fastest.
fn place<const D: usize>(number: usize, counts: [usize; D]) -> [usize; D] {
    std::array::from_fn(|axis| number / counts[..axis].iter().product::<usize>() % counts[axis])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lattice with all handles displaced by a function that is not a polynomial.
    fn bent<const D: usize>(basis: Basis, dims: [usize; D]) -> Lattice<D> {
        let mut lattice = Grid { dims, basis, lo: [-1.0; D], hi: [2.0; D], angle: 0.0 }.at_rest();
        for (k, handle) in lattice.handles.iter_mut().enumerate() {
            handle.iter_mut().enumerate().for_each(|(d, x)| *x += 0.2 * (3.1 * k as f64 + d as f64).sin());
        }
        lattice
    }

    #[test]
    fn nested_functions_lose_nothing() {
        let exact = [
            (Basis::Bernstein, [4, 6], [9, 6]),
            (Basis::Bernstein, [3, 3], [40, 64]),
            (Basis::Bspline, [5, 6], [7, 9]),
            (Basis::Bspline, [10, 10], [24, 17]),
            (Basis::Bilinear, [4, 5], [7, 17]),
            (Basis::Barytri, [4, 5], [10, 13]),
        ];
        for (basis, from, to) in exact {
            let error = bent(basis, from).resized(to, basis).expect("valid dims").error;
            assert!(error < 1e-12, "{basis:?} {from:?} to {to:?}: {error:e}");
        }
        let space = bent(Basis::Bspline, [4, 5, 6]).resized([5, 7, 9], Basis::Bspline).expect("valid dims");
        assert!(space.error < 1e-12 && space.lattice.handles.len() == 315, "{:e}", space.error);
    }

    #[test]
    fn what_does_not_fit_is_reported_and_shrinks_with_handles() {
        let lattice = bent(Basis::Bspline, [8, 8]);
        let error = |dims: usize, basis: Basis| lattice.resized([dims; 2], basis).expect("valid dims").error;
        assert!(error(6, Basis::Bspline) > 1e-2);
        for (coarse, fine, basis) in [(9, 30, Basis::Bspline), (9, 25, Basis::Bernstein), (9, 60, Basis::Bilinear)] {
            assert!(error(fine, basis) < 0.2 * error(coarse, basis), "{basis:?}");
        }
        assert!(lattice.resized([3, 8], Basis::Bspline).is_err());
    }

    #[test]
    fn lattices_of_space_stay_within_memory() {
        let error = bent(Basis::Bspline, [4; 3]).resized([64; 3], Basis::Bspline).expect_err("too large").to_string();
        assert!(error.contains("262144 handles in all") && error.contains("at most 4096"), "{error}");
        assert_eq!((probe_counts([64; 2]), probe_counts([16; 3]), probe_counts([4; 3])), ([193; 2], [33; 3], [13; 3]));
    }

    #[test]
    fn a_raised_lattice_comes_back() {
        let lattice = bent(Basis::Bernstein, [6, 8]);
        let raised = lattice.resized([11, 12], Basis::Bernstein).expect("valid dims").lattice;
        let back = raised.resized([6, 8], Basis::Bernstein).expect("valid dims");
        assert!(back.error < 1e-6, "{:e}", back.error);
    }

    #[test]
    fn high_degrees_stay_calm() {
        let fitted = bent(Basis::Bspline, [6, 6]).resized([64, 64], Basis::Bernstein).expect("valid dims");
        let farthest = fitted.lattice.handles.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        assert!(fitted.error < 1e-2 && farthest < 1e3, "{:e} {farthest:e}", fitted.error);
    }

    #[test]
    fn more_handles_of_a_polynomial_keep_it() -> Result<(), crate::lattice::LatticeError> {
        let mut lattice =
            Grid { dims: [4, 5], basis: Basis::Bernstein, lo: [0.0, 0.0], hi: [2.0, 1.0], angle: 0.0 }.at_rest();
        lattice.handles[6] = [0.9, 0.4];
        let finer = lattice.resized([9, 7], Basis::Bernstein)?;
        assert!(finer.error < 1e-13);
        Ok(())
    }
}
