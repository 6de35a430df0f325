//! Boxes of cells, such as the support of a handle, and their distance from links.
//!
//! In: a handle or a cell. Out: the cells of the box; distances in spans, negative inside.

use super::adjacency::PlacedLink;
use super::link::LinkKind;
use crate::lattice::Grid;

/// Distance from a border, in spans, within which rounding may put a point on the other side.
pub(super) const ROUNDING: f64 = 1e-9;

/// An open box of cells: the support of a handle of a tensor basis, or a single cell.
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
        Self::around(
            grid,
            std::array::from_fn(|axis| [place[axis].saturating_sub(width - 1), place[axis].min(last[axis])]),
        )
    }

    /// A single cell.
    pub(super) fn of_cell(grid: &Grid<D>, cell: usize) -> Self {
        Self::around(grid, grid.cell_coords(cell).map(|place| [place; 2]))
    }

    /// The box of these cells.
    fn around(grid: &Grid<D>, cells: [[usize; 2]; D]) -> Self {
        let last = grid.dims.map(|count| grid.basis.spans(count) - 1);
        let borders = std::array::from_fn(|axis| {
            let [low, high] = cells[axis];
            [
                if low == 0 { f64::NEG_INFINITY } else { border(grid, axis, low) },
                if high == last[axis] { f64::INFINITY } else { border(grid, axis, high + 1) },
            ]
        });
        Self { cells, borders, spacing: std::array::from_fn(|axis| grid.spacing(axis)) }
    }

    /// The cells that a segment may meet.
    pub(super) fn cells_around(grid: &Grid<D>, ends: &[[f64; D]; 2]) -> Vec<usize> {
        let range = |axis: usize| {
            let [low, high] = [ends[0][axis].min(ends[1][axis]), ends[0][axis].max(ends[1][axis])];
            [span_of(grid, axis, low, -ROUNDING), span_of(grid, axis, high, ROUNDING)]
        };
        cells_between(grid, std::array::from_fn(range))
    }

    /// The cell that contains a point; `None` if it lies on a border between cells.
    pub(super) fn cell_inside(grid: &Grid<D>, point: &[f64; D]) -> Option<usize> {
        let mut cell = 0;
        for axis in (0..D).rev() {
            let count = grid.basis.spans(grid.dims[axis]);
            let span = span_of(grid, axis, point[axis], 0.0);
            let is_inside = (span == 0 || border(grid, axis, span) < point[axis])
                && (span + 1 == count || point[axis] < border(grid, axis, span + 1));
            if !is_inside {
                return None;
            }
            cell = cell * count + span;
        }
        Some(cell)
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
            LinkKind::Edge => from || to || (!self.is_beyond(&link.ends) && self.growth(&link.ends) < 0.0),
            LinkKind::Across => from && to,
        }
    }

    /// Growth of the box on all sides, in spans, at which it connects the triangles of a link: 0 if it already does; `None` from 1 on.
    pub(super) fn growth_below_one(&self, link: &PlacedLink<D>) -> Option<f64> {
        let growth = match link.kind {
            LinkKind::Edge => self.outer_growth(&link.ends),
            LinkKind::Across => {
                let [from, to] = link.ends.map(|end| self.distance(&end));
                from.max(to)
            }
        };
        (growth < 1.0).then_some(growth)
    }

    /// Distance of a point from the box along the axis on which it is farthest, in spans; 0 inside.
    fn distance(&self, point: &[f64; D]) -> f64 {
        let along = |axis: usize| {
            let [low, high] = self.borders[axis];
            (low - point[axis]).max(point[axis] - high) / self.spacing[axis]
        };
        (0..D).map(along).fold(0.0, f64::max)
    }

    /// [`Self::growth`] if it is above 0, else 0. Most segments have one border beyond which they lie, if any.
    fn outer_growth(&self, ends: &[[f64; D]; 2]) -> f64 {
        let mut nearest_beyond = 0.0_f64;
        let mut count = 0;
        for (axis, [low, high]) in self.borders.into_iter().enumerate() {
            let [from, to] = [ends[0][axis], ends[1][axis]];
            for nearest in [low - from.max(to), from.min(to) - high] {
                nearest_beyond = nearest_beyond.max(nearest / self.spacing[axis]);
            }
            count += usize::from(low > from.min(to)) + usize::from(from.max(to) > high);
        }
        if count > 1 && nearest_beyond < 1.0 { self.growth(ends).max(0.0) } else { nearest_beyond }
    }

    fn is_inside(&self, point: &[f64; D]) -> bool {
        (0..D).all(|axis| self.borders[axis][0] < point[axis] && point[axis] < self.borders[axis][1])
    }

    /// Whether both ends of a segment are beyond the same border.
    fn is_beyond(&self, ends: &[[f64; D]; 2]) -> bool {
        (0..D).any(|axis| {
            let [low, high] = self.borders[axis];
            ends.iter().all(|end| end[axis] <= low) || ends.iter().all(|end| end[axis] >= high)
        })
    }

    /// Growth of the box on all sides, in spans, at which it meets a segment; negative if it already does.
    pub(super) fn growth(&self, ends: &[[f64; D]; 2]) -> f64 {
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
        let ends = [0, 1].map(|end| lines.iter().map(|line| line[end]).fold(f64::NEG_INFINITY, f64::max));
        let mut least = ends[0].min(ends[1]);
        // The border that is farthest at both ends is farthest all along.
        if lines.iter().any(|line| [0, 1].iter().all(|&end| line[end] == ends[end])) {
            return least;
        }
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

/// The cell that contains a point, or the nearest one.
pub(super) fn cell_at<const D: usize>(grid: &Grid<D>, point: &[f64; D]) -> usize {
    let spans = |axis: usize| grid.basis.spans(grid.dims[axis]);
    (0..D).rev().fold(0, |cell, axis| cell * spans(axis) + span_of(grid, axis, point[axis], 0.0))
}

/// The coordinate at which a span begins.
fn border<const D: usize>(grid: &Grid<D>, axis: usize, span: usize) -> f64 {
    grid.lo[axis] + span as f64 * grid.spacing(axis)
}

/// The span that contains a coordinate moved by some spans; the first or last one outside the grid.
fn span_of<const D: usize>(grid: &Grid<D>, axis: usize, x: f64, by: f64) -> usize {
    let last = grid.basis.spans(grid.dims[axis]) - 1;
    ((x - grid.lo[axis]) / grid.spacing(axis) + by).clamp(0.0, last as f64) as usize
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;
    use proptest::prelude::*;

    /// Least growth at which the box meets one of many points of a segment.
    fn sampled_growth(support: &SupportBox<2>, [from, to]: &[[f64; 2]; 2]) -> f64 {
        let at = |step: u32| {
            let t = f64::from(step) / 4000.0;
            support.distance(&[0, 1].map(|axis| from[axis] + t * (to[axis] - from[axis])))
        };
        (0..=4000).map(at).fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #[test]
        fn a_box_meets_a_segment_when_it_has_grown_to_it(
            handle in 0..64_usize,
            ends in proptest::array::uniform2(proptest::array::uniform2(-0.2..1.2)),
        ) {
            let grid = Grid { dims: [8, 8], basis: Basis::Bspline, lo: [0.0; 2], hi: [1.0; 2], angle: 0.0 };
            let support = SupportBox::of(&grid, 4, handle);
            let link = PlacedLink { triangles: [0, 1], ends, kind: LinkKind::Edge };
            let found = support.growth_below_one(&link).unwrap_or(1.0);
            let wanted = sampled_growth(&support, &ends).min(1.0);
            // Between two samples the distance falls by no more than their distance, in spans.
            prop_assert!(found < wanted + 1e-9 && wanted - found < 1.4 * 5.0 / 4000.0, "{found} {wanted}");
        }
    }
}
