//! Closed contours of coverage by marching squares (Lorensen and Cline, "Marching Cubes", 1987, in the plane).
//!
//! In: [`AlphaGrid`]. Out: loops of points with sub-cell precision, which neither touch nor cross one another or
//! themselves.

use super::coverage::AlphaGrid;

/// Marks the absence of a next point.
const NONE: u32 = u32::MAX;

/// Points keep this fraction of a cell's side away from its corners, so that contours never meet in one.
const MARGIN: f64 = 0.02;

/// Returns all contours; outer ones have positive area, holes negative.
///
/// A contour crosses edges between neighbouring cells: edge 2k leads from cell k to the right, 2k + 1 downwards.
pub(super) fn loops(coverage: &AlphaGrid) -> Vec<Vec<[f64; 2]>> {
    let mut next = vec![NONE; 2 * coverage.values.len()];
    let [width, height] = coverage.size;
    for y in 0..height - 1 {
        for x in 0..width - 1 {
            link(coverage, y * width + x, &mut next);
        }
    }
    let mut loops = Vec::new();
    for start in 0..next.len() {
        let mut points = Vec::new();
        let mut side = start;
        while next[side] != NONE {
            points.push(crossing(coverage, side));
            side = std::mem::replace(&mut next[side], NONE) as usize;
        }
        if !points.is_empty() {
            loops.push(points);
        }
    }
    loops
}

/// Links the edges that the contour crosses around the square whose upper left corner is cell `at`.
fn link(coverage: &AlphaGrid, at: usize, next: &mut [u32]) {
    let width = coverage.size[0];
    // Clockwise from the upper left; after each corner, the edge that starts there.
    let corners = [at, at + 1, at + width + 1, at + width];
    let sides = [2 * at, 2 * (at + 1) + 1, 2 * (at + width), 2 * at + 1];
    let values = corners.map(|corner| coverage.values[corner]);
    let is_in = values.map(|value| value >= coverage.edge);
    let leaves = |k: usize| is_in[k] && !is_in[(k + 1) % 4];
    let enters = |k: usize| !is_in[k] && is_in[(k + 1) % 4];
    let is_saddle = is_in[0] == is_in[2] && is_in[1] == is_in[3] && is_in[0] != is_in[1];
    // At a saddle, the mean decides whether the inside is connected.
    let is_split = is_saddle && values.iter().sum::<f32>() * 0.25 < coverage.edge;
    for from in (0..4).filter(|&k| leaves(k)) {
        let step = if is_split { 3 } else { 1 };
        let to = (1..4).map(|turns| (from + turns * step) % 4).find(|&k| enters(k));
        next[sides[from]] = sides[to.expect("what leaves the inside enters it again")] as u32;
    }
}

/// Returns where the contour crosses an edge.
fn crossing(coverage: &AlphaGrid, side: usize) -> [f64; 2] {
    let (cell, is_down) = (side / 2, side % 2 == 1);
    let width = coverage.size[0];
    let other = if is_down { cell + width } else { cell + 1 };
    let [from, to] = [coverage.values[cell], coverage.values[other]].map(f64::from);
    // Infinite coverage is placed in the middle, as no better position is known.
    let share = (f64::from(coverage.edge) - from) / (to - from);
    let share = if share.is_finite() { share.clamp(MARGIN, 1.0 - MARGIN) } else { 0.5 };
    let [x, y] = [(cell % width) as f64, (cell / width) as f64];
    if is_down { [x, y + share] } else { [x + share, y] }
}

/// Returns the signed area, by the shoelace formula: positive for outer contours, which run clockwise as seen, y down.
pub(super) fn area(points: &[[f64; 2]]) -> f64 {
    0.5 * pairs(points).map(|([ax, ay], [bx, by])| ax * by - ay * bx).sum::<f64>()
}

/// Returns the length of a closed contour.
pub(super) fn length(points: &[[f64; 2]]) -> f64 {
    pairs(points).map(|([ax, ay], [bx, by])| (bx - ax).hypot(by - ay)).sum()
}

/// Returns each point of a loop with the next one.
pub(super) fn pairs(points: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
    points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| (*a, *b))
}
