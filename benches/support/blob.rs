//! Shared by benches: meshes with the vertex counts of the paper's table, and pins on them.

use pinwarp::solve::{PointPin, Shape};

/// A wavy blob of exactly `count` vertices: a bent square grid with an incomplete last row.
pub(crate) fn blob(count: usize) -> Shape<2> {
    let width = (count as f64).sqrt().ceil() as usize;
    let height = count.div_ceil(width);
    let place = |k: usize| {
        let (u, v) = ((k % width) as f64 / (width - 1) as f64 - 0.5, (k / width) as f64 / (height - 1) as f64 - 0.5);
        let waist = 0.55 + 0.35 * (9.0 * v).cos();
        [u * waist + 0.08 * (7.0 * v).sin(), v * (0.9 - 0.5 * u * u)]
    };
    let mut triangles = Vec::new();
    for k in (0..count).filter(|k| k % width + 1 < width && k + width + 1 < count) {
        let corners = [k, k + 1, k + width, k + width + 1].map(|corner| corner as u32);
        triangles.extend([[corners[0], corners[1], corners[3]], [corners[0], corners[3], corners[2]]]);
    }
    Shape::of_triangles((0..count).map(place).collect(), triangles)
}

/// Six pins. The upper ones are rotated by `turn` radians, as if dragged by hand.
pub(crate) fn pins(shape: &Shape<2>, turn: f64) -> Vec<PointPin<2>> {
    let count = shape.points.len();
    let at = |k: usize| shape.points[k * (count - 1) / 5];
    (0..6)
        .map(|k| {
            let at = at(k);
            let (sin, cos) = if k >= 3 { turn.sin_cos() } else { (0.0, 1.0) };
            let target = [cos * at[0] - sin * at[1], sin * at[0] + cos * at[1] + 0.05 * turn];
            PointPin::new(at, target)
        })
        .collect()
}
