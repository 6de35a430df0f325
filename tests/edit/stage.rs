//! A shot that is small enough to be drawn in no time, and an editor on it.

use super::tiny::{Tiny, grid};
use pinwarp::edit::{Document, Held, Ring, Session};
use pinwarp::raster::DeviceChoice;
use pinwarp::space::ScreenPoint;
use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Longest that anything here may take.
pub(crate) const TIMEOUT: Duration = Duration::from_secs(60);

/// How near the pen has to be, frame heights.
pub(crate) const REACH: f64 = 0.03;

/// A folder with a scene, two parts beside each other, and a commented shot of it.
pub(crate) struct Stage {
    pub(crate) folder: TempDir,
}

/// Two pins with keys, to be put into the left layer.
pub(crate) const PINS: &str = "coarse on purpose

[[layer.pin]]
name   = \"a\"
anchor = { screen = [0.3, 0.5], frame = 1 }
keys   = [{ frame = 1, offset = [0.0, 0.0] }, { frame = 3, offset = [0.1, 0.0] }, { frame = 6, offset = [0.0, 0.0] }]

[[layer.pin]]
name   = \"b\"
anchor = { screen = [0.6, 0.5], frame = 1 }
keys   = [{ frame = 2, offset = [0.0, 0.0] }, { frame = 3, offset = [0.0, 0.1] }, { frame = 5, offset = [0.0, 0.0] }]
";

pub(crate) const SHOT: &str = "# Two cards.
version = 1
scene  = \"cards.gltf\"   # beside this file
frames = { first = 1, last = 6, rate = 24 }
size   = [96, 54]
samples = 4

[[layer]]
name    = \"left\"
nodes   = [\"Left\"]
lattice = { dims = [6, 6] }   # coarse on purpose

[[layer]]
name    = \"right\"
nodes   = [\"Right\"]
lattice = { dims = [6, 6] }

[output]
path     = \"out/frame.####.exr\"
channels = [\"beauty\"]
";

impl Stage {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let mut left = grid("Left", [-0.7, -0.3, -0.1, 0.3], 8);
        left.velocity = [0.05, 0.0, 0.0];
        let right = grid("Right", [0.1, -0.3, 0.7, 0.3], 8);
        let scene = Tiny::of(vec![left, right]).json();
        fs::write(folder.path().join("cards.gltf"), scene.to_string()).expect("written");
        fs::write(folder.path().join("shot.toml"), SHOT).expect("written");
        Self { folder }
    }

    /// A folder in which the left layer has more: [`PINS`], or handles.
    pub(crate) fn with(more: &str) -> Self {
        let stage = Self::new();
        fs::write(stage.shot(), SHOT.replacen("coarse on purpose\n", more, 1)).expect("written");
        stage
    }

    /// The folder, and an editor without a window on its shot, the first frame drawn.
    pub(crate) fn open() -> (Self, Session) {
        let stage = Self::new();
        let session = stage.session();
        (stage, session)
    }

    pub(crate) fn shot(&self) -> PathBuf {
        self.folder.path().join("shot.toml")
    }

    pub(crate) fn state(&self) -> PathBuf {
        self.folder.path().join("state")
    }

    /// The shot in an editor without a window, its first frame drawn.
    pub(crate) fn session(&self) -> Session {
        let document = Document::open(&self.shot()).expect("a shot");
        let mut session = Session::new(document, DeviceChoice::Cpu, || ());
        assert!(session.settle(TIMEOUT), "{:?}", session.fault());
        session
    }
}

/// A point of the frame, from its lower left corner.
pub(crate) fn at(x: f64, y: f64) -> ScreenPoint {
    ScreenPoint::new(x, y)
}

/// The pen goes down.
pub(crate) fn press(session: &mut Session, point: ScreenPoint) {
    // The ring is out of the way.
    session.press(point, (REACH, Ring { radius: 9.0, reach: 0.0 }), Held::default());
}

/// Drags what is at a point to another one, and waits until the frame is drawn.
pub(crate) fn drag(session: &mut Session, from: [f64; 2], to: [f64; 2]) {
    press(session, at(from[0], from[1]));
    session.motion(at(0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])));
    session.motion(at(to[0], to[1]));
    session.release();
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
}

/// Waits until something holds.
pub(crate) fn until(session: &mut Session, what: &str, holds: impl Fn(&Session) -> bool) {
    let begun = Instant::now();
    while !holds(session) {
        assert!(begun.elapsed() < TIMEOUT, "{what}: {:?} {:?}", session.fault(), session.message());
        session.pump();
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A pin on the left card, placed as a person does it.
pub(crate) fn place_pin(session: &mut Session, point: ScreenPoint) {
    let count =
        |session: &Session| session.document().shot().layers.iter().map(|layer| layer.pins.len()).sum::<usize>();
    let before = count(session);
    press(session, point);
    session.release();
    until(session, "a pin is placed", |session| count(session) == before + 1);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
}
