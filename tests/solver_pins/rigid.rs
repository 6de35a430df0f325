//! Rigid motions cost nothing: one pin moves everything, more pins turn everything, and a turned problem has the turned
//! solution; with regions, discs, painted stiffness and every basis, in the plane and in space.

use super::{ball, bases, distance, few, grid, pins_2d, pins_3d, sheet};
use crate::internal::solving::run;
use pinwarp::lattice::{Grid, Lattice};
use pinwarp::solve::{PointPin, Region, Settings, Shape};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

/// Largest distance of a handle from where it should be, parts of the unit box.
const RIGID: f64 = 1e-6;

/// Iterates far beyond what a picture shows.
fn exact() -> Settings {
    Settings { tolerance: 1e-8, iteration_limit: 300, ..Settings::default() }
}

/// Every other pin takes a region along; the shape is painted in stripes.
fn decorate<const D: usize>(pins: &mut [PointPin<D>], shape: &mut Shape<D>) {
    let region = Region { radius: 0.2, rigidity: 0.7, stiffness: 4.0 };
    pins.iter_mut().step_by(2).for_each(|pin| pin.region = Some(region));
    shape.stiffness = (0..shape.triangles.len()).map(|k| if k % 6 < 3 { 0.3 } else { 5.0 }).collect();
}

/// x ↦ R x + shift; in space about the axis (1, 2, 2) / 3 (Rodrigues).
fn motion<const D: usize>(angle: f64, shift: [f64; D]) -> impl Fn([f64; D]) -> [f64; D] {
    let (sin, cos) = angle.sin_cos();
    let axis = [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0];
    move |p| {
        if D == 2 {
            return std::array::from_fn(|d| shift[d] + [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1]][d]);
        }
        let along: f64 = (0..D).map(|d| axis[d] * p[d]).sum();
        let cross = |d: usize| axis[(d + 1) % 3] * p[(d + 2) % 3] - axis[(d + 2) % 3] * p[(d + 1) % 3];
        std::array::from_fn(|d| shift[d] + cos * p[d] + sin * cross(d) + (1.0 - cos) * along * axis[d])
    }
}

/// Largest distance of the handles of a lattice from the images of those of another.
fn apart<const D: usize>(found: &Lattice<D>, from: &[[f64; D]], image: impl Fn([f64; D]) -> [f64; D]) -> f64 {
    found.handles.iter().zip(from).map(|(&a, &b)| distance(a, image(b))).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(few())]

    #[test]
    fn one_pin_moves_everything(at in [0.1..0.9_f64, 0.1..0.9_f64], to in [-9.0..9.0_f64, -9.0..9.0_f64], basis in bases()) {
        let (grid, mut shape, mut pins) = (grid(8, basis), sheet(12), [PointPin::new(at, to)]);
        decorate(&mut pins, &mut shape);
        let solution = run(&grid, &shape, &pins, &Settings::default());
        let image = motion(0.0, [to[0] - at[0], to[1] - at[1]]);
        prop_assert!(apart(&solution.lattice, &grid.rest_handles(), image) < RIGID, "{:?}", solution.report);
    }

    #[test]
    fn one_pin_moves_everything_in_space(at in [0.1..0.9_f64, 0.1..0.9_f64, 0.1..0.9_f64], to in -9.0..9.0_f64, basis in bases()) {
        let (grid, mut shape, mut pins) = (grid::<3>(5, basis), ball(), [PointPin::new(at, [to, 1.0, -to])]);
        decorate(&mut pins, &mut shape);
        let solution = run(&grid, &shape, &pins, &Settings::default());
        let image = motion(0.0, [to - at[0], 1.0 - at[1], -to - at[2]]);
        prop_assert!(apart(&solution.lattice, &grid.rest_handles(), image) < RIGID, "{:?}", solution.report);
    }

    #[test]
    fn pins_that_turn_turn_everything(mut pins in pins_2d(), angle in -3.1..3.1_f64, basis in bases()) {
        prop_assume!(pins.len() > 1);
        let (grid, mut shape, image) = (grid(8, basis), sheet(12), motion(angle, [3.0, -2.0]));
        pins.iter_mut().for_each(|pin| pin.target = image(pin.at));
        decorate(&mut pins, &mut shape);
        let solution = run(&grid, &shape, &pins, &Settings::default());
        prop_assert!(apart(&solution.lattice, &grid.rest_handles(), image) < RIGID, "{:?}", solution.report);
    }

    #[test]
    fn pins_that_turn_turn_everything_in_space(mut pins in pins_3d(), angle in -3.1..3.1_f64, basis in bases()) {
        // Two pins leave the turn about their line open.
        prop_assume!(pins.len() > 2);
        let (grid, mut shape, image) = (grid::<3>(5, basis), ball(), motion(angle, [3.0, -2.0, 1.0]));
        pins.iter_mut().for_each(|pin| pin.target = image(pin.at));
        decorate(&mut pins, &mut shape);
        let solution = run(&grid, &shape, &pins, &Settings::default());
        prop_assert!(apart(&solution.lattice, &grid.rest_handles(), image) < RIGID, "{:?}", solution.report);
    }
}

/// The first cases that a strategy draws.
fn drawn<T>(strategy: &impl Strategy<Value = T>, count: usize) -> Vec<T> {
    let mut runner = TestRunner::deterministic();
    (0..count).map(|_| strategy.new_tree(&mut runner).expect("a case").current()).collect()
}

/// How far the solution of a turned problem is from the turned solution; `None` where one of them did not converge.
fn turned_gap<const D: usize>(
    grid: &Grid<D>,
    mut shape: Shape<D>,
    mut pins: Vec<PointPin<D>>,
    image: impl Fn([f64; D]) -> [f64; D],
) -> Option<f64> {
    decorate(&mut pins, &mut shape);
    let first = run(grid, &shape, &pins, &exact());
    pins.iter_mut().for_each(|pin| pin.target = image(pin.target));
    let turned = run(grid, &shape, &pins, &exact());
    let both = first.report.is_converged && turned.report.is_converged;
    both.then(|| apart(&turned.lattice, &first.lattice.handles, image))
}

/// All gaps are small, and most cases converge: else nothing would be measured.
fn most_agree(gaps: &[Option<f64>], limit: f64) {
    let converged: Vec<f64> = gaps.iter().copied().flatten().collect();
    assert!(4 * converged.len() >= 3 * gaps.len(), "{} of {} converge", converged.len(), gaps.len());
    assert!(converged.iter().all(|&gap| gap < limit), "{converged:?}");
}

#[test]
fn a_turned_problem_has_the_turned_solution() {
    let cases = drawn(&(pins_2d(), -3.1..3.1_f64, bases()), 24).into_iter().filter(|case| case.0.len() > 1);
    let gaps =
        cases.map(|(pins, angle, basis)| turned_gap(&grid(8, basis), sheet(12), pins, motion(angle, [0.3, -0.2])));
    most_agree(&gaps.collect::<Vec<_>>(), RIGID);
}

/// Root mean square distance of pins from the line that fits them best.
fn across_line(pins: &[PointPin<3>]) -> f64 {
    let count = pins.len() as f64;
    let mean: [f64; 3] = std::array::from_fn(|d| pins.iter().map(|pin| pin.at[d]).sum::<f64>() / count);
    let places: Vec<[f64; 3]> = pins.iter().map(|pin| std::array::from_fn(|d| pin.at[d] - mean[d])).collect();
    // Power iteration finds the direction of the line.
    let (mut direction, mut along) = ([0.5, 0.6, 0.7], 0.0);
    for _ in 0..200 {
        let mut image = [0.0; 3];
        for place in &places {
            let share: f64 = (0..3).map(|d| place[d] * direction[d]).sum();
            (0..3).for_each(|d| image[d] += share * place[d] / count);
        }
        along = image.iter().map(|x| x * x).sum::<f64>().sqrt();
        direction = image.map(|x| x / along);
    }
    let all: f64 = places.iter().flatten().map(|x| x * x).sum::<f64>() / count;
    (all - along).max(0.0).sqrt()
}

#[test]
fn a_turned_problem_has_the_turned_solution_in_space() {
    // Pins near a line leave the roll about it open; the smallest one from rest is taken.
    let cases = drawn(&(pins_3d(), -3.1..3.1_f64, bases()), 20).into_iter().filter(|case| case.0.len() > 2);
    let cases = cases.filter(|case| across_line(&case.0) > 0.07 * 3.0_f64.sqrt());
    let gaps = cases
        .map(|(pins, angle, basis)| turned_gap(&grid::<3>(5, basis), ball(), pins, motion(angle, [0.3, -0.2, 0.1])));
    // Newton's method ends solves of the plane only: handles that nearly nothing holds rest less exactly in space.
    most_agree(&gaps.collect::<Vec<_>>(), 10.0 * RIGID);
}
