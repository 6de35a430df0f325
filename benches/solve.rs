//! Time of solves, printed as tables: `cargo bench --bench solve`.
//!
//! In: generated blobs with the vertex counts of the paper's time table. Out: milliseconds beside the paper's
//! (column "Ours", a 1.5 GHz laptop), cold solves on one thread; drag updates; a model of a million vertices.

use pinwarp::lattice::{Basis, Grid};
use pinwarp::solve::{PointPin, Problem, Settings, Shape, Solver};
use std::hint::black_box;
use std::time::Instant;

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

/// Moves of a drag, each a hundredth of a radian.
const DRAG_MOVES: usize = 31;

/// A wavy blob of exactly `count` vertices: rows of a square grid, bent, the last row cut short.
fn blob(count: usize) -> Shape<2> {
    let width = (count as f64).sqrt().ceil() as usize;
    let height = count.div_ceil(width);
    let place = |k: usize| {
        let (u, v) = ((k % width) as f64 / (width - 1) as f64 - 0.5, (k / width) as f64 / (height - 1) as f64 - 0.5);
        let waist = 0.55 + 0.35 * (9.0 * v).cos();
        [u * waist + 0.08 * (7.0 * v).sin(), v * (0.9 - 0.5 * u * u)]
    };
    let mut triangles = Vec::new();
    for k in (0..count).filter(|k| k % width + 1 < width && k + width + 1 < count) {
        let corners = [k, k + 1, k + width, k + width + 1].map(|corner| corner as u32);
        triangles.extend([[corners[0], corners[1], corners[3]], [corners[0], corners[3], corners[2]]]);
    }
    Shape::of_triangles((0..count).map(place).collect(), triangles)
}

/// Six pins; `turn` (radians) swings the upper ones, as a dragging hand does.
fn pins(shape: &Shape<2>, turn: f64) -> Vec<PointPin<2>> {
    let count = shape.points.len();
    let at = |k: usize| shape.points[k * (count - 1) / 5];
    (0..6)
        .map(|k| {
            let at = at(k);
            let (sin, cos) = if k >= 3 { turn.sin_cos() } else { (0.0, 1.0) };
            let target = [cos * at[0] - sin * at[1], sin * at[0] + cos * at[1] + 0.05 * turn];
            PointPin::new(at, target)
        })
        .collect()
}

fn grid(dims: usize, basis: Basis) -> Grid<2> {
    Grid { dims: [dims, dims], basis, lo: [-0.7, -0.6], hi: [0.7, 0.6] }
}

/// Time of the fastest run in milliseconds (other work on the machine only adds), and what the last one gave.
fn fastest<T>(mut run: impl FnMut() -> T) -> (f64, T) {
    let mut last = run();
    let mut times = Vec::new();
    let begin = Instant::now();
    while times.len() < 5 || (begin.elapsed().as_secs_f64() < 0.5 && times.len() < 400) {
        let start = Instant::now();
        last = black_box(run());
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    (times.into_iter().fold(f64::INFINITY, f64::min), last)
}

/// One row of the cold table: whole solves from nothing.
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

/// Set-up and drag updates at 15 x 15.
fn drag_row(name: &str, shape: &Shape<2>, settings: &Settings, basis: Basis) {
    let (grid, rest) = (grid(15, basis), pins(shape, 0.6));
    let problem = Problem { grid: &grid, shape, pins: &rest, handles: &[], settings };
    let (cold, solver) = fastest(|| Solver::new(&problem));
    let Ok(solver) = solver else { return println!("{name}: no solver") };
    let swing: Vec<_> = (0..DRAG_MOVES).map(|k| pins(shape, 0.6 + 0.01 * k as f64)).collect();
    let timed = |run: &mut dyn FnMut(&[PointPin<2>])| {
        let time = |pins: &Vec<PointPin<2>>| {
            let start = Instant::now();
            run(pins);
            start.elapsed().as_secs_f64() * 1e3
        };
        median(swing.iter().map(time).collect())
    };
    let mut iterations = Vec::new();
    let update_ms = timed(&mut |pins| {
        iterations.push(solver.update(pins, &[]).map_or(0.0, |solution| solution.report.iterations as f64));
    });
    let mut lattice = solver.solve().lattice;
    let drag_ms = timed(&mut |pins| {
        if let Ok(next) = solver.drag(pins, &[], &lattice) {
            lattice = next;
        }
    });
    let settled = solver.update(&swing[DRAG_MOVES - 1], &[]).map(|solution| solution.lattice.handles);
    let gap = |other: Vec<[f64; 2]>| {
        let gaps = lattice.handles.iter().zip(other).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
        gaps.fold(0.0, f64::max)
    };
    println!(
        "{name:22} {:8} vertices: set-up {cold:8.3} ms, update {update_ms:6.3} ms ({:3} iterations), drag {drag_ms:6.3} ms \
         ({:.0e} behind)",
        shape.points.len(),
        median(iterations),
        settled.map_or(f64::NAN, gap)
    );
}

/// The middle value.
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
    println!("\n15 x 15, prefactored (rayon threads: {})", rayon::current_num_threads());
    for (name, count, _) in PAPER {
        drag_row(&format!("default {name}"), &blob(count), &usual, Basis::Bspline);
    }
    drag_row("paper, 10 iterations", &blob(734), &ten, Basis::Bernstein);
    drag_row("paper, converged", &blob(734), &paper, Basis::Bernstein);
    drag_row("default", &blob(1_000_000), &usual, Basis::Bspline);
}
