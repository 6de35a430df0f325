//! Energy `stroke`: Σ_k Σ_{0<|j−k|≤2} ‖(x'_k − x'_j) − R_k (x_k − x_j)‖² / s_kj along polylines, s_kj the length of line
//! between the points k and j: the paper's equation 3 on drawings (its stroke-based scheme, T. Fukusato and S. Morishima,
//! "Active comicing for freehand drawing animation", 2016). Derived in docs/METHOD.md.
//!
//! In: lines, a grid. Out: points along them and one edge set a point; the second ring makes straight lines resist bending.

use super::area::Area;
use super::edge_sets::{EdgeSets, Seen, SetEdge};
use super::vertices::Vertices;
use crate::lattice::Grid;
use crate::solve::samples::{Sample, subcell_dims};
use crate::solve::small::{dot, minus};
use crate::solve::stiffness::starch_at;
use crate::solve::{PointPin, Sampling, Settings, Shape};

/// Neighbours on each side.
const RINGS: usize = 2;

/// Points of one line, in order.
struct Line<const D: usize> {
    points: Vec<[f64; D]>,
    /// The last point is joined to the first.
    is_closed: bool,
}

/// The energy of the lines of a shape.
pub(super) fn build<const D: usize>(
    grid: &Grid<D>,
    shape: &Shape<D>,
    pins: &[PointPin<D>],
    settings: &Settings,
) -> EdgeSets<D> {
    let lines = shape.strokes.iter().map(|stroke| Line::of(shape, stroke));
    let lines: Vec<Line<D>> = match settings.sampling {
        Sampling::Centroids => lines.collect(),
        Sampling::Subcells => lines.flat_map(|line| line.resampled(spacing(grid)).inside(grid)).collect(),
    };
    let (mut points, mut edges, mut samples) = (Vec::new(), Vec::new(), Vec::new());
    for line in lines {
        line.add_edges(points.len(), &mut edges);
        samples.extend(line.samples());
        points.extend(line.points);
    }
    for SetEdge { ends, weight, .. } in &mut edges {
        let [a, b] = ends.map(|end| &points[end]);
        *weight *= starch_at(pins, std::array::from_fn(|d| 0.5 * (a[d] + b[d])));
    }
    EdgeSets::new(Vertices::new(grid, points), edges, Seen::Samples(Area::new(grid, &samples)))
}

/// Distance of points on resampled lines: the shortest side of a sub-cell.
fn spacing<const D: usize>(grid: &Grid<D>) -> f64 {
    let dims = subcell_dims(grid);
    (0..D).map(|axis| grid.size(axis) / dims[axis] as f64).fold(f64::INFINITY, f64::min)
}

impl<const D: usize> Line<D> {
    fn of(shape: &Shape<D>, stroke: &[u32]) -> Self {
        let mut points: Vec<[f64; D]> = stroke.iter().map(|&vertex| shape.points[vertex as usize]).collect();
        let is_closed = stroke.len() > 2 && points.first() == points.last();
        if is_closed {
            points.pop();
        }
        Self { points, is_closed }
    }

    /// Points on the line, the first one again at the end of a closed one.
    fn corners(&self) -> impl Iterator<Item = &[f64; D]> + Clone {
        self.points.iter().chain(self.points.first().filter(|_| self.is_closed))
    }

    /// Length of line from the start to every corner.
    fn lengths(&self) -> Vec<f64> {
        let mut along = 0.0;
        let segments = self.corners().zip(self.corners().skip(1)).map(|(a, b)| {
            let step = minus(a, b);
            along += dot(&step, &step).sqrt();
            along
        });
        std::iter::once(0.0).chain(segments).collect()
    }

    /// Points at even distances along the line, `spacing` or less; how the line was drawn makes no difference then.
    fn resampled(self, spacing: f64) -> Self {
        let lengths = self.lengths();
        let total = lengths.last().copied().unwrap_or(0.0);
        if total <= 0.0 {
            return self;
        }
        let count = (total / spacing).ceil().max(2.0 * RINGS as f64);
        let corners: Vec<&[f64; D]> = self.corners().collect();
        let steps = if self.is_closed { 0..count as usize } else { 0..count as usize + 1 };
        let point = |step: usize| {
            let at = total * (step as f64 / count);
            let next = lengths.partition_point(|&length| length <= at).clamp(1, corners.len() - 1);
            let share = (at - lengths[next - 1]) / (lengths[next] - lengths[next - 1]).max(f64::MIN_POSITIVE);
            let share = share.min(1.0);
            std::array::from_fn(|d| corners[next - 1][d] + share * (corners[next][d] - corners[next - 1][d]))
        };
        Self { points: steps.map(point).collect(), is_closed: self.is_closed }
    }

    /// The runs of points inside the box: the lattice says nothing about those outside.
    fn inside(self, grid: &Grid<D>) -> Vec<Self> {
        let is_inside = |point: &[f64; D]| grid.nearest_in_box(*point) == *point;
        if self.points.iter().all(is_inside) {
            return vec![self];
        }
        let runs = self.points.split(|point| !is_inside(point)).filter(|run| run.len() > 1);
        runs.map(|run| Self { points: run.to_vec(), is_closed: false }).collect()
    }

    /// Adds the edges of all sets; points of the line are numbered from `first` on.
    fn add_edges(&self, first: usize, edges: &mut Vec<SetEdge>) {
        let (count, lengths) = (self.points.len(), self.lengths());
        let total = lengths.last().copied().unwrap_or(0.0);
        for ring in 1..=RINGS {
            let ends = if self.is_closed && count > 2 * ring { count } else { count.saturating_sub(ring) };
            for start in 0..ends {
                let end = (start + ring) % count;
                let between = lengths[end] - lengths[start];
                let between = if end < start { between + total } else { between };
                if between > 0.0 {
                    let ends = [first + start, first + end];
                    edges.extend(ends.map(|set| SetEdge { set, ends, weight: 1.0 / between }));
                }
            }
        }
    }

    /// Every point with the length of line that is nearest to it.
    fn samples(&self) -> impl Iterator<Item = Sample<D>> {
        let lengths = self.lengths();
        let count = self.points.len();
        let segment = move |k: usize| if k + 1 < lengths.len() { lengths[k + 1] - lengths[k] } else { 0.0 };
        let is_closed = self.is_closed;
        self.points.iter().enumerate().map(move |(k, &at)| {
            let before = if k > 0 {
                segment(k - 1)
            } else if is_closed {
                segment(count - 1)
            } else {
                0.0
            };
            Sample { at, area: 0.5 * (before + segment(k)), stiffness: 1.0 }
        })
    }
}
