//! What pins do: hold exactly, keep their neighbourhood smooth, take regions along, turn with the problem.
//!
//! Shapes, grids and pins that the modules share.

#[path = "../support/random.rs"]
mod random;

mod cancel;
mod hard;
mod regions;
mod rigid;
mod stiffness;

use pinwarp::lattice::{Basis, Grid};
use pinwarp::solve::{HandlePin, PointPin, Problem, Settings, Shape, Solution, solve};
use proptest::prelude::*;

pub(crate) fn few() -> ProptestConfig {
    random::config(24)
}

pub(crate) fn grid<const D: usize>(count: usize, basis: Basis) -> Grid<D> {
    Grid { dims: [count; D], basis, lo: [0.0; D], hi: [1.0; D], angle: 0.0 }
}

/// A square sheet of `count` x `count` cells, standing in the middle of the box in 3D.
pub(crate) fn sheet<const D: usize>(count: u32) -> Shape<D> {
    let side = count + 1;
    let at = |k: u32| f64::from(k) / f64::from(count) * 0.8 + 0.1;
    let point = |k: u32| std::array::from_fn(|d| [at(k % side), at(k / side), 0.5][d]);
    let corners = (0..count * count).map(|k| k % count + k / count * side);
    let cells = corners.flat_map(|k| [[k, k + 1, k + side], [k + 1, k + side + 1, k + side]]);
    Shape::of_triangles((0..side * side).map(point).collect(), cells.collect())
}

/// A sphere of triangles in the middle of the box.
pub(crate) fn ball() -> Shape<3> {
    let (around, up) = (16_u32, 8_u32);
    let point = |k: u32| {
        let turn = f64::from(k % around) / f64::from(around) * std::f64::consts::TAU;
        let tilt = f64::from(k / around) / f64::from(up) * std::f64::consts::PI;
        [0.5 + 0.35 * tilt.sin() * turn.cos(), 0.5 + 0.35 * tilt.sin() * turn.sin(), 0.5 + 0.35 * tilt.cos()]
    };
    let next = |k: u32| k / around * around + (k + 1) % around;
    let cells = (0..around * up).flat_map(|k| [[k, next(k), k + around], [next(k), next(k) + around, k + around]]);
    Shape::of_triangles((0..around * (up + 1)).map(point).collect(), cells.collect())
}

pub(crate) fn run<const D: usize>(
    grid: &Grid<D>,
    shape: &Shape<D>,
    pins: &[PointPin<D>],
    handles: &[HandlePin<D>],
) -> Solution<D> {
    let settings = Settings::default();
    solve(&Problem { grid, shape, pins, handles, settings: &settings }).expect("a valid problem")
}

pub(crate) use crate::internal::numbers::distance;

pub(crate) fn bases() -> impl Strategy<Value = Basis> {
    prop_oneof![Just(Basis::Bspline), Just(Basis::Bernstein), Just(Basis::Bilinear), Just(Basis::Barytri)]
}

/// Pins at least a tenth of the box apart, with targets up to a tenth away.
pub(crate) fn apart<const D: usize>(raw: Vec<([f64; D], [f64; D])>) -> Vec<PointPin<D>> {
    let mut pins: Vec<PointPin<D>> = Vec::new();
    for (at, by) in raw {
        if pins.iter().all(|pin| distance(pin.at, at) > 0.15) {
            pins.push(PointPin::new(at, std::array::from_fn(|d| at[d] + by[d])));
        }
    }
    pins
}

pub(crate) fn pins_2d() -> impl Strategy<Value = Vec<PointPin<2>>> {
    let raw = ([0.05..0.95_f64, 0.05..0.95_f64], [-0.1..0.1_f64, -0.1..0.1_f64]);
    prop::collection::vec(raw, 1..7).prop_map(apart)
}

pub(crate) fn pins_3d() -> impl Strategy<Value = Vec<PointPin<3>>> {
    let place = [0.05..0.95_f64, 0.05..0.95_f64, 0.05..0.95_f64];
    let raw = (place, [-0.1..0.1_f64, -0.1..0.1_f64, -0.1..0.1_f64]);
    prop::collection::vec(raw, 1..5).prop_map(apart)
}
