//! Energy `stroke`: Σ_k Σ_{0<|j−k|≤2} ‖(x'_k − x'_j) − R_k (x_k − x_j)‖² / s_kj along polylines, with s_kj the arc length between
//! points k and j. It is the paper's equation 3 on drawings (its stroke-based scheme, T. Fukusato and S. Morishima, "Active
//! comicing for freehand drawing animation", 2016), derived in docs/METHOD.md, "Energies".
//!
//! In: lines and a grid. Out: points along the lines and one edge set per point. The second ring of neighbours makes straight
//! lines resist bending.

use super::area::Area;
use super::edge_sets::{EdgeSets, MetricSource};
use super::embedded_vertices::EmbeddedVertices;
use super::mesh_edges::{Edge, merged};
use crate::lattice::Grid;
use crate::solve::cancel::Cancel;
use crate::solve::linalg::small_matrix::{dot, minus};
use crate::solve::problem::{PointPin, Shape};
use crate::solve::samples::{Sample, subcell_dims};
use crate::solve::settings::{Sampling, Settings};
use crate::solve::stiffness::region_stiffness_at;

/// Number of neighbours on each side.
const RINGS: usize = 2;

/// Points of one line, in order.
struct Line<const D: usize> {
    points: Vec<[f64; D]>,
    /// Whether the last point is connected to the first.
    is_closed: bool,
}

/// Builds the energy of the strokes of a shape.
pub(super) fn build<const D: usize>(
    grid: &Grid<D>,
    shape: &Shape<D>,
    pins: &[PointPin<D>],
    settings: &Settings,
    cancel: &Cancel,
) -> EdgeSets<D> {
    let lines = shape.strokes.iter().map(|stroke| Line::of(shape, stroke));
    let lines: Vec<Line<D>> = match settings.sampling {
        Sampling::Centroids => lines.collect(),
        Sampling::Subcells => lines.flat_map(|line| line.resampled(spacing(grid), grid)).collect(),
    };
    let (mut points, mut edges, mut samples) = (Vec::new(), Vec::new(), Vec::new());
    for line in lines {
        line.add_edges(points.len(), &mut edges);
        samples.extend(line.samples());
        points.extend(line.points);
    }
    let (mut plain, mut stiffened) = (0.0, 0.0);
    for Edge { ends, weight } in &mut edges {
        let [a, b] = ends.map(|end| &points[end as usize]);
        let (edge, factor) = (minus(a, b), region_stiffness_at(pins, std::array::from_fn(|d| 0.5 * (a[d] + b[d]))));
        plain += *weight * dot(&edge, &edge);
        *weight *= factor;
        stiffened += *weight * dot(&edge, &edge);
    }
    let mean_stiffness = if plain > 0.0 && stiffened > 0.0 { stiffened / plain } else { 1.0 };
    let edges = merged(edges, points.len(), |same| same.iter().map(|edge| edge.weight).sum());
    let seen = MetricSource::Samples(Area::new(grid, &samples, cancel));
    EdgeSets::around_vertices(EmbeddedVertices::new(grid, points, cancel), edges, seen)
        .with_mean_stiffness(mean_stiffness)
}

/// Returns the spacing of points on resampled lines: the shortest side of a sub-cell.
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

    /// Points of the line; a closed line repeats its first point at the end.
    fn corners(&self) -> impl Iterator<Item = &[f64; D]> + Clone {
        self.points.iter().chain(self.points.first().filter(|_| self.is_closed))
    }

    /// Arc length from the start to each corner.
    fn lengths(&self) -> Vec<f64> {
        let mut along = 0.0;
        let segments = self.corners().zip(self.corners().skip(1)).map(|(a, b)| {
            let step = minus(a, b);
            along += dot(&step, &step).sqrt();
            along
        });
        std::iter::once(0.0).chain(segments).collect()
    }

    /// Resamples the line at even spacing, `spacing` or less, so that the result does not depend on how the line was drawn.
    /// Returns the runs of consecutive points inside the box; parts outside the box do not contribute.
    fn resampled(&self, spacing: f64, grid: &Grid<D>) -> Vec<Self> {
        let Some(places) = ArcLengthSteps::along(self, spacing) else { return Vec::new() };
        let mut runs: Vec<InsideRun<D>> = Vec::new();
        for (step, point) in (1..places.corners.len()).flat_map(|next| places.inside(next, grid)) {
            match runs.last_mut() {
                Some(run) if step == run.last + 1.0 => {
                    run.last = step;
                    run.points.push(point);
                }
                Some(run) if step <= run.last => {}
                _ => runs.push(InsideRun { first: step, last: step, points: vec![point] }),
            }
        }
        let is_whole = self.is_closed && runs.iter().map(|run| run.points.len()).sum::<usize>() as f64 == places.count;
        if self.is_closed && !is_whole {
            join_ends(&mut runs, places.count);
        }
        let runs = runs.into_iter().filter(|run| run.points.len() > 1);
        runs.map(|run| Self { points: run.points, is_closed: is_whole }).collect()
    }

    /// Adds the edges, each of which is in the sets of both its ends. `first` is the index of the line's first point.
    fn add_edges(&self, first: usize, edges: &mut Vec<Edge>) {
        let (count, lengths) = (self.points.len(), self.lengths());
        let total = lengths.last().copied().unwrap_or(0.0);
        for ring in 1..=RINGS {
            let ends = if self.is_closed && count > 2 * ring { count } else { count.saturating_sub(ring) };
            for start in 0..ends {
                let end = (start + ring) % count;
                let between = lengths[end] - lengths[start];
                let between = if end < start { between + total } else { between };
                if between > 0.0 {
                    edges.push(Edge::new([first + start, first + end], 1.0 / between));
                }
            }
        }
    }

    /// Returns a sample per point, whose area is the length of the line nearest to the point.
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

/// Evenly spaced points along a line, numbered by steps from its start.
struct ArcLengthSteps<'a, const D: usize> {
    corners: Vec<&'a [f64; D]>,
    /// Arc length from the start to each corner.
    lengths: Vec<f64>,
    total: f64,
    /// Number of steps from end to end: an integral value, which may exceed the range of integer types.
    count: f64,
    /// Last distinct step; on a closed line the one before the start is reached again.
    last: f64,
}

/// Points of consecutive steps.
struct InsideRun<const D: usize> {
    first: f64,
    last: f64,
    points: Vec<[f64; D]>,
}

impl<'a, const D: usize> ArcLengthSteps<'a, D> {
    /// Returns `None` for lines of zero or infinite length.
    fn along(line: &'a Line<D>, spacing: f64) -> Option<Self> {
        let lengths = line.lengths();
        let total = *lengths.last()?;
        let count = (total / spacing).ceil().max(2.0 * RINGS as f64);
        let last = if line.is_closed { count - 1.0 } else { count };
        let is_finite = total > 0.0 && count.is_finite();
        is_finite.then(|| Self { corners: line.corners().collect(), lengths, total, count, last })
    }

    /// Returns the steps on the segment that ends at corner `next`, with their points, as far as these lie in the box.
    fn inside(&self, next: usize, grid: &Grid<D>) -> impl Iterator<Item = (f64, [f64; D])> {
        let (start, end) = (self.lengths[next - 1], self.lengths[next]);
        let step_at = |share: f64| (start + share * (end - start)) / self.total * self.count;
        // One step more on each side, because the entry and exit points are rounded.
        let shares = clipped([self.corners[next - 1], self.corners[next]], grid);
        let range = shares.map(|[from, to]| [(step_at(from).floor() - 1.0).max(0.0), step_at(to).ceil() + 1.0]);
        let [first, last] = range.unwrap_or([1.0, 0.0]);
        // On lines so long that a step is below rounding, at most as many steps as fit into the box.
        let most = grid.diagonal() / self.total * self.count + 4.0;
        let steps = (last.min(self.last) - first + 1.0).clamp(0.0, most) as usize;
        (0..steps).filter_map(move |k| {
            let step = first + k as f64;
            let (owner, place) = self.at(step);
            (owner == next && grid.clamp_to_box(place) == place).then_some((step, place))
        })
    }

    /// Returns the corner at which the segment of a step ends, and the point of the step.
    fn at(&self, step: f64) -> (usize, [f64; D]) {
        let along = self.total * (step / self.count);
        let next = self.lengths.partition_point(|&length| length <= along).clamp(1, self.corners.len() - 1);
        let [before, length] = [next - 1, next].map(|corner| self.lengths[corner]);
        let share = ((along - before) / (length - before).max(f64::MIN_POSITIVE)).min(1.0);
        let [from, to] = [self.corners[next - 1], self.corners[next]];
        (next, std::array::from_fn(|d| from[d] + share * (to[d] - from[d])))
    }
}

/// Joins the last and the first run of a closed line where the line's start lies inside the box, so that the line is cut only
/// outside.
fn join_ends<const D: usize>(runs: &mut Vec<InsideRun<D>>, count: f64) {
    let starts_inside = runs.first().is_some_and(|run| run.first == 0.0);
    let ends_inside = runs.last().is_some_and(|run| run.last == count - 1.0);
    if starts_inside && ends_inside && runs.len() > 1 {
        let start = runs.remove(0);
        runs.last_mut().expect("there were two").points.extend(start.points);
    }
}

/// Returns the interval of a segment that lies in the box, as fractions 0 to 1 of the segment (Y.-D. Liang and B. Barsky, 1984).
fn clipped<const D: usize>([from, to]: [&[f64; D]; 2], grid: &Grid<D>) -> Option<[f64; 2]> {
    let mut shares = [0.0_f64, 1.0_f64];
    for axis in 0..D {
        let by = to[axis] - from[axis];
        if by == 0.0 {
            if !(grid.lo[axis]..=grid.hi[axis]).contains(&from[axis]) {
                return None;
            }
            continue;
        }
        let [low, high] = [grid.lo[axis], grid.hi[axis]].map(|bound| (bound - from[axis]) / by);
        shares = [shares[0].max(low.min(high)), shares[1].min(low.max(high))];
    }
    (shares[0] <= shares[1]).then_some(shares)
}

#[cfg(test)]
mod tests {
    use super::super::Distortion;
    use super::*;
    use crate::lattice::Basis;
    use crate::solve::Region;

    fn grid() -> Grid<2> {
        Grid { dims: [6, 6], basis: Basis::Bspline, lo: [0.0; 2], hi: [1.0; 2], angle: 0.0 }
    }

    fn line(points: &[[f64; 2]], is_closed: bool) -> Line<2> {
        Line { points: points.to_vec(), is_closed }
    }

    #[test]
    fn lines_far_longer_than_the_box_cost_what_lies_inside() {
        for far in [5.0, 1e9, 1e40, 1e150] {
            let runs = line(&[[-far, 0.4], [far, 0.4], [far, far]], false).resampled(0.1, &grid());
            assert!(runs.len() <= 20 && runs.iter().map(|run| run.points.len()).sum::<usize>() < 40, "{far}");
        }
        // Steps are counted from the start of the line, wherever the line enters the box.
        let [run] = &line(&[[-0.53, 0.5], [3.47, 0.5]], false).resampled(0.1, &grid())[..] else { panic!("one run") };
        assert_eq!(run.points.len(), 10);
        let is_even = |(k, point): (usize, &[f64; 2])| (point[0] - (0.07 + 0.1 * k as f64)).abs() < 1e-12;
        assert!(run.points.iter().enumerate().all(is_even), "{:?}", run.points);
    }

    #[test]
    fn closed_lines_are_cut_where_they_are_outside() {
        // The first corner lies inside the box, the third far outside.
        let corners = [[0.3, 0.3], [0.7, 0.3], [0.5, 1.9]];
        let [run] = &line(&corners, true).resampled(0.05, &grid())[..] else { panic!("one run") };
        assert!(!run.is_closed && run.points.len() > 30);
        assert!([run.points[0], run.points[run.points.len() - 1]].iter().all(|end| end[1] > 0.9), "{:?}", run.points);
        let step = |pair: &[[f64; 2]]| (pair[0][0] - pair[1][0]).hypot(pair[0][1] - pair[1][1]);
        assert!(run.points.windows(2).all(|pair| step(pair) < 0.051));
        let inside = [[0.3, 0.3], [0.7, 0.3], [0.5, 0.9]];
        let [run] = &line(&inside, true).resampled(0.05, &grid())[..] else { panic!("one run") };
        assert!(run.is_closed && run.points.len() == 34, "{}", run.points.len());
    }

    #[test]
    fn stiff_regions_leave_the_rest_as_stiff_as_it_was() {
        let points = vec![[0.1, 0.5], [0.5, 0.55], [0.9, 0.5]];
        let shape = Shape { points, strokes: vec![vec![0, 1, 2]], ..Shape::default() };
        let region = Region { radius: 0.2, rigidity: 0.0, stiffness: 50.0 };
        let pin = PointPin { region: Some(region), ..PointPin::new([0.1, 0.5], [0.1, 0.5]) };
        let mass = |pins: &[PointPin<2>]| build(&grid(), &shape, pins, &Settings::default(), &Cancel::never()).mass();
        assert!((mass(&[pin]) / mass(&[]) - 1.0).abs() < 1e-12, "{} {}", mass(&[pin]), mass(&[]));
    }
}
