//! Pins that wind a part up: frames do not jump at half a turn, and each is the same alone and among others.

use super::support::Studio;
use super::tiny::{Tiny, grid};
use pinwarp::lattice::ScreenLattice;
use pinwarp::pipeline::PreparedShot;
use std::fmt::Write;
use std::sync::LazyLock;

/// A tall strip; its lower end is held, its upper end turns by `degrees` in 8 keys, 5 frames apart.
fn strip(degrees: f64, solve: &str) -> Studio {
    let strip = grid("Strip", [-0.06, -0.42, 0.06, 0.42], 8);
    let mut pins = String::new();
    let mut pin = |triangle: usize, barycentric: &str, keys: &str| {
        let anchor = format!("{{ node = \"Strip\", triangle = {triangle}, barycentric = {barycentric} }}");
        writeln!(pins, "[[layer.pin]]\nanchor = {anchor}\nkeys = [{keys}]").expect("text can be written");
    };
    pin(0, "[1, 0, 0]", "");
    pin(14, "[0, 1, 0]", "");
    for (triangle, barycentric, side) in [(113, "[0, 0, 1]", -0.06), (126, "[0, 0, 1]", 0.06)] {
        let key = |k: u32| {
            let (sin, cos) = (degrees / 8.0 * f64::from(k)).to_radians().sin_cos();
            // Around the strip's upper end, which comes down to leave room for the loop.
            let sink = 0.02 * f64::from(k.min(4));
            let (frame, x, y) = (1 + 5 * k, side * (cos - 1.0), side * sin - sink);
            format!("{{ frame = {frame}, offset = [{x:?}, {y:?}] }},")
        };
        pin(triangle, barycentric, &(0..=8).map(key).collect::<String>());
    }
    let layer = format!(
        "[[layer]]\nname = \"all\"\nlattice = {{ dims = [5, 14], box = {{ fixed = [0.7, 0.04, 0.9, 0.96] }} }}\n{solve}\n{pins}"
    );
    let mut studio = Studio::tiny(&Tiny::of(vec![strip]), &layer);
    studio.shot.frames.last = 41;
    studio.shot.solve_range = [1, 41];
    studio
}

/// A whole turn that may not fold, in a picture of 640 x 400 pixels, solved over time once for all tests.
static GUARDED: LazyLock<PreparedShot> = LazyLock::new(|| large(""));

/// A whole turn that may fold.
static FOLDING: LazyLock<PreparedShot> = LazyLock::new(|| large(FOLDS));

/// What a layer says that may fold.
const FOLDS: &str = "solve = { guard = \"report\" }";

fn large(solve: &str) -> PreparedShot {
    let mut studio = strip(360.0, solve);
    studio.shot.size.height *= 10;
    studio.shot.size.width *= 10;
    studio.prepared()
}

fn lattices(prepared: &PreparedShot, frames: std::ops::RangeInclusive<i32>) -> Vec<ScreenLattice> {
    let lattice = |frame| {
        let sample = prepared.sample_at(f64::from(frame)).expect("it is solved");
        sample.layers[0].solution.as_ref().expect("it has pins").lattice.clone()
    };
    frames.map(lattice).collect()
}

/// Greatest move of a point of the strip between frames, frame heights.
fn moves(lattices: &[ScreenLattice]) -> Vec<f64> {
    let points: Vec<[f64; 2]> =
        (0..33).map(|k| [0.74 + 0.06 * f64::from(k % 3), 0.08 + 0.84 * f64::from(k / 3) / 10.0]).collect();
    let moved = |pair: &[ScreenLattice], at: &[f64; 2]| {
        let [a, b] = [&pair[0], &pair[1]].map(|lattice| lattice.evaluate(*at));
        (a[0] - b[0]).hypot(a[1] - b[1])
    };
    lattices.windows(2).map(|pair| points.iter().map(|at| moved(pair, at)).fold(0.0, f64::max)).collect()
}

#[test]
fn a_whole_turn_does_not_jump() {
    let turned = |(name, prepared): (&str, &PreparedShot)| {
        let mut found = lattices(prepared, 1..=41);
        let steps = moves(&found);
        // 9 degrees a frame; the loop's far side swings by its diameter a radian, about 0.3 frame heights.
        assert!(steps.iter().all(|&step| step < 0.12), "{name}: {steps:?}");
        let total: f64 = steps.iter().sum();
        assert!(total > 0.5, "{name}: {total}");
        found.remove(40)
    };
    // Both ways end at the same targets and, where so few handles may fold, at mirrored loops.
    let right = strip(-360.0, FOLDS).prepared();
    let turns = [("to the left", &*FOLDING), ("to the right", &right), ("guarded", &*GUARDED)];
    let [left, right, ..] = turns.map(turned);
    let [a, b] = [left.evaluate([0.8, 0.5]), right.evaluate([0.8, 0.5])];
    assert!((a[0] + b[0] - 2.0 * 0.8).abs() < 0.02 && (a[0] - b[0]).abs() > 0.05, "{a:?} {b:?}");
}

#[test]
fn a_frame_alone_is_the_frame_in_sequence() {
    let studio = strip(360.0, "solve = { temporal = 0 }");
    let sequence = studio.files(&[36, 37, 38, 39, 40]);
    let alone = studio.files(&[40]);
    let bytes = |path: &std::path::PathBuf| std::fs::read(path).expect("the frame is there");
    assert!(bytes(&alone[0]) == bytes(&sequence[4]), "frame 40 depends on its neighbours");
    assert!(bytes(&sequence[3]) != bytes(&sequence[4]), "frames differ, or nothing was compared");
}

#[test]
fn nothing_folds_unless_the_shot_allows_it() {
    let folded = |prepared: &PreparedShot| {
        let mut cells = 0;
        for frame in [1, 6, 11, 21, 31, 41] {
            let sample = prepared.sample_at(f64::from(frame)).expect("it is solved");
            let report = pinwarp::pipeline::report(prepared, frame, &sample);
            let layer = &report.layers[0].solve;
            cells += layer.folded_model_cells;
            // What gives way is told.
            assert!(
                !layer.is_held_back || report.warnings.iter().any(|text| text.contains("guard: pin '")),
                "{report:?}"
            );
        }
        cells
    };
    assert!(folded(&FOLDING) > 0);
    assert_eq!(folded(&GUARDED), 0);
}
