//! Branching lattices over time: their pieces split and join as the box moves over a figure, and nothing jumps.

#[path = "support/bisection.rs"]
mod bisection;
#[path = "support/puppet.rs"]
#[expect(dead_code, reason = "another test asks for limbs")]
mod puppet;

use crate::internal::numbers::SplitMix;
use bisection::jump;
use pinwarp::lattice::{Basis, Grid};
use pinwarp::solve::{
    Cancel, Coupling, ModelPoint, PointPin, Problem, Settings, Shape, Solution, SolveError, Targets, TimedProblem,
    Timeline, Topology, Trajectory, solve,
};
use puppet::Puppet;
use std::collections::{BTreeMap, BTreeSet};

/// Edges of the mesh.
const SPACING: f64 = 0.03;

/// A figure is 1 high; 1080 pixels.
const PIXEL: f64 = 1.0 / 1080.0;

const LAST: f64 = 10.0;

/// A figure whose arms come off its sides and back, under a box that wanders, with pins on their way to a pose.
struct Scene {
    rest: Shape<2>,
    pins: [Vec<PointPin<2>>; 2],
    dims: [usize; 2],
    settings: Settings,
    /// Watched points: a triangle, and a vertex of it. All vertices are watched, the tips of limbs among them.
    watched: Vec<[u32; 2]>,
}

impl Scene {
    fn new(figure: &Puppet, pose: Vec<PointPin<2>>, dims: [usize; 2]) -> Self {
        let settings = Settings { topology: Topology::Branching, ..Settings::default() };
        let rest = figure.mesh(SPACING).linked(1.0);
        let corners =
            rest.triangles.iter().zip(0..).flat_map(|(corners, triangle)| corners.map(|corner| (corner, triangle)));
        let triangles: BTreeMap<u32, u32> = corners.collect();
        let watched = triangles.into_iter().map(|(corner, triangle)| [triangle, corner]).collect();
        Self { rest, pins: [figure.pins(), pose], dims, settings, watched }
    }

    /// Where a point of the figure is at rest at a time: what is beside the body swings out by up to 6 % of the height.
    fn place(&self, [x, y]: [f64; 2], time: f64) -> [f64; 2] {
        let beside = ((x.abs() - 0.09) / 0.05).clamp(0.0, 1.0) * ((0.72 - y) / 0.1).clamp(0.0, 1.0);
        let out = 0.06 * (0.5 * time).sin().powi(2);
        [x + x.signum() * out * beside * beside * (3.0 - 2.0 * beside), y]
    }

    fn shape(&self, time: f64) -> Shape<2> {
        Shape { points: self.rest.points.iter().map(|&point| self.place(point, time)).collect(), ..self.rest.clone() }
    }

    fn pins_at(&self, time: f64) -> Vec<PointPin<2>> {
        let t = (time / LAST).clamp(0.0, 1.0);
        let eased = t * t * (3.0 - 2.0 * t);
        let [from, to] = &self.pins;
        let pins = from.iter().zip(to).map(|(from, to)| {
            let at = self.place(from.at, time);
            let target = [0, 1].map(|d| at[d] + eased * (to.target[d] - to.at[d]));
            PointPin::new(at, target)
        });
        pins.collect()
    }

    /// Where the shape's points go.
    fn images(&self, solution: &Solution<2>, time: f64) -> Vec<[f64; 2]> {
        let shape = self.shape(time);
        let mut images = vec![[0.0; 2]; shape.points.len()];
        for (triangle, corners) in shape.triangles.iter().enumerate() {
            for &corner in corners {
                let point = shape.points[corner as usize];
                images[corner as usize] = match &solution.branches {
                    Some(branches) => branches.evaluate(triangle, point),
                    None => solution.lattice.evaluate(point),
                };
            }
        }
        images
    }
}

impl Timeline<2> for Scene {
    type Error = SolveError;

    fn settings(&self) -> &Settings {
        &self.settings
    }

    fn at(&self, time: f64) -> Result<Option<TimedProblem<2>>, SolveError> {
        let (shape, pins) = (self.shape(time), self.pins_at(time));
        // The box drifts by more than a span, and grows.
        let (shift, grown) = (0.012 * time, 0.004 * time);
        let grid = Grid {
            dims: self.dims,
            basis: Basis::Bspline,
            lo: [-0.42 - shift - grown, -0.12 + shift - grown],
            hi: [0.42 - shift + grown, 1.1 + shift + grown],
            angle: 0.0,
        };
        let watched =
            |&[triangle, corner]: &[u32; 2]| ModelPoint { at: shape.points[corner as usize], triangle: Some(triangle) };
        let points = self.watched.iter().map(watched).collect();
        let path = vec![Targets { pins, handles: Vec::new() }];
        Ok(Some(TimedProblem { grid, shape, path, points, drawing: 0, take: 0 }))
    }
}

/// A layer over time.
struct Motion<'a> {
    scene: &'a Scene,
    trajectory: Trajectory<2>,
}

impl Motion<'_> {
    fn solution(&self, time: f64) -> Solution<2> {
        let problem = self.scene.at(time).expect("a problem").expect("pins act");
        let solved = self.trajectory.solve_at(time, problem, self.scene.settings(), &Cancel::never());
        solved.unwrap_or_else(|error| panic!("at {time}: {error}"))
    }

    fn points(&self, time: f64) -> Vec<[f64; 2]> {
        self.scene.images(&self.solution(time), time)
    }

    /// Farthest jump between two times, pixels.
    fn jump(&self, from: (f64, &[[f64; 2]]), to: (f64, &[[f64; 2]])) -> f64 {
        let ends = [from, to].map(|(time, points)| (time, points.to_vec()));
        jump(ends, 1.0, |time| self.points(time), |a, b| farthest(a, b))
    }
}

/// Farthest move of a point, pixels.
fn farthest(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    moves(a, b).last().copied().unwrap_or(0.0)
}

/// Moves of all points, pixels, ascending.
fn moves(a: &[[f64; 2]], b: &[[f64; 2]]) -> Vec<f64> {
    let mut moves: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]) / PIXEL).collect();
    moves.sort_by(f64::total_cmp);
    moves
}

fn coupling() -> Coupling {
    Coupling { first: 0.0, last: LAST, knots_per_frame: 1, weight: 0.3, least_speed: PIXEL }
}

/// What was found in a scene over time: the farthest jump, pixels; pins; how many branches there were.
struct Finding {
    jump: f64,
    /// Farthest that a pin is off at a frame, pixels.
    pin_error: f64,
    branch_counts: BTreeSet<usize>,
}

fn look(scene: &Scene) -> Finding {
    let trajectory = Trajectory::solve(scene, coupling(), &Cancel::never()).expect("solved");
    let motion = Motion { scene, trajectory };
    let mut finding = Finding { jump: 0.0, pin_error: 0.0, branch_counts: BTreeSet::new() };
    let mut before = motion.points(0.0);
    for frame in 1..=LAST as i32 {
        let solution = motion.solution(f64::from(frame));
        finding.pin_error =
            solution.report.pin_errors.iter().map(|error| error / PIXEL).fold(finding.pin_error, f64::max);
        finding.branch_counts.insert(solution.branches.as_ref().map_or(1, |branches| branches.branch_count()));
        let points = scene.images(&solution, f64::from(frame));
        finding.jump = finding.jump.max(motion.jump((f64::from(frame - 1), &before), (f64::from(frame), &points)));
        before = points;
    }
    finding
}

/// A random figure in a random pose, under a coarse lattice.
fn random_scene(seed: u64) -> Scene {
    let figure = Puppet::random(seed);
    let pose = figure.posed(&mut SplitMix(200 + seed));
    Scene::new(&figure, pose, [[10, 12], [14, 16], [18, 22]][seed as usize % 3])
}

#[test]
fn nothing_jumps_while_pieces_split_and_join() {
    let girl = Puppet::girl();
    let scenes = [Scene::new(&girl, girl.raised(), [16, 20])].into_iter().chain((0..4).map(random_scene));
    for (number, scene) in scenes.enumerate() {
        let Finding { jump, pin_error, branch_counts } = look(&scene);
        println!("figure {number}: jumps by at most {jump:.3} px; {branch_counts:?} branches");
        assert!(branch_counts.len() > 1, "figure {number}: pieces never split or join");
        assert!(jump <= 1.0 && pin_error < 0.05, "figure {number}: jumps by {jump} px, pins are off by {pin_error} px");
    }
}

#[test]
#[ignore = "minutes; PINWARP_FIGURES=count"]
fn many_random_figures() {
    let count = std::env::var("PINWARP_FIGURES").ok().and_then(|x| x.parse().ok()).unwrap_or(60);
    let jumps: Vec<f64> = (0..count).map(|seed| look(&random_scene(seed)).jump).collect();
    let of = |px: f64| jumps.iter().filter(|jump| **jump > px).count();
    let greatest = jumps.iter().copied().fold(0.0, f64::max);
    println!(
        "of {count} figures {} jump by more than 1 px, {} by more than 5; at most {greatest:.2} px",
        of(1.0),
        of(5.0)
    );
    for (seed, jump) in jumps.iter().enumerate().filter(|(_, jump)| **jump > 1.0) {
        println!("seed {seed}: {jump:.2} px");
    }
}

#[test]
fn no_order_and_no_thread_changes_a_bit_of_copies() {
    let girl = Puppet::girl();
    let scene = Scene::new(&girl, girl.raised(), [10, 12]);
    let solve = || Trajectory::solve(&scene, coupling(), &Cancel::never()).expect("solved");
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let (first, second) = (solve(), alone.install(solve));
    assert_eq!(first, second);
    let read = Trajectory::from_bytes(&first.to_bytes()).expect("it was written so");
    let of = |trajectory: Trajectory<2>| {
        let motion = Motion { scene: &scene, trajectory };
        [3.0, 7.25, -0.5].map(|time| motion.solution(time))
    };
    assert!(of(first) == of(read));
}

/// How far all points lie at a time from where they lie if that time is solved alone, pixels, ascending.
fn off_alone(motion: &Motion, time: f64) -> Vec<f64> {
    let scene = motion.scene;
    let problem = scene.at(time).expect("a problem").expect("pins act");
    let Targets { pins, handles } = &problem.path[0];
    let bare = Problem { grid: &problem.grid, shape: &problem.shape, pins, handles, settings: &scene.settings };
    moves(&motion.points(time), &scene.images(&solve(&bare).expect("solved"), time))
}

#[test]
fn states_between_frames_are_near_those_solved_alone() {
    let girl = Puppet::girl();
    let scene = Scene::new(&girl, girl.raised(), [16, 20]);
    let trajectory = Trajectory::solve(&scene, coupling(), &Cancel::never()).expect("solved");
    let motion = Motion { scene: &scene, trajectory };
    // The tip of the arm comes to rest faster than the speed limit allows: it is asked to move by 46 px in the last frame, and moves
    // by 27.
    for (time, limit) in [(0.0, 12.0), (4.0, 12.0), (4.5, 12.0), (10.0, 12.0)] {
        let off = off_alone(&motion, time);
        let (median, farthest) = (off[off.len() / 2], off[off.len() - 1]);
        println!("at {time}: {farthest:.2} px from the solve alone, half of the points by at most {median:.2}");
        assert!(farthest < limit, "{farthest} px at {time}");
    }
}

#[test]
fn a_limb_that_snaps_does_not_hold_back_the_others() {
    let girl = Puppet::girl();
    let girl = Scene::new(&girl, girl.raised(), [16, 20]);
    // Median and nine tenths of all points, pixels; with one weight for all points 2.2 and 7.9, 4.1 and 10.4, 2.2 and 5.4.
    for (name, scene, limits) in [
        ("the girl", girl, [0.8, 6.0]),
        ("figure 17", random_scene(17), [0.6, 4.0]),
        ("figure 56", random_scene(56), [0.6, 3.0]),
    ] {
        let trajectory = Trajectory::solve(&scene, coupling(), &Cancel::never()).expect("solved");
        assert!(!trajectory.spreads().is_empty(), "{name} snaps");
        let motion = Motion { scene: &scene, trajectory };
        let off = [3.0, 6.0, 9.0, 10.0].map(|time| off_alone(&motion, time));
        let greatest = |part: f64| off.iter().map(|off| off[(off.len() as f64 * part) as usize]).fold(0.0, f64::max);
        let found = [greatest(0.5), greatest(0.9)];
        println!("{name}: half of the points are off by at most {:.2} px, nine tenths by {:.2}", found[0], found[1]);
        assert!(found[0] < limits[0] && found[1] < limits[1], "{name}: {found:?} px");
    }
}
