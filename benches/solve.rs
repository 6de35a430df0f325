//! Time of solves, printed as tables: `cargo bench --bench solve`.
//!
//! In: generated blobs with the vertex counts of the paper's time table. Out: milliseconds next to the paper's (column
//! "Ours", a 1.5 GHz laptop): cold solves and single steps on one thread; drag updates; a million vertices.

#[path = "support/blob.rs"]
mod blob;
#[path = "support/stopwatch.rs"]
mod stopwatch;

use blob::{blob, pins};
use pinwarp::lattice::{Basis, Grid};
use pinwarp::solve::{Drag, PointPin, Problem, Settings, Shape, Solver};
use std::time::Instant;
use stopwatch::fastest;

/// Model, vertices, the paper's milliseconds at 5 x 5, 10 x 10, 15 x 15.
const PAPER: [(&str, usize, [f64; 3]); 6] = [
    ("ginger", 225, [3.2, 6.4, 16.4]),
    ("frog", 315, [4.4, 8.8, 25.8]),
    ("panda", 444, [6.2, 15.0, 32.2]),
    ("unicorn", 549, [6.6, 16.4, 34.0]),
    ("girl", 637, [11.8, 21.8, 43.0]),
    ("dinosaur", 734, [15.6, 26.8, 44.2]),
];
const DIMS: [usize; 3] = [5, 10, 15];

/// Moves of a drag, each by a hundredth of a radian.
const DRAG_MOVES: usize = 31;

/// Number of times that a drag is repeated.
const DRAGS: usize = 9;

fn grid(dims: usize, basis: Basis) -> Grid<2> {
    Grid { dims: [dims, dims], basis, lo: [-0.7, -0.6], hi: [0.7, 0.6], angle: 0.0 }
}

/// One row of the table of cold solves, which include all preparation.
fn cold_row(name: &str, shape: &Shape<2>, settings: &Settings, basis: Basis, paper: [f64; 3]) {
    print!("{name:9} {:4}", shape.points.len());
    for (dims, paper) in DIMS.into_iter().zip(paper) {
        let (grid, pins) = (grid(dims, basis), pins(shape, 0.6));
        let problem = Problem { grid: &grid, shape, pins: &pins, handles: &[], settings };
        let (ms, solution) = fastest(|| Solver::new(&problem).map(|solver| solver.solve()));
        let iterations = solution.map_or(0, |solution| solution.report.iterations);
        print!(" | {ms:7.3} {paper:5.1} {:5.1}x {iterations:3}", paper / ms);
    }
    println!();
}

fn cold_table(title: &str, settings: &Settings, basis: Basis) {
    println!("\n{title}: cold solve, one thread, ms | paper ms | ratio | iterations");
    println!("model       #V |        5 x 5            |       10 x 10           |       15 x 15");
    for (name, count, paper) in PAPER {
        cold_row(name, &blob(count), settings, basis, paper);
    }
}

/// Number of steps over which the time of one is averaged.
const STEPS: usize = 40;

/// Time of one local-global step of a prefactored problem: many steps minus one step, divided by their number.
fn step_row(name: &str, shape: &Shape<2>, settings: &Settings, basis: Basis, paper: [f64; 3]) {
    print!("{name:9} {:4}", shape.points.len());
    for (dims, paper) in DIMS.into_iter().zip(paper) {
        let (grid, pins) = (grid(dims, basis), pins(shape, 0.6));
        let of = |limit: usize| {
            let settings = Settings { iteration_limit: limit, tolerance: -1.0, acceleration: 0, ..settings.clone() };
            let problem = Problem { grid: &grid, shape, pins: &pins, handles: &[], settings: &settings };
            let solver = Solver::new(&problem);
            fastest(|| solver.as_ref().map(Solver::solve).ok()).0
        };
        let ms = (of(STEPS + 1) - of(1)) / STEPS as f64;
        print!(" | {:7.2} us {:5.0}x", 1e3 * ms, paper / ms);
    }
    println!();
}

fn step_table(title: &str, settings: &Settings, basis: Basis) {
    println!("\n{title}: one local-global step, prefactored, us | paper's whole solve / step");
    println!("model       #V |      5 x 5       |     10 x 10      |     15 x 15");
    for (name, count, paper) in PAPER {
        step_row(name, &blob(count), settings, basis, paper);
    }
}

/// Converged updates of a drag, with reports: medians over its moves.
fn update_row(name: &str, shape: &Shape<2>, settings: &Settings, basis: Basis) {
    print!("{name:9} {:7}", shape.points.len());
    for dims in DIMS {
        let (grid, rest) = (grid(dims, basis), pins(shape, 0.6));
        let problem = Problem { grid: &grid, shape, pins: &rest, handles: &[], settings };
        let (cold, solver) = fastest(|| Solver::new(&problem));
        let Ok(solver) = solver else { return println!("{name}: no solver") };
        let swing: Vec<_> = (0..DRAG_MOVES).map(|k| pins(shape, 0.6 + 0.01 * k as f64)).collect();
        let mut iterations = Vec::new();
        let updates = swing.iter().map(|pins| {
            fastest_of(5, || {
                let solution = solver.update(pins, &[]);
                iterations.push(solution.map_or(f64::NAN, |solution| solution.report.iterations as f64));
            })
        });
        let update = median(updates.collect());
        let follow = drag_row(&solver, &swing, |drag, pins| drag.follow(pins, &[]).is_ok());
        let settle = drag_row(&solver, &swing, |drag, pins| drag.settle(pins, &[]).is_ok());
        print!(" | {cold:7.3} {update:6.3} {:3} {settle:6.3} {follow:6.3}", median(iterations));
    }
    println!();
}

/// Time of a move when the moves of a drag follow each other: the median over the moves of the fastest of a few drags.
fn drag_row(
    solver: &Solver<2>,
    swing: &[Vec<PointPin<2>>],
    mut step: impl FnMut(&mut Drag<2>, &[PointPin<2>]) -> bool,
) -> f64 {
    let start = solver.solve().lattice;
    let mut least = vec![f64::INFINITY; swing.len()];
    for _ in 0..DRAGS {
        let Ok(mut drag) = solver.drag(&start) else { return f64::NAN };
        for (pins, least) in swing.iter().zip(&mut least) {
            *least = least.min(fastest_of(1, || assert!(step(&mut drag, pins), "the pins of the solver")));
        }
    }
    median(least)
}

/// Time of the fastest of a few runs, in milliseconds.
fn fastest_of(runs: usize, mut run: impl FnMut()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..runs).map(time).fold(f64::INFINITY, f64::min)
}

/// The median.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    let paper = Settings::paper();
    let ten = Settings { iteration_limit: 10, tolerance: -1.0, ..paper.clone() };
    let usual = Settings::default();
    cold_table("default (area, B-spline, bend), to convergence", &usual, Basis::Bspline);
    cold_table("paper preset (edge, Bernstein, rest), 10 iterations", &ten, Basis::Bernstein);
    cold_table("paper preset, to convergence", &paper, Basis::Bernstein);
    step_table("default", &usual, Basis::Bspline);
    step_table("paper preset", &paper, Basis::Bernstein);
    println!(
        "\ndefault: set-up ms, converged update from nothing ms, iterations, converged move of a drag ms, move of a drag ms"
    );
    println!("model          #V |      5 x 5                       |       10 x 10                    |       15 x 15");
    for (name, count, _) in PAPER {
        update_row(name, &blob(count), &usual, Basis::Bspline);
    }
    println!("rayon threads: {}", rayon::current_num_threads());
    update_row("million", &blob(1_000_000), &usual, Basis::Bspline);
}
