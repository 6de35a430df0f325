//! The support of a handle, and its distance from links.
//!
//! In: a handle. Out: the cells of its support; distances in spans, negative inside.

use super::adjacency::PlacedLink;
use super::link::LinkKind;
use crate::lattice::Grid;

/// The open support of a handle of a tensor basis.
#[derive(Clone, Copy, Debug)]
pub(super) struct SupportBox<const D: usize> {
    /// First and last cell of each axis.
    pub(super) cells: [[usize; 2]; D],
    /// Borders on each axis; infinite at the border of the grid, because parts outside belong to the nearest cell.
    borders: [[f64; 2]; D],
    spacing: [f64; D],
}

impl<const D: usize> SupportBox<D> {
    /// `width` is the number of handles with a non-zero weight at a coordinate.
    pub(super) fn of(grid: &Grid<D>, width: usize, handle: usize) -> Self {
        let place = grid.handle_coords(handle);
        let last = grid.dims.map(|count| grid.basis.spans(count) - 1);
        let cells: [[usize; 2]; D] =
            std::array::from_fn(|axis| [place[axis].saturating_sub(width - 1), place[axis].min(last[axis])]);
        let border = |axis: usize, span: usize| grid.lo[axis] + span as f64 * grid.spacing(axis);
        let borders = std::array::from_fn(|axis| {
            let [low, high] = cells[axis];
            [
                if low == 0 { f64::NEG_INFINITY } else { border(axis, low) },
                if high == last[axis] { f64::INFINITY } else { border(axis, high + 1) },
            ]
        });
        Self { cells, borders, spacing: std::array::from_fn(|axis| grid.spacing(axis)) }
    }

    /// The range of cells extended by one cell on all sides, inside the grid.
    pub(super) fn grown(&self, grid: &Grid<D>) -> [[usize; 2]; D] {
        std::array::from_fn(|axis| {
            let [low, high] = self.cells[axis];
            [low.saturating_sub(1), (high + 1).min(grid.basis.spans(grid.dims[axis]) - 1)]
        })
    }

    /// Whether the box connects the triangles of a link: an edge connects them if the box meets it, a link across a gap or a solid if
    /// both ends are inside.
    pub(super) fn connects(&self, link: &PlacedLink<D>) -> bool {
        let [from, to] = link.ends.map(|end| self.is_inside(&end));
        match link.kind {
            LinkKind::Edge => from || to || (!self.is_beyond(&link.ends, 0.0) && self.growth(&link.ends) < 0.0),
            LinkKind::Across => from && to,
        }
    }

    /// [`Self::growth_to`] if it is below 1.
    pub(super) fn growth_below_one(&self, link: &PlacedLink<D>) -> Option<f64> {
        let is_far = link.kind == LinkKind::Edge && self.is_beyond(&link.ends, 1.0);
        let growth = if is_far { 1.0 } else { self.growth_to(link) };
        (growth < 1.0).then_some(growth)
    }

    fn is_inside(&self, point: &[f64; D]) -> bool {
        (0..D).all(|axis| self.borders[axis][0] < point[axis] && point[axis] < self.borders[axis][1])
    }

    /// Whether both ends of a segment are beyond the same border, by at least `spans`.
    fn is_beyond(&self, ends: &[[f64; D]; 2], spans: f64) -> bool {
        (0..D).any(|axis| {
            let ([low, high], by) = (self.borders[axis], spans * self.spacing[axis]);
            ends.iter().all(|end| end[axis] <= low - by) || ends.iter().all(|end| end[axis] >= high + by)
        })
    }

    /// Growth of the box on all sides, in spans, at which it connects the triangles of a link; negative if it already does.
    fn growth_to(&self, link: &PlacedLink<D>) -> f64 {
        match link.kind {
            LinkKind::Edge => self.growth(&link.ends),
            LinkKind::Across => {
                let [from, to] = link.ends.map(|end| self.growth(&[end, end]));
                from.max(to)
            }
        }
    }

    /// Growth of the box on all sides, in spans, at which it meets a segment; negative if it already does.
    fn growth(&self, ends: &[[f64; D]; 2]) -> f64 {
        // The signed distance from each border is linear along the segment. The minimum of the largest distance is at an end, or
        // where two distances are equal.
        let mut lines = [[0.0; 2]; 6];
        let mut count = 0;
        for (axis, [low, high]) in self.borders.into_iter().enumerate() {
            for (border, sign) in [(low, -1.0), (high, 1.0)] {
                if border.is_finite() {
                    lines[count] = [0, 1].map(|end| sign * (ends[end][axis] - border) / self.spacing[axis]);
                    count += 1;
                }
            }
        }
        let lines = &lines[..count];
        let greatest = |t: f64| lines.iter().map(|[a, b]| a + t * (b - a)).fold(f64::NEG_INFINITY, f64::max);
        let mut least = greatest(0.0).min(greatest(1.0));
        for (k, [a, b]) in lines.iter().enumerate() {
            for [c, d] in &lines[k + 1..] {
                let t = (c - a) / ((b - a) - (d - c));
                if t > 0.0 && t < 1.0 {
                    least = least.min(greatest(t));
                }
            }
        }
        least
    }
}

/// Indices of all cells in a range per axis, x fastest.
pub(super) fn cells_between<const D: usize>(grid: &Grid<D>, ranges: [[usize; 2]; D]) -> Vec<usize> {
    let mut cells = vec![0];
    for axis in (0..D).rev() {
        let spans = grid.basis.spans(grid.dims[axis]);
        let [low, high] = ranges[axis];
        cells = cells.iter().flat_map(|cell| (low..=high).map(move |place| cell * spans + place)).collect();
    }
    cells
}
