//! Properties of the solver on generated shapes, pins and settings; hostile ones among them.
//!
//! Tolerances are parts of the box diagonal. A failure prints its smallest case.

#[path = "support/random.rs"]
mod random;

use crate::internal::numbers::distance;
use crate::internal::solving::run;
use pinwarp::lattice::{Basis, Grid, Lattice};
use pinwarp::solve::{
    HandlePin, PointPin, Problem, Regularizer, Settings, Shape, Solution, SolveError, Solver, Topology, solve,
};
use proptest::prelude::*;

/// A wavy strip of 2·(n+1) points in the unit square, finer or coarser, with isolated parts beside it.
fn strip(cells: u32) -> Shape<2> {
    let place = |k: u32| {
        let t = f64::from(k / 2) / f64::from(cells);
        [0.1 + 0.8 * t, 0.42 + 0.16 * f64::from(k % 2) + 0.1 * (5.0 * t).sin()]
    };
    let mut points: Vec<[f64; 2]> = (0..2 * (cells + 1)).map(place).collect();
    let mut triangles: Vec<[u32; 3]> = (0..2 * cells).map(|k| [k, k + 1, k + 2]).collect();
    let island = points.len() as u32;
    points.extend([[0.2, 0.85], [0.3, 0.85], [0.25, 0.95]]);
    triangles.push([island, island + 1, island + 2]);
    Shape::of_triangles(points, triangles)
}

fn grid(dims: usize, basis: Basis) -> Grid<2> {
    Grid { dims: [dims, dims], basis, lo: [0.0, 0.0], hi: [1.0, 1.0], angle: 0.0 }
}

fn pin(at: [f64; 2], target: [f64; 2]) -> PointPin<2> {
    PointPin::new(at, target)
}

/// Largest distance of the handles from where `image` puts the rest handles.
fn largest_miss(lattice: &Lattice<2>, image: impl Fn([f64; 2]) -> [f64; 2]) -> f64 {
    let rest = lattice.grid.rest_handles();
    lattice.handles.iter().zip(rest).map(|(&handle, rest)| distance(handle, image(rest))).fold(0.0, f64::max)
}

fn is_finite(solution: &Solution<2>) -> bool {
    let report = &solution.report;
    solution.lattice.handles.iter().flatten().all(|x| x.is_finite())
        && report.pin_errors.iter().all(|x| x.is_finite())
        && [report.min_det, report.angular, report.area].iter().all(|x| x.is_finite())
}

fn bases() -> impl Strategy<Value = Basis> {
    prop_oneof![Just(Basis::Bspline), Just(Basis::Bernstein), Just(Basis::Bilinear), Just(Basis::Barytri)]
}

fn places() -> impl Strategy<Value = [f64; 2]> {
    [0.05..0.95_f64, 0.05..0.95_f64]
}

/// Pins that a moderate bend can satisfy, at least a tenth of the box apart.
fn soft_pins() -> impl Strategy<Value = Vec<PointPin<2>>> {
    prop::collection::vec((places(), [-0.1..0.1_f64, -0.1..0.1_f64]), 1..6).prop_map(|raw| {
        let mut pins: Vec<PointPin<2>> = Vec::new();
        for (at, by) in raw {
            if pins.iter().all(|pin| distance(pin.at, at) > 0.25) {
                pins.push(pin(at, [at[0] + by[0], at[1] + by[1]]));
            }
        }
        pins
    })
}

/// Plain iterations: acceleration magnifies rounding along directions that nearly nothing holds.
fn plain() -> Settings {
    Settings { acceleration: 0, iteration_limit: 60, ..Settings::default() }
}

fn few() -> ProptestConfig {
    random::config(24)
}

proptest! {
    #![proptest_config(few())]

    #[test]
    fn pins_moved_rigidly_move_the_lattice_rigidly(
        angle in -3.1..3.1_f64, shift in [-5.0..5.0_f64, -5.0..5.0_f64], at in prop::collection::vec(places(), 1..6),
        basis in bases(),
    ) {
        let (sin, cos) = if at.len() == 1 { (0.0, 1.0) } else { angle.sin_cos() };
        let image = |p: [f64; 2]| [cos * p[0] - sin * p[1] + shift[0], sin * p[0] + cos * p[1] + shift[1]];
        prop_assume!(at.iter().skip(1).all(|&other| distance(at[0], other) > 0.01));
        let pins: Vec<_> = at.iter().map(|&at| pin(at, image(at))).collect();
        let solution = run(&grid(8, basis), &strip(20), &pins, &Settings::default());
        prop_assert!(largest_miss(&solution.lattice, image) < 1e-6, "{:?}", solution.report);
        prop_assert!(solution.report.angular < 1e-9 && solution.report.folded_cells == 0);
    }

    #[test]
    fn a_single_pin_is_a_pure_translation(at in places(), target in [-9.0..9.0_f64, -9.0..9.0_f64], basis in bases()) {
        let solution = run(&grid(7, basis), &strip(15), &[pin(at, target)], &Settings::default());
        let image = |p: [f64; 2]| [p[0] + target[0] - at[0], p[1] + target[1] - at[1]];
        prop_assert!(largest_miss(&solution.lattice, image) < 1e-6);
        prop_assert_eq!(solution.report.iterations, 1);
    }

    #[test]
    fn solutions_move_with_their_problem(pins in soft_pins(), shift in [-20.0..20.0_f64, -20.0..20.0_f64]) {
        let add = |p: [f64; 2]| [p[0] + shift[0], p[1] + shift[1]];
        let (here, shape) = (grid(8, Basis::Bspline), strip(20));
        let there = Grid { lo: add(here.lo), hi: add(here.hi), ..here.clone() };
        let moved = Shape { points: shape.points.iter().map(|&p| add(p)).collect(), ..shape.clone() };
        let moved_pins: Vec<_> = pins.iter().map(|p| pin(add(p.at), add(p.target))).collect();
        let first = run(&here, &shape, &pins, &plain());
        let second = run(&there, &moved, &moved_pins, &plain());
        for (a, b) in first.lattice.handles.iter().zip(&second.lattice.handles) {
            prop_assert!(distance(add(*a), *b) < 1e-5, "{a:?} {b:?} {:?} {:?}", first.report, second.report);
        }
    }

    #[test]
    fn the_scale_of_the_model_changes_nothing(pins in soft_pins(), power in -6..7_i32) {
        let scale = 10.0_f64.powi(power);
        let times = |p: [f64; 2]| p.map(|x| x * scale);
        let (unit, shape) = (grid(8, Basis::Bspline), strip(20));
        let large = Grid { lo: times(unit.lo), hi: times(unit.hi), ..unit.clone() };
        let scaled = Shape { points: shape.points.iter().map(|&p| times(p)).collect(), ..shape.clone() };
        let scaled_pins: Vec<_> = pins.iter().map(|p| pin(times(p.at), times(p.target))).collect();
        let first = run(&unit, &shape, &pins, &plain());
        let second = run(&large, &scaled, &scaled_pins, &plain());
        for (a, b) in first.lattice.handles.iter().zip(&second.lattice.handles) {
            prop_assert!(distance(times(*a), *b) < 1e-5 * scale, "{a:?} {b:?} {:?} {:?}", first.report, second.report);
        }
    }

    #[test]
    fn pins_arrive(pins in soft_pins()) {
        let solution = run(&grid(10, Basis::Bspline), &strip(40), &pins, &Settings::default());
        // 0.05 px of a picture 1080 px high, the box filling it.
        for error in &solution.report.pin_errors {
            prop_assert!(*error < 0.05 / 1080.0, "{:?}", solution.report);
        }
    }

    #[test]
    fn hostile_inputs_make_no_nan(
        points in prop::collection::vec([-1.5..2.5_f64, -1.5..2.5_f64], 3..12), seed in any::<u64>(),
        pins in prop::collection::vec((prop_oneof![Just([0.5, 0.5]), [-3.0..4.0_f64, -3.0..4.0_f64]],
            [-2.0..3.0_f64, -2.0..3.0_f64], 0.0..1.0_f64), 0..5),
        scale in prop_oneof![Just(1e-6), Just(1.0), Just(1e6)], basis in bases(), paper in any::<bool>(),
    ) {
        let count = points.len() as u64;
        let pick = |k: u64| (seed.rotate_left(k as u32 * 7) % count) as u32;
        let mut shape = Shape::of_triangles(points, (0..6).map(|k| [pick(3 * k), pick(3 * k + 1), pick(3 * k + 2)]).collect());
        // A sliver, a doubled point, a triangle without area.
        shape.points[1] = [shape.points[0][0] + 1e-13, shape.points[0][1]];
        shape.points[2] = shape.points[0];
        shape.triangles.extend([[0, 1, 2], [0, 0, 1]]);
        shape.points.iter_mut().flatten().for_each(|x| *x *= scale);
        let pins: Vec<_> = pins.into_iter().map(|(at, target, weight)| PointPin {
            weight, ..PointPin::new(at.map(|x| x * scale), target.map(|x| x * scale))
        }).collect();
        let grid = Grid { hi: [scale, scale], ..grid(5, basis) };
        let settings = if paper { Settings::paper() } else { Settings::default() };
        let solution = solve(&Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[], settings: &settings });
        // A case may be refused; where nearly all are, the test fails for want of cases.
        let solution = solution.map_err(|error| TestCaseError::reject(error.to_string()))?;
        prop_assert!(is_finite(&solution), "{:?}", solution.report);
    }

    #[test]
    fn an_update_is_a_solve(pins in soft_pins(), by in [-0.05..0.05_f64, -0.05..0.05_f64]) {
        let (grid, shape, settings) = (grid(8, Basis::Bspline), strip(20), Settings::default());
        let solver = Solver::new(&Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[], settings: &settings });
        let mut dragged = pins.clone();
        dragged[0].target = [dragged[0].target[0] + by[0], dragged[0].target[1] + by[1]];
        let updated = solver.expect("a valid problem").update(&dragged, &[]).expect("the same pins");
        prop_assert_eq!(updated, run(&grid, &shape, &dragged, &settings));
    }

    #[test]
    fn a_drag_follows_its_pins(pins in soft_pins(), by in [-0.02..0.02_f64, -0.02..0.02_f64]) {
        let (grid, shape, settings) = (grid(8, Basis::Bspline), strip(20), Settings::default());
        let solver = Solver::new(&Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[], settings: &settings });
        let solver = solver.expect("a valid problem");
        let mut dragged = pins.clone();
        dragged[0].target = [dragged[0].target[0] + by[0], dragged[0].target[1] + by[1]];
        let updated = solver.update(&dragged, &[]).expect("the same pins");
        prop_assume!(updated.report.iterations < 100);
        let mut lattice = solver.solve().lattice;
        let mut drag = solver.drag(&lattice).expect("a lattice of the solver");
        let missed = |lattice: &Lattice<2>| {
            lattice.handles.iter().zip(&updated.lattice.handles).map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max)
        };
        let before = missed(&lattice);
        for _ in 0..30 {
            lattice = drag.follow(&dragged, &[]).expect("the same pins");
        }
        for pin in &dragged {
            prop_assert!(distance(lattice.evaluate(pin.at), pin.target) < 1e-5);
        }
        prop_assert!(missed(&lattice) <= before + 1e-4, "{before} {}", missed(&lattice));
    }

    #[test]
    fn mesh_density_does_not_matter(pins in soft_pins()) {
        let grid = grid(8, Basis::Bspline);
        let coarse = run(&grid, &strip(200), &pins, &Settings::default());
        let fine = run(&grid, &strip(800), &pins, &Settings::default());
        // Parts that nearly nothing holds creep for hundreds of steps; where they stop says little about the mesh.
        prop_assume!(coarse.report.iterations.max(fine.report.iterations) < 100);
        for x in 1..10 {
            let at = [f64::from(x) / 10.0, 0.5];
            let gap = distance(coarse.lattice.evaluate(at), fine.lattice.evaluate(at));
            prop_assert!(gap < 2e-3, "{gap} at {at:?}: {:?} {:?}", coarse.report, fine.report);
        }
    }

    #[test]
    fn weights_add_up_and_gradients_are_slopes(at in places(), dims in 4..65_usize, basis in bases()) {
        let grid = Grid { dims: [dims, 68 - dims], ..grid(4, basis) };
        let row = grid.weights(at);
        prop_assert!((row.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-12);
        let mut lattice = grid.at_rest();
        let start = lattice.evaluate(at);
        prop_assert!(distance(start, at) < 1e-12);
        for (k, handle) in lattice.handles.iter_mut().enumerate() {
            *handle = [handle[0] + 0.01 * (k as f64).sin(), handle[1] + 0.01 * (1.7 * k as f64).cos()];
        }
        let step = 1e-7;
        let carried = lattice.evaluate_with_gradient(at);
        for column in 0..2 {
            let [mut low, mut high] = [at, at];
            low[column] -= step;
            high[column] += step;
            // Across a crease of a piecewise linear basis there is no slope to compare with.
            if grid.weights(low).iter().map(|w| w.0).ne(grid.weights(high).iter().map(|w| w.0)) {
                continue;
            }
            let (low, high) = (lattice.evaluate(low), lattice.evaluate(high));
            for row in 0..2 {
                let slope = (high[row] - low[row]) / (2.0 * step);
                prop_assert!((slope - carried.gradient[row][column]).abs() < 1e-5 * (1.0 + slope.abs()));
            }
        }
    }
}

#[test]
fn equal_problems_give_equal_bits_on_any_number_of_threads() {
    let (grid, shape) = (grid(12, Basis::Bspline), strip(60_000));
    let pins = [pin([0.1, 0.5], [0.1, 0.5]), pin([0.9, 0.4], [0.7, 0.8])];
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| run(&grid, &shape, &pins, &Settings::default()))
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn isolated_parts_come_to_rest() {
    let (grid, shape) = (grid(15, Basis::Bspline), strip(20));
    let pins = [pin([0.1, 0.45], [0.1, 0.45]), pin([0.5, 0.5], [0.5, 0.5]), pin([0.9, 0.4], [0.55, 0.9])];
    let first = run(&grid, &shape, &pins, &Settings::default());
    assert!(first.report.is_converged && first.report.iterations <= 40, "{:?}", first.report);
    let mut moved = shape.clone();
    for (k, point) in moved.points.iter_mut().enumerate() {
        let angle = 2.4 * k as f64;
        *point = [point[0] + 1e-7 * angle.cos(), point[1] + 1e-7 * angle.sin()];
    }
    let second = run(&grid, &moved, &pins, &Settings::default());
    // The island far from all pins included.
    for point in &shape.points {
        let gap = distance(first.lattice.evaluate(*point), second.lattice.evaluate(*point));
        assert!(gap < 1e-5 * grid.spacing(0), "{point:?} moves by {gap:e}");
    }
}

#[test]
fn contradicting_pins_meet_in_the_middle_and_are_named() {
    let pins = [pin([0.5, 0.5], [0.4, 0.5]), pin([0.2, 0.5], [0.2, 0.5]), pin([0.5, 0.5], [0.6, 0.5])];
    let solution = run(&grid(8, Basis::Bspline), &strip(20), &pins, &Settings::default());
    assert!(distance(solution.lattice.evaluate([0.5, 0.5]), [0.5, 0.5]) < 0.02, "{:?}", solution.report);
    assert_eq!(solution.report.conflicts, [[0, 2]]);
}

#[test]
fn no_pins_give_the_identity_with_a_warning() {
    let solution = run(&grid(8, Basis::Bspline), &strip(20), &[], &Settings::default());
    assert_eq!(solution.lattice, grid(8, Basis::Bspline).at_rest());
    assert!(solution.report.warnings.iter().any(|warning| warning.contains("no pins")));
}

#[test]
fn an_empty_shape_bends_the_box() {
    let pins = [pin([0.1, 0.5], [0.1, 0.4]), pin([0.5, 0.5], [0.5, 0.6]), pin([0.9, 0.5], [0.9, 0.4])];
    for regularizer in [Regularizer::Bend, Regularizer::Rest] {
        let settings = Settings::default().with_regularizer(regularizer);
        let solution = run(&grid(8, Basis::Bspline), &Shape::default(), &pins, &settings);
        assert!(is_finite(&solution) && solution.report.folded_cells == 0, "{:?}", solution.report);
        assert!(!solution.report.warnings.is_empty());
    }
}

#[test]
fn moved_handles_arrive_and_pins_outside_act_like_their_border_point() {
    let (grid, shape, settings) = (grid(6, Basis::Bspline), strip(20), Settings::default());
    let handle = HandlePin { index: 14, target: [0.5, 0.4] };
    let pins = [pin([-0.4, 0.5], [-0.5, 0.5]), pin([0.9, 0.5], [0.9, 0.5])];
    let problem = Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[handle], settings: &settings };
    let solution = solve(&problem).expect("a valid problem");
    assert!(distance(solution.lattice.handles[14], handle.target) < 1e-3);
    assert!(distance(solution.lattice.deform([-0.4, 0.5]), [-0.5, 0.5]) < 1e-3);
    assert!(distance(solution.lattice.evaluate([0.0, 0.5]), [-0.1, 0.5]) < 1e-3);
}

#[test]
fn a_rotation_pin_turns_what_is_around_it() {
    let (sin, cos) = 0.5_f64.sin_cos();
    let turned = PointPin { gradient: Some([[cos, sin], [-sin, cos]]), ..pin([0.5, 0.5], [0.5, 0.5]) };
    let solution = run(&grid(8, Basis::Bspline), &strip(20), &[turned], &Settings::default());
    let image = |p: [f64; 2]| {
        let [x, y] = [p[0] - 0.5, p[1] - 0.5];
        [0.5 + cos * x - sin * y, 0.5 + sin * x + cos * y]
    };
    assert!(largest_miss(&solution.lattice, image) < 1e-6, "{:?}", solution.report);
}

#[test]
fn large_lattices_solve() {
    for basis in [Basis::Bspline, Basis::Bilinear] {
        let pins = [pin([0.1, 0.5], [0.1, 0.5]), pin([0.9, 0.4], [0.8, 0.6])];
        let solution = run(&grid(64, basis), &strip(100), &pins, &Settings::default());
        assert!(is_finite(&solution) && solution.report.is_converged, "{:?}", solution.report);
    }
}

#[test]
fn the_last_energies_are_those_of_the_result() {
    // Soft pins miss, by what the energies say they do.
    let shape = strip(20);
    let pins = [(0, [0.1, 0.1]), (1, [0.2, 0.2]), (40, [0.5, 0.9]), (41, [0.6, 0.95])];
    let pin = |&(vertex, target): &(usize, [f64; 2])| serde_json::json!({ "vertex": vertex, "target": target });
    let problem = serde_json::json!({
        "dims": [7, 7], "bbox": [[0, 0], [1, 1]], "vertices": shape.points, "triangles": shape.triangles,
        "lambdas": { "ml": 1, "mp": 1, "gr": 0.001 }, "form": "quad", "regulariser": "bend",
        "pins": pins.iter().map(pin).collect::<Vec<_>>(),
    });
    let result = pinwarp::solve::problem_file::run_text(&problem.to_string()).expect("a valid problem");
    let misses = pins.iter().map(|&(vertex, target)| {
        let at = &result.vertices[vertex];
        (at[0] - target[0]).powi(2) + (at[1] - target[1]).powi(2)
    });
    let (found, expected) = (result.energies.last().expect("steps").mp, misses.sum::<f64>());
    assert!(expected > 1e-6 && (found / expected - 1.0).abs() < 1e-9, "{found:e} {expected:e} {}", result.iterations);
    // As many as steps, but for those that were taken back.
    assert!(result.energies.len() > 3 && result.energies.len() <= result.iterations + 1, "{}", result.energies.len());
}

#[test]
fn malformed_problems_are_refused_in_words() {
    let (grid, shape, settings) = (grid(6, Basis::Bspline), strip(20), Settings::default());
    let refuse = |grid: &Grid<2>, shape: &Shape<2>, pins: &[PointPin<2>], handles: &[HandlePin<2>]| -> String {
        let problem = Problem { grid, shape, pins, handles, settings: &settings };
        solve(&problem).map(|_| ()).map_err(|error: SolveError| error.to_string()).expect_err("a fault")
    };
    let small = Grid { dims: [3, 6], ..grid.clone() };
    assert!(refuse(&small, &shape, &[], &[]).contains("4 to 64"));
    let flat = Grid { hi: [1.0, 0.0], ..grid.clone() };
    assert!(refuse(&flat, &shape, &[], &[]).contains("axis 1"));
    let nan = Shape::of_triangles(vec![[0.0, 0.0], [f64::NAN, 0.0], [1.0, 1.0]], vec![[0, 1, 2]]);
    assert!(refuse(&grid, &nan, &[], &[]).contains("vertex 1"));
    let loose = Shape::of_triangles(vec![[0.0, 0.0]], vec![[0, 0, 7]]);
    assert!(refuse(&grid, &loose, &[], &[]).contains("triangle 0"));
    assert!(refuse(&grid, &shape, &[pin([0.5, 0.5], [f64::INFINITY, 0.0])], &[]).contains("target of pin 0"));
    let heavy = PointPin { weight: 1.5, ..pin([0.5, 0.5], [0.5, 0.5]) };
    assert!(refuse(&grid, &shape, &[heavy], &[]).contains("pin 0 has weight 1.5; use a weight from 0 to 1"));
    let space = r#"{"dims": [64, 64, 64], "bbox": [[0, 0, 0], [1, 1, 1]], "vertices": [[0, 0, 0]]}"#;
    let error = pinwarp::solve::problem_file::run_text(space).expect_err("too large").to_string();
    assert!(error.contains("262144 handles in all") && error.contains("at most 4096"), "{error}");
    assert!(refuse(&grid, &shape, &[], &[HandlePin { index: 36, target: [0.0, 0.0] }]).contains("index 36"));
}

/// A point rotated about another, and a vector.
fn rotated([x, y]: [f64; 2], [a, b]: [f64; 2], angle: f64) -> [f64; 2] {
    let ((sin, cos), [x, y]) = (angle.sin_cos(), [x - a, y - b]);
    [a + cos * x - sin * y, b + sin * x + cos * y]
}

/// The pin rotated about a point, with its target and gradient.
fn rotated_pin(pin: &PointPin<2>, center: [f64; 2], angle: f64) -> PointPin<2> {
    let (sin, cos) = angle.sin_cos();
    let turned = |columns: [[f64; 2]; 2]| {
        let [p, q] = columns.map(|column| rotated(column, [0.0; 2], angle));
        [[cos * p[0] - sin * q[0], cos * p[1] - sin * q[1]], [sin * p[0] + cos * q[0], sin * p[1] + cos * q[1]]]
    };
    PointPin {
        at: rotated(pin.at, center, angle),
        target: rotated(pin.target, center, angle),
        gradient: pin.gradient.map(turned),
        ..*pin
    }
}

/// A figure that is turned together with its box moves alike, for every basis, plain or branching, solved or dragged.
#[test]
fn a_figure_turned_with_its_box_solves_the_same() {
    let shape = strip(24);
    let (sin, cos) = 0.5_f64.sin_cos();
    let mut pins = vec![pin([0.12, 0.5], [0.15, 0.4]), pin([0.5, 0.5], [0.5, 0.62]), pin([0.88, 0.45], [0.8, 0.7])];
    pins[1].gradient = Some([[1.2 * cos, 1.2 * sin], [-0.9 * sin, 0.9 * cos]]);
    let handle = HandlePin { index: 40, target: [0.3, 0.95] };
    for (basis, topology) in bases_and_topologies() {
        let upright = Grid { hi: [1.0, 1.1], ..grid(9, basis) };
        let settings = Settings { topology, tolerance: 1e-9, ..Settings::default() };
        let center = [0.5, 0.55];
        let problem = Problem { grid: &upright, shape: &shape, pins: &pins, handles: &[handle], settings: &settings };
        let wanted = Solver::new(&problem).expect("a valid problem").solve();
        for angle in [0.3, -1.9, 12.0] {
            let turn = |point: [f64; 2]| rotated(point, center, angle);
            let turned = Shape { points: shape.points.iter().map(|&point| turn(point)).collect(), ..shape.clone() };
            let grid = Grid { angle, ..upright.clone() };
            let pins: Vec<_> = pins.iter().map(|pin| rotated_pin(pin, center, angle)).collect();
            let handles = [HandlePin { target: turn(handle.target), ..handle }];
            let problem = Problem { grid: &grid, shape: &turned, pins: &pins, handles: &handles, settings: &settings };
            let solver = Solver::new(&problem).expect("a valid problem");
            let mut drag = solver.drag_from(&solver.solve()).expect("a solution of this solver");
            let moved =
                |x: f64| pins.iter().map(move |pin| PointPin { target: [pin.target[0] + x, pin.target[1]], ..*pin });
            drag.follow(&moved(0.01).collect::<Vec<_>>(), &handles).expect("the same pins");
            for found in [
                solver.solve(),
                solver.update(&pins, &handles).expect("the same pins"),
                drag.settle(&pins, &handles).expect("the same pins"),
            ] {
                let image = |solution: &Solution<2>, triangle: usize, point: [f64; 2]| match &solution.branches {
                    Some(branches) => branches.evaluate(triangle, point),
                    None => solution.lattice.deform(point),
                };
                let misses = shape.triangles.iter().enumerate().map(|(triangle, corners)| {
                    let point = shape.points[corners[0] as usize];
                    distance(image(&found, triangle, turn(point)), turn(image(&wanted, triangle, point)))
                });
                let (miss, diagonal) = (misses.fold(0.0, f64::max), upright.diagonal());
                assert!(miss < 1e-6 * diagonal, "{basis:?} {topology:?} by {angle}: {miss:.1e}");
                let errors = found.report.pin_errors.iter().zip(&wanted.report.pin_errors);
                assert!(errors.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) < 1e-6 * diagonal);
            }
        }
        // With an upright box the same turned figure moves otherwise.
        let turned = Shape { points: shape.points.iter().map(|&p| rotated(p, center, 0.3)).collect(), ..shape.clone() };
        let pins: Vec<_> = pins.iter().map(|pin| rotated_pin(pin, center, 0.3)).collect();
        let problem = Problem { grid: &upright, shape: &turned, pins: &pins, handles: &[], settings: &settings };
        let found = Solver::new(&problem).expect("a valid problem").solve();
        let [a, b] = [found.lattice.deform(turned.points[20]), wanted.lattice.deform(shape.points[20])];
        assert!(distance(a, rotated(b, center, 0.3)) > 1e-4 * upright.diagonal(), "{basis:?}");
    }
}

fn bases_and_topologies() -> impl Iterator<Item = (Basis, Topology)> {
    let plain =
        [Basis::Bspline, Basis::Bernstein, Basis::Bilinear, Basis::Barytri].map(|basis| (basis, Topology::Plain));
    plain.into_iter().chain([(Basis::Bspline, Topology::Branching)])
}
