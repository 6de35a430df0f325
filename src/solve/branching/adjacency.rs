//! Which triangles of a shape hang together: those that share an edge, however their vertices are numbered; and islands with what
//! is nearest, so that eyes and buttons go along.
//!
//! In: a shape at rest. Out: its seams, and for every triangle those it begins.

use super::disjoint_sets::DisjointSets;
use crate::solve::linalg::small_matrix::distance;
use crate::solve::merge_duplicates::merge_duplicates;
use crate::solve::problem::Shape;

/// An edge that two triangles share, or the shortest way between vertices of two islands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seam<const D: usize> {
    /// The triangle with the smaller index, and the other.
    pub(super) triangles: [usize; 2],
    /// Ends of the edge.
    pub(super) ends: [[f64; D]; 2],
}

/// All seams of a shape, by their first triangle.
#[derive(Clone, Debug)]
pub(super) struct Adjacency<const D: usize> {
    seams: Vec<Seam<D>>,
    /// Where the seams of each triangle end, #triangles.
    ends: Vec<usize>,
}

impl<const D: usize> Adjacency<D> {
    /// Vertices at one place count as one, so that seams of textures do not separate what they join.
    pub(super) fn of(shape: &Shape<D>) -> Self {
        let welded = merge_duplicates(shape);
        let mut sides: Vec<([u32; 2], usize)> = Vec::with_capacity(3 * welded.triangles.len());
        for (number, &[a, b, c]) in welded.triangles.iter().enumerate() {
            sides.extend([[a, b], [b, c], [c, a]].map(|[from, to]| ([from.min(to), from.max(to)], number)));
        }
        sides.sort_unstable();
        let mut seams = Vec::new();
        // Where more than two triangles meet at an edge, all of them hang together.
        for shared in sides.chunk_by(|a, b| a.0 == b.0) {
            let ends = shared[0].0.map(|vertex| welded.points[vertex as usize]);
            seams.extend(shared.windows(2).map(|pair| Seam { triangles: [pair[0].1, pair[1].1], ends }));
        }
        seams.extend(bridges(&welded, &seams));
        seams.sort_by_key(|seam| seam.triangles);
        let ends = (0..welded.triangles.len()).map(|number| seams.partition_point(|seam| seam.triangles[0] <= number));
        Self { ends: ends.collect(), seams }
    }

    /// The seams of a triangle with those of larger index.
    pub(super) fn from(&self, triangle: usize) -> &[Seam<D>] {
        let start = if triangle == 0 { 0 } else { self.ends[triangle - 1] };
        &self.seams[start..self.ends[triangle]]
    }
}

/// A corner of a triangle: its index, and where the corner is.
type Corner<const D: usize> = (usize, [f64; D]);

/// Joins every island to what is nearest, from the largest island on (R. Prim, "Shortest Connection Networks", 1957).
fn bridges<const D: usize>(shape: &Shape<D>, seams: &[Seam<D>]) -> Vec<Seam<D>> {
    let mut islands = DisjointSets::of(shape.triangles.len());
    seams.iter().for_each(|seam| islands.join(seam.triangles));
    let roots: Vec<usize> = (0..shape.triangles.len()).map(|triangle| islands.root(triangle)).collect();
    let mut sizes = vec![0; roots.len()];
    roots.iter().for_each(|&root| sizes[root] += 1);
    let mut order: Vec<usize> = (0..roots.len()).filter(|&root| sizes[root] > 0).collect();
    // Of islands of one size the first.
    order.sort_by_key(|&root| (std::cmp::Reverse(sizes[root]), root));
    let [largest, others @ ..] = order.as_slice() else { return Vec::new() };
    let mut corners: Vec<Corner<D>> = Vec::with_capacity(3 * roots.len());
    for (triangle, vertices) in shape.triangles.iter().enumerate() {
        corners.extend(vertices.iter().map(|&vertex| (triangle, shape.points[vertex as usize])));
    }
    corners.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]).then(a.0.cmp(&b.0)));
    let mut places_of = vec![Vec::new(); roots.len()];
    corners.iter().enumerate().for_each(|(place, corner)| places_of[roots[corner.0]].push(place));
    let mut is_joined = vec![false; roots.len()];
    is_joined[*largest] = true;
    let mut bridges = Vec::new();
    for &island in others {
        let is_wanted = |triangle: usize| is_joined[roots[triangle]];
        let mut best: Option<(f64, Seam<D>)> = None;
        for &place in &places_of[island] {
            let least = best.as_ref().map_or(f64::INFINITY, |(gap, _)| *gap);
            best = nearest(&corners, place, least, is_wanted).or(best);
        }
        is_joined[island] = true;
        bridges.extend(best.map(|(_, seam)| seam));
    }
    bridges
}

/// The way from a corner to the nearest one of a wanted triangle, where it is shorter than `least`; corners are in order of their first
/// coordinate.
fn nearest<const D: usize>(
    corners: &[Corner<D>],
    place: usize,
    mut least: f64,
    is_wanted: impl Fn(usize) -> bool,
) -> Option<(f64, Seam<D>)> {
    let (triangle, from) = corners[place];
    let mut best = None;
    let mut look = |others: &mut dyn Iterator<Item = &Corner<D>>| {
        for &(other, to) in others {
            if (to[0] - from[0]).abs() >= least {
                return;
            }
            let gap = distance(&from, &to);
            if gap < least && is_wanted(other) {
                least = gap;
                best = Some((gap, Seam { triangles: [triangle.min(other), triangle.max(other)], ends: [from, to] }));
            }
        }
    };
    look(&mut corners[..place].iter().rev());
    look(&mut corners[place + 1..].iter());
    best
}
