//! Isolated parts of a shape, and the shortest gaps between groups of them.
//!
//! In: a shape and the island of every triangle. Out: for every group of islands the nearest corners of it and of another group. Corners lie in
//! a k-d tree whose nodes know whether all of their corners belong to one group, so that no search passes the corners of its own group
//! (W. B. March, P. Ram, A. G. Gray, "Fast Euclidean Minimum Spanning Tree", 2010).

use crate::solve::problem::Shape;
use std::collections::BTreeMap;
use std::ops::Range;

/// Largest number of corners in a leaf of the tree.
const LEAF: usize = 8;

/// A corner of a triangle.
#[derive(Clone, Copy)]
struct Corner<const D: usize> {
    point: [f64; D],
    /// 3 · triangle + corner.
    number: usize,
}

/// A box around some corners.
struct Node<const D: usize> {
    low: [f64; D],
    high: [f64; D],
    corners: Range<usize>,
    /// Indices of the halves, which follow their parent; `None` in leaves.
    halves: Option<[usize; 2]>,
}

/// A squared distance, and the corners between which it lies.
type Gap = (f64, [usize; 2]);

/// The corners of all islands of a shape, each once for every island.
pub(super) struct Islands<const D: usize> {
    corners: Vec<Corner<D>>,
    nodes: Vec<Node<D>>,
    triangle_count: usize,
}

impl<const D: usize> Islands<D> {
    /// Collects the corners of every island. `roots`: the island of each triangle, #triangles.
    pub(super) fn of(shape: &Shape<D>, roots: &[usize]) -> Self {
        let all = shape.triangles.iter().flatten().enumerate();
        let mut all: Vec<(usize, u32, usize)> =
            all.map(|(number, &vertex)| (roots[number / 3], vertex, number)).collect();
        all.sort_unstable();
        let corner =
            |same: &[(usize, u32, usize)]| Corner { point: shape.points[same[0].1 as usize], number: same[0].2 };
        let corners = all.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).map(corner).collect();
        let mut islands = Self { corners, nodes: Vec::new(), triangle_count: shape.triangles.len() };
        islands.grow(0..islands.corners.len());
        islands
    }

    /// Adds the node over some corners, with those below it, and returns its index.
    fn grow(&mut self, range: Range<usize>) -> usize {
        let corners = &mut self.corners[range.clone()];
        let (mut low, mut high) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
        for corner in corners.iter() {
            for axis in 0..D {
                low[axis] = low[axis].min(corner.point[axis]);
                high[axis] = high[axis].max(corner.point[axis]);
            }
        }
        let index = self.nodes.len();
        let middle = corners.len() / 2;
        let is_leaf = corners.len() <= LEAF;
        if !is_leaf {
            let side = |axis: &usize| high[*axis] - low[*axis];
            let widest = (0..D).max_by(|a, b| side(a).total_cmp(&side(b))).unwrap_or(0);
            corners.select_nth_unstable_by(middle, |a, b| {
                a.point[widest].total_cmp(&b.point[widest]).then(a.number.cmp(&b.number))
            });
        }
        self.nodes.push(Node { low, high, corners: range.clone(), halves: None });
        if !is_leaf {
            let middle = range.start + middle;
            self.nodes[index].halves = Some([self.grow(range.start..middle), self.grow(middle..range.end)]);
        }
        index
    }

    /// Returns the shortest gap from every group of islands but the largest to another group, up to `radius`, shortest first. `group`: the
    /// group of a triangle.
    pub(super) fn shortest_gaps(&self, radius: f64, group: impl FnMut(usize) -> usize) -> Vec<Gap> {
        let group_of_triangle: Vec<usize> = (0..self.triangle_count).map(group).collect();
        let mut sizes: BTreeMap<usize, usize> = BTreeMap::new();
        group_of_triangle.iter().for_each(|group| *sizes.entry(*group).or_default() += 1);
        let largest = sizes.into_iter().max_by_key(|&(group, size)| (size, std::cmp::Reverse(group)));
        let groups: Vec<usize> = self.corners.iter().map(|corner| group_of_triangle[corner.number / 3]).collect();
        let groups = Groups { uniform: self.uniform(&groups), of_corners: groups };
        let mut best: BTreeMap<usize, Gap> = BTreeMap::new();
        for (corner, &own) in self.corners.iter().zip(&groups.of_corners) {
            if largest.is_none_or(|(largest, _)| own != largest) {
                let known = best.get(&own).copied();
                if let Some(gap) = self.shortest_gap((corner, own), &groups, (known, radius * radius)) {
                    best.insert(own, gap);
                }
            }
        }
        let mut found: Vec<Gap> = best.into_values().collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found
    }

    /// Returns the group to which all corners of each node belong, #nodes; `None` where several meet.
    fn uniform(&self, groups: &[usize]) -> Vec<Option<usize>> {
        let mut uniform = vec![None; self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate().rev() {
            uniform[index] = match node.halves {
                Some([a, b]) => uniform[a].filter(|_| uniform[a] == uniform[b]),
                None => {
                    let own = &groups[node.corners.clone()];
                    own.first().copied().filter(|first| own.iter().all(|group| group == first))
                }
            };
        }
        uniform
    }

    /// Returns the shortest gap from a corner of a group to other groups, if it is shorter than a known one, or than a limit without one.
    fn shortest_gap(
        &self,
        (from, own): (&Corner<D>, usize),
        groups: &Groups,
        (mut best, limit): (Option<Gap>, f64),
    ) -> Option<Gap> {
        let known = best;
        let mut waiting = vec![(0.0, 0)];
        while let Some((square, index)) = waiting.pop() {
            if square > best.map_or(limit, |gap| gap.0) || groups.uniform[index] == Some(own) {
                continue;
            }
            let node = &self.nodes[index];
            if let Some(halves) = node.halves {
                let mut halves = halves.map(|half| (self.nodes[half].squared_distance(&from.point), half));
                // The nearer half is looked at first.
                halves.sort_by(|a, b| b.0.total_cmp(&a.0));
                waiting.extend(halves);
                continue;
            }
            let others = node.corners.clone().filter(|&other| groups.of_corners[other] != own);
            for to in others.map(|other| &self.corners[other]) {
                let square: f64 = (0..D).map(|axis| (from.point[axis] - to.point[axis]).powi(2)).sum();
                let gap = (square, [from.number, to.number]);
                if square <= limit && best.is_none_or(|best| is_shorter(&gap, &best)) {
                    best = Some(gap);
                }
            }
        }
        best.filter(|_| best != known)
    }
}

/// The groups of islands in a round.
struct Groups {
    /// #corners.
    of_corners: Vec<usize>,
    /// #nodes: the group of all corners of the node, if there is one.
    uniform: Vec<Option<usize>>,
}

impl<const D: usize> Node<D> {
    /// Squared distance of a point to the box; no more than that to any corner in it, whatever the rounding.
    fn squared_distance(&self, point: &[f64; D]) -> f64 {
        let outside = |axis: usize| (self.low[axis] - point[axis]).max(point[axis] - self.high[axis]).max(0.0);
        (0..D).map(|axis| outside(axis).powi(2)).sum()
    }
}

fn is_shorter(one: &Gap, other: &Gap) -> bool {
    one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)).is_lt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shortest gaps between single triangles at places along x, in groups.
    fn gaps(places: &[f64], groups: &[usize], radius: f64) -> Vec<Gap> {
        let points = places.iter().flat_map(|&x| [[x, 0.0], [x + 1.0, 0.0], [x, 1.0]]).collect();
        let triangles: Vec<[u32; 3]> = (0..places.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let roots: Vec<usize> = (0..places.len()).collect();
        let shape = Shape::<2>::of_triangles(points, triangles);
        Islands::of(&shape, &roots).shortest_gaps(radius, |triangle| groups[triangle])
    }

    #[test]
    fn each_island_but_the_largest_reaches_the_nearest_other_within_the_radius() {
        assert_eq!(gaps(&[0.0, 1.5, 4.0], &[0, 1, 2], 2.0), [(0.25, [3, 1]), (2.25, [6, 4])]);
        assert_eq!(gaps(&[0.0, 1.5, 4.0], &[0, 1, 2], 1.0), [(0.25, [3, 1])]);
        assert_eq!(gaps(&[0.0, 1.5, 4.0], &[0, 0, 1], 9.0), [(2.25, [6, 4])]);
        assert!(gaps(&[0.0, 9.0], &[0, 1], 2.0).is_empty() && gaps(&[0.0], &[0], 2.0).is_empty());
    }

    #[test]
    fn in_a_large_tree_the_shortest_gap_is_that_of_all_pairs() {
        // Golden-ratio steps: spread evenly, without equal distances.
        let places: Vec<f64> = (0..300).map(|k| 3000.0 * (f64::from(k) * 0.618_034).fract()).collect();
        let groups: Vec<usize> = places.iter().map(|x| (x / 700.0) as usize).collect();
        let shortest = |own: usize| {
            let is_own = |k: &usize| groups[*k] == own;
            let corners = |k: usize| [[places[k], 0.0], [places[k] + 1.0, 0.0], [places[k], 1.0]];
            let square = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
            let mut shortest = f64::INFINITY;
            for from in (0..300).filter(is_own).flat_map(corners) {
                let others = (0..300).filter(|k| !is_own(k)).flat_map(corners);
                shortest = others.map(|to| square(from, to)).fold(shortest, f64::min);
            }
            shortest
        };
        let mut expected: Vec<f64> = (0..5).map(shortest).collect();
        let found: Vec<f64> = gaps(&places, &groups, 3000.0).into_iter().map(|gap| gap.0).collect();
        expected.sort_by(f64::total_cmp);
        assert_eq!(found.len(), 4, "the largest looks for none");
        assert!(found.iter().all(|gap| expected.contains(gap)), "{found:?} of {expected:?}");
    }
}
