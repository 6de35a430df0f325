//! The guard against folds, and parts that are wound up: what gives way, and which way things turn.

#[path = "support/figure.rs"]
mod figure;

use crate::internal::numbers::distance;
use crate::internal::solving::run;
use figure::{Pose, around, figure, posed};
use pinwarp::lattice::{Basis, Grid, Lattice};
use pinwarp::solve::{Guard, HandlePin, PointPin, Problem, ResidualReason, Settings, Shape, Solver, Targets, solve};

fn limit() -> Settings {
    Settings { guard: Guard::Limit, ..Settings::default() }
}

/// The head pushed `down` into the body.
fn squashed(down: f64) -> Vec<PointPin<2>> {
    let mut pins = posed(Pose::default());
    pins[4].target[1] -= down;
    pins
}

#[test]
fn a_head_pushed_through_the_body_folds_nothing() {
    let (grid, shape) = (around(10, Basis::Bspline), figure(0.08));
    for down in [0.5, 0.9, 1.6] {
        let pins = squashed(down);
        let free = run(&grid, &shape, &pins, &Settings { guard: Guard::Report, ..Settings::default() });
        assert!(free.report.folded_model_cells > 0 && free.report.min_cell_det <= 0.0, "{:?}", free.report);
        assert!(!free.report.is_held_back);
        let held = run(&grid, &shape, &pins, &limit());
        eprintln!("{down}: {:?}", held.report);
        assert!(held.report.is_converged && held.report.folded_model_cells == 0, "{:?}", held.report);
        assert!(held.report.min_cell_det > 0.0 && held.report.min_det > 0.0, "{:?}", held.report);
        // The report says how far each pin is from its target, and why.
        for (pin, error) in pins.iter().zip(&held.report.pin_errors) {
            assert!((distance(held.lattice.evaluate(pin.at), pin.target) - error).abs() < 1e-12);
        }
        assert!(held.report.pin_residuals.iter().all(|miss| miss.reason == ResidualReason::Guard));
        assert_eq!(held.report.is_held_back, !held.report.pin_residuals.is_empty());
        // Pins that have nothing to do with it hold.
        assert!(held.report.pin_errors[..4].iter().all(|&error| error < 1e-4), "{:?}", held.report);
    }
}

#[test]
fn problems_without_folds_are_left_alone() {
    let (grid, shape) = (around(10, Basis::Bspline), figure(0.08));
    let pins = posed(Pose { limbs: [0.2, -0.1, 0.1, 0.0], shift: [0.1, 0.0] });
    let free = run(&grid, &shape, &pins, &Settings { guard: Guard::Report, ..Settings::default() });
    assert!(free.report.min_cell_det > 0.2, "{:?}", free.report);
    assert_eq!(run(&grid, &shape, &pins, &limit()), free);
}

#[test]
fn the_guard_gives_way_bit_by_bit() {
    // Pushing on and on moves the result without a jump where the barrier begins to act, and where pins begin to give way.
    let (grid, shape) = (around(10, Basis::Bspline), figure(0.08));
    let solutions: Vec<_> = (0..50).map(|k| run(&grid, &shape, &squashed(0.015 * f64::from(k)), &limit())).collect();
    assert!(solutions[0].report.min_cell_det > 0.2 && solutions[49].report.min_cell_det < 0.1);
    let moved = |a: &Lattice<2>, b: &Lattice<2>| {
        let moves = shape.points.iter().map(|&point| distance(a.evaluate(point), b.evaluate(point)));
        moves.fold(0.0, f64::max)
    };
    let steps: Vec<f64> = solutions.windows(2).map(|pair| moved(&pair[0].lattice, &pair[1].lattice)).collect();
    eprintln!("{steps:.4?}");
    assert!(steps.iter().all(|&step| step < 0.03), "{steps:?}");
}

#[test]
fn the_guard_knows_no_direction() {
    let (grid, shape) = (around(8, Basis::Bspline), figure(0.1));
    let turned = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let turned = |[x, y]: [f64; 2]| [cos * x - sin * y, sin * x + cos * y];
        let mut pins = squashed(0.9);
        pins.iter_mut().for_each(|pin| pin.target = turned(pin.target));
        pins[0].gradient = Some([turned([1.0, 0.0]), turned([0.0, 1.0])]);
        run(&grid, &shape, &pins, &limit()).report
    };
    let straight = turned(0.0);
    for degrees in [100.0, 135.0, 180.0, 225.0] {
        let report = turned(degrees);
        assert!(report.folded_model_cells == 0 && report.min_cell_det > 0.0, "{report:?}");
        let errors = report.pin_errors.iter().zip(&straight.pin_errors);
        assert!(errors.map(|(a, b)| (a - b).abs()).all(|gap| gap < 1e-5), "{degrees}: {report:?} {straight:?}");
    }
}

#[test]
fn moved_handles_hold_where_nothing_has_to_fold() {
    let (grid, shape) = (around(6, Basis::Bspline), figure(0.1));
    let pins = posed(Pose::default());
    let handle = HandlePin { index: 2 + 6 * 2, target: [3.0, 2.6] };
    let [free, held] = [Guard::Report, Guard::Limit].map(|guard| {
        let settings = Settings { guard, ..Settings::default() };
        solve(&Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[handle], settings: &settings })
            .expect("a valid problem")
            .report
    });
    assert!(free.folded_model_cells > 0, "{free:?}");
    assert!(held.folded_model_cells == 0 && !held.is_held_back && held.handle_errors[0] < 1e-6, "{held:?}");
}

#[test]
fn a_box_of_space_is_guarded() {
    let grid = Grid { dims: [4, 4, 4], basis: Basis::Bspline, lo: [-1.2; 3], hi: [1.2; 3], angle: 0.0 };
    let flat = figure(0.12);
    let shape = Shape::of_triangles(flat.points.iter().map(|&[x, y]| [x, y, 0.3 * x * y]).collect(), flat.triangles);
    let pins: Vec<_> = squashed(1.0)
        .iter()
        .map(|pin| PointPin::new([pin.at[0], pin.at[1], 0.0], [pin.target[0], pin.target[1], 0.0]))
        .collect();
    let [free, held] = [Guard::Report, Guard::Limit].map(|guard| {
        let settings = Settings { guard, ..Settings::default() };
        run(&grid, &shape, &pins, &settings)
    });
    assert!(free.report.folded_model_cells > 0, "{:?}", free.report);
    assert!(held.report.folded_model_cells == 0, "{:?}", held.report);
}

/// The figure stands, head and hands wind about the neck.
fn wound(degrees: f64) -> Targets<2> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let still = [[-0.32, -0.9], [0.32, -0.9], [-0.17, -0.4], [0.17, -0.4]].map(|at| PointPin::new(at, at));
    let turned = [[-0.2, 0.66], [0.2, 0.66]];
    let turned = turned.map(|at| PointPin::new(at, [cos * at[0], 0.66 + sin * at[0]]));
    Targets { pins: still.into_iter().chain(turned).collect(), handles: Vec::new() }
}

fn largest_move(a: &Lattice<2>, b: &Lattice<2>, grid: &Grid<2>) -> f64 {
    let moves = a.handles.iter().zip(&b.handles).map(|(&a, &b)| distance(a, b));
    moves.fold(0.0, f64::max) / grid.spacing(0)
}

#[test]
fn a_head_winds_past_half_a_turn_without_a_jump() {
    let (grid, shape, settings) = (around(10, Basis::Bspline), figure(0.08), Settings::default());
    let path: Vec<_> = (0..=72).map(|k| wound(5.0 * f64::from(k))).collect();
    let goal = &path[0];
    let problem = Problem { grid: &grid, shape: &shape, pins: &goal.pins, handles: &[], settings: &settings };
    let solver = Solver::new(&problem).expect("a valid problem");
    let followed: Vec<_> = (1..=path.len()).map(|end| solver.follow(&path[..end]).expect("valid")).collect();
    let steps: Vec<f64> =
        followed.windows(2).map(|pair| largest_move(&pair[0].lattice, &pair[1].lattice, &grid)).collect();
    // 130 to 200 degrees. Far beyond, the short neck cannot hold the twist and snaps back within a few steps.
    assert!(steps[26..40].iter().all(|&step| step < 0.5), "{steps:?}");
    // The other way round is the mirror image.
    let back: Vec<_> = (0..=40).map(|k| wound(-5.0 * f64::from(k))).collect();
    let back = solver.follow(&back).expect("valid").lattice;
    let there = followed[40].lattice.evaluate([0.0, 0.4]);
    let back = back.evaluate([0.0, 0.4]);
    assert!((there[0] + back[0]).abs() < 0.02 && (there[1] - back[1]).abs() < 0.02, "{there:?} {back:?}");
    // With coarse steps the same.
    let coarse: Vec<_> = path[..=40].iter().step_by(8).cloned().collect();
    let coarse = solver.follow(&coarse).expect("valid");
    assert!(largest_move(&coarse.lattice, &followed[40].lattice, &grid) < 0.01);
}

#[test]
fn nothing_folds_on_the_way_of_a_winding() {
    let (grid, shape) = (around(10, Basis::Bspline), figure(0.08));
    let settings = limit();
    let path: Vec<_> = (0..=25).map(|k| wound(10.0 * f64::from(k))).collect();
    let problem = Problem { grid: &grid, shape: &shape, pins: &path[0].pins, handles: &[], settings: &settings };
    let solver = Solver::new(&problem).expect("a valid problem");
    let solutions: Vec<_> = (1..=path.len()).map(|end| solver.follow(&path[..end]).expect("valid")).collect();
    assert!(solutions.iter().all(|solution| solution.report.folded_model_cells == 0));
    let moved = |a: &Lattice<2>, b: &Lattice<2>| {
        let moves = shape.points.iter().map(|&point| distance(a.evaluate(point), b.evaluate(point)));
        moves.fold(0.0, f64::max)
    };
    let moves: Vec<f64> = solutions.windows(2).map(|pair| moved(&pair[0].lattice, &pair[1].lattice)).collect();
    eprintln!("{moves:.3?}");
    // Ten degrees move the top of the head by 0.053. It swings out as the neck is wound up (0.156 at most), but nothing snaps.
    assert!(moves[0] < 0.06, "{moves:?}");
    assert!(moves.windows(2).all(|pair| pair[1] < 2.0 * pair[0]), "{moves:?}");
    assert!(moves.iter().all(|&step| step < 0.32), "{moves:?}");
}
