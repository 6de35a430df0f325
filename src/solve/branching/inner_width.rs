//! Thickness of a flat shape along its outline.
//!
//! In: a 2D shape. Out: the distance from evenly spaced points of the outline, perpendicular to it, to the opposite side of the
//! shape.

use super::ray::Ray;
use rstar::RTree;
use rstar::primitives::{GeomWithData, Line};
use std::collections::HashMap;

/// Approximate number of points along the outline.
const POINTS: f64 = 1000.0;

/// Offset of the start of a ray from the outline, as a fraction of the spacing of the points.
const INSIDE: f64 = 1e-6;

/// Widths at evenly spaced points of the outline, about a thousand in all.
#[must_use]
pub(crate) fn inner_widths(points: &[[f64; 2]], triangles: &[[u32; 3]]) -> Vec<f64> {
    let outline = outline(points, triangles);
    let length: f64 = outline.iter().map(|[from, to]| (to[0] - from[0]).hypot(to[1] - from[1])).sum();
    let step = length / POINTS;
    let sides = outline.iter().enumerate().map(|(number, &[from, to])| GeomWithData::new(Line::new(from, to), number));
    let tree = RTree::bulk_load(sides.collect());
    let mut widths = Vec::new();
    let mut until_next = 0.5 * step;
    for (number, &[from, to]) in outline.iter().enumerate() {
        let side = (to[0] - from[0]).hypot(to[1] - from[1]);
        while until_next < side {
            let t = until_next / side;
            // The shape is on the left of the side.
            let inwards = [(from[1] - to[1]) / side, (to[0] - from[0]) / side];
            let start = [0, 1].map(|d| from[d] + t * (to[d] - from[d]) + INSIDE * step * inwards[d]);
            widths.extend(width(&tree, &outline, (number, start, inwards)));
            until_next += step;
        }
        until_next -= side;
    }
    widths
}

/// Sides that belong to one triangle only, with the shape on their left.
fn outline(points: &[[f64; 2]], triangles: &[[u32; 3]]) -> Vec<[[f64; 2]; 2]> {
    let key = |vertex: u32| points[vertex as usize].map(|x| (x + 0.0).to_bits());
    let mut sides: HashMap<[[u64; 2]; 2], (usize, [u32; 2])> = HashMap::new();
    let mut order = Vec::new();
    for &[a, b, c] in triangles {
        let [p, q, r] = [a, b, c].map(|corner| points[corner as usize]);
        let is_left = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) >= 0.0;
        let [a, b, c] = if is_left { [a, b, c] } else { [a, c, b] };
        for side in [[a, b], [b, c], [c, a]] {
            let mut ends = side.map(key);
            ends.sort_unstable();
            let known = sides.entry(ends).or_insert_with(|| {
                order.push(ends);
                (0, side)
            });
            known.0 += 1;
        }
    }
    let alone = order.iter().map(|ends| sides[ends]).filter(|(count, _)| *count == 1);
    alone.map(|(_, side)| side.map(|vertex| points[vertex as usize])).collect()
}

/// Distance along the ray from a point inside a side to the next side.
fn width(
    tree: &RTree<GeomWithData<Line<[f64; 2]>, usize>>,
    outline: &[[[f64; 2]; 2]],
    (number, start, direction): (usize, [f64; 2], [f64; 2]),
) -> Option<f64> {
    let ray = Ray { start, direction };
    let nearest = ray.nearest_hit(tree, |side| {
        let [from, to] = outline[side.data];
        let (along, gap) = ([to[0] - from[0], to[1] - from[1]], [from[0] - start[0], from[1] - start[1]]);
        let det = direction[0] * along[1] - direction[1] * along[0];
        let t = (gap[0] * along[1] - gap[1] * along[0]) / det;
        let s = (gap[0] * direction[1] - gap[1] * direction[0]) / det;
        (side.data != number && det != 0.0 && t > 0.0 && (0.0..=1.0).contains(&s)).then_some((t, side.data))
    });
    nearest.map(|(t, _)| t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_is_as_wide_as_it_is() {
        let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.2], [0.0, 0.2]];
        let mut widths = inner_widths(&points, &[[0, 1, 2], [0, 2, 3]]);
        widths.sort_by(f64::total_cmp);
        assert!((990..=1010).contains(&widths.len()), "{}", widths.len());
        // The long sides are 2 of the total length 2.4. Measured from the short ones the bar is 1 wide.
        let [thin, long] = [widths[widths.len() / 2], widths[widths.len() - 1]];
        assert!((thin - 0.2).abs() < 1e-6 && (long - 1.0).abs() < 1e-6, "{thin}, {long}");
    }
}
