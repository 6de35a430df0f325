//! Hard pins: exact where they can be, in the middle where they contradict each other, and never silent about it.

use super::{ball, bases, distance, few, grid, pins_2d, pins_3d, run, sheet};
use pinwarp::lattice::{Basis, Lattice};
use pinwarp::solve::{ConstraintOwner, HandlePin, PinHold, PointPin, Problem, ResidualReason, Settings, Solver, solve};
use proptest::prelude::*;

/// A miss below this part of the diagonal is exact.
const EXACT: f64 = 1e-9;

proptest! {
    #![proptest_config(few())]

    #[test]
    fn independent_pins_are_exact(pins in pins_2d(), basis in bases()) {
        let solution = run(&grid(10, basis), &sheet(12), &pins, &[]);
        for pin in &pins {
            let miss = distance(solution.lattice.evaluate(pin.at), pin.target);
            prop_assert!(miss < EXACT * 2.0_f64.sqrt(), "{miss} {:?}", solution.report);
        }
        prop_assert!(solution.report.pin_residuals.is_empty());
    }

    #[test]
    fn independent_pins_are_exact_in_space(pins in pins_3d(), basis in bases()) {
        let solution = run(&grid(5, basis), &ball(), &pins, &[]);
        for pin in &pins {
            let miss = distance(solution.lattice.evaluate(pin.at), pin.target);
            prop_assert!(miss < EXACT * 3.0_f64.sqrt(), "{miss} {:?}", solution.report);
        }
    }

    #[test]
    fn pins_and_handles_are_exact_together(pins in pins_2d(), index in 0..100_usize, by in [-0.05..0.05_f64, -0.05..0.05_f64]) {
        let grid = grid(10, Basis::Bspline);
        let rest = grid.rest_handle(index);
        let handle = HandlePin { index, target: [rest[0] + by[0], rest[1] + by[1]] };
        let solution = run(&grid, &sheet(12), &pins, &[handle]);
        prop_assert!(distance(solution.lattice.handles[index], handle.target) < EXACT);
        for pin in &pins {
            prop_assert!(distance(solution.lattice.evaluate(pin.at), pin.target) < EXACT, "{:?}", solution.report);
        }
    }

    #[test]
    fn a_duplicate_pin_is_reported_once(pins in pins_2d(), basis in bases()) {
        let twice: Vec<_> = pins.iter().chain(&pins).copied().collect();
        let solution = run(&grid(10, basis), &sheet(12), &twice, &[]);
        for pin in &pins {
            prop_assert!(distance(solution.lattice.evaluate(pin.at), pin.target) < EXACT, "{:?}", solution.report);
        }
        prop_assert!(solution.report.pin_residuals.is_empty() && solution.report.conflicts.is_empty());
    }

    #[test]
    fn contradicting_pins_share_the_miss(pins in pins_2d(), by in [0.01..0.1_f64, -0.1..0.1_f64], basis in bases()) {
        let mut both = pins.clone();
        both.push(PointPin::new(pins[0].at, [pins[0].target[0] + by[0], pins[0].target[1] + by[1]]));
        let solution = run(&grid(10, basis), &sheet(12), &both, &[]);
        let middle = [pins[0].target[0] + 0.5 * by[0], pins[0].target[1] + 0.5 * by[1]];
        prop_assert!(distance(solution.lattice.evaluate(pins[0].at), middle) < EXACT, "{:?}", solution.report);
        for pin in &pins[1..] {
            prop_assert!(distance(solution.lattice.evaluate(pin.at), pin.target) < EXACT, "{:?}", solution.report);
        }
        let told: Vec<_> = solution.report.pin_residuals.iter().map(|miss| (miss.pin, miss.reason)).collect();
        let last = both.len() - 1;
        let wanted = [(0, last), (last, 0)].map(|(pin, rival)| (pin, ResidualReason::Conflict(ConstraintOwner::Pin(rival))));
        prop_assert_eq!(told, wanted);
    }

    #[test]
    fn a_drag_holds_its_pins_too(pins in pins_2d(), by in [-0.05..0.05_f64, -0.05..0.05_f64]) {
        let (grid, shape, settings) = (grid(10, Basis::Bspline), sheet(12), Settings::default());
        let problem = Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[], settings: &settings };
        let solver = Solver::new(&problem).expect("a valid problem");
        let mut dragged = pins.clone();
        dragged[0].target = [dragged[0].target[0] + by[0], dragged[0].target[1] + by[1]];
        let mut drag = solver.drag(&solver.solve().lattice).expect("a lattice of the solver");
        let lattice: Lattice<2> = drag.follow(&dragged, &[]).expect("the same pins");
        for pin in &dragged {
            prop_assert!(distance(lattice.evaluate(pin.at), pin.target) < EXACT);
        }
    }
}

#[test]
fn more_pins_than_a_cell_has_handles_miss_by_least_squares() {
    // Five pins in one bilinear cell of four handles: the middle one is asked to go where the others do not let it.
    let corners = [[0.42, 0.42], [0.58, 0.42], [0.58, 0.58], [0.42, 0.58]];
    let mut pins: Vec<_> = corners.map(|at| PointPin::new(at, at)).to_vec();
    pins.push(PointPin::new([0.5, 0.5], [0.55, 0.5]));
    let grid = grid(6, Basis::Bilinear);
    let solution = run(&grid, &sheet(12), &pins, &[]);
    // The middle is the mean of the corners: (1, −4) / 5 of the contradiction each, in least squares.
    for corner in &pins[..4] {
        assert!((solution.lattice.evaluate(corner.at)[0] - corner.at[0] - 0.01).abs() < 1e-6, "{:?}", solution.report);
    }
    assert!((solution.lattice.evaluate([0.5, 0.5])[0] - 0.51).abs() < 1e-6);
    assert_eq!(solution.report.pin_residuals.len(), 5);
    assert!(solution.report.pin_residuals[0].reason == ResidualReason::Conflict(ConstraintOwner::Pin(4)));
    let words = solution.report.pin_residuals[0].reason.words(|pin| format!("'p{pin}'"));
    assert!(words.contains("it and pin 'p4' over-constrain the lattice"), "{words}");
}

#[test]
fn a_handle_that_holds_a_pinned_point_is_named() {
    let grid = grid::<2>(6, Basis::Bilinear);
    let index = 14;
    let rest = grid.rest_handle(index);
    let pin = PointPin::new(rest, [rest[0] + 0.1, rest[1]]);
    let solution = run(&grid, &sheet(12), &[pin], &[HandlePin { index, target: rest }]);
    assert!((solution.lattice.handles[index][0] - rest[0] - 0.05).abs() < EXACT);
    assert_eq!(solution.report.pin_residuals[0].reason, ResidualReason::Conflict(ConstraintOwner::Handle(0)));
}

#[test]
fn other_reasons_are_distinguished() {
    let (grid, shape) = (grid::<2>(8, Basis::Bspline), sheet(12));
    let held = [[0.2, 0.2], [0.8, 0.2], [0.2, 0.8]].map(|at| PointPin::new(at, at));
    let reasons = |pins: &[PointPin<2>], settings: &Settings| -> Vec<ResidualReason> {
        let problem = Problem { grid: &grid, shape: &shape, pins, handles: &[], settings };
        solve(&problem).expect("a valid problem").report.pin_residuals.iter().map(|miss| miss.reason).collect()
    };
    let fading = PointPin { weight: 1e-5, ..PointPin::new([0.5, 0.5], [0.7, 0.6]) };
    assert_eq!(reasons(&[held[0], held[1], held[2], fading], &Settings::default()), [ResidualReason::Fading]);
    let pulled = PointPin::new([0.8, 0.8], [0.9, 0.95]);
    let paper = Settings::paper();
    assert!(reasons(&[held[0], held[1], pulled], &paper).iter().all(|reason| *reason == ResidualReason::Soft));
    let hard = Settings { pin_hold: PinHold::Hard, ..paper };
    assert_eq!(reasons(&[held[0], held[1], pulled], &hard), []);
    let outside = [PointPin::new([0.5, 1.2], [0.5, 1.3]), PointPin::new([0.5, 1.4], [0.5, 1.4])];
    let rivals = [1, 0].map(|pin| ResidualReason::Outside(ConstraintOwner::Pin(pin)));
    assert_eq!(reasons(&outside, &Settings::default()), rivals);
}

#[test]
fn rotation_and_scale_are_exact_too() {
    let (sin, cos) = 0.8_f64.sin_cos();
    let gradient = [[1.2 * cos, 1.2 * sin], [-1.2 * sin, 1.2 * cos]];
    let turned = PointPin { gradient: Some(gradient), ..PointPin::new([0.5, 0.5], [0.55, 0.5]) };
    let held = [[0.1, 0.1], [0.9, 0.1], [0.1, 0.9]].map(|at| PointPin::new(at, at));
    for basis in [Basis::Bspline, Basis::Bernstein] {
        let solution = run(&grid(10, basis), &sheet(12), &[held[0], turned, held[1], held[2]], &[]);
        let found = solution.lattice.evaluate_with_gradient(turned.at).gradient;
        for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            assert!((found[row][column] - gradient[column][row]).abs() < 1e-8, "{found:?} {:?}", solution.report);
        }
        assert!(solution.report.pin_residuals.is_empty());
    }
}
