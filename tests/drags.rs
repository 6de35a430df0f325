//! Drags: the shape stays with the hand, ends where a solve does, and goes the same way every time.
//!
//! In: a waisted blob with six pins, one of which a hand swings at 60 moves a second. Out: distances from solves.

use pinwarp::lattice::{Basis, Grid, Lattice};
use pinwarp::solve::{Energy, PointPin, Problem, Regularizer, Settings, Shape, Solver};
use std::f64::consts::TAU;

/// Moves a second.
const RATE: f64 = 60.0;

fn blob(side: usize) -> Shape<2> {
    let place = |k: usize| {
        let [u, v] = [k % side, k / side].map(|x| x as f64 / (side - 1) as f64 - 0.5);
        [u * (0.55 + 0.35 * (9.0 * v).cos()) + 0.08 * (7.0 * v).sin(), v * (0.9 - 0.5 * u * u)]
    };
    let corners = (0..side * side).filter(|k| k % side + 1 < side && k / side + 1 < side);
    let triangles = corners.flat_map(|k| [[k, k + 1, k + side + 1], [k, k + side + 1, k + side]]);
    let triangles = triangles.map(|corners| corners.map(|corner| corner as u32)).collect();
    Shape::of_triangles((0..side * side).map(place).collect(), triangles)
}

fn grid(dims: usize) -> Grid<2> {
    Grid { dims: [dims; 2], basis: Basis::Bspline, lo: [-0.7, -0.6], hi: [0.7, 0.6], angle: 0.0 }
}

/// The pins after a number of moves of a hand that swings the last one `laps` times a second, up to a box diagonal a
/// second for one lap.
fn swing(shape: &Shape<2>, moves: usize, laps: f64) -> Vec<PointPin<2>> {
    let count = shape.points.len();
    let mut pins: Vec<_> = (0..6).map(|k| shape.points[k * (count - 1) / 5]).map(|at| PointPin::new(at, at)).collect();
    let turn = TAU * laps * moves as f64 / RATE;
    let [x, y] = pins[5].at;
    pins[5].target = [x + 0.3 * turn.sin(), y + 0.15 * (1.0 - turn.cos())];
    pins
}

/// Farthest distance of a vertex between two lattices, in cells.
fn gap(shape: &Shape<2>, a: &Lattice<2>, b: &Lattice<2>) -> f64 {
    let pitch = a.grid.spacing(0).min(a.grid.spacing(1));
    let gaps = shape.points.iter().map(|&point| {
        let [a, b] = [a, b].map(|lattice| lattice.evaluate(point));
        (a[0] - b[0]).hypot(a[1] - b[1]) / pitch
    });
    gaps.fold(0.0, f64::max)
}

/// Runs `check` with the solver of a grid at the beginning of the swing.
fn with_solver(dims: usize, settings: &Settings, check: impl Fn(&Solver<2>, &Shape<2>)) {
    let (shape, grid) = (blob(20), grid(dims));
    let pins = swing(&shape, 0, 1.0);
    let problem = Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[], settings };
    check(&Solver::new(&problem).expect("a valid problem"), &shape);
}

#[test]
fn a_hand_at_sixty_moves_a_second_never_sees_the_shape_lag() {
    for (dims, laps) in [(5, 1.0), (10, 0.5), (10, 2.0), (15, 0.25), (15, 1.0)] {
        with_solver(dims, &Settings::default(), |solver, shape| {
            let mut drag = solver.drag(&solver.solve().lattice).expect("a lattice of the solver");
            let mut lags = Vec::new();
            for moves in 1..=60 {
                let pins = swing(shape, moves, laps);
                let lattice = drag.follow(&pins, &[]).expect("the same pins");
                let goal = solver.update(&pins, &[]).expect("the same pins").lattice;
                lags.push(gap(shape, &lattice, &goal));
                for pin in &pins {
                    let at = lattice.evaluate(pin.at);
                    assert!((at[0] - pin.target[0]).hypot(at[1] - pin.target[1]) < 1e-9, "{dims} {moves}");
                }
            }
            lags.sort_by(f64::total_cmp);
            let [middle, most] = [lags[lags.len() / 2], lags[lags.len() - 1]];
            println!("{dims} x {dims}, {laps} laps a second: median {middle:.1e}, most {most:.1e} cells");
            assert!(middle < 5e-4 && most < 5e-3, "{dims} x {dims}, {laps} laps: {middle:.1e} {most:.1e} cells");
        });
    }
}

#[test]
fn every_settled_move_is_a_solve() {
    for (dims, energy, nearness) in [(10, Energy::Area, 1e-5), (15, Energy::Area, 1e-5), (8, Energy::Edge, 1e-3)] {
        let settings = Settings { energy, ..Settings::default() };
        with_solver(dims, &settings, |solver, shape| {
            let mut drag = solver.drag(&solver.solve().lattice).expect("a lattice of the solver");
            for moves in (0..=60).step_by(4) {
                let pins = swing(shape, moves, 1.0);
                let settled = drag.settle(&pins, &[]).expect("the same pins");
                let solved = solver.update(&pins, &[]).expect("the same pins");
                let far = gap(shape, &settled.lattice, &solved.lattice);
                assert!(far < nearness, "{dims} {energy:?} {moves}: {far:.1e} cells");
                assert!(settled.report.is_converged && settled.report.pin_residuals.is_empty());
                assert_eq!(settled.report.folded_cells, solved.report.folded_cells);
            }
        });
    }
}

#[test]
fn a_jump_is_caught_up_within_a_few_moves() {
    let soft = Settings { pin_hold: pinwarp::solve::PinHold::Soft, ..Settings::default() };
    let edge = Settings { energy: Energy::Edge, ..Settings::default() };
    let affine = Settings::default().with_regularizer(Regularizer::Affine);
    for (settings, nearness) in [(Settings::default(), 1e-3), (soft, 1e-3), (affine, 1e-3), (edge, 2e-2)] {
        with_solver(10, &settings, |solver, shape| {
            let mut drag = solver.drag(&solver.solve().lattice).expect("a lattice of the solver");
            // A quarter of a lap at once: a fifth of the box.
            let pins = swing(shape, 15, 1.0);
            let goal = solver.update(&pins, &[]).expect("the same pins").lattice;
            let follow = |_| gap(shape, &drag.follow(&pins, &[]).expect("the same pins"), &goal);
            let lags: Vec<f64> = (0..8).map(follow).collect();
            println!("{:?} {:?}: {lags:?}", settings.energy, settings.regularizer);
            assert!(lags[7] < nearness, "{:?}: {lags:?}", settings.energy);
        });
    }
}

#[test]
fn the_same_moves_give_the_same_bits() {
    with_solver(15, &Settings::default(), |solver, shape| {
        let way = || {
            let mut drag = solver.drag(&solver.solve().lattice).expect("a lattice of the solver");
            let follow = |moves| drag.follow(&swing(shape, moves, 1.0), &[]).expect("the same pins").handles;
            (1..=20).map(follow).collect::<Vec<_>>()
        };
        assert_eq!(way(), way());
    });
}

#[test]
fn a_drag_refuses_inputs_of_another_size() {
    with_solver(8, &Settings::default(), |solver, shape| {
        let error = solver.drag(&grid(9).at_rest()).expect_err("another number of handles");
        assert!(error.to_string().contains("81 handles"), "{error}");
        let mut drag = solver.drag(&solver.solve().lattice).expect("a lattice of the solver");
        assert!(drag.follow(&swing(shape, 1, 1.0)[1..], &[]).is_err());
        assert!(drag.follow(&swing(shape, 1, 1.0), &[]).is_ok());
    });
}
