//! Isolated parts of a shape, and the shortest gaps between them.
//!
//! In: a shape and the island of every triangle. Out: for every group of islands the nearest corners of it and of another group. Boxes around
//! islands tell which of them can be near, so that no search passes the corners of its own island.

use crate::solve::problem::Shape;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::collections::BTreeMap;

/// Fraction of the radius within which others are looked for at first.
const FIRST_RADIUS: f64 = 1.0 / 64.0;

/// The position of a corner of a triangle, with the number 3 · triangle + corner.
pub(super) type Corner<const D: usize> = GeomWithData<[f64; D], usize>;

/// A connected part of a shape.
struct Island<const D: usize> {
    /// One of its triangles.
    triangle: usize,
    triangle_count: usize,
    bounds: AABB<[f64; D]>,
    corners: RTree<Corner<D>>,
}

/// All islands of a shape.
pub(super) struct Islands<const D: usize> {
    list: Vec<Island<D>>,
    /// The bounds of the islands, with their indices.
    tree: RTree<GeomWithData<Rectangle<[f64; D]>, usize>>,
}

/// A squared distance, and the corners between which it lies.
type Gap = (f64, [usize; 2]);

impl<const D: usize> Islands<D> {
    /// Collects the corners of every island. `roots`: the island of each triangle, #triangles.
    pub(super) fn of(shape: &Shape<D>, roots: &[usize]) -> Self {
        let corners = shape.triangles.iter().flatten().enumerate();
        let mut corners: Vec<(usize, u32, usize)> =
            corners.map(|(number, &vertex)| (roots[number / 3], vertex, number)).collect();
        corners.sort_unstable();
        let island = |corners: &[(usize, u32, usize)]| {
            let mut places: Vec<Corner<D>> = Vec::with_capacity(corners.len());
            for same in corners.chunk_by(|a, b| a.1 == b.1) {
                places.push(Corner::new(shape.points[same[0].1 as usize], same[0].2));
            }
            let points: Vec<[f64; D]> = places.iter().map(|corner| *corner.geom()).collect();
            Island {
                triangle: corners[0].0,
                triangle_count: corners.len() / 3,
                bounds: AABB::from_points(&points),
                corners: RTree::bulk_load(places),
            }
        };
        let list: Vec<Island<D>> = corners.chunk_by(|a, b| a.0 == b.0).map(island).collect();
        let leaf = |(index, island): (usize, &Island<D>)| {
            GeomWithData::new(Rectangle::from_corners(island.bounds.lower(), island.bounds.upper()), index)
        };
        let tree = RTree::bulk_load(list.iter().enumerate().map(leaf).collect());
        Self { list, tree }
    }

    /// Returns the shortest gap from every group of islands but the largest to another group, up to `radius`, shortest first. `group`: the
    /// group of a triangle.
    pub(super) fn shortest_gaps(&self, radius: f64, mut group: impl FnMut(usize) -> usize) -> Vec<Gap> {
        let groups: Vec<usize> = self.list.iter().map(|island| group(island.triangle)).collect();
        let mut sizes: BTreeMap<usize, usize> = BTreeMap::new();
        for (island, group) in self.list.iter().zip(&groups) {
            *sizes.entry(*group).or_default() += island.triangle_count;
        }
        let largest = sizes.into_iter().max_by_key(|&(group, size)| (size, std::cmp::Reverse(group)));
        let mut best: BTreeMap<usize, Gap> = BTreeMap::new();
        for (island, &own) in self.list.iter().zip(&groups) {
            if largest.is_none_or(|(largest, _)| own != largest) {
                let known = best.get(&own).map_or(radius * radius, |gap| gap.0);
                let is_other = |index: usize| groups[index] != own;
                if let Some(gap) = self.shortest_gap(island, known.sqrt(), is_other) {
                    let kept = best.entry(own).or_insert(gap);
                    if is_shorter(&gap, kept) {
                        *kept = gap;
                    }
                }
            }
        }
        let mut found: Vec<Gap> = best.into_values().collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found
    }

    /// Returns the shortest gap from an island to some others, up to a length.
    fn shortest_gap(&self, island: &Island<D>, limit: f64, is_other: impl Fn(usize) -> bool) -> Option<Gap> {
        let mut within = FIRST_RADIUS * limit;
        loop {
            let near = grown(&island.bounds, within);
            let others = self.tree.locate_in_envelope_intersecting(near).map(|leaf| leaf.data);
            let mut best: Option<Gap> = None;
            for other in others.filter(|&other| is_other(other)) {
                let least = best.map_or(within * within, |gap| gap.0);
                let gap = gap_between(island, &self.list[other], least);
                best = [best, gap].into_iter().flatten().reduce(|a, b| if is_shorter(&b, &a) { b } else { a });
            }
            if best.is_some() || within >= limit {
                return best;
            }
            within = (2.0 * within).min(limit);
        }
    }
}

fn is_shorter(one: &Gap, other: &Gap) -> bool {
    one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)).is_lt()
}

fn grown<const D: usize>(bounds: &AABB<[f64; D]>, by: f64) -> AABB<[f64; D]> {
    AABB::from_corners(bounds.lower().map(|x| x - by), bounds.upper().map(|x| x + by))
}

/// Returns the shortest gap between the corners of two islands, at most of a squared length.
fn gap_between<const D: usize>(island: &Island<D>, other: &Island<D>, mut least: f64) -> Option<Gap> {
    let is_turned = island.corners.size() > other.corners.size();
    let [few, many] = if is_turned { [other, island] } else { [island, other] };
    let mut best: Option<Gap> = None;
    for corner in few.corners.locate_in_envelope(grown(&many.bounds, least.sqrt())) {
        let Some((to, square)) = many.corners.nearest_neighbor_iter_with_distance_2(*corner.geom()).next() else {
            continue;
        };
        let ends = if is_turned { [to.data, corner.data] } else { [corner.data, to.data] };
        let gap = (square, ends);
        if square <= least && best.is_none_or(|best| is_shorter(&gap, &best)) {
            (least, best) = (square, Some(gap));
        }
    }
    best
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
}
