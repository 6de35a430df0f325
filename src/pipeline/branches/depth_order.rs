//! Determines which parts lie in front of which after the warp.
//!
//! In: the lattice and the order of each label, and what every pixel shows before the warp. Out: labels from back to front.

use super::drawn_pieces::{FrontSurface, NO_LABEL};
use crate::lattice::ScreenLattice;
use crate::space::{FrameSize, ImagePoint, PixelRect};
use std::collections::HashMap;

/// Approximate number of pixels that are sampled.
const FOLLOWED: f64 = 250_000.0;

/// Pixels closer together than this before the warp, in cells, belong to connected surfaces, whose relative depth says nothing.
const BESIDE: i32 = 4;

/// Relative difference of nearness below which two surfaces count as equally far away, as in a drawing.
const SAME: f64 = 1e-5;

/// Sorts labels from back to front.
///
/// Labels with a higher order come later. Among labels of one order, those that are in front at more places where both
/// land come later; of labels that never meet, the one with the smaller index is behind.
pub(super) fn from_back_to_front(
    (lattices, orders): (&[ScreenLattice], &[i32]),
    (front, window, frame): (&[FrontSurface], PixelRect, FrameSize),
) -> Vec<usize> {
    let wins = wins(lattices, (front, window, frame));
    let mut left: Vec<usize> = (0..lattices.len()).collect();
    let mut order = Vec::with_capacity(left.len());
    while !left.is_empty() {
        // Number of places where this label would wrongly lie behind the others.
        let wrong = |&label: &usize| -> i64 {
            let net = |&other: &usize| wins.get(&[label, other]).copied().unwrap_or(0).max(0);
            left.iter().map(net).sum()
        };
        let place = (0..left.len()).min_by_key(|&place| (orders[left[place]], wrong(&left[place]))).unwrap_or(0);
        order.push(left.remove(place));
    }
    order
}

/// Counts pairs of sampled pixels that land in the same cell: the number in which the first label is in front of the
/// second, minus the number in which it is behind.
fn wins(
    lattices: &[ScreenLattice],
    (front, window, frame): (&[FrontSurface], PixelRect, FrameSize),
) -> HashMap<[usize; 2], i64> {
    let step = (front.len() as f64 / FOLLOWED).sqrt().ceil().max(1.0) as usize;
    let width = window.width as usize;
    let cell = 2.0 * step as f64;
    let mut cells: HashMap<[i32; 2], Vec<(FrontSurface, [i32; 2])>> = HashMap::new();
    let rows = (0..front.len() / width.max(1)).step_by(step);
    for place in rows.flat_map(|row| (0..width).step_by(step).map(move |column| row * width + column)) {
        let seen = front[place];
        if seen.label == NO_LABEL {
            continue;
        }
        let [x, y] = window.pixel_at(place);
        let from = frame.screen_from_image(ImagePoint::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let to = frame.image_from_screen(lattices[seen.label as usize].warp(from)).0;
        if to.is_finite() {
            let [column, row] = [to.x, to.y].map(|x| (x / cell).floor() as i32);
            cells.entry([column, row]).or_default().push((seen, [x, y].map(|x| x / cell as i32)));
        }
    }
    let mut wins: HashMap<[usize; 2], i64> = HashMap::new();
    for landed in cells.values() {
        for (index, (one, from)) in landed.iter().enumerate() {
            for (other, there) in &landed[index + 1..] {
                let apart = (from[0] - there[0]).abs().max((from[1] - there[1]).abs());
                let gap = (one.nearness - other.nearness).abs();
                let is_level = gap <= SAME * one.nearness.abs().max(other.nearness.abs());
                if one.label == other.label || is_level || apart <= BESIDE {
                    continue;
                }
                let (near, far) = if one.nearness > other.nearness { (one, other) } else { (other, one) };
                let [near, far] = [near, far].map(|seen| seen.label as usize);
                *wins.entry([near, far]).or_default() += 1;
                *wins.entry([far, near]).or_default() -= 1;
            }
        }
    }
    wins
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Basis, Grid};

    /// A row of eight pixels with two labels; the second label moves over the first.
    #[test]
    fn what_is_nearer_is_in_front_and_of_equals_the_first_is_behind() {
        let frame = FrameSize::new(64, 64);
        let grid = Grid { dims: [4, 4], basis: Basis::Bspline, lo: [0.0; 2], hi: [1.0; 2], angle: 0.0 };
        let mut moved = grid.at_rest();
        moved.handles.iter_mut().for_each(|handle| handle[0] -= 0.5);
        let lattices = [grid.at_rest(), moved];
        let order = |nearness: [f64; 2], orders: [i32; 2]| {
            let label = |place: usize| usize::from(place % 64 >= 32);
            let front = |place: usize| FrontSurface { label: label(place) as u32, nearness: nearness[label(place)] };
            let front: Vec<FrontSurface> = (0..64 * 64).map(front).collect();
            from_back_to_front((&lattices, &orders), (&front, frame.window(), frame))
        };
        let level = [0, 0];
        assert_eq!(
            [order([1.0, 2.0], level), order([2.0, 1.0], level), order([1.0 + 1e-9, 1.0], level)],
            [[0, 1], [1, 0], [0, 1]]
        );
        assert_eq!([order([1.0, 2.0], [3, -1]), order([2.0, 1.0], [0, 1])], [[1, 0], [0, 1]], "the order leads");
    }
}
