//! What moves evenly is warped evenly: rigid motion, and jerk against the input's own.

use super::support::{Studio, hold, pinned_layer};
use super::tiny::{Tiny, grid};
use pinwarp::pipeline::{FrameReport, Jerk, JerkMeter, PreparedShot, lattices, report};
use pinwarp::shot::{Shot, Transfer, TransferFit};
use pinwarp::space::FrameSize;
use std::path::Path;

fn reports(prepared: &PreparedShot, frames: impl IntoIterator<Item = i32>) -> Vec<FrameReport> {
    let mut meter = JerkMeter::default();
    let watched = |frame| {
        let sample = prepared.mid_exposure(frame).expect("it is solved");
        let mut report = report(prepared, frame, &sample);
        meter.watch(prepared, &sample, &mut report);
        report
    };
    frames.into_iter().map(watched).collect()
}

fn jerks(reports: &[FrameReport]) -> Vec<Option<Jerk>> {
    reports.iter().flat_map(|report| &report.layers).map(|layer| layer.jerk).collect()
}

#[test]
fn a_rigidly_moving_model_whose_pins_move_along_is_warped_the_same_in_every_frame() {
    // The square drifts; one corner is pulled by the same offset at all times.
    let mut quad = grid("Quad", [-0.2, -0.2, 0.2, 0.2], 6);
    quad.velocity = [0.03 * 24.0, 0.01 * 24.0, 0.0];
    let layer = pinned_layer("{ frame = 1, offset = [0.08, -0.05] }")
        + "[[layer.pin]]\nanchor = { node = \"Quad\", triangle = 71, barycentric = [0.0, 1.0, 0.0] }\n";
    let studio = Studio::tiny(&Tiny::of(vec![quad]), &layer);
    let prepared = studio.prepared();
    let lattices: Vec<_> = (5..=10)
        .map(|frame| {
            prepared.sample_at(f64::from(frame)).expect("solved").layers[0].solution.clone().expect("pins").lattice
        })
        .collect();
    let warped = lattices[0].handles[0][0] - lattices[0].grid.rest_handle(0)[0];
    assert!(warped.abs() > 0.01, "{warped}");
    for pair in lattices.windows(2) {
        for (a, b) in pair[0].handles.iter().zip(&pair[1].handles) {
            assert!((b[0] - a[0] - 0.03).abs() < 1e-5 && (b[1] - a[1] - 0.01).abs() < 1e-5, "{a:?} {b:?}");
        }
    }
    let jerks = jerks(&reports(&prepared, 5..=10));
    assert!(jerks.iter().all(|jerk| jerk.is_some_and(|jerk| jerk.warp_px < 2e-3)), "{jerks:?}");
}

#[test]
fn a_frame_after_a_gap_has_the_jerk_that_it_has_in_a_run() {
    let studio = Studio::tiny(&Tiny::of(vec![grid("Quad", [-0.2, -0.2, 0.2, 0.2], 2)]), &pinned_layer(""));
    let found = jerks(&reports(&studio.prepared(), [1, 2, 3, 4, 5, 7, 8]));
    assert_eq!(found.iter().map(Option::is_some).collect::<Vec<_>>(), [false, false, false, true, true, true, true]);
    let run = jerks(&reports(&studio.prepared(), 1..=8));
    assert_eq!((found[5], found[6]), (run[6], run[7]));
}

#[test]
fn jerk_of_keys_is_attributed_to_the_input() {
    // A jump of 0.25 frame heights: |1 − 3 + ...| gives 1, 2 and 1 times 10 px, twice as much in the middle.
    let studio = |last: &str| {
        let keys = format!("{{ frame = 1, offset = [0.0, 0.0] }}, {{ frame = 5, offset = [0.0, 0.0] }}, {last}");
        Studio::tiny(&Tiny::of(vec![grid("Quad", [-0.2, -0.2, 0.2, 0.2], 2)]), &pinned_layer(&keys))
    };
    let reports = reports(&studio("{ frame = 6, offset = [0.25, 0.0] }").prepared(), 1..=9);
    let found: Vec<[f64; 2]> =
        jerks(&reports).into_iter().flatten().map(|jerk| [jerk.warp_px, jerk.input_px]).collect();
    let expected = [0.0, 0.0, 10.0, 20.0, 10.0, 0.0];
    for (found, expected) in found.iter().zip(expected) {
        assert!(found.iter().all(|px| (px - expected).abs() < 0.05), "{found:?} {expected}");
    }
    assert!(reports.iter().all(|report| report.warnings.is_empty()), "the keys wanted it");
}

#[test]
fn a_warp_that_jerks_by_itself_is_reported() {
    // Two pins all but on one point, the model turning under them a little: what they hold far away flickers.
    let mut studio = Studio::tiny(&Tiny::of(vec![grid("Quad", [-0.2, -0.2, 0.2, 0.2], 2)]), &pinned_layer(""));
    let mut near = studio.shot.layers[0].pins[0].clone();
    near.name = "near".into();
    if let pinwarp::shot::Anchor::Surface { barycentric, .. } = &mut near.anchor {
        *barycentric = [0.995, 0.005, 0.0];
    }
    studio.shot.layers[0].pins.push(near);
    studio.shot.size = FrameSize::new(640, 400);
    let prepared = |frame: i32| {
        let mut shot = studio.shot.clone();
        let flick = if frame == 5 { 0.0008 } else { 0.0 };
        hold(&mut shot.layers[0].pins[1], [0.0, flick]);
        PreparedShot::new(shot).expect("the scene fits")
    };
    let mut meter = JerkMeter::default();
    let mut told = Vec::new();
    for frame in 1..=6 {
        let prepared = prepared(frame);
        let sample = prepared.mid_exposure(frame).expect("it is solved");
        let mut report = report(&prepared, frame, &sample);
        meter.watch(&prepared, &sample, &mut report);
        told.extend(report.warnings);
    }
    assert!(told.iter().any(|text| text.contains("the warp jerks by")), "{told:?}");
}

/// What is said of jerk in the frames of a shot, and the greatest jerk of warp and input where neither starts nor stops.
fn said_of_jerk(prepared: &PreparedShot, steady: std::ops::RangeInclusive<i32>) -> (Vec<String>, [f64; 2]) {
    let reports = reports(prepared, prepared.shot.frames.first..=prepared.shot.frames.last);
    let is_steady = |report: &&FrameReport| steady.contains(&report.frame);
    let found: Vec<FrameReport> = reports.iter().filter(is_steady).cloned().collect();
    let peak = |of: fn(&Jerk) -> f64| jerks(&found).iter().flatten().map(of).fold(0.0, f64::max);
    let peaks = [peak(|jerk| jerk.warp_px), peak(|jerk| jerk.input_px)];
    let told = reports.into_iter().flat_map(|report| report.warnings).filter(|text| text.contains("jerks by"));
    (told.collect(), peaks)
}

#[test]
fn an_evenly_raised_arm_is_quiet_and_a_strip_that_snaps_is_not() {
    // The hand goes straight up within eight frames: keys without jerk, and an arm that turns.
    let arm = grid("Arm", [-0.4, -0.04, 0.2, 0.04], 10);
    let pins = "[[layer.pin]]\nname = \"shoulder\"\nanchor = { screen = [0.42, 0.5], frame = 1 }\n\
        [[layer.pin]]\nname = \"hand\"\nanchor = { screen = [0.7, 0.5], frame = 1 }\n\
        keys = [{ frame = 1, offset = [0.0, 0.0] }, { frame = 9, offset = [-0.25, 0.27] }]\n";
    let mut studio = Studio::tiny(&Tiny::of(vec![arm]), &format!("[[layer]]\nname = \"arm\"\n{pins}"));
    studio.shot.size = FrameSize::new(1728, 1080);
    let (told, [warp, input]) = said_of_jerk(&studio.prepared(), 4..=9);
    assert!(warp > 2.5 && input < 1e-3, "it turns without jerk of the keys: {warp} {input}");
    assert_eq!(told, [""; 0]);
    let mut snapping = super::trajectories::swing("temporal = 0");
    snapping.shot.size = FrameSize::new(1728, 1080);
    let (told, _) = said_of_jerk(&snapping.prepared(), 1..=9);
    assert!(told.iter().any(|text| text.starts_with("layer 'strip': the warp jerks by")), "{told:?}");
}

#[test]
fn the_knights_raised_arm_is_quiet() {
    let Some(knight) = super::assets::asset("kaykit/Knight.glb") else { return };
    let text = format!(
        "version = 1\nscene = {knight:?}\ncamera = \"front\"\nshow = [\"Knight_*\"]\nsize = [1280, 960]\n\
         frames = {{ first = 1, last = 18, rate = 24, clip = \"T-Pose\" }}\n[[layer]]\nname = \"arm\"\nnodes = [\"Knight_*\"]\n\
         select = {{ joints = [\"upperarm.l\"] }}\n[[layer.pin]]\nname = \"shoulder\"\nanchor = {{ screen = [0.788, 0.459], frame = 1 }}\n\
         [[layer.pin]]\nname = \"hand\"\nanchor = {{ screen = [0.993, 0.452], frame = 1 }}\n\
         keys = [{{ frame = 5, offset = [0.0, 0.0] }}, {{ frame = 15, offset = [-0.162, 0.203] }}]\n"
    );
    let shot = Shot::parse(&text, Path::new("shot.toml")).expect("a right shot");
    let (told, [warp, input]) = said_of_jerk(&PreparedShot::new(shot).expect("the scene fits"), 8..=15);
    assert!(warp > 10.0 && input < 1e-3, "{warp} {input}");
    assert_eq!(told, [""; 0]);
}

#[test]
fn a_lattice_from_a_file_is_not_blamed_for_its_jerk() {
    let keys = "{ frame = 5, offset = [0.0, 0.0] }, { frame = 6, offset = [0.25, 0.0] }";
    let mut studio = Studio::tiny(&Tiny::of(vec![grid("Quad", [-0.2, -0.2, 0.2, 0.2], 2)]), &pinned_layer(keys));
    let frames: Vec<i32> = (1..=9).collect();
    let file = studio.scene().with_file_name("jump.lattice.json");
    lattices(&studio.prepared(), &frames, |_| {})
        .expect("it is warped")
        .write(&file)
        .expect("the folder can be written to");
    let layer = &mut studio.shot.layers[0];
    layer.pins.clear();
    layer.transfer = Some(Transfer { file, layer: None, fit: TransferFit::AsIs, start: None });
    let reports = reports(&studio.prepared(), frames);
    let found = jerks(&reports);
    assert!(found.iter().flatten().any(|jerk| jerk.warp_px > 10.0 && jerk.input_px < 1e-6), "{found:?}");
    assert!(reports.iter().all(|report| report.warnings.is_empty()), "{reports:?}");
    assert!(reports.iter().all(|report| report.layers[0].solve.angular.is_nan()), "nobody measured it");
}

#[test]
fn the_walkers_warp_jerks_no_more_than_what_it_follows() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/walker/shot.toml");
    let prepared = PreparedShot::new(Shot::read(&path).expect("a right shot")).expect("the scene fits");
    let reports = reports(&prepared, 1..=48);
    let found: Vec<Jerk> = jerks(&reports).into_iter().flatten().collect();
    assert_eq!(found.len(), 3 * 45);
    let peak = |of: fn(&Jerk) -> f64| found.iter().map(of).fold(0.0, f64::max);
    let [warp, input] = [peak(|jerk| jerk.warp_px), peak(|jerk| jerk.input_px)];
    eprintln!("walker: the warp jerks by at most {warp:.1} px, model and keys by {input:.1} px");
    assert!(input > 1.0 && warp <= 1.5 * input, "{warp} {input}");
    assert!(!reports.iter().flat_map(|report| &report.warnings).any(|text| text.contains("jerks")));
}
