//! Simplifies lines and closed outlines, which stay apart (Douglas and Peucker, "Algorithms for the reduction of the number of points required to
//! represent a digitized line or its caricature", 1973).
//!
//! In: a line or a loop, and a tolerance. Out: a subset of its points, of a loop at least three.

use super::contour;
use std::collections::BTreeMap;

/// Side of the squares in which segments are sought that may touch, in units of the points.
const PLACE: f64 = 16.0;

/// A segment of a simplified loop: the loop, and the indices of its ends, of which the second may be the number of points.
type Section = (usize, [usize; 2]);

/// Returns the points needed to stay within a tolerance, given for each point, of loops that neither touch nor cross one another or
/// themselves, and for that to stay so.
pub(super) fn simplified_apart(loops: &[&Vec<[f64; 2]>], tolerance: impl Fn([f64; 2]) -> f64) -> Vec<Vec<[f64; 2]>> {
    let mut kept: Vec<Vec<bool>> = loops.iter().map(|points| needed(points, &tolerance)).collect();
    loop {
        let close = touching(loops, &sections(&kept));
        if close.is_empty() {
            break;
        }
        for (index, [from, to]) in close {
            let points = loops[index];
            let (a, b) = (points[from], points[to % points.len()]);
            kept[index][farthest(from + 1..to, |k| distance_to_segment(points[k], a, b))] = true;
        }
    }
    let chosen = |(points, kept): (&&Vec<[f64; 2]>, &Vec<bool>)| {
        points.iter().zip(kept).filter(|(_, is_kept)| **is_kept).map(|(point, _)| *point).collect()
    };
    loops.iter().zip(&kept).map(chosen).collect()
}

/// Returns the segments between points that are kept.
fn sections(kept: &[Vec<bool>]) -> Vec<Section> {
    let of_loop = |(index, kept): (usize, &Vec<bool>)| {
        let ends: Vec<usize> = (0..kept.len()).filter(|&k| kept[k]).collect();
        let next = ends.iter().skip(1).copied().chain(ends.first().map(|first| first + kept.len()));
        ends.iter().copied().zip(next).map(|(from, to)| (index, [from, to])).collect::<Vec<_>>()
    };
    kept.iter().enumerate().flat_map(of_loop).collect()
}

/// Returns the segments that touch or cross another, where points between their ends were left out.
fn touching(loops: &[&Vec<[f64; 2]>], sections: &[Section]) -> Vec<Section> {
    let ends = |&(index, [from, to]): &Section| [loops[index][from], loops[index][to % loops[index].len()]];
    let side = PLACE;
    let mut places: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
    for (number, section) in sections.iter().enumerate() {
        let [a, b] = ends(section);
        let count = ((b[0] - a[0]).hypot(b[1] - a[1]) / side).ceil().max(1.0);
        let mut own: Vec<[i64; 2]> = (0..=count as usize)
            .flat_map(|k| {
                let at = [0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) * k as f64 / count);
                // A piece is no longer than the side of a place: its ends lie in neighbouring places.
                let place = at.map(|x| (x / side).floor() as i64);
                (-1..=1).flat_map(move |y| (-1..=1).map(move |x| [place[0] + x, place[1] + y]))
            })
            .collect();
        own.sort_unstable();
        own.dedup();
        own.into_iter().for_each(|place| places.entry(place).or_default().push(number));
    }
    let mut close = vec![false; sections.len()];
    for numbers in places.values() {
        for (k, &first) in numbers.iter().enumerate() {
            for &second in &numbers[k + 1..] {
                let [a, b] = [sections[first], sections[second]];
                if !are_neighbours(loops, a, b) && meet(ends(&a), ends(&b)) {
                    (close[first], close[second]) = (true, true);
                }
            }
        }
    }
    let is_short = |&(_, [from, to]): &Section| to - from < 2;
    (0..sections.len()).filter(|&k| close[k] && !is_short(&sections[k])).map(|k| sections[k]).collect()
}

/// Whether two segments have an end in common.
fn are_neighbours(loops: &[&Vec<[f64; 2]>], (first, [a, b]): Section, (second, [c, d]): Section) -> bool {
    let count = loops[first].len();
    first == second && (b % count == c || d % count == a)
}

/// Whether two segments touch or cross.
fn meet([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let overlap =
        |axis: usize| a[axis].min(b[axis]) <= c[axis].max(d[axis]) && c[axis].min(d[axis]) <= a[axis].max(b[axis]);
    overlap(0) && overlap(1) && side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
}

/// Marks the points needed to stay within a tolerance of the loop, which is reduced for small loops.
fn needed(points: &[[f64; 2]], tolerance: impl Fn([f64; 2]) -> f64) -> Vec<bool> {
    if points.len() <= 3 {
        return vec![true; points.len()];
    }
    let most = 0.2 * contour::area(points).abs().sqrt();
    let tolerance = |point| tolerance(point).min(most);
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
    is_kept
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
    keep_needed(points, vec![[0, middle], [middle, last]], |_| tolerance, &mut is_kept);
    (0..=last).filter(|&k| is_kept[k]).map(|k| points[k]).collect()
}

/// Marks the points needed to stay within a tolerance of sections, given by their ends; the index after the last is the first point.
fn keep_needed(
    points: &[[f64; 2]],
    mut sections: Vec<[usize; 2]>,
    tolerance: impl Fn([f64; 2]) -> f64,
    is_kept: &mut [bool],
) {
    while let Some([from, to]) = sections.pop() {
        let (a, b) = (points[from], points[to % points.len()]);
        let off = |k: usize| distance_to_segment(points[k], a, b) / tolerance(points[k]);
        if to - from < 2 {
            continue;
        }
        let middle = farthest(from + 1..to, off);
        if off(middle) > 1.0 {
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
