//! Pins and handles on their way: places between two states of them, and how far they wind each other up.
//!
//! In: states of the same pins and handles. Out: states between them; turns of pairs, unwrapped along a path.

use super::pins::Rigid;
use super::small::{Square, best_rotation, minus, rotation_part, times, transpose};
use super::{HandlePin, PointPin};
use crate::lattice::Grid;
use std::f64::consts::{PI, TAU};

/// Where pins and moved handles have to go at one place of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Waypoint<const D: usize> {
    /// Pins.
    pub pins: Vec<PointPin<D>>,
    /// Moved handles.
    pub handles: Vec<HandlePin<D>>,
}

/// Pairs are measured between a point and this many that follow it: all pairs of up to 24 points.
const PARTNERS: usize = 23;

impl<const D: usize> Waypoint<D> {
    /// Where the rigid motion that fits best brings everything.
    pub(crate) fn rigid(&self, grid: &Grid<D>) -> Self {
        let rigid = Rigid::fit(grid, &self.pins, &self.handles);
        let turned = transpose(&rigid.rotation());
        let pins = self.pins.iter().map(|pin| PointPin {
            target: rigid.image(&pin.at),
            gradient: pin.gradient.map(|_| turned),
            ..*pin
        });
        let target = |handle: &HandlePin<D>| rigid.image(&grid.rest_handle(handle.index));
        let handles = self.handles.iter().map(|handle| HandlePin { target: target(handle), ..*handle });
        Self { pins: pins.collect(), handles: handles.collect() }
    }

    /// The state at a share of the way to another one: targets on straight lines, gradients by rotation and stretch.
    pub(crate) fn towards(&self, to: &Self, share: f64) -> Self {
        let mix = |a: [f64; D], b: [f64; D]| std::array::from_fn(|d| a[d] * (1.0 - share) + b[d] * share);
        let pins = self.pins.iter().zip(&to.pins).map(|(a, b)| PointPin {
            target: mix(a.target, b.target),
            gradient: a.gradient.zip(b.gradient).map(|(a, b)| mix_gradients(&a, &b, share)),
            ..*b
        });
        let handles = self.handles.iter().zip(&to.handles);
        let handles = handles.map(|(a, b)| HandlePin { target: mix(a.target, b.target), ..*b });
        Self { pins: pins.collect(), handles: handles.collect() }
    }

    /// Rest places and targets of everything that has any weight.
    fn ends(&self, grid: &Grid<D>) -> Vec<[[f64; D]; 2]> {
        let pins = self.pins.iter().filter(|pin| pin.weight > 0.0).map(|pin| [pin.at, pin.target]);
        let handles = self.handles.iter().map(|handle| [grid.rest_handle(handle.index), handle.target]);
        pins.chain(handles).collect()
    }
}

/// Gradients (columns: images of the axes) between two: both parted into rotation and stretch.
fn mix_gradients<const D: usize>(a: &Square<D>, b: &Square<D>, share: f64) -> Square<D> {
    let [(turn_a, stretch_a), (turn_b, stretch_b)] = [a, b].map(|columns| {
        // S of `best_rotation` is Σ (axis)(image)ᵀ: the columns as rows.
        let rotation = best_rotation(columns);
        (rotation, times(&transpose(&rotation), &transpose(columns)))
    });
    let turn = times(&rotation_part(&times(&turn_b, &transpose(&turn_a)), share), &turn_a);
    let stretch: Square<D> = std::array::from_fn(|row| {
        std::array::from_fn(|column| stretch_a[row][column] * (1.0 - share) + stretch_b[row][column] * share)
    });
    transpose(&times(&turn, &stretch))
}

/// How pairs of points and rotations held by pins turn along a path: one row a waypoint, radians, unwrapped from the
/// first on. In space nothing is unwrapped: no rows.
pub(crate) fn turns<const D: usize>(grid: &Grid<D>, path: &[Waypoint<D>]) -> Vec<Vec<f64>> {
    if D != 2 {
        return Vec::new();
    }
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(path.len());
    for waypoint in path {
        let mut row = directions(grid, waypoint);
        if let Some(last) = rows.last() {
            row.iter_mut().zip(last).for_each(|(angle, last)| *angle = last + wrapped(*angle - last));
        }
        rows.push(row);
    }
    rows
}

/// Turns of pairs and rotations at one waypoint, each within ±π.
fn directions<const D: usize>(grid: &Grid<D>, waypoint: &Waypoint<D>) -> Vec<f64> {
    let ends = waypoint.ends(grid);
    let mut angles = Vec::new();
    for (first, a) in ends.iter().enumerate() {
        for b in ends.iter().skip(first + 1).take(PARTNERS) {
            let (rest, now) = (minus(&b[0], &a[0]), minus(&b[1], &a[1]));
            angles.push((rest[0] * now[1] - rest[1] * now[0]).atan2(rest[0] * now[0] + rest[1] * now[1]));
        }
    }
    let gradients = waypoint.pins.iter().filter_map(|pin| pin.gradient);
    angles.extend(gradients.map(|g| (g[0][1] - g[1][0]).atan2(g[0][0] + g[1][1])));
    angles
}

fn wrapped(angle: f64) -> f64 {
    angle - TAU * ((angle + PI) / TAU).floor()
}

/// How far apart the turns of a row are: parts wound against each other.
pub(crate) fn spread(row: &[f64]) -> f64 {
    let [low, high] =
        row.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &turn| [low.min(turn), high.max(turn)]);
    (high - low).max(0.0)
}

/// The waypoints of a path that are no more than `most` radians of any turn apart, with others between where the path
/// itself goes farther at once.
pub(crate) fn steps<const D: usize>(path: &[Waypoint<D>], turns: &[Vec<f64>], most: f64) -> Vec<Waypoint<D>> {
    let turn =
        |from: usize, to: usize| turns[from].iter().zip(&turns[to]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let mut steps = vec![path[0].clone()];
    let mut at = 0;
    while at + 1 < path.len() {
        let near = (at + 1..path.len()).take_while(|&next| turn(at, next) <= most).last();
        let next = near.unwrap_or(at + 1);
        let parts = (turn(at, next) / most).ceil().max(1.0) as usize;
        steps.extend((1..parts).map(|part| path[at].towards(&path[next], part as f64 / parts as f64)));
        steps.push(path[next].clone());
        at = next;
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;

    fn pin(at: [f64; 2], target: [f64; 2], degrees: f64) -> PointPin<2> {
        let (sin, cos) = degrees.to_radians().sin_cos();
        PointPin { gradient: Some([[2.0 * cos, 2.0 * sin], [-sin, cos]]), ..PointPin::new(at, target) }
    }

    #[test]
    fn gradients_turn_without_shrinking() {
        let [from, to] = [30.0, 190.0].map(|degrees| pin([0.0; 2], [degrees, 0.0], degrees));
        let [from, to] = [from, to].map(|pin| Waypoint { pins: vec![pin], handles: Vec::new() });
        let found = from.towards(&to, 0.25).pins[0];
        let expected = pin([0.0; 2], [70.0, 0.0], 70.0);
        assert_eq!(found.target, expected.target);
        let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
        let (found, expected) = (found.gradient.unwrap_or_default(), expected.gradient.unwrap_or_default());
        assert!(found.as_flattened().iter().zip(expected.as_flattened()).all(near), "{found:?}");
        // In space: half of a half turn about x is a quarter turn.
        let half = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
        let quarter = mix_gradients(&crate::solve::small::identity::<3>(), &half, 0.5);
        assert!(
            (quarter[0][0] - 1.0).abs() < 1e-12 && quarter[1][1].abs() < 1e-12 && quarter[1][2].abs() > 1.0 - 1e-12
        );
    }

    #[test]
    fn turns_go_on_past_a_whole_one_and_steps_are_small() {
        let grid = Grid { dims: [4, 4], basis: Basis::Bspline, lo: [0.0; 2], hi: [1.0; 2] };
        let state = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let pins = [[0.2, 0.1], [0.8, 0.1]].map(|at| PointPin::new(at, at));
            let turned = [1.0, -1.0]
                .map(|side| PointPin::new([0.5 + 0.2 * side, 0.9], [0.5 + 0.2 * side * cos, 0.9 + 0.2 * side * sin]));
            Waypoint { pins: pins.into_iter().chain(turned).collect(), handles: Vec::new() }
        };
        let path: Vec<_> = [0.0, 100.0, 210.0, 330.0, 400.0].map(state).to_vec();
        let turns = turns(&grid, &path);
        // The turned pair against pairs across, which sway by a few degrees.
        assert!((spread(&turns[4]).to_degrees() - 400.0).abs() < 6.0, "{turns:?}");
        let steps = steps(&path, &turns, 50_f64.to_radians());
        assert_eq!((steps.len(), &steps[0], steps.last()), (1 + 2 + 3 + 3 + 2, &path[0], path.last()));
    }
}
