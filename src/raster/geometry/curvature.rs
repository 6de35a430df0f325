//! The curvature of a lattice's warp, as a table that answers whether an edge may remain a straight line.
//!
//! In: a lattice. Out: an upper estimate of the second derivative of its warp over any square of the screen.

use crate::lattice::{Grid, ScreenLattice};
use crate::solve::Bending;
use crate::space::ScreenPoint;
use glam::{DMat2, DVec2};

/// Maximum deviation of an edge from its warped curve in frame heights: a twentieth of a pixel at 1000 lines.
pub(super) const TOLERANCE: f64 = 5e-5;

/// Minimum length of split edges, however strong the warp: a pixel at 1000 lines. It bounds the number of pieces.
pub(super) const MIN_LENGTH: f64 = 1e-3;

/// The maximum second derivative in each cell of a regular table over the lattice box, and in blocks of 2x2 cells, and so on up to
/// one block.
pub(super) struct Curvature {
    /// The grid, whose box may be rotated; `lo` and `size` are those of the box before its rotation.
    grid: Grid<2>,
    lo: DVec2,
    size: DVec2,
    /// `levels[l]` holds blocks of 2^l cells a side.
    levels: Vec<Level>,
    /// Maximum jump of the gradient across the border of the box.
    kink: f64,
}

/// The maxima over equal blocks of cells.
struct Level {
    /// Rows from below.
    blocks: Vec<f64>,
    /// Number of blocks along each axis.
    counts: [usize; 2],
}

impl Curvature {
    /// Samples a lattice at twice the density of its handles.
    pub(super) fn of(lattice: &ScreenLattice) -> Self {
        let side = (2 * lattice.grid.dims[0].max(lattice.grid.dims[1])).next_power_of_two().clamp(16, 128);
        let (lo, size) = corner_and_size(&lattice.grid);
        let place = |i: usize, j: usize| {
            let upright = lo + size * (DVec2::new(i as f64, j as f64) / side as f64);
            ScreenPoint(lattice.grid.point_from_upright(upright.to_array()).into())
        };
        let row = |j: usize| (0..=side).map(move |i| lattice.jacobian(place(i, j))).collect::<Vec<_>>();
        let gradients: Vec<Vec<DMat2>> = (0..=side).map(row).collect();
        let step = size / side as f64;
        let cells = (0..side * side)
            .map(|cell| {
                let (i, j) = (cell % side, cell / side);
                let [a, b, c, d] = [gradients[j][i], gradients[j][i + 1], gradients[j + 1][i], gradients[j + 1][i + 1]];
                let across = change(a, b).max(change(c, d)) / step.x;
                let up = change(a, c).max(change(b, d)) / step.y;
                across.max(up)
            })
            .collect();
        let border = (0..=side).flat_map(|k| [(0, k), (side, k), (k, 0), (k, side)]);
        let kink = border.map(|(i, j)| change(gradients[j][i], DMat2::IDENTITY)).fold(0.0, f64::max);
        Self { grid: lattice.grid.clone(), lo, size, levels: pyramid(cells, [side; 2]), kink }
    }

    /// The curvature of one branch of a lattice: 0 where the branch does not contain the shape.
    pub(super) fn of_branch(grid: &Grid<2>, bending: &Bending) -> Self {
        let (lo, size) = corner_and_size(grid);
        let levels = pyramid(bending.cells.clone(), bending.counts);
        Self { grid: grid.clone(), lo, size, levels, kink: bending.strain_at_border }
    }

    /// Returns whether the warp of the edge from `a` to `b` needs more than a straight line. Symmetric in its ends.
    ///
    /// The square around the edge's disc is tested, not only the edge: the discs over a triangle's three sides cover
    /// the triangle, so a triangle whose edges all remain straight is flat inside, too.
    pub(super) fn bends(&self, [a, b]: [DVec2; 2]) -> bool {
        let length = a.distance(b);
        if length < MIN_LENGTH {
            return false;
        }
        let [a, b] = [a, b].map(|point| DVec2::from(self.grid.upright_from_point(point.to_array())));
        let strays = self.greatest((a + b) * 0.5, length * 0.5) * length * length / 8.0;
        let crosses = self.holds(a) != self.holds(b);
        let kinks = if crosses { self.kink * length / 4.0 } else { 0.0 };
        strays.max(kinks) > TOLERANCE
    }

    fn holds(&self, point: DVec2) -> bool {
        let t = (point - self.lo) / self.size;
        t.cmpge(DVec2::ZERO).all() && t.cmple(DVec2::ONE).all()
    }

    /// Returns the maximum second derivative in the square around `center`.
    fn greatest(&self, center: DVec2, half: f64) -> f64 {
        let last = DVec2::from(self.levels[0].counts.map(|count| count as f64));
        let cells = last / self.size;
        let low = (center - half - self.lo) * cells;
        let high = (center + half - self.lo) * cells;
        if high.cmplt(DVec2::ZERO).any() || low.cmpgt(last).any() {
            return 0.0;
        }
        let first = low.clamp(DVec2::ZERO, last - 1.0).as_usizevec2();
        let end = high.clamp(DVec2::ZERO, last - 1.0).as_usizevec2();
        let span = (end - first).max_element() + 1;
        let level = (span.next_power_of_two().trailing_zeros() as usize).min(self.levels.len() - 1);
        let Level { blocks, counts: [columns, _] } = &self.levels[level];
        let rows = first.y >> level..=end.y >> level;
        rows.flat_map(|j| (first.x >> level..=end.x >> level).map(move |i| blocks[i + columns * j])).fold(0.0, f64::max)
    }
}

/// Returns the lower left corner and the size of a grid's box before its rotation.
fn corner_and_size(grid: &Grid<2>) -> (DVec2, DVec2) {
    let lo = DVec2::from_array(grid.lo);
    (lo, DVec2::from_array(grid.hi) - lo)
}

/// Returns the Frobenius norm of the difference between two gradients.
fn change(a: DMat2, b: DMat2) -> f64 {
    let difference = a - b;
    (difference.x_axis.length_squared() + difference.y_axis.length_squared()).sqrt()
}

/// Returns the maxima over blocks of 1, 2, 4, ... cells a side.
fn pyramid(cells: Vec<f64>, counts: [usize; 2]) -> Vec<Level> {
    let mut levels = vec![Level { blocks: cells, counts }];
    loop {
        let Level { blocks: below, counts } = &levels[levels.len() - 1];
        if counts.iter().all(|&count| count <= 1) {
            return levels;
        }
        let halves = counts.map(|count| count.div_ceil(2));
        let block = |k: usize| {
            let [columns, rows] = [(k % halves[0], counts[0]), (k / halves[0], counts[1])]
                .map(|(block, count)| 2 * block..(2 * block + 2).min(count));
            let within = rows.flat_map(|j| columns.clone().map(move |i| below[i + counts[0] * j]));
            within.fold(0.0, f64::max)
        };
        let level = Level { blocks: (0..halves[0] * halves[1]).map(block).collect(), counts: halves };
        levels.push(level);
    }
}
