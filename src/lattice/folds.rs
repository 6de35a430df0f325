//! Finds the folded cells of a lattice, and the smallest determinant of its gradient.
//!
//! In: a lattice, in 2D or 3D. Out: [`Folds`]. Local bases are polynomial in every cell, so the result is proven:
//! Bernstein coefficients of det J bound it, and cells are bisected until the bound is conclusive. Cells of the
//! Bernstein basis, whose degree grows with the grid, are sampled at 3 points per axis.

use super::axis::AxisTerms;
use super::basis::Support;
use super::bezier::BezierPolynomial;
use super::grid::Lattice;

/// Samples per cell and axis for the Bernstein basis; the outer ones lie on the border of the cell.
const PROBES: usize = 3;

/// Bisections of a cell, alternating between its axes, after which it counts as folded because det J touches zero.
pub(super) const MAX_HALVINGS: usize = 14;

/// Accuracy of the smallest determinant.
pub(super) const PRECISION: f64 = 1e-3;

/// Folded cells (det J ≤ 0 somewhere inside). B-spline cells outside the box contain no picture and are ignored.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Folds<const D: usize> {
    /// Folded cells between handles (column, row, ...), 0..dims−1.
    pub cells: Vec<[usize; D]>,
    /// Number of folded cells that are active.
    pub active_count: usize,
    /// A lower bound of det J over the active cells, within 1e-3; 1 at rest and without active cells.
    pub min_det: f64,
}

/// Cells whose bounds are not proven yet.
struct OpenCells {
    cells: Vec<usize>,
    /// Determinant from which on a bound need not be tight.
    wanted: f64,
}

impl<const D: usize> Lattice<D> {
    /// Finds the folded cells. `is_active` marks the cells that contain part of the shape:
    /// #[`super::Grid::cell_count`], x fastest.
    ///
    /// # Panics
    /// If `is_active` has another length.
    #[must_use]
    pub(crate) fn folds(&self, is_active: &[bool]) -> Folds<D> {
        assert_eq!(is_active.len(), self.grid.cell_count(), "one entry a cell");
        let bounds = match self.grid.basis.support() {
            Support::Global => self.probe(),
            Support::Simplex => (0..is_active.len()).map(|cell| self.min_of_simplices(cell)).collect(),
            Support::Tensor { width } => {
                let starts = self.slope_starts(width);
                let rough: Vec<f64> = (0..is_active.len()).map(|cell| self.rough_bound(cell, &starts)).collect();
                let open = (0..rough.len()).filter(|&cell| is_active[cell] || rough[cell] <= 0.0).collect();
                self.proven_bounds(rough, OpenCells { cells: open, wanted: f64::INFINITY }, is_active, width)
            }
        };
        self.folds_within(&bounds, is_active)
    }

    /// Same as [`Self::folds`], for a basis that is a tensor product of polynomials, without the cells that are not active.
    /// `min_det` is tight only if it may be less than `wanted`.
    pub(crate) fn active_folds(&self, is_active: &[bool], wanted: f64) -> Folds<D> {
        let Support::Tensor { width } = self.grid.basis.support() else { return self.folds(is_active) };
        let open: Vec<usize> = (0..is_active.len()).filter(|&cell| is_active[cell]).collect();
        let (mut bounds, starts) = (vec![f64::INFINITY; is_active.len()], self.slope_starts(width));
        open.iter().for_each(|&cell| bounds[cell] = self.rough_bound(cell, &starts));
        let bounds = self.proven_bounds(bounds, OpenCells { cells: open, wanted }, is_active, width);
        self.folds_within(&bounds, is_active)
    }

    /// The folds for lower bounds of det J of all cells.
    fn folds_within(&self, bounds: &[f64], is_active: &[bool]) -> Folds<D> {
        let margin = self.grid.basis.margin();
        let mut folds = Folds { cells: Vec::new(), active_count: 0, min_det: f64::INFINITY };
        for (cell, (&least, &is_active)) in bounds.iter().zip(is_active).enumerate() {
            if is_active {
                folds.min_det = folds.min_det.min(least);
            }
            if least <= 0.0 {
                folds.cells.push(self.grid.cell_coords(cell).map(|place| place + margin));
                folds.active_count += usize::from(is_active);
            }
        }
        if folds.min_det == f64::INFINITY {
            folds.min_det = 1.0;
        }
        folds
    }

    /// Returns the folded cells between handles (column, row, ...), 0..dims−1, active or not.
    #[must_use]
    pub(crate) fn folded_cells(&self) -> Vec<[usize; D]> {
        self.folds(&vec![true; self.grid.cell_count()]).cells
    }

    /// Refines lower bounds of det J in the `open` cells until they have the correct sign, and the smallest one of the active cells
    /// is tight if it may be less than wanted. `width`: number of handles that act at a coordinate.
    fn proven_bounds(&self, mut bounds: Vec<f64>, open: OpenCells, is_active: &[bool], width: usize) -> Vec<f64> {
        let OpenCells { cells: mut open, wanted: mut least } = open;
        // In ascending order, so that the rough bound suffices for most cells, which are neither near a fold nor the smallest.
        open.sort_unstable_by(|&a, &b| bounds[a].total_cmp(&bounds[b]));
        for cell in open {
            if bounds[cell] > 0.0 && bounds[cell] >= least {
                break;
            }
            let wanted = if is_active[cell] { least } else { f64::NEG_INFINITY };
            bounds[cell] = min_of(self.determinant(cell, width - 1), wanted);
            if is_active[cell] {
                least = least.min(bounds[cell]);
            }
        }
        bounds
    }

    /// Returns, for each axis, the handles of a cell that have a neighbour ahead along this axis in the cell, counted from the first
    /// handle of the cell.
    fn slope_starts(&self, width: usize) -> [Vec<usize>; D] {
        let within = |number: usize, axis: usize| number / width.pow(axis as u32) % width;
        let offset = |number: usize| (0..D).map(|axis| within(number, axis) * self.grid.stride(axis)).sum();
        std::array::from_fn(|axis| {
            (0..width.pow(D as u32)).filter(|&number| within(number, axis) + 1 < width).map(offset).collect()
        })
    }

    /// Returns a rough lower bound of det J in a cell: derivatives lie between the differences of neighbouring handles. Minus infinity
    /// if one of these is not finite.
    fn rough_bound(&self, cell: usize, starts: &[Vec<usize>; D]) -> f64 {
        let place = self.grid.cell_coords(cell);
        let first: usize = (0..D).map(|axis| place[axis] * self.grid.stride(axis)).sum();
        let mut slopes = [[[f64::INFINITY, f64::NEG_INFINITY]; D]; D];
        let mut is_finite = true;
        for axis in 0..D {
            let (step, per_pitch) = (self.grid.stride(axis), 1.0 / self.grid.spacing(axis));
            for start in &starts[axis] {
                let [from, to] = [first + start, first + start + step].map(|handle| &self.handles[handle]);
                for d in 0..D {
                    let slope = (to[d] - from[d]) * per_pitch;
                    let [low, high] = &mut slopes[d][axis];
                    (*low, *high) = (low.min(slope), high.max(slope));
                    is_finite &= slope.is_finite();
                }
            }
        }
        if is_finite { rough_determinant(&slopes) } else { f64::NEG_INFINITY }
    }

    /// Returns det J in a cell of a basis that is a tensor product of polynomials of this degree.
    pub(super) fn determinant(&self, cell: usize, degree: usize) -> BezierPolynomial<D> {
        let coordinates: [BezierPolynomial<D>; D] = std::array::from_fn(|d| self.coordinate(cell, degree, d));
        let gradient: [[BezierPolynomial<D>; D]; D] =
            std::array::from_fn(|row| std::array::from_fn(|axis| coordinates[row].slope(axis)));
        let minor = |a: usize, b: usize| {
            BezierPolynomial::sum_of_products(&[
                (1.0, &gradient[D - 2][a], &gradient[D - 1][b]),
                (-1.0, &gradient[D - 2][b], &gradient[D - 1][a]),
            ])
        };
        let scale: f64 = (0..D).map(|axis| 1.0 / self.grid.spacing(axis)).product();
        if D == 2 {
            return minor(0, 1).scaled(scale);
        }
        let minors = [minor(1, 2), minor(2, 0), minor(0, 1)];
        let pairs: Vec<_> = gradient[0].iter().zip(&minors).map(|(slope, minor)| (scale, slope, minor)).collect();
        BezierPolynomial::sum_of_products(&pairs)
    }

    /// Returns one coordinate of the image of a cell; B-splines are converted to Bernstein form (Farin, section 8.1).
    fn coordinate(&self, cell: usize, degree: usize, d: usize) -> BezierPolynomial<D> {
        let (side, first) = (degree + 1, self.grid.cell_coords(cell));
        let handle = |number: usize| {
            let places = (0..D).map(|axis| (axis, first[axis] + number / side.pow(axis as u32) % side));
            self.handles[places.map(|(axis, place)| place * self.grid.stride(axis)).sum::<usize>()][d]
        };
        let mut values: Vec<f64> = (0..side.pow(D as u32)).map(handle).collect();
        if degree == 3 {
            for step in (0..D).map(|axis| side.pow(axis as u32)) {
                let starts = (0..values.len()).filter(|index| index / step % side == 0);
                starts.for_each(|start| bezier_from_spline(&mut values, start, step));
            }
        }
        BezierPolynomial::new([degree; D], values)
    }

    /// Returns the smallest determinant of the D! simplices of a cell; it is constant in each.
    fn min_of_simplices(&self, cell: usize) -> f64 {
        let place = self.grid.cell_coords(cell);
        let orders: &[[usize; 3]] = if D == 2 {
            &[[0, 1, 2], [1, 0, 2]]
        } else {
            &[[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]]
        };
        let det = |order: &[usize; 3]| {
            let within = |axis: usize| (order[axis] + 1) as f64 / (D + 1) as f64;
            let spans = std::array::from_fn(|axis| place[axis] as f64 + within(axis));
            determinant(&self.evaluate_with_gradient(self.grid.point_from_spans(spans)).gradient)
        };
        orders.iter().map(det).fold(f64::INFINITY, lower)
    }

    /// Returns the smallest determinant of every cell over its samples, evaluated axis by axis; neighbours share the
    /// samples on their border.
    fn probe(&self) -> Vec<f64> {
        let spans = self.grid.dims.map(|count| self.grid.basis.spans(count));
        let counts = spans.map(|spans| spans * (PROBES - 1) + 1);
        let terms: [Vec<AxisTerms>; D] = std::array::from_fn(|axis| {
            let unit = |probe: usize| probe as f64 / (counts[axis] - 1) as f64;
            (0..counts[axis]).map(|probe| AxisTerms::at(self.grid.basis, self.grid.dims[axis], unit(probe))).collect()
        });
        // One plane per coordinate: [slope][coordinate][probe].
        let gradient: [[Vec<f64>; D]; D] = std::array::from_fn(|slope| {
            std::array::from_fn(|d| {
                let plane = self.handles.iter().map(|handle| handle[d]).collect();
                (0..D).fold(plane, |plane: Vec<f64>, axis| {
                    let factors =
                        |terms| if axis == slope { AxisTerms::slopes(terms) } else { AxisTerms::values(terms) };
                    let rows: Vec<&[f64]> = terms[axis].iter().map(factors).collect();
                    blend(&plane, counts[..axis].iter().product(), &rows)
                })
            })
        });
        let scale: f64 = (0..D).map(|axis| 1.0 / self.grid.size(axis)).product();
        let determinant_at = |probe: usize| {
            let columns = gradient.each_ref().map(|planes| planes.each_ref().map(|plane| plane[probe]));
            scale * determinant(&columns)
        };
        let determinants: Vec<f64> = (0..counts.iter().product()).map(determinant_at).collect();
        let of_cell = |cell: usize| {
            let place = self.grid.cell_coords(cell);
            let probes = (0..PROBES.pow(D as u32)).map(|number| {
                (0..D).rev().fold(0, |probe, axis| {
                    let within = number / PROBES.pow(axis as u32) % PROBES;
                    probe * counts[axis] + place[axis] * (PROBES - 1) + within
                })
            });
            probes.fold(f64::INFINITY, |least, probe| lower(least, determinants[probe]))
        };
        (0..self.grid.cell_count()).map(of_cell).collect()
    }
}

/// Multiplies lines of a plane, `step` apart, by the rows of a matrix.
fn blend(plane: &[f64], step: usize, rows: &[&[f64]]) -> Vec<f64> {
    let count = rows.first().map_or(1, |row| row.len());
    let mut blended = vec![0.0; plane.len() / count * rows.len()];
    if step == 1 {
        // Along the fastest axis the factors are contiguous.
        let columns: Vec<f64> = (0..count).flat_map(|k| rows.iter().map(move |row| row[k])).collect();
        for (numbers, slots) in plane.chunks_exact(count).zip(blended.chunks_exact_mut(rows.len())) {
            sum_of_lines(numbers, &columns, slots);
        }
        return blended;
    }
    for (lines, slots) in plane.chunks_exact(count * step).zip(blended.chunks_exact_mut(rows.len() * step)) {
        for (row, slots) in rows.iter().zip(slots.chunks_exact_mut(step)) {
            sum_of_lines(row, lines, slots);
        }
    }
    blended
}

/// Number of values of a line that are summed together.
const TOGETHER: usize = 8;

/// Writes Σ factor · line over consecutive lines as long as `sum`.
fn sum_of_lines(factors: &[f64], lines: &[f64], sum: &mut [f64]) {
    let length = sum.len();
    for (number, slots) in sum.chunks_mut(TOGETHER).enumerate() {
        let mut sums = [0.0; TOGETHER];
        for (factor, line) in factors.iter().zip(lines.chunks_exact(length)) {
            let line = &line[number * TOGETHER..];
            // Both branches do the same: sums over a constant length stay in registers.
            if let Some(line) = line.first_chunk::<TOGETHER>() {
                sums.iter_mut().zip(line).for_each(|(sum, x)| *sum += factor * x);
            } else {
                sums.iter_mut().zip(line).for_each(|(sum, x)| *sum += factor * x);
            }
        }
        slots.copy_from_slice(&sums[..slots.len()]);
    }
}

/// Converts four B-spline control values to those of the same cubic's Bézier form.
fn bezier_from_spline(values: &mut [f64], start: usize, step: usize) {
    let [a, b, c, d] = [0, 1, 2, 3].map(|k| values[start + k * step]);
    let curve = [a + 4.0 * b + c, 4.0 * b + 2.0 * c, 2.0 * b + 4.0 * c, b + 4.0 * c + d];
    curve.into_iter().enumerate().for_each(|(k, value)| values[start + k * step] = value / 6.0);
}

/// Returns a lower bound of a polynomial in its cell, with the correct sign, and within [`PRECISION`] of the minimum if
/// that may be less than `wanted`. Branch and bound by bisection.
fn min_of<const D: usize>(patch: BezierPolynomial<D>, wanted: f64) -> f64 {
    let mut open = vec![(patch, 0)];
    let mut least = f64::INFINITY;
    while let Some((patch, depth)) = open.pop() {
        let Some(bound) = patch.bound() else { return f64::NEG_INFINITY };
        if bound >= least {
            continue;
        }
        let value = patch.min_corner();
        let is_near = value - bound <= PRECISION * value.abs().max(1.0) || bound >= wanted;
        let has_sign = bound > 0.0 || value <= 0.0;
        if is_near && has_sign || depth >= MAX_HALVINGS {
            least = bound;
        } else {
            open.extend(patch.halves(depth % D).map(|half| (half, depth + 1)));
        }
    }
    least
}

/// Returns a lower bound of the determinant of a matrix with entries in the given ranges.
pub(crate) fn rough_determinant<const D: usize>(slopes: &[[[f64; 2]; D]; D]) -> f64 {
    let minor = |a: usize, b: usize| {
        let [first, second] = [&slopes[D - 2], &slopes[D - 1]];
        let (plus, minus) = (range(first[a], second[b]), range(first[b], second[a]));
        [plus[0] - minus[1], plus[1] - minus[0]]
    };
    if D == 2 {
        return minor(0, 1)[0];
    }
    [minor(1, 2), minor(2, 0), minor(0, 1)].iter().zip(slopes[0]).map(|(minor, slope)| range(slope, *minor)[0]).sum()
}

/// Returns the smallest and largest product of values from two ranges.
fn range(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let corners = [a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]];
    [corners.into_iter().fold(f64::INFINITY, f64::min), corners.into_iter().fold(f64::NEG_INFINITY, f64::max)]
}

/// Returns the smaller value; NaN counts as smallest.
fn lower(a: f64, b: f64) -> f64 {
    if b.is_nan() || b < a { if b.is_nan() { f64::NEG_INFINITY } else { b } } else { a }
}

/// Returns the determinant of a 2 x 2 or 3 x 3 matrix, given by rows or columns.
fn determinant<const D: usize>(m: &[[f64; D]; D]) -> f64 {
    if D == 2 {
        return m[0][0] * m[1][1] - m[0][1] * m[1][0];
    }
    let minor = |k: usize| m[1][(k + 1) % 3] * m[2][(k + 2) % 3] - m[1][(k + 2) % 3] * m[2][(k + 1) % 3];
    (0..3).map(|k| m[0][k] * minor(k)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Basis, Grid};

    fn grid(basis: Basis) -> Grid<2> {
        Grid { dims: [8, 7], basis, lo: [-1.0, 0.0], hi: [1.0, 1.5], angle: 0.0 }
    }

    /// Returns the smallest det J over a dense grid of points of every cell.
    fn searched<const D: usize>(lattice: &Lattice<D>, fineness: usize) -> Vec<f64> {
        let side = |axis: usize| lattice.grid.basis.spans(lattice.grid.dims[axis]);
        let within = |k: usize| (k as f64 + 0.5) / fineness as f64;
        let least = |cell: usize| {
            let place = lattice.grid.cell_coords(cell);
            let dets = (0..fineness.pow(D as u32)).map(|number| {
                let at = |axis: usize| {
                    let k = number / fineness.pow(axis as u32) % fineness;
                    let share = (place[axis] as f64 + within(k)) / side(axis) as f64;
                    lattice.grid.lo[axis] + share * lattice.grid.size(axis)
                };
                determinant(&lattice.evaluate_with_gradient(std::array::from_fn(at)).gradient)
            });
            dets.fold(f64::INFINITY, f64::min)
        };
        (0..lattice.grid.cell_count()).map(least).collect()
    }

    fn shake<const D: usize>(grid: &Grid<D>, amount: f64) -> Lattice<D> {
        let mut lattice = grid.at_rest();
        for (k, x) in lattice.handles.as_flattened_mut().iter_mut().enumerate() {
            *x += amount * grid.spacing(k % D) * (12.9898 * k as f64).sin();
        }
        lattice
    }

    #[test]
    fn the_bound_is_the_least_determinant_that_a_fine_search_finds() {
        for basis in Basis::ALL {
            let lattice = shake(&grid(basis), 0.4);
            let found = searched(&lattice, 40);
            for (cell, found) in found.into_iter().enumerate() {
                let only: Vec<bool> = (0..lattice.grid.cell_count()).map(|other| other == cell).collect();
                let bound = lattice.folds(&only).min_det;
                assert!(bound <= found + 1e-9 || basis == Basis::Bernstein, "{basis:?} {cell}: {bound} {found}");
                assert!(bound > found - 0.04, "{basis:?} {cell}: {bound} {found}");
            }
        }
    }

    #[test]
    fn cells_of_space_are_searched_too() {
        for basis in Basis::ALL {
            let lattice = shake(&Grid { dims: [5, 5, 5], basis, lo: [0.0; 3], hi: [1.0, 2.0, 1.0], angle: 0.0 }, 0.5);
            let least = searched(&lattice, 9).into_iter().fold(f64::INFINITY, f64::min);
            let folds = lattice.folds(&vec![true; lattice.grid.cell_count()]);
            assert!(folds.min_det < least + 0.05 && folds.min_det > least - 0.2, "{basis:?} {folds:?} {least}");
            assert_eq!(folds.cells.is_empty(), folds.min_det > 0.0);
        }
    }

    #[test]
    fn a_fold_between_corners_and_middle_is_found() {
        let rest = Grid { dims: [4, 4], basis: Basis::Bspline, lo: [0.0; 2], hi: [1.0; 2], angle: 0.0 }.at_rest();
        // Handles a h + (h − ¼)³ make the slope a + 1 + 3 (x − ¼)², least at ¼, between 0 and ½.
        let folded = |a: f64| {
            let mut lattice = rest.clone();
            for handle in &mut lattice.handles {
                let u = handle[0] - 0.25;
                handle[0] = a * handle[0] + u * u * u;
            }
            lattice
        };
        assert_eq!(folded(-0.95).folded_cells(), Vec::<[usize; 2]>::new());
        let crease = folded(-1.05);
        assert_eq!(crease.folded_cells().len(), 1);
        assert!(crease.folds(&[false]).min_det == 1.0 && crease.folds(&[true]).min_det < 0.0);
    }

    #[test]
    fn a_handle_pulled_across_its_neighbours_folds_cells_around_it() {
        for basis in [Basis::Bspline, Basis::Bilinear, Basis::Barytri] {
            let mut lattice = Grid { dims: [8, 8], basis, lo: [0.0, 0.0], hi: [1.0, 1.0], angle: 0.0 }.at_rest();
            assert_eq!(lattice.folded_cells(), Vec::<[usize; 2]>::new());
            lattice.handles[4 + 8 * 4][0] += 2.0;
            let folded = lattice.folded_cells();
            assert!(!folded.is_empty() && folded.iter().all(|cell| cell.iter().all(|place| (2..=6).contains(place))));
        }
    }

    #[test]
    fn a_mirrored_lattice_is_folded_everywhere_and_a_nan_counts_as_folded() {
        for basis in Basis::ALL {
            let mut lattice = Grid { dims: [4, 5], basis, lo: [0.0, 0.0], hi: [1.0, 1.0], angle: 0.0 }.at_rest();
            lattice.handles.iter_mut().for_each(|handle| handle[0] = -handle[0]);
            let count = lattice.grid.cell_count();
            assert_eq!(lattice.folded_cells().len(), count);
            let mut broken = lattice.grid.at_rest();
            broken.handles[0] = [f64::NAN; 2];
            assert!(!broken.folded_cells().is_empty());
        }
    }
}
