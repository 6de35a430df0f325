//! What real models and hands do to a solver: thousands of poses, trembling vertices, boxes that are mostly empty, twists.
//!
//! Seeds are fixed. `cargo test --lib -- --ignored robust::` runs all 10,000 poses.

#[path = "support/figure.rs"]
mod figure;

use crate::internal::numbers::{Congruential, Random, distance};
use crate::internal::solving;
use figure::{Pose, around, figure, posed};
use pinwarp::lattice::{Basis, Grid, Lattice};
use pinwarp::solve::{PointPin, Problem, Settings, Shape, Solution, Solver, Targets};

/// Arms up to 110 degrees, legs up to 80, every other limb at rest; the body somewhere else.
fn random_pose(random: &mut impl Random) -> Pose {
    let mut limb = |degrees: f64| if random.unit() < 0.5 { random.within(degrees.to_radians()) } else { 0.0 };
    let limbs = [limb(110.0), limb(110.0), limb(80.0), limb(80.0)];
    Pose { limbs, shift: [random.within(0.3), random.within(0.3)] }
}

fn run(grid: &Grid<2>, shape: &Shape<2>, pins: &[PointPin<2>]) -> Solution<2> {
    solving::run(grid, shape, pins, &Settings::default())
}

fn is_finite(solution: &Solution<2>) -> bool {
    let report = &solution.report;
    solution.lattice.handles.iter().flatten().all(|x| x.is_finite())
        && [report.min_det, report.min_cell_det, report.angular, report.area].iter().all(|x| x.is_finite())
}

/// Farthest that a vertex of the shape goes from one lattice to the other.
fn apart(a: &Lattice<2>, b: &Lattice<2>, shape: &Shape<2>) -> f64 {
    shape.points.iter().map(|&point| distance(a.evaluate(point), b.evaluate(point))).fold(0.0, f64::max)
}

/// Solves poses of three figures, finer and finer; prints iterations, fails where one diverges.
fn try_poses(count: usize) {
    let grid = around(10, Basis::Bspline);
    let mut rng = Congruential(2405);
    let mut iterations = Vec::new();
    let mut unconverged = 0;
    for spacing in [0.086, 0.064, 0.0485] {
        let shape = figure(spacing);
        assert!((225..=734).contains(&shape.points.len()), "{} vertices", shape.points.len());
        let (rest, settings) = (posed(Pose::default()), Settings::default());
        let problem = Problem { grid: &grid, shape: &shape, pins: &rest, handles: &[], settings: &settings };
        let solver = Solver::new(&problem).expect("a valid problem");
        for _ in 0..count.div_ceil(3) {
            let pose = random_pose(&mut rng);
            let solution = solver.update(&posed(pose), &[]).expect("the same pins");
            let report = &solution.report;
            assert!(is_finite(&solution), "{pose:?}");
            assert!(report.pin_errors.iter().all(|error| *error < 1e-5 * grid.diagonal()), "{pose:?} {report:?}");
            // Nothing flies off: handles stay within a few boxes.
            assert!(solution.lattice.handles.iter().all(|&at| distance(at, [0.0; 2]) < 10.0), "{pose:?}");
            let is_told = report.warnings.iter().any(|text| text.contains("not converged"));
            assert!(report.is_converged || is_told, "{pose:?}");
            unconverged += usize::from(!report.is_converged);
            iterations.push(report.iterations);
        }
    }
    iterations.sort_unstable();
    let [median, most] = [iterations[iterations.len() / 2], iterations[iterations.len() - 1]];
    let slow = iterations.iter().filter(|&&count| count > 100).count();
    eprintln!(
        "{} poses: {median} iterations in the median, {most} at most, {slow} above 100, {unconverged} not converged",
        iterations.len()
    );
    assert!(median <= MEDIAN_ITERATIONS && most <= MAX_ITERATIONS, "{median} {most}");
}

/// Iterations that the poses may need.
const MEDIAN_ITERATIONS: usize = 20;
const MAX_ITERATIONS: usize = 100;

#[test]
fn five_hundred_poses_arrive() {
    try_poses(500);
}

#[test]
#[ignore = "minutes; the normal suite runs 500 of them"]
fn ten_thousand_poses_arrive() {
    try_poses(10_000);
}

#[test]
fn trembling_vertices_do_not_move_the_lattice() {
    let (grid, shape, mut rng) = (around(10, Basis::Bspline), figure(0.08), Congruential(7));
    let tremble = 1e-7 * grid.diagonal();
    let mut worst: f64 = 0.0;
    for _ in 0..20 {
        let pins = posed(random_pose(&mut rng));
        let mut trembled = shape.clone();
        for point in &mut trembled.points {
            let angle = std::f64::consts::PI * rng.within(1.0);
            *point = [point[0] + tremble * angle.cos(), point[1] + tremble * angle.sin()];
        }
        let [a, b] = [&shape, &trembled].map(|shape| run(&grid, shape, &pins).lattice);
        worst = worst.max(apart(&a, &b, &shape) / grid.spacing(0));
    }
    eprintln!("vertices that tremble by 1e-7 of the diagonal move the lattice by at most {worst:.1e} of a cell");
    assert!(worst < 1e-5, "{worst:.1e} of a cell");
}

#[test]
fn scales_of_micrometres_and_of_planets_bend_alike() {
    let (grid, shape, mut rng) = (around(10, Basis::Bspline), figure(0.08), Congruential(11));
    let pins = posed(random_pose(&mut rng));
    let unit = run(&grid, &shape, &pins);
    for scale in [1e-6, 1e6] {
        let times = |p: [f64; 2]| p.map(|x| x * scale);
        let large = Grid { lo: times(grid.lo), hi: times(grid.hi), ..grid.clone() };
        let scaled = Shape { points: shape.points.iter().map(|&p| times(p)).collect(), ..shape.clone() };
        let pins: Vec<_> = pins.iter().map(|pin| PointPin::new(times(pin.at), times(pin.target))).collect();
        let found = run(&large, &scaled, &pins);
        for &point in &shape.points {
            let [a, b] = [times(unit.lattice.evaluate(point)), found.lattice.evaluate(times(point))];
            assert!(distance(a, b) < 1e-5 * grid.spacing(0) * scale, "{scale}: {a:?} {b:?}");
        }
    }
}

#[test]
fn boxes_that_are_mostly_empty_fold_where_nobody_sees_it() {
    let shape = figure(0.08);
    for factor in [2.0, 3.0, 4.0] {
        let tight = around(10, Basis::Bspline);
        let grid = Grid { lo: tight.lo.map(|x| factor * x), hi: tight.hi.map(|x| factor * x), ..tight };
        let pins = posed(Pose { limbs: [1.0, 0.0, 0.0, -0.4], shift: [0.0, 0.1] });
        let solution = run(&grid, &shape, &pins);
        assert!(is_finite(&solution), "{:?}", solution.report);
        assert!(solution.report.pin_errors.iter().all(|error| *error < 1e-4), "{factor}: {:?}", solution.report);
        // The box folds, but no cell that a triangle of the figure touches.
        assert!(solution.report.folded_cells > 0, "{factor}: nothing folds, so nothing is tested");
        assert_eq!(solution.report.folded_model_cells, 0, "{factor}: {:?}", solution.report);
        assert!(solution.lattice.handles.iter().all(|&at| distance(at, [0.0; 2]) < 5.0 * factor), "{factor}");
    }
}

#[test]
fn flaws_of_screen_meshes_change_little() {
    // Slivers, edges of no length, folded triangles over the others, doubled ones, a speck far from all pins.
    let (grid, sound, mut rng) = (around(10, Basis::Bspline), figure(0.08), Congruential(3));
    let mut flawed = sound.clone();
    for k in (0..sound.triangles.len()).step_by(9) {
        let [a, b, c] = sound.triangles[k];
        let middle = flawed.points.len() as u32;
        let between = |d: usize| f64::midpoint(sound.points[a as usize][d], sound.points[b as usize][d]);
        flawed.points.push([between(0), between(1) + 1e-14]);
        flawed.triangles.extend([[a, middle, b], [a, a, c], [a, c, b]]);
    }
    let speck = flawed.points.len() as u32;
    flawed.points.extend([[1.1, 1.1], [1.1 + 1e-9, 1.1], [1.1, 1.1 + 1e-9]]);
    flawed.triangles.push([speck, speck + 1, speck + 2]);
    for _ in 0..5 {
        let pins = posed(random_pose(&mut rng));
        let [a, b] = [&sound, &flawed].map(|shape| run(&grid, shape, &pins));
        assert!(is_finite(&b), "{:?}", b.report);
        // Doubled triangles weigh twice: the same bend but for that.
        let gap = apart(&a.lattice, &b.lattice, &sound) / grid.spacing(0);
        assert!(gap < 0.1, "{gap} of a cell");
    }
}

#[test]
fn twists_from_90_to_185_degrees_neither_break_nor_jump() {
    let (grid, shape, settings) = (around(10, Basis::Bspline), figure(0.08), Settings::default());
    for joint in [[0.0, -0.05], [0.1, 0.3], [0.0, 0.45]] {
        let state = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let turned = |pin: PointPin<2>| {
                let [x, y] = [pin.at[0] - joint[0], pin.at[1] - joint[1]];
                let target = [joint[0] + cos * x - sin * y, joint[1] + sin * x + cos * y];
                PointPin::new(pin.at, if pin.at[1] > joint[1] { target } else { pin.at })
            };
            Targets { pins: posed(Pose::default()).into_iter().map(turned).collect(), handles: Vec::new() }
        };
        let path: Vec<_> = (0..=37).map(|k| state(5.0 * f64::from(k))).collect();
        let problem = Problem { grid: &grid, shape: &shape, pins: &path[0].pins, handles: &[], settings: &settings };
        let solver = Solver::new(&problem).expect("a valid problem");
        let found: Vec<_> = (18..=37).map(|end| solver.follow(&path[..=end]).expect("valid")).collect();
        assert!(found.iter().all(is_finite));
        for (k, pair) in found.windows(2).enumerate() {
            // What turns, turns by 5 degrees: 0.17 units at most. Twice that is no jump.
            let step = apart(&pair[0].lattice, &pair[1].lattice, &shape);
            assert!(step < 0.35, "{joint:?}: {step} from {} degrees on", 90 + 5 * k);
        }
    }
}
