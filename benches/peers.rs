//! Times relative to public packages, measured in one run: `cargo bench --bench peers`.
//!
//! Needs Python 3 with numpy, scipy and libigl, and bpy for Blender's lattice (`PYTHON` names another interpreter); prints a
//! message if they are missing. In: the blobs of the solve bench. Out: milliseconds of both sides and their ratio.

#[path = "support/blob.rs"]
mod blob;
#[path = "support/stopwatch.rs"]
mod stopwatch;

use blob::{blob, pins};
use pinwarp::lattice::{Basis, DisplayWarp, Grid};
use pinwarp::solve::{Problem, Settings, Shape, solve};
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::Command;
use stopwatch::fastest;

/// Number of points of the forward deformation; they form a square.
const POINTS: usize = 1_000_000;

/// A problem file and pinwarp's milliseconds for it.
struct Case {
    name: String,
    path: PathBuf,
    paper_ms: f64,
    default_ms: f64,
    handles: Vec<[f64; 2]>,
}

fn write(name: &str, shape: &Shape<2>, grid: &Grid<2>, folder: &std::path::Path) -> PathBuf {
    let vertex = |at: [f64; 2]| shape.points.iter().position(|point| *point == at);
    let pins: Vec<Value> =
        pins(shape, 0.6).iter().map(|pin| json!({ "vertex": vertex(pin.at), "target": pin.target })).collect();
    let problem = json!({
        "vertices": shape.points, "triangles": shape.triangles, "dims": grid.dims, "bbox": [grid.lo, grid.hi],
        "pins": pins,
    });
    let path = folder.join(format!("{name}.json"));
    std::fs::write(&path, problem.to_string()).expect("the temporary folder can be written to");
    path
}

fn case(count: usize, dims: usize, folder: &std::path::Path) -> Case {
    let name = format!("{count}-{dims}");
    let (shape, pins) = (blob(count), pins(&blob(count), 0.6));
    let grid = |basis| Grid { dims: [dims, dims], basis, lo: [-0.7, -0.6], hi: [0.7, 0.6], angle: 0.0 };
    let paper = Settings { iteration_limit: 10, tolerance: -1.0, ..Settings::paper() };
    let timed = |grid: &Grid<2>, settings: &Settings| {
        let problem = Problem { grid, shape: &shape, pins: &pins, handles: &[], settings };
        fastest(|| solve(&problem).expect("a valid problem").lattice.handles)
    };
    let (paper_ms, handles) = timed(&grid(Basis::Bernstein), &paper);
    let (default_ms, _) = timed(&grid(Basis::Bspline), &Settings::default());
    Case { path: write(&name, &shape, &grid(Basis::Bernstein), folder), name, paper_ms, default_ms, handles }
}

/// Milliseconds of pinwarp's forward deformation on all threads.
fn display_ms() -> f64 {
    let lattice =
        Grid { dims: [15, 15], basis: Basis::Bspline, lo: [-0.5, -0.5], hi: [0.5, 0.5], angle: 0.0 }.at_rest();
    let warp = DisplayWarp::new(&lattice);
    let side = POINTS.isqrt();
    let place = |k: usize| [k % side, k / side].map(|x| 0.98 * x as f32 / side as f32 - 0.49);
    let mut points: Vec<[f32; 2]> = (0..side * side).map(place).collect();
    fastest(|| warp.warp(&mut points)).0
}

/// The output of the Python script; `None` if it fails.
fn peers(cases: &[Case]) -> Option<Value> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/peers.py");
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let mut command = Command::new(python);
    command.arg(script).arg(POINTS.to_string()).args(cases.iter().map(|case| &case.path));
    let output = command.output().ok()?;
    if !output.status.success() {
        eprintln!("{}", String::from_utf8_lossy(&output.stderr));
        return None;
    }
    serde_json::from_str(String::from_utf8_lossy(&output.stdout).lines().last()?).ok()
}

fn main() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let sizes = [225, 734].into_iter().flat_map(|count| [10, 15].map(|dims| (count, dims)));
    let cases: Vec<Case> = sizes.map(|(count, dims)| case(count, dims, folder.path())).collect();
    let display = display_ms();
    let Some(answer) = peers(&cases) else {
        return println!("SKIPPED: no peers; pip install numpy scipy libigl bpy, and name the interpreter in PYTHON");
    };
    println!(
        "cold, ms         ours, paper preset | same solve in scipy | ratio | gap of handles | ours, default | libigl ARAP"
    );
    for (case, peer) in cases.iter().zip(answer["problems"].as_array().into_iter().flatten()) {
        let number = |key: &str| peer[key].as_f64().unwrap_or(f64::NAN);
        let theirs: Vec<[f64; 2]> = serde_json::from_value(peer["handles"].clone()).unwrap_or_default();
        let gaps = case.handles.iter().zip(&theirs).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
        println!(
            "{:16} {:18.3} | {:19.2} | {:4.0}x | {:14.0e} | {:13.3} | {:11.3}",
            case.name,
            case.paper_ms,
            number("scipy_ms"),
            number("scipy_ms") / case.paper_ms,
            gaps.fold(f64::NAN, f64::max),
            case.default_ms,
            number("libigl_ms"),
        );
    }
    let blender = answer["blender_ms"].as_f64().unwrap_or(f64::NAN);
    println!(
        "forward FFD of {POINTS} points, 15 x 15: ours {display:.1} ms, Blender {blender:.1} ms, {:.1}x",
        blender / display
    );
}
