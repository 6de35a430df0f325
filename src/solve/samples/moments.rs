//! Area, centroid and covariance of the model inside every sub-cell of a grid, and the samples that match them.
//!
//! In: triangles (any orientation, slivers, overlaps) and the sub-cells of a box. Out: samples. A triangle inside one sub-cell
//! adds its moments as a whole; only triangles that cross borders are clipped.

use super::clip::Polygon;
use super::sample::{Sample, subcell_dims};
use crate::lattice::Grid;
use crate::solve::linalg::small_matrix::{area_of, minus, symmetric_root};
use crate::solve::problem::Shape;
use rayon::prelude::*;

/// Triangles per task. The number is fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 1 << 15;

/// Maximum distance of a sample that must stay inside its sub-cell, as a fraction of the distance from the pair's midpoint to the
/// border.
const INSIDE: f64 = 0.999;

/// Moments about the centre of a sub-cell.
#[derive(Clone, Copy, Debug)]
struct Moments<const D: usize> {
    area: f64,
    /// Area times stiffness.
    stiff: f64,
    first: [f64; D],
    second: [[f64; D]; D],
}

impl<const D: usize> Moments<D> {
    const NONE: Self = Self { area: 0.0, stiff: 0.0, first: [0.0; D], second: [[0.0; D]; D] };

    fn add(&mut self, other: &Self) {
        self.area += other.area;
        self.stiff += other.stiff;
        for a in 0..D {
            self.first[a] += other.first[a];
            (0..D).for_each(|b| self.second[a][b] += other.second[a][b]);
        }
    }

    /// Adds a triangle whose corners are relative to the centre: ∫xxᵀ = A/12 (Σ v vᵀ + 9 c cᵀ), with c the centroid.
    fn add_triangle(&mut self, corners: [[f64; D]; 3], stiffness: f64) {
        let [v0, v1, v2] = corners;
        let area = 0.5 * area_of(&minus(&v1, &v0), &minus(&v2, &v0));
        let sum: [f64; D] = std::array::from_fn(|d| v0[d] + v1[d] + v2[d]);
        let (third, twelfth) = (area / 3.0, area / 12.0);
        self.area += area;
        self.stiff += area * stiffness;
        for a in 0..D {
            self.first[a] += third * sum[a];
            for b in 0..D {
                let squares = v0[a] * v0[b] + v1[a] * v1[b] + v2[a] * v2[b];
                self.second[a][b] += twelfth * (squares + sum[a] * sum[b]);
            }
        }
    }

    /// Appends 2 D points, centre + c ± s_k with s_k the columns of √D·Σ^½, of equal area and with the same first and second
    /// moments.
    fn samples(&self, middle: [f64; D], samples: &mut Vec<Sample<D>>) {
        let mean = self.first.map(|x| x / self.area);
        let covariance =
            std::array::from_fn(|a| std::array::from_fn(|b| self.second[a][b] / self.area - mean[a] * mean[b]));
        let root = symmetric_root::<D>(&covariance);
        let (spread, area) = ((D as f64).sqrt(), self.area / (2 * D) as f64);
        // The root is symmetric, so its rows are its columns.
        for column in &root {
            for sign in [-spread, spread] {
                let at = std::array::from_fn(|d| middle[d] + mean[d] + sign * column[d]);
                samples.push(Sample { at, area, stiffness: self.stiff / self.area });
            }
        }
    }
}

/// The sub-cells of a grid.
#[derive(Clone, Copy, Debug)]
struct Layout<const D: usize> {
    dims: [usize; D],
    lo: [f64; D],
    side: [f64; D],
}

impl<const D: usize> Layout<D> {
    fn of(grid: &Grid<D>) -> Self {
        let dims = subcell_dims(grid);
        Self { dims, lo: grid.lo, side: std::array::from_fn(|axis| grid.size(axis) / dims[axis] as f64) }
    }

    fn count(&self) -> usize {
        self.dims.iter().product()
    }

    /// Cell index of a coordinate; an index below 0, or `dims` and above, lies outside the box.
    fn cell(&self, axis: usize, x: f64) -> f64 {
        let place = (x - self.lo[axis]) / self.side[axis];
        // Without SSE 4.1 `floor` is a function call. Beyond the range of integers any index outside the box is correct.
        let whole = place as i64 as f64;
        if whole > place { whole - 1.0 } else { whole }
    }

    fn border(&self, axis: usize, cell: usize) -> f64 {
        self.lo[axis] + cell as f64 * self.side[axis]
    }

    fn middle(&self, place: [usize; D]) -> [f64; D] {
        std::array::from_fn(|axis| self.border(axis, place[axis]) + 0.5 * self.side[axis])
    }

    fn number(&self, place: [usize; D]) -> usize {
        (0..D).rev().fold(0, |number, axis| number * self.dims[axis] + place[axis])
    }

    fn place(&self, number: usize) -> [usize; D] {
        std::array::from_fn(|axis| number / self.dims[..axis].iter().product::<usize>() % self.dims[axis])
    }
}

/// Moments of a shape in all sub-cells.
#[derive(Clone, Debug)]
pub(super) struct Subcells<const D: usize> {
    layout: Layout<D>,
    cells: Vec<Moments<D>>,
    /// Stiffness of the triangle that is being added.
    stiffness: f64,
}

impl<const D: usize> Subcells<D> {
    /// Distributes a shape over the sub-cells of a grid; parts outside the box are dropped.
    pub(super) fn of(grid: &Grid<D>, shape: &Shape<D>) -> Self {
        let layout = Layout::of(grid);
        let empty = Self { layout, cells: vec![Moments::NONE; layout.count()], stiffness: 1.0 };
        let spread = |(chunk, triangles): (usize, &[[u32; 3]])| {
            let mut part = empty.clone();
            for (number, triangle) in triangles.iter().enumerate() {
                part.stiffness = shape.stiffness_of(chunk * CHUNK + number);
                part.add_triangle(triangle.map(|corner| shape.points[corner as usize]));
            }
            part
        };
        if shape.triangles.len() <= CHUNK {
            return spread((0, &shape.triangles));
        }
        let parts: Vec<Self> = shape.triangles.par_chunks(CHUNK).enumerate().map(spread).collect();
        let mut total = empty;
        for part in &parts {
            total.cells.iter_mut().zip(&part.cells).for_each(|(cell, other)| cell.add(other));
        }
        total
    }

    /// Distributes polygons in a cell of a grid, each with its stiffness, over the sub-cells of that cell.
    pub(super) fn in_cell<'a>(
        grid: &Grid<D>,
        cell: usize,
        polygons: impl Iterator<Item = (&'a Polygon<D>, f64)>,
    ) -> Self {
        let whole = Layout::of(grid);
        let place = grid.cell_coords(cell);
        let dims = std::array::from_fn(|axis| whole.dims[axis] / grid.basis.spans(grid.dims[axis]));
        let lo = std::array::from_fn(|axis| grid.lo[axis] + place[axis] as f64 * grid.spacing(axis));
        let layout = Layout { dims, lo, ..whole };
        let mut own = Self { layout, cells: vec![Moments::NONE; layout.count()], stiffness: 1.0 };
        for (polygon, stiffness) in polygons {
            own.stiffness = stiffness;
            let corners = polygon.corners();
            (2..corners.len()).for_each(|k| own.add_triangle([corners[0], corners[k - 1], corners[k]]));
        }
        own
    }

    fn add_triangle(&mut self, corners: [[f64; D]; 3]) {
        let mut place = [0; D];
        for axis in 0..D {
            let cells = corners.map(|corner| self.layout.cell(axis, corner[axis]));
            let most = self.layout.dims[axis] as f64;
            let low = cells[0].min(cells[1]).min(cells[2]);
            let high = cells[0].max(cells[1]).max(cells[2]);
            if high < 0.0 || low > most {
                return;
            }
            if low != high || low < 0.0 || low >= most {
                return self.cut(&mut Polygon::triangle(corners), 0, [0; D]);
            }
            place[axis] = low as usize;
        }
        self.add_piece(corners, place);
    }

    fn add_piece(&mut self, corners: [[f64; D]; 3], place: [usize; D]) {
        let middle = self.layout.middle(place);
        let cell = &mut self.cells[self.layout.number(place)];
        cell.add_triangle(corners.map(|corner| minus(&corner, &middle)), self.stiffness);
    }

    /// Cuts a polygon into the slabs of cells along each axis in turn, and adds the pieces to their sub-cells.
    fn cut(&mut self, polygon: &mut Polygon<D>, axis: usize, mut place: [usize; D]) {
        if axis == D {
            let corners = polygon.corners();
            for k in 2..corners.len() {
                self.add_piece([corners[0], corners[k - 1], corners[k]], place);
            }
            return;
        }
        let [low, high] = polygon.range(axis).map(|x| self.layout.cell(axis, x));
        let most = self.layout.dims[axis] as f64;
        if high < 0.0 || low > most {
            return;
        }
        if low < 0.0 {
            polygon.split_off(axis, self.layout.lo[axis]);
        }
        let last = high.min(most - 1.0) as usize;
        for cell in low.max(0.0) as usize..=last {
            place[axis] = cell;
            if cell as f64 == high {
                return self.cut(polygon, axis + 1, place);
            }
            let mut below = polygon.split_off(axis, self.layout.border(axis, cell + 1));
            self.cut(&mut below, axis + 1, place);
        }
    }

    /// Returns the samples, each pair moved together until both lie inside their sub-cell. Samples that match the covariance
    /// leave the sub-cell where the model lies at two ends of it. Sub-cells with an area of at most `least` are left out.
    pub(super) fn samples_inside(&self, least: f64) -> Vec<Sample<D>> {
        let mut samples = self.samples_above(least);
        for pair in samples.chunks_exact_mut(2) {
            let middle: [f64; D] = std::array::from_fn(|axis| f64::midpoint(pair[0].at[axis], pair[1].at[axis]));
            let mut share: f64 = 1.0;
            for (axis, &middle) in middle.iter().enumerate() {
                let place = self.layout.cell(axis, middle).clamp(0.0, (self.layout.dims[axis] - 1) as f64);
                let low = self.layout.border(axis, place as usize);
                let room = (middle - low).min(low + self.layout.side[axis] - middle).max(0.0);
                let spread = 0.5 * (pair[1].at[axis] - pair[0].at[axis]).abs();
                if spread > INSIDE * room {
                    share = share.min(INSIDE * room / spread);
                }
            }
            for sample in pair {
                sample.at = std::array::from_fn(|axis| middle[axis] + share * (sample.at[axis] - middle[axis]));
            }
        }
        samples
    }

    /// Returns the samples of all sub-cells that contain some of the model, in cell order.
    pub(super) fn samples(&self) -> Vec<Sample<D>> {
        let total: f64 = self.cells.iter().map(|cell| cell.area).sum();
        // Areas at a border that are only rounding errors are ignored.
        self.samples_above(1e-12 * total)
    }

    /// Returns the samples of all sub-cells with a larger area, in cell order.
    fn samples_above(&self, least: f64) -> Vec<Sample<D>> {
        let mut samples = Vec::new();
        for (number, cell) in self.cells.iter().enumerate() {
            if cell.area > least {
                cell.samples(self.layout.middle(self.layout.place(number)), &mut samples);
            }
        }
        samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;
    use proptest::prelude::*;

    fn grid() -> Grid<2> {
        Grid { dims: [6, 5], basis: Basis::Bspline, lo: [0.0, 0.0], hi: [1.0, 1.0], angle: 0.0 }
    }

    /// Area, first and second moments of samples about the origin.
    fn moments_of(samples: impl Iterator<Item = Sample<2>>) -> [f64; 6] {
        let mut sums = [0.0; 6];
        for Sample { at: [x, y], area, .. } in samples {
            for (sum, value) in sums.iter_mut().zip([1.0, x, y, x * x, x * y, y * y]) {
                *sum += area * value;
            }
        }
        sums
    }

    /// Dense reference: the midpoints of the sides of a triangle integrate quadratics exactly.
    fn dense(shape: &Shape<2>) -> impl Iterator<Item = Sample<2>> {
        shape.triangles.iter().flat_map(|triangle| {
            let corners = triangle.map(|corner| shape.points[corner as usize]);
            let area = 0.5 * area_of(&minus(&corners[1], &corners[0]), &minus(&corners[2], &corners[0]));
            (0..3).map(move |k| {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                Sample { at: [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])], area: area / 3.0, stiffness: 1.0 }
            })
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn samples_have_the_moments_of_the_model(
            points in prop::collection::vec([0.0..1.0_f64, 0.0..1.0_f64], 3..9), thin in 0.0..1.0_f64,
        ) {
            let mut shape = Shape::of_triangles(points, Vec::new());
            // A sliver as thin as rounding allows, on the line between two corners.
            let [a, b] = [shape.points[0], shape.points[1]];
            shape.points.push([a[0] + thin * (b[0] - a[0]), a[1] + thin * (b[1] - a[1])]);
            let count = shape.points.len() as u32;
            shape.triangles = (0..count).map(|k| [k, (k + 1) % count, (k + 3) % count]).collect();
            shape.triangles.push([0, 1, count - 1]);
            let found = moments_of(Subcells::of(&grid(), &shape).samples().into_iter());
            let wanted = moments_of(dense(&shape));
            for (found, wanted) in found.iter().zip(wanted) {
                // Sub-cells with less than 1e-12 of the area are dropped.
                prop_assert!((found - wanted).abs() < 1e-10 * (1.0 + wanted), "{found} {wanted}");
            }
        }

        #[test]
        fn what_lies_outside_the_box_is_left_out(x in -3.0..3.0_f64, y in -3.0..3.0_f64) {
            let points = vec![[x, y], [x + 5.0, y], [x, y + 5.0], [x + 5.0, y + 5.0]];
            let shape = Shape::of_triangles(points, vec![[0, 1, 2], [3, 1, 2]]);
            let found = moments_of(Subcells::of(&grid(), &shape).samples().into_iter())[0];
            let side = |from: f64| ((from + 5.0).min(1.0) - from.max(0.0)).max(0.0);
            prop_assert!((found - side(x) * side(y)).abs() < 1e-9);
        }
    }

    #[test]
    fn samples_of_a_polygon_in_a_cell_have_its_moments_and_stay_in_the_cell() {
        let corners = [[0.35, 0.55], [0.6, 0.6], [0.4, 0.95]];
        let polygon = Polygon::triangle(corners);
        // The middle cell of the upper row.
        let cells = Subcells::in_cell(&grid(), 4, [(&polygon, 2.0)].into_iter());
        let wanted = moments_of(dense(&Shape::of_triangles(corners.to_vec(), vec![[0, 1, 2]])));
        let found = moments_of(cells.samples_above(0.0).into_iter());
        assert!(found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-12), "{found:?} {wanted:?}");
        let inside = cells.samples_inside(0.0);
        let found = moments_of(inside.iter().copied());
        assert!((0..3).all(|k| (found[k] - wanted[k]).abs() < 1e-12), "{found:?} {wanted:?}");
        assert!(inside.iter().all(|Sample { at: [x, y], stiffness, .. }| {
            (1.0 / 3.0..2.0 / 3.0).contains(x) && (0.5..1.0).contains(y) && *stiffness == 2.0
        }));
    }

    #[test]
    fn samples_stay_near_their_cell_and_every_cell_has_four() {
        let points = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let shape = Shape::of_triangles(points, vec![[0, 1, 2], [0, 3, 2]]);
        let samples = Subcells::of(&grid(), &shape).samples();
        assert_eq!(samples.len(), 4 * 9 * 6);
        assert!(samples.iter().flat_map(|sample| sample.at).all(|x| (0.0..=1.0).contains(&x)));
    }
}
