//! What the editor takes under the hand: from a file to its first picture, from the pointer to new marks and to a new picture.
//!
//! `cargo bench --bench edit`. The walker at 1080p; Knight.glb where the shared assets lie beside the repository.

use pinwarp::edit::{Document, Held, Ring, Session, open};
use pinwarp::raster::DeviceChoice;
use pinwarp::scene::FileAccess;
use pinwarp::space::ScreenPoint;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(120);

/// Moves of the pen in a drag.
const MOVES: usize = 60;

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let walker = root.join("scenes/walker/shot.toml");
    let text = std::fs::read_to_string(&walker).expect("a bundled scene");
    let text = text.replace("size    = [1280, 720]", "size    = [1920, 1080]");
    measure("walker, 1920 x 1080", || Document::new(&walker, text.clone()).expect("a shot"));
    if let Some(knight) = find(&root.join("../shared/assets"), "Knight.glb") {
        measure("Knight.glb, 1920 x 1080", || open(&knight, FileAccess::SceneFolder).expect("a scene"));
    }
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

/// Waits until something is there.
fn wait<T>(session: &mut Session, find: impl Fn(&Session) -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        session.pump();
        if let Some(found) = find(session) {
            return found;
        }
        assert!(begun.elapsed() < PATIENCE, "{:?}", session.fault());
        std::thread::sleep(Duration::from_micros(100));
    }
}

fn ms(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

fn measure(name: &str, document: impl Fn() -> Document) {
    let begun = Instant::now();
    let mut session = Session::new(document(), DeviceChoice::Cpu, || ());
    wait(&mut session, |session| session.picture().map(|_| ()));
    println!("{name}: open to the first picture {:.0} ms", ms(begun));
    assert!(session.settle(PATIENCE), "{:?}", session.fault());
    println!("{name}: open to the rendered frame {:.0} ms", ms(begun));
    let ring = Ring { radius: 9.0, reach: 0.0 };
    let from = match session.marks().iter().flat_map(|marks| &marks.pins).next() {
        Some(pin) => pin.target,
        None => {
            let aspect = session.shot().size.aspect();
            session.press(ScreenPoint::new(0.5 * aspect, 0.55), (0.01, ring), Held::default());
            session.release();
            wait(&mut session, |session| session.selection.single_pin());
            assert!(session.settle(PATIENCE), "{:?}", session.fault());
            session.marks()[0].pins[0].target
        }
    };
    session.press(from, (0.01, ring), Held::default());
    let (mut marks, mut pictures) = (Vec::new(), Vec::new());
    for step in 1..=MOVES {
        let (old_marks, old_picture) = (session.solve().map(Arc::clone), session.picture().map(Arc::clone));
        let begun = Instant::now();
        let far = 0.1 * step as f64 / MOVES as f64;
        session.motion(ScreenPoint::new(from.0.x + far, from.0.y + 0.5 * far));
        wait(&mut session, |session| {
            let is_old = session.solve().zip(old_marks.as_ref()).is_some_and(|(new, old)| Arc::ptr_eq(new, old));
            (!is_old).then_some(())
        });
        marks.push(ms(begun));
        wait(&mut session, |session| {
            let is_old = session.picture().zip(old_picture.as_ref()).is_some_and(|(new, old)| Arc::ptr_eq(new, old));
            (!is_old).then_some(())
        });
        pictures.push(ms(begun));
    }
    let size = session.picture().map_or([0, 0], |picture| picture.size);
    let released = Instant::now();
    session.release();
    assert!(session.settle(PATIENCE), "{:?}", session.fault());
    println!("{name}: pointer to marks {}", spread(marks));
    println!("{name}: pointer to picture {}, {} x {}", spread(pictures), size[0], size[1]);
    println!("{name}: release to the rendered frame {:.0} ms", ms(released));
}

/// Median and worst; the first of a drag prepares the solver.
fn spread(mut times: Vec<f64>) -> String {
    let first = times.remove(0);
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
    format!("{:.1} ms (median), {:.1} ms (95 %), first {first:.1} ms", at(0.5), at(0.95))
}
