//! Lattices in space: Newton's method with conjugate gradients converges, where local-global steps would end, too.

#[path = "support/bisection.rs"]
mod bisection;

use crate::internal::solving::run;
use bisection::jump;
use pinwarp::lattice::{Basis, Grid};
use pinwarp::solve::{
    Cancel, Coupling, Guard, ModelPoint, PointPin, Settings, Shape, Solution, SolveError, Targets, TimedProblem,
    Timeline, Trajectory, active_cells,
};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A ball of radius 1, or a tube of it along y: rings at heights and radii, closed by points at both ends.
fn rings(profile: &[[f64; 2]], segments: usize) -> Shape<3> {
    let mut points = Vec::new();
    for &[height, radius] in profile {
        for k in 0..segments {
            let (sin, cos) = (k as f64 / segments as f64 * TAU).sin_cos();
            points.push([radius * cos, height, radius * sin]);
        }
    }
    let mut triangles = Vec::new();
    for ring in 0..profile.len() - 1 {
        for k in 0..segments {
            let at = |ring: usize, k: usize| (ring * segments + k % segments) as u32;
            let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k), at(ring + 1, k + 1)];
            triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    Shape::of_triangles(points, triangles)
}

fn ball() -> Shape<3> {
    let profile: Vec<[f64; 2]> = (0..=24).map(|k| (f64::from(k) / 24.0 * PI).sin_cos()).map(|(s, c)| [c, s]).collect();
    rings(&profile, 48)
}

fn cube(count: usize) -> Grid<3> {
    Grid { dims: [count; 3], basis: Basis::Bspline, lo: [-1.2; 3], hi: [1.2; 3], angle: 0.0 }
}

/// Four pins around the axis at each height, turned by an angle for each.
fn turned(radius: f64, heights: impl Iterator<Item = (f64, f64)>) -> Vec<PointPin<3>> {
    let of = |(height, angle): (f64, f64)| {
        (0..4).map(move |k| {
            let place = |angle: f64| [radius * angle.cos(), height, radius * angle.sin()];
            let start = f64::from(k) * FRAC_PI_2;
            PointPin::new(place(start), place(start + angle))
        })
    };
    heights.flat_map(of).collect()
}

fn assert_converged(solution: &Solution<3>, grid: &Grid<3>, most: usize) {
    let report = &solution.report;
    assert!(report.is_converged && report.iterations <= most, "{} {:?}", report.iterations, report.warnings);
    assert!(report.pin_errors.iter().all(|&error| error < 1e-9 * grid.diagonal()), "{:?}", report.pin_errors);
}

/// The farthest that a point of the shape lies from where another solution takes it.
fn gap(a: &Solution<3>, b: &Solution<3>, shape: &Shape<3>) -> f64 {
    let gaps = shape.points.iter().map(|&point| {
        let (a, b) = (a.lattice.evaluate(point), b.lattice.evaluate(point));
        (0..3).map(|d| (a[d] - b[d]).powi(2)).sum::<f64>().sqrt()
    });
    gaps.fold(0.0, f64::max)
}

#[test]
fn a_ball_twisted_by_120_degrees_converges() {
    let (grid, shape) = (cube(5), ball());
    let pins = turned(0.6, [(-0.8, 0.0), (0.8, 120_f64.to_radians())].into_iter());
    assert_converged(&run(&grid, &shape, &pins, &Settings::default()), &grid, 40);
}

#[test]
fn a_tube_twisted_by_a_full_turn_over_eight_spans_converges() {
    let grid =
        Grid { dims: [5, 11, 5], basis: Basis::Bspline, lo: [-0.5, -2.1, -0.5], hi: [0.5, 2.1, 0.5], angle: 0.0 };
    let shape = rings(&(0..=40).map(|k| [0.1 * f64::from(k) - 2.0, 0.4]).collect::<Vec<_>>(), 24);
    // A ring of pins each quarter turn: an eighth would say more than the lattice has to find out.
    let pins = turned(0.4, (0..=4).map(|k| (f64::from(k) - 2.0, f64::from(k) * FRAC_PI_2)));
    let solution = run(&grid, &shape, &pins, &Settings::default());
    assert_converged(&solution, &grid, 60);
    // Halfway between two rings of pins the tube has turned halfway.
    let [x, _, z] = solution.lattice.evaluate([0.4, 0.5, 0.0]);
    let angle = z.atan2(x).rem_euclid(TAU);
    assert!((angle - 2.5 * FRAC_PI_2).abs() < 0.1, "{angle}");
}

#[test]
fn newtons_method_ends_where_local_global_steps_do() {
    let (grid, shape) = (cube(5), ball());
    let mut pins = [[1., 0., 0.], [-1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.], [0., 0., -1.]]
        .map(|at| PointPin::new(at, at))
        .to_vec();
    pins[0].target = [1.3, 0.2, 0.1];
    // One that turns the shape around it brings the response of its region in.
    pins[2].region = Some(pinwarp::solve::Region { radius: 0.4, rigidity: 0.5, stiffness: 1.0 });
    pins[2].target = [0.2, 1.1, 0.0];
    let newton = run(&grid, &shape, &pins, &Settings::default());
    assert_converged(&newton, &grid, 30);
    let plain = Settings { acceleration: 0, tolerance: 1e-9, iteration_limit: 20_000, ..Settings::default() };
    let plain = run(&grid, &shape, &pins, &plain);
    assert!(plain.report.is_converged && plain.report.iterations > 60, "{}", plain.report.iterations);
    assert!(gap(&newton, &plain, &shape) < 1e-5 * grid.diagonal(), "{}", gap(&newton, &plain, &shape));
}

#[test]
fn solves_do_not_depend_on_the_number_of_threads() {
    let (grid, shape) = (cube(8), ball());
    let pins = turned(0.6, [(-0.8, 0.0), (0.8, 0.8)].into_iter());
    let alone = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| run(&grid, &shape, &pins, &Settings::default()).lattice)
    };
    assert_eq!(alone(1), alone(3));
}

#[test]
fn pins_near_a_line_bend_a_shape_and_do_not_turn_it_over() {
    let grid = Grid { dims: [5; 3], basis: Basis::Bspline, lo: [-0.5, -1.1, -0.5], hi: [0.5, 1.1, 0.5], angle: 0.0 };
    let radius = |height: f64| 0.4 * (1.0 - height * height).sqrt();
    let profile: Vec<[f64; 2]> = (0..=24).map(|k| -(f64::from(k) / 24.0 * PI).cos()).map(|y| [y, radius(y)]).collect();
    let shape = rings(&profile, 32);
    // The middle one of three pins along the back is moved across the line of the others, or sideways.
    let moves = [[-0.1, 0.0], [-0.3, 0.0], [-0.5, 0.0], [0.2, 0.0], [0.0, 0.3], [-0.2, 0.1], [0.0, -0.3]];
    for (aside, by) in [0.0, 0.1].into_iter().flat_map(|aside| moves.map(|by| (aside, by))) {
        let on_back = |height: f64, z: f64| [(radius(height).powi(2) - z * z).sqrt(), height, z];
        let mut pins = [on_back(-0.7, 0.0), on_back(0.0, aside), on_back(0.7, 0.0)].map(|at| PointPin::new(at, at));
        (pins[1].target[0], pins[1].target[2]) = (pins[1].at[0] + by[0], pins[1].at[2] + by[1]);
        let solution = run(&grid, &shape, &pins, &Settings::default());
        assert_converged(&solution, &grid, 30);
        let [left, right] = [0.4, -0.4].map(|z| solution.lattice.evaluate([0.0, 0.0, z]));
        let rolled = (right[0] - left[0]).atan2(left[2] - right[2]).to_degrees();
        assert!(rolled.abs() < 60.0, "pins {aside} aside, moved by {by:?}: {rolled} degrees");
    }
}

/// A ball whose upper ring of pins is turned by an angle.
struct TwistedBall {
    angle: f64,
    shape: Shape<3>,
    settings: Settings,
}

/// Frames of the twist.
const FRAMES: f64 = 8.0;

impl Timeline<3> for TwistedBall {
    type Error = SolveError;

    fn settings(&self) -> &Settings {
        &self.settings
    }

    fn at(&self, time: f64) -> Result<Option<TimedProblem<3>>, SolveError> {
        let pins = turned(0.6, [(-0.8, 0.0), (0.8, self.angle * time / FRAMES)].into_iter());
        let points = self.shape.points.iter().step_by(5).map(|&at| ModelPoint { at, triangle: None }).collect();
        let path = vec![Targets { pins, handles: Vec::new() }];
        Ok(Some(TimedProblem { grid: cube(5), shape: self.shape.clone(), path, points, drawing: 0, take: 0 }))
    }
}

impl TwistedBall {
    fn at(&self, trajectory: &Trajectory<3>, time: f64) -> Solution<3> {
        let problem = Timeline::at(self, time).expect("a problem").expect("pins act");
        let solution = trajectory.solve_at(time, problem, &self.settings, &Cancel::never()).expect("solved");
        let report = &solution.report;
        assert!(report.is_converged, "{} iterations in frame {time}", report.iterations);
        solution
    }
}

#[test]
fn a_ball_that_is_twisted_over_time_converges_at_all_times_and_does_not_jump() {
    // Beyond 180 degrees the best rigid fit of the pins changes sides.
    for angle in [PI, TAU] {
        let ball = TwistedBall { angle, shape: ball(), settings: Settings::default() };
        let coupling = Coupling { first: 0.0, last: FRAMES, knots_per_frame: 1, weight: 0.3, least_speed: 1e-3 };
        let trajectory = Trajectory::solve(&ball, coupling, &Cancel::never()).expect("solved");
        let solved = |k: u32| (f64::from(k) / 8.0, ball.at(&trajectory, f64::from(k) / 8.0));
        let solutions: Vec<(f64, Solution<3>)> = (0..=8 * FRAMES as u32).map(solved).collect();
        let distance = |a: &Solution<3>, b: &Solution<3>| gap(a, b, &ball.shape);
        // Two and a half times what the pins move between two of these times.
        let fast = solutions.windows(2).filter(|pair| distance(&pair[0].1, &pair[1].1) > 0.0235 * angle);
        let ends = fast.map(|pair| [pair[0].clone(), pair[1].clone()]);
        let jumps = ends.map(|ends| jump(ends, 0.01, |time| ball.at(&trajectory, time), distance));
        let jump = jumps.fold(0.0, f64::max);
        assert!(jump < 0.01, "{jump} at an angle of {angle}");
    }
}

/// A ball held by six pins, one of which is pulled out, or in, in any direction by up to its radius.
fn pulled(number: u32) -> Vec<PointPin<3>> {
    let mut pins = [[1., 0., 0.], [-1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.], [0., 0., -1.]]
        .map(|at| PointPin::new(at, at))
        .to_vec();
    let (turn, height) = (2.4 * f64::from(number), 2.0 * (f64::from(number) + 0.5) / 20.0 - 1.0);
    let (across, far) = ((1.0 - height * height).sqrt(), 0.5 + f64::from(number % 6) / 10.0);
    let by = [far * height, far * across * turn.cos(), far * across * turn.sin()];
    (0..3).for_each(|d| pins[0].target[d] += by[d]);
    pins
}

/// Whole cells are looked at, as the barrier covers them: the surface of these balls does not fold.
#[test]
fn pulled_balls_do_not_fold_with_the_barrier() {
    let (grid, shape) = (cube(5), ball());
    let is_active = active_cells(&grid, &shape);
    let (mut folded, mut given_way, mut slowest) = (0, 0, 0.0_f64);
    for number in 0..20 {
        let pins = pulled(number);
        let free = run(&grid, &shape, &pins, &Settings::default());
        folded += usize::from(free.lattice.folds(&is_active).active_count > 0);
        let settings = Settings { guard: Guard::Limit, ..Settings::default() };
        let begun = std::time::Instant::now();
        let held = run(&grid, &shape, &pins, &settings);
        slowest = slowest.max(begun.elapsed().as_secs_f64());
        let folds = held.lattice.folds(&is_active);
        assert!(folds.active_count == 0 && folds.min_det > 0.0, "{number}: {folds:?}");
        assert!(held.report.is_converged, "{number}: {:?}", held.report);
        given_way += usize::from(held.report.is_held_back);
    }
    eprintln!("{folded} of 20 fold without the barrier; with it pins give way in {given_way}; {slowest:.2} s at most");
    assert!(folded > 10, "{folded}");
}

#[test]
fn a_twisted_ball_converges_with_the_barrier() {
    let (grid, shape) = (cube(5), ball());
    let pins = turned(0.6, [(-0.8, 0.0), (0.8, 120_f64.to_radians())].into_iter());
    let settings = Settings { guard: Guard::Limit, ..Settings::default() };
    let held = run(&grid, &shape, &pins, &settings).report;
    assert!(held.is_converged && held.folded_model_cells == 0 && held.min_cell_det > 0.0, "{held:?}");
}
