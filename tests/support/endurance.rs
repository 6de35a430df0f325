//! A long editing session as a script: edits of all kinds on a small shot, and the memory of the process over them.
//!
//! In: how long it goes on. Out: printed memory; its slope by a straight line through what follows the warm-up, which must
//! not exceed a bound. Every second round takes back what the one before did, so the shot itself does not grow.

use super::tiny::{Tiny, grid};
use pinwarp::edit::{Document, EasePreset, Held, PinPart, Ring, Session};
use pinwarp::raster::DeviceChoice;
use pinwarp::shot::edit::Setting;
use pinwarp::space::ScreenPoint;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Bytes by which an edit may raise the memory. Each one stays in the undo history with the text that it replaced.
const BYTES_PER_EDIT: f64 = 4096.0;

/// Largest expected scatter of the memory about the line, in bytes: it blurs the slope of short sessions.
const SCATTER: f64 = 3e5;

/// Number of edits of a round, one of each kind.
const KINDS: usize = 20;

/// Fraction of the session that is its warm-up.
const WARM_UP: f64 = 0.35;

const TIMEOUT: Duration = Duration::from_secs(180);

/// A ring that cannot be grabbed.
const RING: Ring = Ring { radius: 9.0, reach: 0.0 };

const FRAMES: usize = 6;

const SHOT: &str = "version = 1
scene = \"cards.gltf\"
frames = { first = 1, last = 6 }
size = [96, 54]
samples = 1

[[layer]]
name = \"left\"
nodes = [\"Left\"]
lattice = { dims = [5, 5] }

[[layer]]
name = \"right\"
nodes = [\"Right\"]
lattice = { dims = [5, 5] }
";

/// An editor under a script.
pub(crate) struct Endurance {
    session: Session,
    _folder: TempDir,
}

impl Endurance {
    /// Opens the shot and places the pins that are edited.
    pub(crate) fn begin() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let cards = [grid("Left", [-0.7, -0.3, -0.1, 0.3], 8), grid("Right", [0.1, -0.3, 0.7, 0.3], 8)];
        std::fs::write(folder.path().join("cards.gltf"), Tiny::of(cards.into()).json().to_string()).expect("written");
        let document = Document::new(&folder.path().join("shot.toml"), SHOT.to_owned()).expect("a shot");
        let mut endurance = Self { session: Session::new(document, DeviceChoice::Cpu, || ()), _folder: folder };
        endurance.settle();
        for x in [0.3, 0.6] {
            endurance.place(ScreenPoint::new(x, 0.5));
        }
        endurance
    }

    /// Edits until `goes_on` refuses the number of edits done, and returns the memory meanwhile. `reports`: after how many
    /// edits the memory is looked at, at least.
    pub(crate) fn run(&mut self, reports: usize, goes_on: impl Fn(usize) -> bool) -> Growth {
        let (begun, mut growth, mut edit) = (Instant::now(), Growth::default(), 0);
        let between = reports.next_multiple_of(KINDS).max(KINDS);
        while goes_on(edit) {
            self.edit(edit);
            edit += 1;
            if edit.is_multiple_of(between) {
                self.rest();
                let Some(bytes) = resident_bytes() else { return growth };
                growth.seen.push([edit as f64, bytes]);
                let (changes, secs) = (self.session.document().history().labels().count(), begun.elapsed().as_secs());
                println!("{edit} edits in {secs} s: {:.1} MiB, {changes} changes to undo", bytes / 1048576.0);
            }
        }
        growth
    }

    /// Waits for the rendered frame.
    fn settle(&mut self) {
        assert!(self.session.settle(TIMEOUT), "{:?}", self.session.fault());
    }

    fn wait(&mut self, holds: impl Fn(&Session) -> bool) {
        let begun = Instant::now();
        while !holds(&self.session) {
            assert!(begun.elapsed() < TIMEOUT, "{:?} {:?}", self.session.fault(), self.session.message());
            self.session.pump();
            std::thread::sleep(Duration::from_micros(500));
        }
    }

    /// Goes to the first frame and waits until all frames are drawn, so that the caches are alike each time.
    fn rest(&mut self) {
        self.session.go(1);
        self.settle();
        self.wait(Session::is_idle);
    }

    /// One edit; the kinds take turns. Most do not wait for the frame, as people do not.
    fn edit(&mut self, number: usize) {
        let (round, kind) = (number / KINDS, number % KINDS);
        // A round there, and the same round back.
        let far = 0.002 * (1 + round / 2 % 13) as f64 * if round % 2 == 0 { 1.0 } else { -1.0 };
        self.session.go(1 + ((7 * (round / 2) + kind) % FRAMES) as i32);
        match kind {
            0 | 10 => self.drag_pin(0, far, PinPart::Target),
            1 => self.drag_pin(1, far, PinPart::Target),
            2 | 12 => self.session.undo(),
            3 => self.session.redo(),
            4 => self.session.nudge(glam::DVec2::new(far, -far)),
            5 => self.scrub(),
            6 => self.key(),
            7 => self.paint(far),
            8 => self.session.clear_painting(),
            9 => self.session.save().expect("writable"),
            11 => self.session.toggle_mute("right"),
            13 => self.set("Change smoothness", &["solve", "smoothness"], 1.0 + far.abs()),
            14 => self.set("Change strength", &["strength"], 1.0 - far.abs()),
            15 => self.session.set_dims(if round % 2 == 0 { &[6, 5] } else { &[5, 5] }),
            16 => self.session.set_shot("Change samples", &["samples"], &Setting::Whole(1 + (round % 3) as i64), None),
            17 => self.drag_pin(0, far, PinPart::Radius),
            18 => {
                self.place(ScreenPoint::new(1.2, 0.4 + far));
                self.session.delete_pins();
            }
            _ => self.settle(),
        }
        self.session.pump();
    }

    fn set(&mut self, label: &str, key: &[&str], value: f64) {
        self.session.set_layer(label, key, &Setting::Number(value), None);
    }

    /// Places a pin.
    fn place(&mut self, at: ScreenPoint) {
        self.session.selection.clear();
        self.session.press(at, (0.001, RING), Held::default());
        self.session.release();
        self.wait(|session| session.selection.single_pin().is_some());
    }

    /// Drags a pin of the left card, or the radius of its region.
    fn drag_pin(&mut self, pin: usize, far: f64, part: PinPart) {
        let frame = self.session.playhead.frame();
        self.wait(|session| session.picture().is_some_and(|picture| picture.frame == frame));
        self.settle();
        let marks = self.session.marks().iter().find(|marks| marks.layer == 0).expect("a layer with pins");
        let from = marks.pins.iter().find(|mark| mark.pin == pin).expect("a pin that is seen").target;
        self.session.selection.clear();
        self.session.press(from, (0.01, RING), Held { part, ..Held::default() });
        for step in 1..=4 {
            let by = 0.25 * far * f64::from(step);
            self.session.motion(ScreenPoint::new(from.0.x + by, from.0.y - 0.5 * by));
            self.session.pump();
            std::thread::sleep(Duration::from_millis(2));
        }
        self.session.release();
    }

    /// Drags the playhead over all frames.
    fn scrub(&mut self) {
        for frame in 1..=FRAMES {
            self.session.go(frame as i32);
            self.session.pump();
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Sets a key, eases it, and deletes it.
    fn key(&mut self) {
        self.session.selection.clear();
        self.session.selection.pins.insert([0, 0]);
        self.session.insert_keys();
        let time = f64::from(self.session.playhead.frame());
        self.session.choose_key([0, 0], time, false);
        self.session.ease_keys(EasePreset::Overshoot);
        self.session.undo();
    }

    /// Paints a stroke of stiffness.
    fn paint(&mut self, far: f64) {
        self.session.selection.clear();
        let held = Held { part: PinPart::Stiffness, ..Held::default() };
        let before = self.session.document().history().labels().count();
        self.session.press(ScreenPoint::new(0.45, 0.35 + far), (0.001, RING), held);
        self.session.motion(ScreenPoint::new(0.55, 0.4));
        self.session.release();
        self.wait(|session| session.document().history().labels().count() > before);
    }
}

/// The memory over a session.
#[derive(Debug, Default)]
pub(crate) struct Growth {
    /// Number of edits, and bytes in use.
    seen: Vec<[f64; 2]>,
}

impl Growth {
    /// Returns the bytes per edit by which the memory grows after the warm-up; `None` if too little is known.
    pub(crate) fn slope(&self) -> Option<f64> {
        let warm = self.warm();
        (warm.len() >= 4).then(|| slope(warm))
    }

    /// Returns the slope that is too steep: the bound, and what scatter alone can make of a session of this length.
    pub(crate) fn bound(&self) -> f64 {
        let warm = self.warm();
        let span = warm.last().zip(warm.first()).map_or(1.0, |(last, first)| (last[0] - first[0]).max(1.0));
        BYTES_PER_EDIT + SCATTER / span
    }

    fn warm(&self) -> &[[f64; 2]] {
        &self.seen[(self.seen.len() as f64 * WARM_UP).ceil() as usize..]
    }
}

/// The slope of a straight line through points, by least squares.
fn slope(points: &[[f64; 2]]) -> f64 {
    let count = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count;
    let [x, y] = [mean(0), mean(1)];
    let over: f64 = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    over / points.iter().map(|point| (point[0] - x).powi(2)).sum::<f64>().max(1.0)
}

/// Resident memory of this process; `None` if the system does not tell it.
pub(crate) fn resident_bytes() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.split_whitespace().next()?.parse::<f64>().ok()? * 1024.0)
}
