//! Distances along a surface from points on or near it.
//!
//! In: triangles in space, source points. Out: for points of triangles, the length of the shortest way over the surface. Method:
//! M. Novotni and R. Klein, "Computing geodesic distances on triangular meshes", WSCG 2002: waves run from vertex to vertex; the distances
//! of an edge's ends place a source in the plane of the triangle, from which the way to the third corner is straight.

use glam::{DVec2, DVec3};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// Triangles whose distance from a source exceeds that of the nearest one by less than this fraction of the limit are touched, too:
/// stored points of a surface are rounded.
const TOUCHED_WITHIN: f64 = 0.02;

/// Distances along a surface, up to a limit.
pub(super) struct SurfaceDistance<'a> {
    /// #triangles: places of the corners.
    triangles: &'a [[DVec3; 3]],
    /// #triangles: merged vertices of the corners.
    corners: Vec<[u32; 3]>,
    /// #merged vertices: shortest distance from a source; infinite beyond the limit.
    distances: Vec<f64>,
    /// #triangles: sources from which all of the triangle is seen.
    sources: Vec<Vec<DVec3>>,
}

impl<'a> SurfaceDistance<'a> {
    /// Computes the distances from `sources`, up to `limit`; corners of triangles at one place are one vertex.
    pub(super) fn new(triangles: &'a [[DVec3; 3]], sources: &[DVec3], limit: f64) -> Self {
        let (corners, count) = merged(triangles);
        let (distances, touched) = (vec![f64::INFINITY; count], vec![Vec::new(); triangles.len()]);
        let mut found = Self { triangles, corners, distances, sources: touched };
        sources.iter().for_each(|&source| found.touch(source, limit));
        found.spread(limit);
        found
    }

    /// Returns the distance of a point of a triangle, given its barycentric coordinates.
    pub(super) fn of(&self, triangle: usize, barycentric: [f64; 3]) -> f64 {
        let places = self.triangles[triangle];
        let at: DVec3 = places.iter().zip(barycentric).map(|(place, weight)| *place * weight).sum();
        let seen = self.sources[triangle].iter().map(|source| source.distance(at));
        let ends = self.corners[triangle].map(|corner| self.distances[corner as usize]);
        let over_edges =
            [(0, 1), (1, 2), (2, 0)].map(|(a, b)| over_edge([places[a], places[b]], [ends[a], ends[b]], at));
        seen.chain(over_edges).fold(f64::INFINITY, f64::min)
    }

    /// Starts the waves from a source at the triangles that are nearest to it.
    fn touch(&mut self, source: DVec3, limit: f64) {
        let mut gaps: Vec<(f64, usize)> = Vec::new();
        let mut most = limit;
        for (index, corners) in self.triangles.iter().enumerate() {
            let (low, high) = (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
            if source.distance_squared(source.clamp(low, high)) > most * most {
                continue;
            }
            let gap = gap(source, corners);
            if gap <= most {
                gaps.push((gap, index));
                most = most.min(gap + TOUCHED_WITHIN * limit);
            }
        }
        for (_, index) in gaps.into_iter().filter(|(gap, _)| *gap <= most) {
            self.sources[index].push(source);
            for (corner, place) in self.corners[index].into_iter().zip(self.triangles[index]) {
                let distance = &mut self.distances[corner as usize];
                *distance = distance.min(source.distance(place));
            }
        }
    }

    /// Lets the waves run over the triangles, the nearest vertex first.
    fn spread(&mut self, limit: f64) {
        let around = self.triangles_around();
        let reached = self.distances.iter().enumerate().filter(|(_, distance)| distance.is_finite());
        // Distances are not negative, so their bits have their order.
        let mut queue: BinaryHeap<Reverse<(u64, u32)>> =
            reached.map(|(vertex, distance)| Reverse((distance.to_bits(), vertex as u32))).collect();
        while let Some(Reverse((bits, vertex))) = queue.pop() {
            let distance = f64::from_bits(bits);
            if distance > limit {
                break;
            }
            if distance > self.distances[vertex as usize] {
                continue;
            }
            for &triangle in &around[vertex as usize] {
                for corner in 0..3 {
                    let (to, new) = (self.corners[triangle][corner], self.over(triangle, corner));
                    if new < self.distances[to as usize] {
                        self.distances[to as usize] = new;
                        queue.push(Reverse((new.to_bits(), to)));
                    }
                }
            }
        }
    }

    /// Returns the distance of a corner of a triangle over the opposite edge.
    fn over(&self, triangle: usize, corner: usize) -> f64 {
        let [a, b] = [(corner + 1) % 3, (corner + 2) % 3];
        let (places, ends) = (self.triangles[triangle], self.corners[triangle]);
        let distances = [a, b].map(|end| self.distances[ends[end] as usize]);
        over_edge([places[a], places[b]], distances, places[corner])
    }

    /// #merged vertices: the triangles around each.
    fn triangles_around(&self) -> Vec<Vec<usize>> {
        let mut around = vec![Vec::new(); self.distances.len()];
        for (index, corners) in self.corners.iter().enumerate() {
            corners.iter().for_each(|&corner| around[corner as usize].push(index));
        }
        around
    }
}

/// Returns the merged vertices of the triangles' corners, and their number.
fn merged(triangles: &[[DVec3; 3]]) -> (Vec<[u32; 3]>, usize) {
    let mut known: HashMap<[u64; 3], u32> = HashMap::new();
    let mut vertex = |place: DVec3| {
        let next = known.len() as u32;
        // Adding 0 turns -0 into 0, so that both are one place.
        *known.entry((place + 0.0).to_array().map(f64::to_bits)).or_insert(next)
    };
    let corners = triangles.iter().map(|corners| corners.map(&mut vertex)).collect();
    (corners, known.len())
}

/// Returns the distance of a point from a triangle.
fn gap(point: DVec3, corners: &[DVec3; 3]) -> f64 {
    let barycentric = crate::solve::nearest_barycentric(&point.to_array(), &corners.map(|corner| corner.to_array()));
    let nearest: DVec3 = corners.iter().zip(barycentric).map(|(corner, weight)| *corner * weight).sum();
    nearest.distance(point)
}

/// Returns the distance of a point in the plane of a triangle, over an edge whose ends have these distances: straight from a source beyond
/// the edge if the way crosses the edge, else around one of its ends.
fn over_edge([a, b]: [DVec3; 2], [from_a, from_b]: [f64; 2], point: DVec3) -> f64 {
    let around = (from_a + a.distance(point)).min(from_b + b.distance(point));
    let length = a.distance(b);
    let along = (from_a * from_a - from_b * from_b + length * length) / (2.0 * length);
    let beyond = from_a * from_a - along * along;
    // Also refuses what is not a number: edges without length, ends that no wave reached.
    if !(beyond >= 0.0 && along.is_finite()) {
        return around;
    }
    let source = DVec2::new(along, -beyond.sqrt());
    let direction = (b - a) / length;
    let x = (point - a).dot(direction);
    let target = DVec2::new(x, ((point - a) - x * direction).length());
    let height = target.y - source.y;
    let crossing = if height > 0.0 { source.x + (target.x - source.x) * (-source.y / height) } else { source.x };
    if (0.0..=length).contains(&crossing) { source.distance(target).min(around) } else { around }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sheet of squares cut in halves, bent by a function.
    fn sheet(count: usize, size: f64, bend: impl Fn(DVec2) -> DVec3) -> Vec<[DVec3; 3]> {
        let step = size / count as f64;
        let place = |x: usize, y: usize| bend(DVec2::new(x as f64, y as f64) * step);
        let square = |x: usize, y: usize| {
            let [a, b, c, d] = [place(x, y), place(x + 1, y), place(x + 1, y + 1), place(x, y + 1)];
            [[a, b, c], [a, c, d]]
        };
        (0..count).flat_map(|y| (0..count).flat_map(move |x| [(x, y)])).flat_map(|(x, y)| square(x, y)).collect()
    }

    /// The middle of a triangle, and its distance.
    fn middles(triangles: &[[DVec3; 3]], sources: &[DVec3], limit: f64) -> Vec<(DVec3, f64)> {
        let found = SurfaceDistance::new(triangles, sources, limit);
        let middle = |index: usize| (triangles[index].iter().sum::<DVec3>() / 3.0, found.of(index, [1.0 / 3.0; 3]));
        (0..triangles.len()).map(middle).collect()
    }

    #[test]
    fn on_a_plane_ways_are_straight() {
        let triangles = sheet(20, 2.0, |at| at.extend(0.0));
        let source = DVec3::new(0.83, 1.04, 0.0);
        for (at, distance) in middles(&triangles, &[source], 5.0) {
            assert!((distance - at.distance(source)).abs() < 1e-6, "{at}: {distance}");
        }
    }

    #[test]
    fn a_bent_sheet_is_as_wide_as_it_was() {
        // Once around a tube of circumference 2, less a slit.
        let tube = |at: DVec2| {
            let angle = std::f64::consts::TAU * at.x / 2.1;
            DVec3::new(angle.cos(), angle.sin(), 0.0) * (2.1 / std::f64::consts::TAU) + DVec3::Z * at.y
        };
        let triangles = sheet(40, 2.0, tube);
        let flat = sheet(40, 2.0, |at| at.extend(0.0));
        let source = DVec2::new(0.3, 1.0);
        let distances = middles(&triangles, &[tube(source)], 9.0);
        for ((_, distance), corners) in distances.into_iter().zip(&flat) {
            let straight = (corners.iter().sum::<DVec3>() / 3.0).distance(source.extend(0.0));
            assert!((distance - straight).abs() < 0.03, "{corners:?}: {distance} for {straight}");
        }
    }

    #[test]
    fn what_hangs_not_together_is_never_reached() {
        let mut triangles = sheet(4, 1.0, |at| at.extend(0.0));
        let count = triangles.len();
        triangles.extend(sheet(4, 1.0, |at| at.extend(-0.1)));
        let found = middles(&triangles, &[DVec3::new(0.5, 0.5, 0.001)], 3.0);
        assert!(found[..count].iter().all(|(_, distance)| distance.is_finite()));
        assert!(found[count..].iter().all(|(_, distance)| *distance == f64::INFINITY));
    }

    #[test]
    fn odd_triangles_and_far_sources_are_survived() {
        let point = [DVec3::ONE; 3];
        let line = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        let found = middles(&[point, line], &[DVec3::ZERO, DVec3::splat(1e9)], 10.0);
        assert!(found.iter().all(|(_, distance)| !distance.is_nan()), "{found:?}");
        assert!((found[1].1 - 1.0).abs() < 1e-9, "{found:?}");
        assert!(SurfaceDistance::new(&[], &[DVec3::ZERO], 1.0).distances.is_empty());
    }
}
