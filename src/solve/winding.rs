//! Measures how far pins and handles rotate parts of a shape against each other along a path of targets.
//!
//! In: a path. Out: rotation angles of pairs, unwrapped along the path, and the path in small steps.

use super::linalg::small_matrix::{dot, minus};
use super::targets::Targets;
use crate::lattice::Grid;
use std::f64::consts::{PI, TAU};

/// Number of following points with which each point forms pairs; up to 24 points form all pairs.
const PARTNERS: usize = 23;

/// Returns the rotation angles of pairs of points and of prescribed gradients along a path, in radians: one row per point of the
/// path, unwrapped from the first row on. Empty in 3D, where angles cannot be unwrapped.
pub(crate) fn rotations<const D: usize>(grid: &Grid<D>, path: &[Targets<D>]) -> Vec<Vec<f64>> {
    if D != 2 {
        return Vec::new();
    }
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(path.len());
    for targets in path {
        let mut row = angles(grid, targets);
        if let Some(last) = rows.last() {
            row.iter_mut().zip(last).for_each(|(angle, last)| *angle = last + wrapped(*angle - last));
        }
        rows.push(row);
    }
    rows
}

/// Distance of two targets, relative to that of their rest positions, below which their angle says nothing about winding: pins that
/// pass through each other turn by half a turn to either side.
const CLOSE: f64 = 0.25;

/// Rotation angles of pairs of points and of prescribed gradients, unwrapped from time to time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Winding {
    angles: Vec<f64>,
    /// Smallest distance of each pair so far, relative to that at rest; 1 for gradients.
    nearest: Vec<f64>,
}

impl Winding {
    /// Continues to the next targets. With other pins or handles than before it starts anew.
    pub(crate) fn advance<const D: usize>(&mut self, grid: &Grid<D>, targets: &Targets<D>) {
        if D != 2 {
            return;
        }
        let angles = angles(grid, targets);
        let ratios = distance_ratios(grid, targets);
        if angles.len() != self.angles.len() {
            *self = Self { nearest: vec![1.0; angles.len()], angles };
        } else {
            self.angles.iter_mut().zip(&angles).for_each(|(last, angle)| *last += wrapped(angle - *last));
        }
        self.nearest.iter_mut().zip(ratios).for_each(|(nearest, ratio)| *nearest = nearest.min(ratio));
    }

    /// Whether parts have been wound around each other by more than half a turn.
    pub(crate) fn is_wound(&self) -> bool {
        self.angles.iter().zip(&self.nearest).any(|(angle, &nearest)| angle.abs() > PI && nearest > CLOSE)
    }
}

/// Distances of pairs of targets relative to those of their rest positions, in the order of [`angles`].
fn distance_ratios<const D: usize>(grid: &Grid<D>, targets: &Targets<D>) -> Vec<f64> {
    let ratio = |[rest, now]: [[f64; D]; 2]| {
        let [rest, now] = [rest, now].map(|between| dot(&between, &between).sqrt());
        if rest > 0.0 { now / rest } else { 0.0 }
    };
    pairs(&targets.ends(grid)).map(ratio).collect()
}

/// Angles of pairs and gradients at one point of the path, each within ±π.
fn angles<const D: usize>(grid: &Grid<D>, targets: &Targets<D>) -> Vec<f64> {
    let ends = targets.ends(grid);
    let angle =
        |[rest, now]: [[f64; D]; 2]| (rest[0] * now[1] - rest[1] * now[0]).atan2(rest[0] * now[0] + rest[1] * now[1]);
    let gradients = targets.pins.iter().filter_map(|pin| pin.gradient);
    let of_gradients = gradients.map(|g| (g[0][1] - g[1][0]).atan2(g[0][0] + g[1][1]));
    pairs(&ends).map(angle).chain(of_gradients).collect()
}

/// The vectors between the points of each pair, at rest and between their targets.
fn pairs<const D: usize>(ends: &[[[f64; D]; 2]]) -> impl Iterator<Item = [[f64; D]; 2]> {
    ends.iter().enumerate().flat_map(|(first, a)| {
        ends.iter().skip(first + 1).take(PARTNERS).map(move |b| [minus(&b[0], &a[0]), minus(&b[1], &a[1])])
    })
}

pub(crate) fn wrapped(angle: f64) -> f64 {
    angle - TAU * ((angle + PI) / TAU).floor()
}

/// Range of the angles of a row, which measures how far parts are wound against each other.
pub(crate) fn spread(row: &[f64]) -> f64 {
    let [low, high] =
        row.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &turn| [low.min(turn), high.max(turn)]);
    (high - low).max(0.0)
}

/// Returns points of the path whose consecutive angles differ by at most `most` radians, with interpolated targets where the path
/// itself has larger steps.
pub(crate) fn steps<const D: usize>(path: &[Targets<D>], rotations: &[Vec<f64>], most: f64) -> Vec<Targets<D>> {
    let turn = |from: usize, to: usize| {
        rotations[from].iter().zip(&rotations[to]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let mut steps = vec![path[0].clone()];
    let mut at = 0;
    while at + 1 < path.len() {
        let near = (at + 1..path.len()).take_while(|&next| turn(at, next) <= most).last();
        let next = near.unwrap_or(at + 1);
        let parts = (turn(at, next) / most).ceil().max(1.0) as usize;
        steps.extend((1..parts).map(|part| path[at].interpolated(&path[next], part as f64 / parts as f64)));
        steps.push(path[next].clone());
        at = next;
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;
    use crate::solve::PointPin;

    #[test]
    fn turns_go_on_past_a_whole_one_and_steps_are_small() {
        let grid = Grid { dims: [4, 4], basis: Basis::Bspline, lo: [0.0; 2], hi: [1.0; 2], angle: 0.0 };
        let state = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let pins = [[0.2, 0.1], [0.8, 0.1]].map(|at| PointPin::new(at, at));
            let turned = [1.0, -1.0]
                .map(|side| PointPin::new([0.5 + 0.2 * side, 0.9], [0.5 + 0.2 * side * cos, 0.9 + 0.2 * side * sin]));
            Targets { pins: pins.into_iter().chain(turned).collect(), handles: Vec::new() }
        };
        let path: Vec<_> = [0.0, 100.0, 210.0, 330.0, 400.0].map(state).to_vec();
        let rotations = rotations(&grid, &path);
        // The rotated pair is compared with pairs across, which sway by a few degrees.
        assert!((spread(&rotations[4]).to_degrees() - 400.0).abs() < 6.0, "{rotations:?}");
        let steps = steps(&path, &rotations, 50_f64.to_radians());
        assert_eq!((steps.len(), &steps[0], steps.last()), (1 + 2 + 3 + 3 + 2, &path[0], path.last()));
    }
}
