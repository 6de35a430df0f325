//! Where other solves start: turned, and bent in waves.
//!
//! In: the rigid fit. Out: states, in rounds. What is pressed buckles to one side or the other, or to both by turns; a wave
//! along an axis of the box leads into each. What the fit turned the wrong way round is found by turning it further.

use crate::lattice::Grid;
use crate::solve::linalg::small_matrix::{SquareMatrix, apply};
use std::f64::consts::PI;

/// Half waves along an axis, at most.
const HALVES: usize = 4;

/// Height of a wave, in box diagonals.
const HEIGHT: f64 = 0.2;

/// Further turns, degrees.
const TURNS: [f64; 2] = [120.0, -120.0];

/// Starts beside the rigid fit `start` of the unknowns that are at `rest`: turned and in one half wave, then in more and more halves.
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

/// Waves of so many halves: along each axis, across each other one, with both signs.
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

/// A state turned about its middle in the plane of the first two axes.
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
