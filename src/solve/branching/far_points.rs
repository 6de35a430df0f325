//! Points of one support that lie far apart along the shape, and move together all the same.
//!
//! In: a grid and a shape at rest. Out: for every copy of a handle that acts on two such points, the points and the way between them.
//! The farthest points of a piece are those at the end of two searches (E. W. Dijkstra, 1959), each for the point farthest from the
//! start, over the triangles of the piece; the way between them is then pulled tight inside the triangles that it crosses.

use super::adjacency::{Adjacency, PlacedLink};
use super::cell_parts::CellParts;
use super::checked_width;
use super::copies::copies;
use super::cuts::{Cut, cuts};
use super::link::LinkKind;
use super::support_box::SupportBox;
use crate::lattice::Grid;
use crate::solve::error::SolveError;
use crate::solve::linalg::small_matrix::distance;
use crate::solve::problem::Shape;
use crate::solve::upright::Upright;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Length of a way along the shape, in diagonals of a support, up to which its ends may share a handle. At any dims a support holds the
/// end of a gap between two parts, and the way around that is as long as two diagonals at most.
const MOST_DIAGONALS: f64 = 2.0;

/// Largest number of times that a way is pulled tight, and the change of its length, relative to it, below which it is.
const PULLS: (usize, f64) = (400, 1e-5);

/// Two points on which one copy of a handle acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FarPoints<const D: usize> {
    /// The points, at rest.
    pub(crate) points: [[f64; D]; 2],
    /// Length of the way between them along the shape, in diagonals of a support.
    pub(crate) diagonals: f64,
}

/// The farthest points of each copy that acts on points farther apart along the shape than twice the diagonal of its support.
///
/// # Errors
/// [`SolveError::Invalid`] if the grid's basis or the shape does not support branching lattices.
pub(crate) fn far_points<const D: usize>(grid: &Grid<D>, shape: &Shape<D>) -> Result<Vec<FarPoints<D>>, SolveError> {
    farther_than(MOST_DIAGONALS, grid, shape)
}

fn farther_than<const D: usize>(most: f64, grid: &Grid<D>, shape: &Shape<D>) -> Result<Vec<FarPoints<D>>, SolveError> {
    let width = checked_width(grid, shape)?;
    let shape = Upright::of(grid).shape(shape);
    let upright = grid.upright();
    let diagonal = (0..D).map(|axis| (width as f64 * grid.spacing(axis)).powi(2)).sum::<f64>().sqrt();
    let (cuts, adjacency) = (cuts(&upright, &shape), Adjacency::of(&shape));
    let parts = CellParts::of(&upright, &cuts, &adjacency);
    let copies = copies(&upright, width, &cuts, &parts);
    let mut of_copies: Vec<Vec<&Cut<D>>> = vec![Vec::new(); copies.handles.len()];
    for (cut, &part) in cuts.iter().zip(&parts.of_cuts) {
        copies.of_part(part as usize).iter().for_each(|&copy| of_copies[copy].push(cut));
    }
    let mut found = Vec::new();
    for (own, &handle) in of_copies.iter().zip(&copies.handles) {
        let support = SupportBox::of(&upright, width, handle);
        let piece = Piece::of(own, &adjacency, |link| support.connects(link));
        if let Some((points, length)) = piece.farthest(most * diagonal) {
            let points = points.map(|point| grid.point_from_upright(point));
            found.push(FarPoints { points, diagonals: length / diagonal });
        }
    }
    Ok(found)
}

/// The triangles of a copy's piece, and the links between them.
struct Piece<'a, const D: usize> {
    /// The middle of the part of each triangle that lies in the support.
    middles: Vec<[f64; D]>,
    /// Neighbours of each triangle, with the link to each.
    neighbours: Vec<Vec<(usize, &'a PlacedLink<D>)>>,
}

impl<'a, const D: usize> Piece<'a, D> {
    /// `own`: the cuts of the piece, in the order of their triangles.
    fn of(own: &[&Cut<D>], adjacency: &'a Adjacency<D>, connects: impl Fn(&PlacedLink<D>) -> bool) -> Self {
        let (mut triangles, mut middles) = (Vec::new(), Vec::new());
        for same in own.chunk_by(|one, other| one.triangle == other.triangle) {
            let area: f64 = same.iter().map(|cut| cut.area).sum();
            let mean = |d: usize| same.iter().map(|cut| cut.middle()[d] * cut.area).sum::<f64>() / area;
            let middle = if area > 0.0 { std::array::from_fn(mean) } else { same[0].middle() };
            triangles.push(same[0].triangle);
            middles.push(middle);
        }
        let mut neighbours = vec![Vec::new(); triangles.len()];
        for (from, &triangle) in triangles.iter().enumerate() {
            for link in adjacency.from(triangle).iter().filter(|link| connects(link)) {
                if let Ok(to) = triangles.binary_search(&link.triangles[1]) {
                    neighbours[from].push((to, link));
                    neighbours[to].push((from, link));
                }
            }
        }
        Self { middles, neighbours }
    }

    /// The farthest points and the length of the way between them, if that is longer than `most`.
    fn farthest(&self, most: f64) -> Option<([[f64; D]; 2], f64)> {
        let (start, _) = self.search(0);
        let (end, before) = self.search(start);
        let mut way = vec![end];
        while let Some((last, _)) = before[way[way.len() - 1]] {
            way.push(last);
        }
        let loose: f64 = way.windows(2).map(|pair| distance(&self.middles[pair[0]], &self.middles[pair[1]])).sum();
        if loose <= most {
            return None;
        }
        let gates: Vec<_> = way.iter().filter_map(|&triangle| before[triangle]).map(|(_, link)| gate(link)).collect();
        let points = [self.middles[end], self.middles[start]];
        let length = pulled_tight(points, &gates);
        (length > most).then_some((points, length))
    }

    /// The triangle that is farthest from another one, and for each the one before it on the way there, with the link.
    fn search(&self, start: usize) -> (usize, Vec<Option<(usize, &'a PlacedLink<D>)>>) {
        let mut lengths = vec![f64::INFINITY; self.middles.len()];
        let mut before = vec![None; self.middles.len()];
        let mut waiting = BinaryHeap::new();
        let mut farthest = start;
        lengths[start] = 0.0;
        // The bit patterns of non-negative numbers have the order of the numbers.
        waiting.push(Reverse((0_u64, start)));
        while let Some(Reverse((length, at))) = waiting.pop() {
            if f64::from_bits(length) > lengths[at] {
                continue;
            }
            farthest = at;
            for &(next, link) in &self.neighbours[at] {
                let length = lengths[at] + distance(&self.middles[at], &self.middles[next]);
                if length < lengths[next] {
                    lengths[next] = length;
                    before[next] = Some((at, link));
                    waiting.push(Reverse((length.to_bits(), next)));
                }
            }
        }
        (farthest, before)
    }
}

/// The segment through which a way crosses a link: the edge, or the middle of a link across a gap.
fn gate<const D: usize>(link: &PlacedLink<D>) -> [[f64; D]; 2] {
    match link.kind {
        LinkKind::Edge => link.ends,
        LinkKind::Across => [std::array::from_fn(|d| f64::midpoint(link.ends[0][d], link.ends[1][d])); 2],
    }
}

/// Length of the shortest way from one point to another through some gates: the place in each gate moves to where the way bends least,
/// until nothing changes. The length is convex in the places.
fn pulled_tight<const D: usize>([from, to]: [[f64; D]; 2], gates: &[[[f64; D]; 2]]) -> f64 {
    let at = |[a, b]: &[[f64; D]; 2], share: f64| std::array::from_fn(|d| a[d] + share * (b[d] - a[d]));
    let mut places: Vec<[f64; D]> = Vec::with_capacity(gates.len() + 2);
    places.push(from);
    places.extend(gates.iter().map(|gate| at(gate, 0.5)));
    places.push(to);
    let length = |places: &[[f64; D]]| places.windows(2).map(|pair| distance(&pair[0], &pair[1])).sum::<f64>();
    let mut last = length(&places);
    for _ in 0..PULLS.0 {
        for (k, gate) in gates.iter().enumerate() {
            places[k + 1] = at(gate, best_share(gate, [&places[k], &places[k + 2]]));
        }
        let now = length(&places);
        if last - now <= PULLS.1 * last {
            return now;
        }
        last = now;
    }
    last
}

/// The share of a segment at which a way between two points through it is shortest. In the plane of the segment and either point, both lie
/// at some height above it; the way is straight once they are laid out on both sides.
fn best_share<const D: usize>([a, b]: &[[f64; D]; 2], points: [&[f64; D]; 2]) -> f64 {
    let side = distance(a, b);
    if side == 0.0 {
        return 0.0;
    }
    let [(along, height), (other_along, other_height)] = points.map(|point| {
        let along = (0..D).map(|d| (point[d] - a[d]) * (b[d] - a[d])).sum::<f64>() / side;
        (along, (distance(point, a).powi(2) - along * along).max(0.0).sqrt())
    });
    let total = height + other_height;
    let place = if total > 0.0 { (along * other_height + other_along * height) / total } else { along };
    (place / side).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;

    /// A strip along a line of points, `width` wide, of squares of two triangles, mitred at its corners.
    fn strip(line: &[[f64; 2]], width: f64) -> Shape<2> {
        let unit = |[from, to]: [[f64; 2]; 2]| {
            let length = distance(&from, &to);
            [(to[0] - from[0]) / length, (to[1] - from[1]) / length]
        };
        let beside = |k: usize| {
            let before = unit(if k == 0 { [line[0], line[1]] } else { [line[k - 1], line[k]] });
            let after = if k + 1 == line.len() { before } else { unit([line[k], line[k + 1]]) };
            let scale = 0.5 * width / (1.0 + before[0] * after[0] + before[1] * after[1]);
            [-(before[1] + after[1]) * scale, (before[0] + after[0]) * scale]
        };
        let mut shape = Shape::default();
        for (k, at) in line.iter().enumerate() {
            let by = beside(k);
            shape.points.extend([[at[0] + by[0], at[1] + by[1]], [at[0] - by[0], at[1] - by[1]]]);
            let first = 2 * k as u32;
            if k + 1 < line.len() {
                shape.triangles.extend([[first, first + 1, first + 2], [first + 1, first + 3, first + 2]]);
            }
        }
        shape
    }

    fn grid(dims: [usize; 2]) -> Grid<2> {
        Grid { dims, basis: Basis::Bspline, lo: [0.0; 2], hi: [1.0; 2], angle: 0.0 }
    }

    /// One support holds all of it: its diagonal is that of four spans.
    #[test]
    fn the_way_is_that_along_the_shape() {
        let corners = [[0.02, 0.02], [0.02, 0.22], [0.07, 0.22], [0.07, 0.02], [0.12, 0.02], [0.12, 0.22]];
        let between = |k: usize| {
            let [from, to] = [corners[k], corners[k + 1]];
            (0..20).map(move |n| [0, 1].map(|d| from[d] + f64::from(n) / 20.0 * (to[d] - from[d])))
        };
        let line: Vec<[f64; 2]> = (0..5).flat_map(between).chain([corners[5]]).collect();
        let winding = strip(&line, 0.01);
        // Spans of 0.0625, diagonals of 0.354.
        let found = farther_than(0.0, &grid([19, 19]), &winding).expect("a right shape");
        let most = found.iter().map(|far| far.diagonals).fold(0.0, f64::max) * 0.25 * 2.0_f64.sqrt();
        // The middle line is 0.7 long; the shortest way cuts its four corners.
        assert!((0.65..0.7).contains(&most), "{most}");
        let [coarse, fine] = [[19, 19], [43, 43]].map(|dims| far_points(&grid(dims), &winding).expect("a right shape"));
        assert!(coarse.is_empty() && fine.is_empty(), "{coarse:?} {fine:?}");
    }

    /// Five rows instead of three.
    #[test]
    fn what_winds_inside_one_support_is_found_until_the_supports_are_small() {
        let row = |k: usize| {
            let x = 0.3 + 0.02 * k as f64;
            let ends = if k.is_multiple_of(2) { [0.3, 0.5] } else { [0.5, 0.3] };
            (0..=20).map(move |n| [x, ends[0] + f64::from(n) / 20.0 * (ends[1] - ends[0])])
        };
        let line: Vec<[f64; 2]> = (0..5).flat_map(row).collect();
        let shape = strip(&line, 0.008);
        let found = |dims: usize| far_points(&grid([dims; 2]), &shape).expect("a right shape");
        let [coarse, fine] = [19, 64].map(found);
        let most = coarse.iter().map(|far| far.diagonals).fold(0.0, f64::max);
        // All five rows of 0.2, between them 0.02, of diagonals of 0.354.
        assert!((2.7..3.1).contains(&most), "{most}");
        let ends = |far: &FarPoints<2>| (distance(&far.points[0], &far.points[1]) - 0.2154).abs() < 0.02;
        assert!(coarse.iter().any(ends), "{coarse:?}");
        assert!(fine.is_empty(), "{fine:?}");
        // A grid that is rotated with the shape finds the same.
        let rotated = Grid { angle: 0.4, ..grid([19, 19]) };
        let points = shape.points.iter().map(|&point| rotated.point_from_upright(point)).collect();
        let again = far_points(&rotated, &Shape { points, ..shape.clone() }).expect("a right shape");
        assert_eq!(again.len(), coarse.len());
    }
}
