//! Latency and memory of the editor: opening a file to the first picture, pointer to marks and to picture, processor load at
//! rest, memory after a long session.
//!
//! Run with `cargo test --release --lib -- --ignored --nocapture --test-threads=1 edit::latency`. In: the walker and the hare at 1080p;
//! Knight.glb, if the shared assets are next to the repository or in PINWARP_SHARED; the puppet, which is a drawing; a plate
//! at 1080p; models of a million vertices. Out: printed lines.

use super::crowd;
use super::endurance::resident_bytes;
use super::tiny::{Tiny, grid};
use pinwarp::edit::{Document, Held, Ring, Session, open};
use pinwarp::image::{Channel, Frame, Plate, Storage, write_plate};
use pinwarp::raster::DeviceChoice;
use pinwarp::scene::FileAccess;
use pinwarp::space::{FrameSize, ScreenPoint};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

const TIMEOUT: Duration = Duration::from_secs(180);

/// Pointer moves of a drag.
const MOVES: usize = 60;

/// Drags of the long session; some are undone.
const ROUNDS: usize = 240;

/// Duration of the measurement at rest.
const REST: Duration = Duration::from_secs(5);

#[test]
#[ignore = "measures, and needs a quiet machine"]
fn scenes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let walker = root.join("scenes/walker/shot.toml");
    let text = std::fs::read_to_string(&walker).expect("a bundled scene");
    let text = text.replace("size    = [1280, 720]", "size    = [1920, 1080]");
    assert!(text.contains("1920"), "the shot says its size as it did");
    measure("walker, 1920 x 1080", || Document::new(&walker, text.clone()).expect("a shot"));
    let hare = root.join("scenes/hare/shot.toml");
    let in_scene = std::fs::read_to_string(&hare).expect("a bundled scene").replace("[960, 960]", "[1080, 1080]");
    measure("hare, 1080 x 1080", || Document::new(&hare, in_scene.clone()).expect("a shot"));
    let shared = std::env::var_os("PINWARP_SHARED").map_or_else(|| root.join("../shared"), PathBuf::from);
    if let Some(knight) = find(&shared.join("assets"), "Knight.glb") {
        measure("Knight.glb, 1920 x 1080", || open(&knight, FileAccess::SceneFolder).expect("a scene"));
    }
    work("walker, 640 x 360", || Document::new(&walker, text.replace("1920, 1080", "640, 360")).expect("a shot"));
}

/// A plate of one frame, and the puppet, which is a drawing.
#[test]
#[ignore = "measures, and needs a quiet machine"]
fn drawings_and_plates() {
    let folder = tempfile::tempdir().expect("a folder");
    write_plate(&folder.path().join("plate.0001.exr"), &plate(FrameSize::new(1920, 1080))).expect("written");
    let plates = folder.path().join("plate.####.exr");
    measure("plate, 1920 x 1080", || open(&plates, FileAccess::SceneFolder).expect("plates"));
    let puppet = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/puppet/shot.toml");
    measure("puppet, a drawing of 640 x 960", || Document::open(&puppet).expect("a shot"));
}

/// Models of a million vertices: one that moves as a whole, as text, and one that joints bend, binary.
#[test]
#[ignore = "measures, and needs a quiet machine"]
fn large_models() {
    let folder = tempfile::tempdir().expect("a folder");
    let [plane, ball] = ["plane.gltf", "ball.glb"].map(|name| folder.path().join(name));
    let scene = Tiny::of(vec![grid("Plane", [-0.7, -0.4, 0.7, 0.4], 1000)]).json();
    std::fs::write(&plane, scene.to_string()).expect("written");
    drag_at_once("a flat million vertices, 1920 x 1080", || open(&plane, FileAccess::SceneFolder).expect("a scene"));
    std::fs::write(&ball, crowd::ball(1000, 1000)).expect("written");
    drag_at_once("a bent million vertices, 1920 x 1080", || open(&ball, FileAccess::SceneFolder).expect("a scene"));
}

/// A plate in half floats: soft waves of colour, opaque.
fn plate(size: FrameSize) -> Plate {
    let window = size.window();
    let wave = |name: &str, [across, up]: [f32; 2]| {
        let sample = |index: usize| {
            let [x, y] = window.pixel_at(index).map(|place| place as f32);
            0.5 + 0.4 * (x * across).sin() * (y * up).cos()
        };
        let samples = (0..window.area()).map(sample).collect();
        Channel { name: name.into(), storage: Storage::Half, samples }
    };
    let mut channels: Vec<Channel> =
        [("R", [0.02, 0.03]), ("G", [0.11, 0.01]), ("B", [0.005, 0.2])].map(|(name, by)| wave(name, by)).into();
    channels.push(Channel { name: "A".into(), storage: Storage::Half, samples: vec![1.0; window.area()] });
    Plate::from_frame(Frame { display: window, data_window: window, pixel_aspect: size.pixel_aspect, channels })
}

fn find(folder: &Path, name: &str) -> Option<PathBuf> {
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if path.file_name().is_some_and(|other| other == name) {
                return Some(path);
            }
        }
    }
    None
}

/// Waits until `find` returns something.
fn wait<T>(session: &mut Session, find: impl Fn(&Session) -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        session.pump();
        if let Some(found) = find(session) {
            return found;
        }
        assert!(begun.elapsed() < TIMEOUT, "{:?}", session.fault());
        std::thread::sleep(Duration::from_micros(100));
    }
}

fn ms(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// A ring that cannot be grabbed.
const RING: Ring = Ring { radius: 9.0, reach: 0.0 };

/// The target of a pin that can be dragged; places one if the shot has none.
fn pin(session: &mut Session) -> ScreenPoint {
    if let Some(pin) = session.marks().iter().flat_map(|marks| &marks.pins).next() {
        return pin.target;
    }
    let aspect = session.shot().size.aspect();
    session.press(ScreenPoint::new(0.5 * aspect, 0.55), (0.01, RING), Held::default());
    session.release();
    wait(session, |session| session.selection.single_pin());
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    session.marks()[0].pins[0].target
}

fn measure(name: &str, document: impl Fn() -> Document) {
    let begun = Instant::now();
    let mut session = Session::new(document(), DeviceChoice::Cpu, || ());
    wait(&mut session, |session| session.picture().map(|_| ()));
    println!("{name}: open to the first picture {:.0} ms", ms(begun));
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    println!("{name}: open to the rendered frame {:.0} ms", ms(begun));
    let from = pin(&mut session);
    let (marks, pictures) = drag(&mut session, from);
    let size = session.picture().map_or([0, 0], |picture| picture.size);
    let released = Instant::now();
    session.release();
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    println!("{name}: pointer to marks {}", spread(marks));
    println!("{name}: pointer to picture {}, {} x {}", spread(pictures), size[0], size[1]);
    println!("{name}: release to the rendered frame {:.0} ms", ms(released));
    wait(&mut session, |session| session.is_idle().then_some(()));
    if let Some(before) = processor_secs() {
        std::thread::sleep(REST);
        let spent = processor_secs().unwrap_or(before) - before;
        println!("{name}: at rest {:.1} % of a core", 100.0 * spent / REST.as_secs_f64());
    }
}

/// Drags a pin; returns the milliseconds from each move to new marks and to a new picture. The button stays pressed.
fn drag(session: &mut Session, from: ScreenPoint) -> (Vec<f64>, Vec<f64>) {
    session.press(from, (0.01, RING), Held::default());
    let (mut marks, mut pictures) = (Vec::new(), Vec::new());
    for step in 1..=MOVES {
        let (old_marks, old_picture) = (session.solve().map(Arc::clone), session.picture().map(Arc::clone));
        let begun = Instant::now();
        let far = 0.1 * step as f64 / MOVES as f64;
        session.motion(ScreenPoint::new(from.0.x + far, from.0.y + 0.5 * far));
        wait(session, |session| {
            let is_old = session.solve().zip(old_marks.as_ref()).is_some_and(|(new, old)| Arc::ptr_eq(new, old));
            (!is_old).then_some(())
        });
        marks.push(ms(begun));
        wait(session, |session| {
            let is_old = session.picture().zip(old_picture.as_ref()).is_some_and(|(new, old)| Arc::ptr_eq(new, old));
            (!is_old).then_some(())
        });
        pictures.push(ms(begun));
    }
    (marks, pictures)
}

/// Measures a model that is too large to wait for its frames: the drag begins as soon as there is a pin.
fn drag_at_once(name: &str, document: impl Fn() -> Document) {
    let begun = Instant::now();
    let mut session = Session::new(document(), DeviceChoice::Cpu, || ());
    wait(&mut session, |session| session.picture().map(|_| ()));
    println!("{name}: open to the first picture {:.0} ms", ms(begun));
    let aspect = session.shot().size.aspect();
    session.press(ScreenPoint::new(0.5 * aspect, 0.55), (0.01, RING), Held::default());
    session.release();
    let seen = |session: &Session| session.marks().iter().flat_map(|marks| &marks.pins).next().map(|pin| pin.target);
    let from = wait(&mut session, seen);
    let (marks, pictures) = drag(&mut session, from);
    let size = session.picture().map_or([0, 0], |picture| picture.size);
    println!("{name}: pointer to marks {}", spread(marks));
    println!("{name}: pointer to picture {}, {} x {}", spread(pictures), size[0], size[1]);
}

/// A long session on many frames: pins are dragged, some drags are undone, frames are rendered.
fn work(name: &str, document: impl Fn() -> Document) {
    let mut session = Session::new(document(), DeviceChoice::Cpu, || ());
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    let begun = Instant::now();
    let [first, last] = session.playhead.shot_range();
    let mut told = Vec::new();
    for round in 0..ROUNDS {
        session.go(first + (7 * round as i32).rem_euclid(last - first + 1));
        assert!(session.settle(TIMEOUT), "{:?}", session.fault());
        let from = pin(&mut session);
        session.press(from, (0.01, RING), Held::default());
        for step in 1..=8 {
            let far = 0.01 * f64::from(step);
            session.motion(ScreenPoint::new(from.0.x + far, from.0.y - 0.5 * far));
            wait(&mut session, |session| session.solve().map(|_| ()));
        }
        session.release();
        assert!(session.settle(TIMEOUT), "{:?}", session.fault());
        if round % 3 > 0 {
            session.undo();
        }
        if (round + 1) % (ROUNDS / 4) == 0 {
            told.extend(resident_bytes().map(|bytes| format!("{:.0}", bytes / 1048576.0)));
        }
    }
    println!("{name}: {ROUNDS} drags in {:.0} s; memory after each quarter {} MiB", ms(begun) / 1e3, told.join(", "));
}

/// Processor time of this process over all cores, in seconds; `None` if the system does not provide it.
fn processor_secs() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |place: usize| fields.get(place)?.parse::<f64>().ok();
    // On Linux clock ticks are hundredths of a second.
    Some((ticks(11)? + ticks(12)?) / 100.0)
}

/// Median and 95th percentile, without the first move, which prepares the solver and is given separately.
fn spread(mut times: Vec<f64>) -> String {
    let first = times.remove(0);
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
    format!("{:.1} ms (median), {:.1} ms (95 %), first {first:.1} ms", at(0.5), at(0.95))
}
