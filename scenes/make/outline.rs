//! Flat shapes: the contour of a distance field and triangles inside it.
//!
//! In: a function that is negative inside. Out: points and counter-clockwise triangles. Triangulation: A. Bowyer,
//! "Computing Dirichlet tessellations", 1981, and D. F. Watson, 1981.

use glam::DVec2;

/// Direction of steepest ascent of a field.
pub(crate) fn gradient(field: impl Fn(DVec2) -> f64, at: DVec2) -> DVec2 {
    const STEP: f64 = 1e-4;
    let slope = |axis: DVec2| (field(at + axis * STEP) - field(at - axis * STEP)) / (2.0 * STEP);
    DVec2::new(slope(DVec2::X), slope(DVec2::Y))
}

/// The closed level curve of the field at `level`, as `count` points at equal distances, counter-clockwise from near
/// `start`.
pub(crate) fn contour(field: impl Fn(DVec2) -> f64, level: f64, start: DVec2, count: usize) -> Vec<DVec2> {
    const STEP: f64 = 0.005;
    let settled = |mut point: DVec2| {
        for _ in 0..8 {
            let slope = gradient(&field, point);
            point -= slope * (field(point) - level) / slope.length_squared();
        }
        point
    };
    let mut curve = vec![settled(start)];
    while curve.len() < 100_000 && (curve.len() < 10 || curve[curve.len() - 1].distance(curve[0]) > STEP) {
        let last = curve[curve.len() - 1];
        curve.push(settled(last + gradient(&field, last).perp().normalize() * STEP));
    }
    (0..count).map(|index| curve[index * curve.len() / count]).collect()
}

/// Points of a triangular grid at which the field is at most `level`.
pub(crate) fn fill(field: impl Fn(DVec2) -> f64, level: f64, spacing: f64) -> Vec<DVec2> {
    const REACH: i32 = 40;
    let mut points = Vec::new();
    for row in -REACH..=REACH {
        let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
        for column in -REACH..=REACH {
            let at = DVec2::new(f64::from(column) + shift, f64::from(row) * 0.866) * spacing;
            if field(at) <= level {
                points.push(at);
            }
        }
    }
    points
}

/// Delaunay triangles of the points whose centroid is inside the field, counter-clockwise.
pub(crate) fn triangulate(points: &[DVec2], field: impl Fn(DVec2) -> f64) -> Vec<[u32; 3]> {
    const FAR: f64 = 1e3;
    let count = points.len();
    // Points of a regular grid are cocircular; an invisible shift breaks the ties.
    let shift = |index: usize| DVec2::new((index * 7919 % 1009) as f64, (index * 6271 % 1013) as f64) * 1e-8;
    let mut all: Vec<DVec2> = points.iter().enumerate().map(|(index, point)| *point + shift(index)).collect();
    all.extend([DVec2::new(-FAR, -FAR), DVec2::new(FAR, -FAR), DVec2::new(0.0, FAR)]);
    let mut triangles = vec![[count, count + 1, count + 2]];
    for index in 0..count {
        insert(&mut triangles, &all, index);
    }
    triangles
        .into_iter()
        .filter(|corners| corners.iter().all(|corner| *corner < count))
        .filter(|corners| field(corners.iter().map(|corner| all[*corner]).sum::<DVec2>() / 3.0) < 0.0)
        .map(|corners| corners.map(|corner| corner as u32))
        .collect()
}

/// Replaces the triangles whose circumcircle contains the new point by a fan around it.
fn insert(triangles: &mut Vec<[usize; 3]>, points: &[DVec2], index: usize) {
    let holds = |corners: &[usize; 3]| in_circle(corners.map(|corner| points[corner] - points[index])) > 0.0;
    let (hit, kept): (Vec<_>, Vec<_>) = triangles.iter().copied().partition(holds);
    *triangles = kept;
    let edges: Vec<[usize; 2]> = hit.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    let rim = edges.iter().filter(|[from, to]| !edges.contains(&[*to, *from]));
    triangles.extend(rim.map(|&[from, to]| [from, to, index]));
}

/// Positive if the origin lies inside the circle through three counter-clockwise points.
fn in_circle([a, b, c]: [DVec2; 3]) -> f64 {
    let lift = |point: DVec2, from: DVec2, to: DVec2| point.length_squared() * from.perp_dot(to);
    lift(a, b, c) + lift(b, c, a) + lift(c, a, b)
}
