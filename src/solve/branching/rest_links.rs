//! Links of a shape at rest: between triangles that share an edge, and from isolated parts (such as eyes and buttons) to the
//! nearest other part, so that they move with it.
//!
//! In: points and triangles at rest, 2D or 3D. Out: [`Link`]s.

use super::islands::Islands;
use super::link::{Link, LinkEnd, LinkKind};
use super::nearest_point::nearest_barycentric;
use crate::disjoint_sets::DisjointSets;
use crate::solve::counting_sort::counting_sort_then_by;
use crate::solve::linalg::small_matrix::distance;
use crate::solve::merge_duplicates::merge_duplicates;
use crate::solve::problem::Shape;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::collections::{BTreeMap, BTreeSet};
#[cfg(test)]
use std::sync::Arc;

/// Number of rounds. Each links every island to its nearest one and at least halves the number of islands, so this suffices for
/// 2^20.
const ROUNDS: usize = 20;

/// Gap between two islands, in diagonals of the shape, up to which they touch.
const TOUCHING: f64 = 0.01;

/// Number of bridged islands above which contacts are not looked for.
const MAX_TOUCHING_ISLANDS: usize = 10_000;

impl<const D: usize> Shape<D> {
    /// Links the triangles that hang together in the present position, and islands to the nearest other part within `radius`, a length.
    /// A shape that moves is linked at rest: by itself a branching lattice links islands where they are nearest at each time, and
    /// jumps where another part comes nearer.
    #[cfg(test)]
    #[must_use]
    pub(crate) fn linked(self, radius: f64) -> Self {
        let links = surface_links(&self.points, &self.triangles, radius);
        Self { links: Some(Arc::new(links)), ..self }
    }
}

/// Links between triangles with a common edge, and between islands. Vertices in the same position count as one, so that texture
/// seams do not separate triangles. Where more than two triangles share an edge, all are linked. Islands are linked to the
/// nearest other island within `radius`.
#[must_use]
pub(crate) fn surface_links<const D: usize>(points: &[[f64; D]], triangles: &[[u32; 3]], radius: f64) -> Vec<Link> {
    let welded = merge_duplicates(&Shape::of_triangles(points.to_vec(), triangles.to_vec()));
    let mut sides: Vec<([u32; 2], usize)> = Vec::with_capacity(3 * triangles.len());
    for (number, &[a, b, c]) in welded.triangles.iter().enumerate() {
        sides.extend([[a, b], [b, c], [c, a]].map(|[from, to]| ([from.min(to), from.max(to)], number)));
    }
    counting_sort_then_by(
        &mut sides,
        welded.points.len(),
        |side| side.0[0] as usize,
        |a, b| (a.0[1], a.1).cmp(&(b.0[1], b.1)),
    );
    let mut links = Vec::new();
    for shared in sides.chunk_by(|a, b| a.0 == b.0) {
        let end = |triangle: usize, vertex: u32| {
            let corner = welded.triangles[triangle].iter().position(|&corner| corner == vertex);
            LinkEnd::corner(triangle, corner.unwrap_or(0))
        };
        let [from, to] = shared[0].0;
        let link = |pair: &[([u32; 2], usize)]| Link {
            ends: [end(pair[0].1, from), end(pair[1].1, to)],
            kind: LinkKind::Edge,
        };
        links.extend(shared.windows(2).map(link));
    }
    let mut islands = DisjointSets::of(triangles.len());
    links.iter().for_each(|link| islands.join(link.ends.map(|end| end.triangle as usize)));
    let roots: Vec<usize> = (0..triangles.len()).map(|triangle| islands.root(triangle)).collect();
    if roots.iter().all(|root| *root == roots[0]) {
        return links;
    }
    let bridges = bridges(&welded, islands, radius);
    let contacts = contacts(&welded, &roots, &bridges);
    links.extend(bridges);
    links.extend(contacts);
    links
}

/// Links two sets of triangles at their nearest corners; `None` if one of them is empty.
#[must_use]
pub(crate) fn nearest_link<const D: usize>(
    points: &[[f64; D]],
    triangles: &[[u32; 3]],
    sides: [&[usize]; 2],
) -> Option<Link> {
    let corners = |side: &[usize]| -> Vec<GeomWithData<[f64; D], usize>> {
        let corner = |number: usize| GeomWithData::new(points[triangles[number / 3][number % 3] as usize], number);
        side.iter().flat_map(|&triangle| 3 * triangle..3 * triangle + 3).map(corner).collect()
    };
    let tree = RTree::bulk_load(corners(sides[0]));
    let nearest = corners(sides[1]).into_iter().filter_map(|to| {
        let (from, square) = tree.nearest_neighbor_iter_with_distance_2(*to.geom()).next()?;
        Some((square, [from.data, to.data]))
    });
    let (_, pair) = nearest.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
    Some(Link { ends: pair.map(|corner| LinkEnd::corner(corner / 3, corner % 3)), kind: LinkKind::Across })
}

/// Links two sets of triangles at the points of each that are nearest to a place; `None` if one of them is empty.
#[must_use]
pub(crate) fn link_at<const D: usize>(
    points: &[[f64; D]],
    triangles: &[[u32; 3]],
    sides: [&[usize]; 2],
    place: &[f64; D],
) -> Option<Link> {
    let end = |&triangle: &usize| {
        let corners = triangles[triangle].map(|corner| points[corner as usize]);
        let barycentric = nearest_barycentric(place, &corners).map(|share| share as f32);
        let end = LinkEnd { triangle: triangle as u32, barycentric };
        (distance(&end.point(points, triangles), place), end)
    };
    let [from, to] = sides.map(|side| side.iter().map(end).min_by(|a, b| a.0.total_cmp(&b.0)));
    Some(Link { ends: [from?.1, to?.1], kind: LinkKind::Across })
}

/// Links every island to the one with the nearest corner, repeatedly, until all are connected (O. Borůvka, 1926) or farther apart
/// than `radius`.
fn bridges<const D: usize>(shape: &Shape<D>, mut sets: DisjointSets, radius: f64) -> Vec<Link> {
    let mut bridges = Vec::new();
    let roots: Vec<usize> = (0..shape.triangles.len()).map(|triangle| sets.root(triangle)).collect();
    let islands = Islands::of(shape, &roots);
    for _ in 0..ROUNDS {
        let found = islands.shortest_gaps(radius, |triangle| sets.root(triangle));
        if found.is_empty() {
            break;
        }
        for (_, [from, to]) in found {
            let ends = [from, to].map(|corner| LinkEnd::corner(corner / 3, corner % 3));
            let pair = ends.map(|end| end.triangle as usize);
            if sets.root(pair[0]) != sets.root(pair[1]) {
                sets.join(pair);
                bridges.push(Link { ends, kind: LinkKind::Across });
            }
        }
    }
    bridges
}

/// Links islands that touch wherever they touch: a lid is carried by the whole rim of its pot, a sword by the whole hand. With very
/// many islands (grass) the bridges alone remain. `roots`: the island of each triangle, #triangles.
fn contacts<const D: usize>(shape: &Shape<D>, roots: &[usize], bridges: &[Link]) -> Vec<Link> {
    let limit = TOUCHING * shape.diagonal();
    let mut partners: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for bridge in bridges {
        let [from, to] = bridge.ends.each_ref().map(|end| end.point(&shape.points, &shape.triangles));
        if distance(&from, &to) <= limit {
            let [from, to] = bridge.ends.each_ref().map(|end| roots[end.triangle as usize]);
            partners.entry(from).or_default().insert(to);
            partners.entry(to).or_default().insert(from);
        }
    }
    if partners.is_empty() || partners.len() > MAX_TOUCHING_ISLANDS {
        return Vec::new();
    }
    let corners = |triangle: usize| shape.triangles[triangle].map(|corner| shape.points[corner as usize]);
    let leaf = |triangle: usize| {
        let bounds = AABB::from_points(&corners(triangle));
        GeomWithData::new(Rectangle::from_corners(bounds.lower(), bounds.upper()), triangle)
    };
    let tree: RTree<GeomWithData<Rectangle<[f64; D]>, usize>> =
        RTree::bulk_load((0..shape.triangles.len()).map(leaf).collect());
    let mut found = Vec::new();
    let mut is_seen = vec![false; shape.points.len()];
    for corner in 0..3 * shape.triangles.len() {
        let (triangle, vertex) = (corner / 3, shape.triangles[corner / 3][corner % 3] as usize);
        if std::mem::replace(&mut is_seen[vertex], true) {
            continue;
        }
        let Some(partners) = partners.get(&roots[triangle]) else { continue };
        let point = shape.points[vertex];
        let around = AABB::from_corners(point.map(|x| x - limit), point.map(|x| x + limit));
        // The nearest contact with each partner.
        let mut nearest: BTreeMap<usize, (f64, LinkEnd)> = BTreeMap::new();
        for other in tree.locate_in_envelope_intersecting(around).map(|leaf| leaf.data) {
            if !partners.contains(&roots[other]) {
                continue;
            }
            let barycentric = nearest_barycentric(&point, &corners(other)).map(|share| share as f32);
            let end = LinkEnd { triangle: other as u32, barycentric };
            let gap = distance(&end.point(&shape.points, &shape.triangles), &point);
            let is_nearer =
                |(known, kept): &(f64, LinkEnd)| gap.total_cmp(known).then(end.triangle.cmp(&kept.triangle)).is_lt();
            if gap <= limit && nearest.get(&roots[other]).is_none_or(is_nearer) {
                nearest.insert(roots[other], (gap, end));
            }
        }
        let link = |(_, end)| Link { ends: [LinkEnd::corner(triangle, corner % 3), end], kind: LinkKind::Across };
        found.extend(nearest.into_values().map(link));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of `count` quads along x, from height `low` to `high`.
    fn strip(count: usize, [low, high]: [f64; 2]) -> (Vec<[f64; 2]>, Vec<[u32; 3]>) {
        let points = (0..=count).flat_map(|k| [[k as f64, low], [k as f64, high]]).collect();
        let quad = |k: usize| {
            let a = 2 * k as u32;
            [[a, a + 2, a + 3], [a, a + 3, a + 1]]
        };
        (points, (0..count).flat_map(quad).collect())
    }

    /// Places along x at which a lower and an upper strip are linked across the gap between them.
    fn linked_places(gap: f64) -> Vec<f64> {
        let (mut points, mut triangles) = strip(8, [0.0, 1.0]);
        // Fewer quads above: vertices of one strip lie over the edges of the other.
        let (above, others) = strip(4, [1.0 + gap, 2.0 + gap]);
        let base = points.len() as u32;
        points.extend(above.iter().map(|[x, y]| [2.0 * x, *y]));
        triangles.extend(others.iter().map(|corners| corners.map(|corner| corner + base)));
        let links = surface_links(&points, &triangles, 1.0);
        let across = links.iter().filter(|link| link.kind == LinkKind::Across);
        let mut places: Vec<f64> = across.map(|link| link.ends[0].point(&points, &triangles)[0]).collect();
        places.sort_by(f64::total_cmp);
        places.dedup();
        places
    }

    #[test]
    fn islands_that_touch_are_linked_along_their_contact_and_others_at_one_place() {
        assert_eq!(linked_places(0.01), (0..=8).map(f64::from).collect::<Vec<_>>());
        assert_eq!(linked_places(0.5).len(), 1);
    }
}
