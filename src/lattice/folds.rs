//! Cells of a lattice that turn over, and the least determinant of its gradient.
//!
//! In: a lattice, in the plane or in space. Out: [`Folds`]. Local bases are polynomials in every cell, so the answer is
//! a proof: Bernstein coefficients of det J bound it, and cells are halved until they decide. Cells of the Bernstein
//! basis, whose degree grows with the grid, are probed at 3 points an axis.

use super::patch::Patch;
use super::{AxisTerms, Basis, Lattice};

/// Probe points a cell and axis of the Bernstein basis; the outer ones lie on its border.
const PROBES: usize = 3;

/// Halvings of a cell, in turn along its axes, after which it counts as folded: det J touches zero there.
const MOST_HALVINGS: usize = 14;

/// The least determinant is known to this.
const PRECISION: f64 = 1e-3;

/// Cells that turn over (det J ≤ 0 somewhere in them). B-spline cells outside the box hold no picture and never count.
#[derive(Clone, Debug, PartialEq)]
pub struct Folds<const D: usize> {
    /// Folded cells between handles (column, row, ...), 0..dims−1.
    pub cells: Vec<[usize; D]>,
    /// How many of them are occupied.
    pub occupied_count: usize,
    /// A lower bound of det J over the occupied cells, near to it by 1e-3; at rest and without occupied cells 1.
    pub least_det: f64,
}

impl<const D: usize> Lattice<D> {
    /// Which cells turn over. `is_occupied` tells which of [`super::Grid::cell_count`] cells hold something, x fastest.
    ///
    /// # Panics
    /// Where `is_occupied` has another length.
    #[must_use]
    pub fn folds(&self, is_occupied: &[bool]) -> Folds<D> {
        assert_eq!(is_occupied.len(), self.grid.cell_count(), "one entry a cell");
        let margin = usize::from(self.grid.basis == Basis::Bspline);
        let mut folds = Folds { cells: Vec::new(), occupied_count: 0, least_det: f64::INFINITY };
        let bounds = match self.grid.basis {
            Basis::Bernstein => self.probe(),
            Basis::Barytri => (0..is_occupied.len()).map(|cell| self.least_of_simplices(cell)).collect(),
            Basis::Bspline | Basis::Bilinear => self.proven_bounds(is_occupied),
        };
        for (cell, (&least, &is_occupied)) in bounds.iter().zip(is_occupied).enumerate() {
            if is_occupied {
                folds.least_det = folds.least_det.min(least);
            }
            if least <= 0.0 {
                folds.cells.push(self.grid.cell_place(cell).map(|place| place + margin));
                folds.occupied_count += usize::from(is_occupied);
            }
        }
        if folds.least_det == f64::INFINITY {
            folds.least_det = 1.0;
        }
        folds
    }

    /// Cells between handles (column, row, ...), 0..dims−1, in which the warp turns over, occupied or not.
    #[must_use]
    pub fn folded_cells(&self) -> Vec<[usize; D]> {
        self.folds(&vec![true; self.grid.cell_count()]).cells
    }

    /// A lower bound of det J for each cell, with the right sign; near to the least of the occupied cells in one of them.
    fn proven_bounds(&self, is_occupied: &[bool]) -> Vec<f64> {
        let mut bounds = self.rough_bounds();
        let is_open = |cell: &usize| is_occupied[*cell] || bounds[*cell] <= 0.0;
        let mut open: Vec<usize> = (0..bounds.len()).filter(is_open).collect();
        // The worst first, so that most cells need no more than their rough bound: far from a fold, and not the worst.
        open.sort_unstable_by(|&a, &b| bounds[a].total_cmp(&bounds[b]));
        let mut least = f64::INFINITY;
        for cell in open {
            if bounds[cell] > 0.0 && bounds[cell] >= least {
                break;
            }
            let wanted = if is_occupied[cell] { least } else { f64::NEG_INFINITY };
            bounds[cell] = least_of(self.determinant(cell), wanted);
            if is_occupied[cell] {
                least = least.min(bounds[cell]);
            }
        }
        bounds
    }

    /// Cheap and rough lower bounds of det J, for each cell: slopes lie between the steps from handle to handle.
    fn rough_bounds(&self) -> Vec<f64> {
        if !self.handles.as_flattened().iter().all(|x| x.is_finite()) {
            return vec![f64::NEG_INFINITY; self.grid.cell_count()];
        }
        let ranges: [Vec<[[f64; 2]; D]>; D] = std::array::from_fn(|axis| self.slope_ranges(axis));
        let bound = |cell: usize| {
            let places = self.grid.cell_place(cell).into_iter().enumerate();
            let first: usize = places.map(|(axis, place)| place * self.grid.stride(axis)).sum();
            rough_determinant::<D>(&std::array::from_fn(|d| std::array::from_fn(|axis| ranges[axis][first][d])))
        };
        (0..self.grid.cell_count()).map(bound).collect()
    }

    /// For each handle: least and greatest slope along `axis`, by coordinate, among the handles of the cell that begins
    /// there. Handles without such a cell hold anything.
    fn slope_ranges(&self, axis: usize) -> Vec<[[f64; 2]; D]> {
        let side = if self.grid.basis == Basis::Bspline { 4 } else { 2_usize };
        let (count, step) = (self.handles.len(), self.grid.stride(axis));
        let per_pitch = 1.0 / self.grid.pitch(axis);
        let slope = |handle: usize| {
            let (from, to) = (&self.handles[handle], &self.handles[(handle + step).min(count - 1)]);
            std::array::from_fn(|d| [(to[d] - from[d]) * per_pitch; 2])
        };
        let mut ranges: Vec<[[f64; 2]; D]> = (0..count).map(slope).collect();
        // Each round widens the windows by one handle.
        for along in 0..D {
            let ahead = self.grid.stride(along);
            let rounds = if along == axis { side - 2 } else { side - 1 };
            for _ in 0..rounds {
                (ahead..count).for_each(|next| ranges[next - ahead] = joined(&ranges[next - ahead], &ranges[next]));
            }
        }
        ranges
    }

    /// det J in a cell of a basis that is a product of axes.
    fn determinant(&self, cell: usize) -> Patch<D> {
        let degree = if self.grid.basis == Basis::Bspline { 3 } else { 1 };
        let coordinates: [Patch<D>; D] = std::array::from_fn(|d| self.coordinate(cell, degree, d));
        let gradient: [[Patch<D>; D]; D] =
            std::array::from_fn(|row| std::array::from_fn(|axis| coordinates[row].slope(axis)));
        let minor = |a: usize, b: usize| {
            Patch::sum_of_products(&[
                (1.0, &gradient[D - 2][a], &gradient[D - 1][b]),
                (-1.0, &gradient[D - 2][b], &gradient[D - 1][a]),
            ])
        };
        let scale: f64 = (0..D).map(|axis| 1.0 / self.grid.pitch(axis)).product();
        if D == 2 {
            return minor(0, 1).scaled(scale);
        }
        let minors = [minor(1, 2), minor(2, 0), minor(0, 1)];
        let pairs: Vec<_> = gradient[0].iter().zip(&minors).map(|(slope, minor)| (scale, slope, minor)).collect();
        Patch::sum_of_products(&pairs)
    }

    /// One coordinate of the image of a cell; B-splines change to Bernstein form (Farin, section 8.1).
    fn coordinate(&self, cell: usize, degree: usize, d: usize) -> Patch<D> {
        let (side, first) = (degree + 1, self.grid.cell_place(cell));
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
        Patch::new([degree; D], values)
    }

    /// Least determinant of the D! simplices of a cell, constant in each.
    fn least_of_simplices(&self, cell: usize) -> f64 {
        let place = self.grid.cell_place(cell);
        let orders: &[[usize; 3]] = if D == 2 {
            &[[0, 1, 2], [1, 0, 2]]
        } else {
            &[[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]]
        };
        let det = |order: &[usize; 3]| {
            let within = |axis: usize| (order[axis] + 1) as f64 / (D + 1) as f64;
            let at = |axis: usize| self.grid.lo[axis] + (place[axis] as f64 + within(axis)) * self.grid.pitch(axis);
            determinant(&self.carry_with_gradient(std::array::from_fn(at)).gradient)
        };
        orders.iter().map(det).fold(f64::INFINITY, lower)
    }

    /// Least determinant of every cell over its probes, blended axis by axis; neighbours share those on their border.
    fn probe(&self) -> Vec<f64> {
        let spans = self.grid.dims.map(|count| self.grid.basis.spans(count));
        let counts = spans.map(|spans| spans * (PROBES - 1) + 1);
        let terms: [Vec<AxisTerms>; D] = std::array::from_fn(|axis| {
            let unit = |probe: usize| probe as f64 / (counts[axis] - 1) as f64;
            (0..counts[axis]).map(|probe| AxisTerms::at(self.grid.basis, self.grid.dims[axis], unit(probe))).collect()
        });
        // Planes of one coordinate each: [slope][coordinate][probe].
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
            let place = self.grid.cell_place(cell);
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

/// Blends lines of a plane, `step` apart, by as many rows of factors as wanted.
fn blend(plane: &[f64], step: usize, rows: &[&[f64]]) -> Vec<f64> {
    let count = rows.first().map_or(1, |row| row.len());
    let mut blended = vec![0.0; plane.len() / count * rows.len()];
    if step == 1 {
        // Neighbours are blended: the factors are what lies side by side.
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

/// Numbers of a line that are summed up together.
const TOGETHER: usize = 8;

/// Puts Σ factor · line, over lines as long as `sum`, one after the other.
fn sum_of_lines(factors: &[f64], lines: &[f64], sum: &mut [f64]) {
    let length = sum.len();
    for (number, slots) in sum.chunks_mut(TOGETHER).enumerate() {
        let mut sums = [0.0; TOGETHER];
        for (factor, line) in factors.iter().zip(lines.chunks_exact(length)) {
            let line = &line[number * TOGETHER..];
            if let Some(line) = line.first_chunk::<TOGETHER>() {
                sums.iter_mut().zip(line).for_each(|(sum, x)| *sum += factor * x);
            } else {
                sums.iter_mut().zip(line).for_each(|(sum, x)| *sum += factor * x);
            }
        }
        slots.copy_from_slice(&sums[..slots.len()]);
    }
}

/// Four B-spline controls become those of the same cubic's Bézier curve.
fn bezier_from_spline(values: &mut [f64], start: usize, step: usize) {
    let [a, b, c, d] = [0, 1, 2, 3].map(|k| values[start + k * step]);
    let curve = [a + 4.0 * b + c, 4.0 * b + 2.0 * c, 2.0 * b + 4.0 * c, b + 4.0 * c + d];
    curve.into_iter().enumerate().for_each(|(k, value)| values[start + k * step] = value / 6.0);
}

/// A lower bound of a polynomial's least value in its cell, with the right sign; within [`PRECISION`] of it where it may
/// be less than `wanted`. Branch and bound over halves of the cell.
fn least_of<const D: usize>(patch: Patch<D>, wanted: f64) -> f64 {
    let mut open = vec![(patch, 0)];
    let mut least = f64::INFINITY;
    while let Some((patch, depth)) = open.pop() {
        let Some(bound) = patch.bound() else { return f64::NEG_INFINITY };
        if bound >= least {
            continue;
        }
        let value = patch.least_corner();
        let is_near = value - bound <= PRECISION * value.abs().max(1.0) || bound >= wanted;
        let has_sign = bound > 0.0 || value <= 0.0;
        if is_near && has_sign || depth >= MOST_HALVINGS {
            least = bound;
        } else {
            open.extend(patch.halves(depth % D).map(|half| (half, depth + 1)));
        }
    }
    least
}

/// The ranges that hold both.
fn joined<const D: usize>(a: &[[f64; 2]; D], b: &[[f64; 2]; D]) -> [[f64; 2]; D] {
    std::array::from_fn(|d| {
        let ([low, high], [least, most]) = (a[d], b[d]);
        [if least < low { least } else { low }, if most > high { most } else { high }]
    })
}

/// A lower bound of the determinant of a matrix whose entries lie in ranges.
fn rough_determinant<const D: usize>(slopes: &[[[f64; 2]; D]; D]) -> f64 {
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

/// Least and greatest product of values from two ranges.
fn range(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let products = [a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]];
    [products.into_iter().fold(f64::INFINITY, f64::min), products.into_iter().fold(f64::NEG_INFINITY, f64::max)]
}

/// The lower of both; what is not a number is lowest.
fn lower(a: f64, b: f64) -> f64 {
    if b.is_nan() || b < a { if b.is_nan() { f64::NEG_INFINITY } else { b } } else { a }
}

/// Determinant of a 2 x 2 or 3 x 3 matrix, by rows or columns.
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
    use crate::lattice::Grid;

    fn grid(basis: Basis) -> Grid<2> {
        Grid { dims: [8, 7], basis, lo: [-1.0, 0.0], hi: [1.0, 1.5] }
    }

    const ALL: [Basis; 4] = [Basis::Bspline, Basis::Bernstein, Basis::Bilinear, Basis::Barytri];

    /// Least det J over a fine net of points of every cell.
    fn searched<const D: usize>(lattice: &Lattice<D>, fineness: usize) -> Vec<f64> {
        let side = |axis: usize| lattice.grid.basis.spans(lattice.grid.dims[axis]);
        let within = |k: usize| (k as f64 + 0.5) / fineness as f64;
        let least = |cell: usize| {
            let place = lattice.grid.cell_place(cell);
            let dets = (0..fineness.pow(D as u32)).map(|number| {
                let at = |axis: usize| {
                    let k = number / fineness.pow(axis as u32) % fineness;
                    let share = (place[axis] as f64 + within(k)) / side(axis) as f64;
                    lattice.grid.lo[axis] + share * lattice.grid.size(axis)
                };
                determinant(&lattice.carry_with_gradient(std::array::from_fn(at)).gradient)
            });
            dets.fold(f64::INFINITY, f64::min)
        };
        (0..lattice.grid.cell_count()).map(least).collect()
    }

    fn shake<const D: usize>(grid: &Grid<D>, amount: f64) -> Lattice<D> {
        let mut lattice = grid.at_rest();
        for (k, x) in lattice.handles.as_flattened_mut().iter_mut().enumerate() {
            *x += amount * grid.pitch(k % D) * (12.9898 * k as f64).sin();
        }
        lattice
    }

    #[test]
    fn the_bound_is_the_least_determinant_that_a_fine_search_finds() {
        for basis in ALL {
            let lattice = shake(&grid(basis), 0.4);
            let found = searched(&lattice, 40);
            for (cell, found) in found.into_iter().enumerate() {
                let only: Vec<bool> = (0..lattice.grid.cell_count()).map(|other| other == cell).collect();
                let bound = lattice.folds(&only).least_det;
                assert!(bound <= found + 1e-9 || basis == Basis::Bernstein, "{basis:?} {cell}: {bound} {found}");
                assert!(bound > found - 0.04, "{basis:?} {cell}: {bound} {found}");
            }
        }
    }

    #[test]
    fn cells_of_space_are_searched_too() {
        for basis in ALL {
            let lattice = shake(&Grid { dims: [5, 5, 5], basis, lo: [0.0; 3], hi: [1.0, 2.0, 1.0] }, 0.5);
            let least = searched(&lattice, 9).into_iter().fold(f64::INFINITY, f64::min);
            let folds = lattice.folds(&vec![true; lattice.grid.cell_count()]);
            assert!(folds.least_det < least + 0.05 && folds.least_det > least - 0.2, "{basis:?} {folds:?} {least}");
            assert_eq!(folds.cells.is_empty(), folds.least_det > 0.0);
        }
    }

    #[test]
    fn a_fold_between_corners_and_middle_is_found() {
        let rest = Grid { dims: [4, 4], basis: Basis::Bspline, lo: [0.0; 2], hi: [1.0; 2] }.at_rest();
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
        assert!(crease.folds(&[false]).least_det == 1.0 && crease.folds(&[true]).least_det < 0.0);
    }

    #[test]
    fn a_handle_pulled_across_its_neighbours_folds_cells_around_it() {
        for basis in [Basis::Bspline, Basis::Bilinear, Basis::Barytri] {
            let mut lattice = Grid { dims: [8, 8], basis, lo: [0.0, 0.0], hi: [1.0, 1.0] }.at_rest();
            assert_eq!(lattice.folded_cells(), Vec::<[usize; 2]>::new());
            lattice.handles[4 + 8 * 4][0] += 2.0;
            let folded = lattice.folded_cells();
            assert!(!folded.is_empty() && folded.iter().all(|cell| cell.iter().all(|place| (2..=6).contains(place))));
        }
    }

    #[test]
    fn a_mirrored_lattice_is_folded_everywhere_and_a_nan_counts_as_folded() {
        for basis in ALL {
            let mut lattice = Grid { dims: [4, 5], basis, lo: [0.0, 0.0], hi: [1.0, 1.0] }.at_rest();
            lattice.handles.iter_mut().for_each(|handle| handle[0] = -handle[0]);
            let count = lattice.grid.cell_count();
            assert_eq!(lattice.folded_cells().len(), count);
            let mut broken = lattice.grid.at_rest();
            broken.handles[0] = [f64::NAN; 2];
            assert!(!broken.folded_cells().is_empty());
        }
    }
}
