//! Links through the inside of solids, between front and back of a limb, for example, and from what covers a part to that part: a
//! sleeve goes along with its arm everywhere.
//!
//! In: a surface at rest in 3D, the distance between links. Out: [`Link`]s from points of each triangle, along the inward normal, to the
//! opposite side, or to another island close below. Open surfaces with nothing below have no such links; solids whose triangles all face
//! inwards are read as if they faced outwards.

use super::link::{Link, LinkEnd, LinkKind};
use super::ray::Ray;
use crate::disjoint_sets::DisjointSets;
use crate::solve::linalg::small_matrix::{distance, dot, minus};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::collections::BTreeMap;

/// Largest number of points along a side of a triangle.
const MAX_POINTS: usize = 16;

/// Largest number of rays; if there would be more, each triangle has one.
const MAX_RAYS: usize = 400_000;

/// Largest number of triangles from which the thickness of a shape is measured.
const MAX_SAMPLED: usize = 50_000;

/// Offset of the start of a ray from the surface, as a fraction of the diagonal.
const OFF_SURFACE: f64 = 1e-7;

/// Largest distance of a cover (clothes, hair, a shadow) from what it covers, as a fraction of the diagonal.
const COVER: f64 = 0.03;

/// An island is open if the sum of its triangles' normals, which is 0 for a closed surface, is longer than this fraction of its area.
const OPEN: f64 = 0.2;

/// The bounding box of a triangle, with the index of the triangle.
type Boxed = GeomWithData<Rectangle<[f64; 3]>, usize>;

/// Links through the inside of closed surfaces. `pitch`: distance of the points from which they start on a triangle, as a fraction of the
/// shape's diagonal. `islands`: the island of each triangle, #triangles; with it, covers are linked to what they cover, too.
#[must_use]
pub(crate) fn solid_links(
    points: &[[f64; 3]],
    triangles: &[[u32; 3]],
    pitch: f64,
    islands: Option<&[usize]>,
) -> Vec<Link> {
    links_of_every(1, (points, triangles), pitch, islands)
}

/// As [`solid_links`], from triangles that are evenly spread over the list if there are many: enough to measure a shape.
#[must_use]
pub(crate) fn sampled_solid_links(points: &[[f64; 3]], triangles: &[[u32; 3]], pitch: f64) -> Vec<Link> {
    links_of_every(triangles.len().div_ceil(MAX_SAMPLED), (points, triangles), pitch, None)
}

/// The links from every `step`-th triangle.
fn links_of_every(
    step: usize,
    (points, triangles): (&[[f64; 3]], &[[u32; 3]]),
    pitch: f64,
    islands: Option<&[usize]>,
) -> Vec<Link> {
    let is_turned = turned_inside_out(points, triangles, islands);
    let surface = Surface::of(points, triangles, &is_turned);
    let pitch = pitch * surface.diagonal;
    let count = |corners: &[[f64; 3]; 3]| {
        let longest = (0..3).map(|k| distance(&corners[k], &corners[(k + 1) % 3])).fold(0.0, f64::max);
        ((longest / pitch).ceil() as usize).clamp(1, MAX_POINTS)
    };
    let chosen = || surface.corners.iter().enumerate().step_by(step.max(1));
    let rays: usize = chosen().map(|(_, corners)| count(corners).pow(2)).sum();
    let mut links = Vec::new();
    for (number, corners) in chosen() {
        let side = if rays > MAX_RAYS { 1 } else { count(corners) };
        for from in centroids(side) {
            let start = LinkEnd { triangle: number as u32, barycentric: from.map(|share| share as f32) };
            let end = surface.below(number, &from, islands);
            links.extend(end.map(|end| Link { ends: [start, end], kind: LinkKind::Across }));
        }
    }
    for end in links.iter_mut().flat_map(|link| &mut link.ends).filter(|end| is_turned[end.triangle as usize]) {
        end.barycentric.swap(1, 2);
    }
    links
}

/// #triangles: whether the triangle belongs to a closed island of negative volume.
fn turned_inside_out(points: &[[f64; 3]], triangles: &[[u32; 3]], islands: Option<&[usize]>) -> Vec<bool> {
    let island = |triangle: usize| islands.map_or(0, |islands| islands[triangle]);
    let mut sums: BTreeMap<usize, Sums> = BTreeMap::new();
    for (number, corners) in triangles.iter().enumerate() {
        let corners = corners.map(|corner| points[corner as usize]);
        let doubled = normal(&corners);
        let sums = sums.entry(island(number)).or_insert_with(|| Sums { origin: corners[0], ..Sums::default() });
        sums.area += dot(&doubled, &doubled).sqrt();
        sums.volume += dot(&doubled, &minus(&corners[0], &sums.origin));
        (0..3).for_each(|axis| sums.normal[axis] += doubled[axis]);
    }
    let is_turned = |sums: &Sums| sums.volume < 0.0 && dot(&sums.normal, &sums.normal).sqrt() <= OPEN * sums.area;
    (0..triangles.len()).map(|triangle| is_turned(&sums[&island(triangle)])).collect()
}

/// Sums over the triangles of an island.
#[derive(Default)]
struct Sums {
    /// A point of the island, near which volumes lose no digits.
    origin: [f64; 3],
    /// Twice the area.
    area: f64,
    /// Six times the volume of the cone from the origin.
    volume: f64,
    /// Twice the area, as a vector.
    normal: [f64; 3],
}

/// The island of each triangle: the number of one of the triangles with which it hangs together along the surface.
#[must_use]
pub(crate) fn islands_of(triangle_count: usize, links: &[Link]) -> Vec<usize> {
    let mut islands = DisjointSets::of(triangle_count);
    let edges = links.iter().filter(|link| link.kind == LinkKind::Edge);
    edges.for_each(|link| islands.join(link.ends.each_ref().map(|end| end.triangle as usize)));
    (0..triangle_count).map(|triangle| islands.root(triangle)).collect()
}

/// The distance between the ends of a link.
#[must_use]
pub(crate) fn link_length(link: &Link, points: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
    let [from, to] = link.ends.map(|end| end.point(points, triangles));
    distance(&from, &to)
}

/// Barycentric coordinates of the centroids of a triangle's subdivision with `side` small triangles along each side.
fn centroids(side: usize) -> Vec<[f64; 3]> {
    let unit = 1.0 / (3 * side) as f64;
    let upright = (0..side).flat_map(|i| (0..side - i).map(move |j| [3 * i + 1, 3 * j + 1]));
    let inverted = (0..side).flat_map(|i| (0..(side - i).saturating_sub(1)).map(move |j| [3 * i + 2, 3 * j + 2]));
    let shares = upright.chain(inverted).map(|[a, b]| [a as f64 * unit, b as f64 * unit]);
    shares.map(|[a, b]| [a, b, 1.0 - a - b]).collect()
}

/// The triangles of a surface, with a tree for ray queries.
struct Surface {
    corners: Vec<[[f64; 3]; 3]>,
    diagonal: f64,
    tree: RTree<Boxed>,
}

impl Surface {
    /// Collects the triangles. `is_turned`: those whose corners are listed in reverse order, #triangles.
    fn of(points: &[[f64; 3]], triangles: &[[u32; 3]], is_turned: &[bool]) -> Self {
        let outwards = |(corners, is_turned): (&[u32; 3], &bool)| {
            let [a, b, c] = corners.map(|corner| points[corner as usize]);
            if *is_turned { [a, c, b] } else { [a, b, c] }
        };
        let corners: Vec<[[f64; 3]; 3]> = triangles.iter().zip(is_turned).map(outwards).collect();
        let bounds = AABB::from_points(corners.as_flattened().iter());
        let diagonal = if corners.is_empty() { 0.0 } else { distance(&bounds.upper(), &bounds.lower()) };
        let boxed = corners.iter().enumerate().map(|(number, corners)| {
            let bounds = AABB::from_points(corners.iter());
            Boxed::new(Rectangle::from_corners(bounds.lower(), bounds.upper()), number)
        });
        Self { tree: RTree::bulk_load(boxed.collect()), diagonal, corners }
    }

    /// The point where a ray that enters the solid at a point of a triangle leaves it again, or enters another island close below;
    /// `None` if it first meets any other surface from outside, or meets nothing.
    fn below(&self, triangle: usize, from: &[f64; 3], islands: Option<&[usize]>) -> Option<LinkEnd> {
        let corners = &self.corners[triangle];
        let normal = unit(&normal(corners))?;
        let off = OFF_SURFACE * self.diagonal;
        let start = std::array::from_fn(|d| (0..3).map(|k| from[k] * corners[k][d]).sum::<f64>() - off * normal[d]);
        let ray = Ray { start, direction: normal.map(|x| -x) };
        let (t, number) = ray.nearest_hit(&self.tree, |boxed| {
            let (t, _) = ray.hit(&self.corners[boxed.data])?;
            (boxed.data != triangle).then_some((t, boxed.data))
        })?;
        let (_, barycentric) = ray.hit(&self.corners[number])?;
        let is_exit = dot(&self::normal(&self.corners[number]), &ray.direction) > 0.0;
        let is_cover = islands.is_some_and(|islands| islands[number] != islands[triangle]);
        (is_exit || is_cover && t <= COVER * self.diagonal)
            .then(|| LinkEnd { triangle: number as u32, barycentric: barycentric.map(|share| share as f32) })
    }
}

impl Ray<3> {
    /// Distance and barycentric coordinates of the intersection with a triangle (T. Möller, B. Trumbore, "Fast, Minimum Storage
    /// Ray-Triangle Intersection", 1997).
    fn hit(&self, [a, b, c]: &[[f64; 3]; 3]) -> Option<(f64, [f64; 3])> {
        let (ab, ac) = (minus(b, a), minus(c, a));
        let p = cross(&self.direction, &ac);
        let det = dot(&ab, &p);
        if det == 0.0 {
            return None;
        }
        let from_a = minus(&self.start, a);
        let v = dot(&from_a, &p) / det;
        let q = cross(&from_a, &ab);
        let w = dot(&self.direction, &q) / det;
        let t = dot(&ac, &q) / det;
        (v >= 0.0 && w >= 0.0 && v + w <= 1.0 && t > 0.0).then_some((t, [1.0 - v - w, v, w]))
    }
}

fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: &[f64; 3]) -> Option<[f64; 3]> {
    let length = dot(a, a).sqrt();
    (length > 0.0).then(|| a.map(|x| x / length))
}

/// The normal of a triangle that is counter-clockwise seen from outside. Its length is twice the area.
fn normal([a, b, c]: &[[f64; 3]; 3]) -> [f64; 3] {
    cross(&minus(b, a), &minus(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::branching::surface_links;

    const PITCH: f64 = 1.0 / 48.0;

    /// A box with corners at 0 and `size`; opposite faces are consecutive.
    fn faces(size: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let points = (0..8).map(|k| [0, 1, 2].map(|axis| f64::from(k >> axis & 1) * size[axis])).collect();
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        (points, faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
    }

    #[test]
    fn the_sides_of_a_box_hang_together_through_it_and_those_of_a_sheet_do_not() {
        let size = [1.0, 2.0, 4.0];
        let (points, triangles) = faces(size);
        let links = solid_links(&points, &triangles, PITCH, None);
        assert!(links.len() > 100);
        for link in &links {
            let length = link_length(link, &points, &triangles);
            assert!(size.iter().any(|side| (length - side).abs() < 1e-5), "{length}");
            let [from, to] = link.ends.each_ref().map(|end| end.triangle / 2);
            assert_eq!(from ^ 1, to, "opposite faces");
        }
        assert!(solid_links(&points, &triangles[..2], PITCH, None).is_empty());
        let inside_out: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        let turned = solid_links(&points, &inside_out, PITCH, None);
        assert_eq!(turned.len(), links.len());
        for (link, turned) in links.iter().zip(&turned) {
            let [own, other] = [(link, &triangles), (turned, &inside_out)]
                .map(|(link, triangles)| link.ends.map(|end| end.point(&points, triangles)));
            let gaps = own.iter().zip(&other).map(|(own, other)| distance(own, other));
            assert!(gaps.into_iter().all(|gap| gap < 1e-6), "{own:?} and {other:?}");
        }
    }

    #[test]
    fn a_sample_of_the_links_starts_from_evenly_spread_triangles() {
        let (points, triangles) = faces([1.0, 2.0, 4.0]);
        let of_sampled = |link: &Link| link.ends[0].triangle.is_multiple_of(5);
        let all: Vec<Link> = solid_links(&points, &triangles, PITCH, None).into_iter().filter(of_sampled).collect();
        assert_eq!(links_of_every(5, (&points, &triangles), PITCH, None), all);
        assert_eq!(sampled_solid_links(&points, &triangles, PITCH), solid_links(&points, &triangles, PITCH, None));
    }

    #[test]
    fn a_cover_is_linked_to_what_lies_close_below_it() {
        let (mut points, mut triangles) = faces([1.0, 2.0, 4.0]);
        let solid = solid_links(&points, &triangles, PITCH, None).len();
        let mut covers = |gap: f64| {
            let base = points.len() as u32;
            points.extend([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]].map(|[x, y]| [x, y, 4.0 + gap]));
            triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
            let links = surface_links(&points, &triangles, 0.0);
            let links = solid_links(&points, &triangles, PITCH, Some(&islands_of(triangles.len(), &links)));
            points.truncate(8);
            triangles.truncate(12);
            links.len() - solid
        };
        assert!(covers(0.1) > 100, "{}", covers(0.1));
        assert_eq!(covers(0.5), 0, "too far away");
        assert_eq!(covers(-4.1), 0, "the solid does not cover what faces away below it");
    }
}
