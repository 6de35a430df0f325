//! Long sequences of plates: memory does not grow, every frame depends on itself alone.
//!
//! A program of its own, so that no other test uses memory beside it.

#[path = "support/skip.rs"]
mod skip;

use pinwarp::image::{Channel, Frame, Plate, Storage, write_plate};
use pinwarp::pipeline::{Existing, PlateWarp, PreparedShot, WarpDirection, WarpJob, warp_frames};
use pinwarp::plate::WarpSettings;
use pinwarp::raster::DeviceChoice;
use pinwarp::shot::Shot;
use pinwarp::space::FrameSize;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use tempfile::TempDir;

const SHOT: &str = "plate = 'p.####.exr'\nframes = { first = 1, last = 60 }\nsize = [320, 180]\n\
    [[layer]]\nlattice = { dims = [6, 6] }\n[[layer.pin]]\nanchor = { screen = [0.9, 0.5] }\n\
    keys = [{ frame = 1, offset = [0.0, 0.0] }, { frame = 60, offset = [0.2, 0.1] }]\n";

/// Megabytes a plate of eight channels takes.
const PLATE_MB: f64 = 320.0 * 180.0 * 8.0 * 4.0 / 1e6;

/// One plate for all frames, in a folder.
fn studio() -> (TempDir, PreparedShot) {
    let folder = TempDir::new().expect("a folder");
    let window = FrameSize::new(320, 180).window();
    let names = ["R", "G", "B", "A", "depth.Z", "forward.u", "forward.v", "P.X"];
    let sample = |k: usize, c: usize| ((k % 97) as f32).mul_add(0.01, c as f32);
    let channel = |(c, name): (usize, &&str)| Channel {
        name: (*name).into(),
        storage: Storage::Float,
        samples: (0..window.area()).map(|k| sample(k, c)).collect(),
    };
    let channels = names.iter().enumerate().map(channel).collect();
    let plate = Plate::from_frame(Frame { display: window, data_window: window, pixel_aspect: 1.0, channels });
    write_plate(&folder.path().join("p.exr"), &plate).expect("written");
    let prepared =
        PreparedShot::new(Shot::parse(SHOT, Path::new("shot.toml")).expect("a right shot")).expect("a plate's shot");
    (folder, prepared)
}

fn warp(folder: &Path, prepared: &PreparedShot, output: &str, frames: Vec<i32>, tell: &(dyn Fn() + Sync)) {
    let job = WarpJob {
        plate: folder.join("p.exr"),
        output: folder.join(output),
        warp: PlateWarp::Shot(prepared),
        settings: WarpSettings::default(),
        direction: WarpDirection::Forward,
        layers: Vec::new(),
        frames,
        existing: Existing::Refuse,
        device: DeviceChoice::Cpu,
        durability: pinwarp::image::Durability::Cached,
        inputs: Vec::new(),
    };
    let summary = warp_frames(&job, &AtomicBool::new(false), &|_| tell()).expect("warped");
    assert_eq!(summary.failed, 0);
}

/// Megabytes that this process holds now; `None` where the system does not tell.
fn resident_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.trim().trim_end_matches("kB").trim().parse::<f64>().ok()? / 1e3)
}

#[test]
fn memory_does_not_grow_with_the_length_of_a_sequence() {
    let (folder, prepared) = studio();
    let seen = std::sync::Mutex::new(Vec::new());
    let tell = || seen.lock().expect("nothing panics here").extend(resident_mb());
    warp(folder.path(), &prepared, "w.####.exr", Vec::new(), &tell);
    let seen = seen.into_inner().expect("all threads ended");
    if seen.is_empty() {
        skip::skip("the system does not tell how much memory is used");
        return;
    }
    let peak = |range: &[f64]| range.iter().copied().fold(0.0, f64::max);
    let (early, late) = (peak(&seen[10..25]), peak(&seen[45..]));
    eprintln!("{early:.0} MB in frames 10 to 25, {late:.0} MB from 45 on; a plate is {PLATE_MB:.1} MB");
    assert!(late < early + 4.0 * PLATE_MB, "{early:.0} MB grew to {late:.0} MB");
}

#[test]
fn a_frame_does_not_depend_on_its_neighbours() {
    let (folder, prepared) = studio();
    let path = |name: &str| folder.path().join(name);
    warp(folder.path(), &prepared, "a.####.exr", vec![40, 41, 42], &|| ());
    warp(folder.path(), &prepared, "b.####.exr", vec![42], &|| ());
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    one_thread.install(|| warp(folder.path(), &prepared, "c.####.exr", vec![42, 1], &|| ()));
    let [a, b, c] = ["a.0042.exr", "b.0042.exr", "c.0042.exr"].map(|name| std::fs::read(path(name)).expect("a frame"));
    assert!(a == b && a == c, "the same bytes, alone or among others, on any number of threads");
}
