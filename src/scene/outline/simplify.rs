//! Simplifies lines and closed outlines (Douglas and Peucker, "Algorithms for the reduction of the number of points required to
//! represent a digitized line or its caricature", 1973).
//!
//! In: a line or a loop, and a tolerance. Out: a subset of its points, of a loop at least three.

use super::contour;

/// Returns the points needed to stay within `tolerance` of the loop; the tolerance is reduced for small loops.
pub(super) fn simplified(points: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    if points.len() <= 3 {
        return points.to_vec();
    }
    let tolerance = tolerance.min(0.2 * contour::area(points).abs().sqrt());
    let count = points.len();
    // The loop is split at its first point and the one farthest from it.
    let far = farthest(1..count, |k| distance(points[0], points[k]));
    let mut is_kept = vec![false; count];
    (is_kept[0], is_kept[far]) = (true, true);
    // The last section leads back to the first point.
    keep_needed(points, vec![[0, far], [far, count]], tolerance, &mut is_kept);
    if is_kept.iter().filter(|&&is_kept| is_kept).count() < 3 {
        let off = |k: usize| distance_to_segment(points[k], points[0], points[far]);
        is_kept[farthest((1..count).filter(|&k| k != far), off)] = true;
    }
    (0..count).filter(|&k| is_kept[k]).map(|k| points[k]).collect()
}

/// Returns the points needed to stay within `tolerance` of a line; it is closed if it ends at its first point.
pub(super) fn simplified_line(points: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let last = points.len().saturating_sub(1);
    if last < 2 {
        return points.to_vec();
    }
    let mut is_kept = vec![false; points.len()];
    let middle = if points[0] == points[last] { farthest(1..last, |k| distance(points[0], points[k])) } else { 0 };
    (is_kept[0], is_kept[middle], is_kept[last]) = (true, true, true);
    keep_needed(points, vec![[0, middle], [middle, last]], tolerance, &mut is_kept);
    (0..=last).filter(|&k| is_kept[k]).map(|k| points[k]).collect()
}

/// Marks the points needed to stay within `tolerance` of sections, given by their ends; the index after the last is the first point.
fn keep_needed(points: &[[f64; 2]], mut sections: Vec<[usize; 2]>, tolerance: f64, is_kept: &mut [bool]) {
    while let Some([from, to]) = sections.pop() {
        let (a, b) = (points[from], points[to % points.len()]);
        let off = |k: usize| distance_to_segment(points[k], a, b);
        if to - from < 2 {
            continue;
        }
        let middle = farthest(from + 1..to, off);
        if off(middle) > tolerance {
            is_kept[middle] = true;
            sections.extend([[from, middle], [middle, to]]);
        }
    }
}

/// Returns the first index with the maximum value.
fn farthest(mut range: impl Iterator<Item = usize>, value: impl Fn(usize) -> f64) -> usize {
    let first = range.next().expect("ranges of outlines hold a point");
    range.fold((first, value(first)), |best, k| if value(k) > best.1 { (k, value(k)) } else { best }).0
}

fn distance([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    (bx - ax).hypot(by - ay)
}

/// Returns the distance from a point to the segment between `a` and `b`.
pub(super) fn distance_to_segment(point: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let [along, way] = [[b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]];
    let square = along[0] * along[0] + along[1] * along[1];
    let share = if square > 0.0 { ((way[0] * along[0] + way[1] * along[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (way[0] - share * along[0]).hypot(way[1] - share * along[1])
}
