//! Whole renders: overlap of the stages, and growth of memory.
//!
//! Run with `cargo bench --bench frame`. Prints the memory of a long render after its first frames and at its end; then, for
//! each scene, the busy time of every stage, the wall time, and its ratio to the slowest stage; then the drawn girl, whose parts
//! have handles of their own, and the ratio of her frames to those of a plain lattice with as many handles.

use pinwarp::pipeline::{Event, Existing, PreparedShot, RenderOptions, Summary, render};
use pinwarp::raster::DeviceChoice;
use pinwarp::shot::Shot;
use pinwarp::solve::Topology;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

/// Frames of the long render.
const LONG: i32 = 200;

/// Frames after which its memory is first read.
const WARM_UP: usize = 20;

fn main() {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    // This runs first, while the process holds no other memory.
    if let Some(prepared) = prepared("teapot", folder.path(), 4) {
        let memory = Mutex::new(Vec::new());
        let look = |event: Event| {
            if matches!(event, Event::FrameDone(_)) {
                memory.lock().expect("no panic holds it").push(resident_mib());
            }
        };
        run(&prepared, (1..=LONG).collect(), DeviceChoice::Cpu, &look);
        let memory = memory.into_inner().expect("no panic holds it");
        let late = memory[WARM_UP..].iter().fold(0.0, |a: f64, &b| a.max(b));
        println!(
            "resident memory of {LONG} frames: {:.0} MiB after {WARM_UP}, {late:.0} MiB at most later\n",
            memory[WARM_UP]
        );
    }
    println!(
        "{:<28} {:>9} {:>9} {:>9} {:>9} {:>12}",
        "scene, device", "geometry", "raster", "write", "wall", "wall/slowest"
    );
    for scene in ["teapot", "gingerman", "walker"] {
        for (name, device) in [("cpu", DeviceChoice::Cpu), ("auto", DeviceChoice::Auto)] {
            let Some(prepared) = prepared(scene, folder.path(), 1) else { continue };
            let frames = (prepared.shot.frames.first..=prepared.shot.frames.last).take(12).collect();
            let summary = run(&prepared, frames, device, &|_| {});
            print_row(&format!("{scene}, {name}"), &summary);
        }
    }
    compare_topologies(folder.path());
}

/// Prints a picture's frames with a branching and with a plain lattice of the same dims, and their ratio.
fn compare_topologies(folder: &Path) {
    let Some(automatic) = prepared("puppet", folder, 1) else { return };
    let wall_secs = [Topology::Branching, Topology::Plain].map(|topology| {
        let mut shot = automatic.shot.clone();
        shot.layers[0].has_auto_dims = false;
        shot.layers[0].settings.topology = topology;
        let prepared = PreparedShot::new(shot).expect("the scenes of the repository fit their shots");
        let frames: Vec<i32> = (prepared.shot.frames.first..=prepared.shot.frames.last).collect();
        // The first run solves the layer over time.
        let summaries = [0, 1].map(|_| run(&prepared, frames.clone(), DeviceChoice::Cpu, &|_| {}));
        print_row(&format!("puppet, {topology:?}, and its solve"), &summaries[0]);
        print_row(&format!("puppet, {topology:?}, frames"), &summaries[1]);
        summaries.map(|summary| summary.wall_secs)
    });
    let [branching, plain] = wall_secs;
    let ratio = |run: usize| branching[run] / plain[run];
    println!("puppet, branching to plain: {:.2} with the solve, {:.2} without", ratio(0), ratio(1));
}

/// A scene of the repository, prepared with its size divided by `shrink`; its frames go to `folder`.
fn prepared(scene: &str, folder: &Path, shrink: u32) -> Option<PreparedShot> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene).join("shot.toml");
    let mut shot = match Shot::read(&path) {
        Ok(shot) => shot,
        Err(error) => {
            println!("SKIPPED: {error}");
            return None;
        }
    };
    shot.size.width /= shrink;
    shot.size.height /= shrink;
    shot.output.path = folder.join("frame.####.exr");
    Some(PreparedShot::new(shot).expect("the scenes of the repository fit their shots"))
}

fn run(prepared: &PreparedShot, frames: Vec<i32>, device: DeviceChoice, look: &(dyn Fn(Event) + Sync)) -> Summary {
    let options = RenderOptions { frames, device, existing: Existing::Overwrite, ..RenderOptions::default() };
    render(prepared, &options, &AtomicBool::new(false), look).expect("the scenes of the repository render")
}

fn print_row(name: &str, summary: &Summary) {
    let slowest_ms = summary.geometry_ms.max(summary.raster_ms).max(summary.write_ms);
    let wall_ms = summary.wall_secs * 1e3;
    println!(
        "{name:<28} {:>6.0} ms {:>6.0} ms {:>6.0} ms {wall_ms:>6.0} ms {:>12.2}",
        summary.geometry_ms,
        summary.raster_ms,
        summary.write_ms,
        wall_ms / slowest_ms
    );
}

/// Resident memory of this process; 0 if the system does not provide it.
fn resident_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kib = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<f64>().ok());
    kib.unwrap_or(0.0) / 1024.0
}
