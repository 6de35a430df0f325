//! Other start states of a solve: the rigid fit rotated, and bent in waves.
//!
//! In: the rigid fit. Out: states, in rounds. A compressed shape buckles to one side, to the other, or to both alternately; waves
//! along the axes of the box lead to each of these. Parts that the rigid fit has rotated the wrong way are found by rotating it
//! further.

use crate::lattice::Grid;
use crate::solve::linalg::small_matrix::{SquareMatrix, apply};
use std::f64::consts::PI;

/// Maximum number of half waves along an axis.
const HALVES: usize = 4;

/// Amplitude of a wave, in box diagonals.
const HEIGHT: f64 = 0.2;

/// Further rotations of the rigid fit, in degrees.
const TURNS: [f64; 2] = [120.0, -120.0];

/// Returns the start states beside the rigid fit `start` of the unknowns whose rest positions are `rest`: first rotated ones and
/// single half waves, then more and more half waves.
pub(super) fn rounds<const D: usize>(
    grid: &Grid<D>,
    (start, rest): (&[[f64; D]], &[[f64; D]]),
    rotation: &SquareMatrix<D>,
) -> Vec<Vec<Vec<[f64; D]>>> {
    let mut rounds: Vec<Vec<Vec<[f64; D]>>> =
        (1..=HALVES).map(|halves| waves(grid, (start, rest), (rotation, halves))).collect();
    rounds[0].extend(TURNS.map(|degrees| turned(start, degrees)));
    rounds
}

/// Returns waves of `halves` half waves: along each axis, displaced along each other axis, with both signs.
fn waves<const D: usize>(
    grid: &Grid<D>,
    (start, rest): (&[[f64; D]], &[[f64; D]]),
    (rotation, halves): (&SquareMatrix<D>, usize),
) -> Vec<Vec<[f64; D]>> {
    let ways = (0..D).flat_map(|along| (0..D).map(move |across| (along, across)));
    let ways = ways.filter(|(along, across)| along != across).flat_map(|way| [(way, 1.0), (way, -1.0)]);
    let wave = |((along, across), sign): ((usize, usize), f64)| {
        let unit: [f64; D] = std::array::from_fn(|d| if d == across { sign } else { 0.0 });
        let most = apply(rotation, &unit).map(|x| x * HEIGHT * grid.diagonal());
        let at = |(from, point): (&[f64; D], &[f64; D])| {
            let share = (point[along] - grid.lo[along]) / grid.size(along);
            let height = (PI * halves as f64 * share).sin();
            std::array::from_fn(|d| from[d] + height * most[d])
        };
        start.iter().zip(rest).map(at).collect()
    };
    ways.map(wave).collect()
}

/// Rotates a state about its centroid in the plane of the first two axes.
fn turned<const D: usize>(state: &[[f64; D]], degrees: f64) -> Vec<[f64; D]> {
    let count = state.len().max(1) as f64;
    let middle: [f64; D] = std::array::from_fn(|d| state.iter().map(|x| x[d]).sum::<f64>() / count);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let turn = |point: &[f64; D]| {
        let mut turned = *point;
        let [x, y] = [point[0] - middle[0], point[1] - middle[1]];
        [turned[0], turned[1]] = [middle[0] + cos * x - sin * y, middle[1] + sin * x + cos * y];
        turned
    };
    state.iter().map(turn).collect()
}
