//! Layers with a temporal weight: no snaps, also within a frame, and each frame the same alone and among others.

use super::bisection;
use super::support::Studio;
use super::tiny::{Tiny, grid};
use glam::DVec3;
use pinwarp::lattice::ScreenLattice;
use pinwarp::pipeline::{PreparedShot, report};
use pinwarp::shot::{LayerSpace, WorldBoxRule};
use std::fmt::Write;

/// A strip that is pressed to two thirds, its upper end swinging from left to right: it buckles to one side, then to the other.
pub(crate) fn swing(solve: &str) -> Studio {
    pressed(solve, "{ frame = 1, offset = [-0.2, -0.3] }, { frame = 9, offset = [0.2, -0.3] }")
}

/// A strip with two pins at each end, the upper ones with these keys.
fn pressed(solve: &str, keys: &str) -> Studio {
    let strip = grid("Strip", [-0.05, -0.42, 0.05, 0.42], 8);
    let mut pins = String::new();
    let mut pin = |triangle: usize, barycentric: &str, keys: &str| {
        let anchor = format!("{{ node = \"Strip\", triangle = {triangle}, barycentric = {barycentric} }}");
        writeln!(pins, "[[layer.pin]]\nanchor = {anchor}\nkeys = [{keys}]").expect("text can be written");
    };
    pin(0, "[1, 0, 0]", "");
    pin(14, "[0, 1, 0]", "");
    pin(113, "[0, 0, 1]", keys);
    pin(126, "[0, 0, 1]", keys);
    Studio::tiny(&Tiny::of(vec![strip]), &format!("[[layer]]\nname = \"strip\"\nsolve = {{ {solve} }}\n{pins}"))
}

fn lattice(prepared: &PreparedShot, frame: f64) -> ScreenLattice {
    let sample = prepared.sample_at(frame).expect("it is solved");
    sample.layers[0].solution.as_ref().expect("it has pins").lattice.clone()
}

/// Farthest move of a point of the strip, pixels of 1080 lines.
fn moved(a: &ScreenLattice, b: &ScreenLattice) -> f64 {
    let points = (0..33).map(|k| [0.76 + 0.04 * f64::from(k % 3), 0.1 + 0.8 * f64::from(k / 3) / 10.0]);
    let moves = points.map(|at| {
        let [from, to] = [a, b].map(|lattice| lattice.evaluate(at));
        (from[0] - to[0]).hypot(from[1] - to[1])
    });
    moves.fold(0.0, f64::max) * 1080.0
}

/// Farthest jump between two times, pixels.
fn jump(prepared: &PreparedShot, times: [f64; 2]) -> f64 {
    bisection::jump(times.map(|time| (time, lattice(prepared, time))), 1.0, |time| lattice(prepared, time), moved)
}

fn farthest_jump(solve: &str) -> f64 {
    let prepared = swing(solve).prepared();
    (1..9).map(|frame| jump(&prepared, [f64::from(frame), f64::from(frame + 1)])).fold(0.0, f64::max)
}

#[test]
fn a_temporal_weight_leaves_no_snap_between_two_moments() {
    let alone = farthest_jump("temporal = 0");
    assert!(alone > 50.0, "the strip snaps where each frame is solved alone: {alone} px");
    let together = farthest_jump("temporal = 0.3");
    assert!(together <= 1.0, "{together} px");
}

#[test]
fn frames_of_a_trajectory_are_the_same_alone_in_any_order_and_in_a_trimmed_shot() {
    let times = [2.0, 5.25, 7.0, 9.5];
    let prepared = swing("temporal = 0.3").prepared();
    let forward = times.map(|time| lattice(&prepared, time));
    let mut trimmed = swing("temporal = 0.3");
    trimmed.shot.frames.first = 5;
    let prepared = trimmed.prepared();
    let mut backward = times;
    backward.reverse();
    let mut found = backward.map(|time| lattice(&prepared, time));
    found.reverse();
    assert_eq!(forward, found);
    // Another range is another trajectory.
    let mut other = swing("temporal = 0.3");
    other.shot.solve_range = [4, 9];
    assert_ne!(lattice(&other.prepared(), 5.25), forward[1]);
}

#[test]
fn a_spread_snap_is_reported() {
    // A straight strip that is pressed buckles suddenly.
    let told = |weight: f64| -> usize {
        let keys = "{ frame = 1, offset = [0, 0] }, { frame = 9, offset = [0, -0.2] }";
        let prepared = pressed(&format!("temporal = {weight}"), keys).prepared();
        let is_spread = |frame: &i32| {
            let report = report(&prepared, *frame, &prepared.mid_exposure(*frame).expect("it is solved"));
            let is_told = report.warnings.iter().any(|text| text.contains("a sudden jump is spread over frames"));
            let covers = |[first, last]: &[f64; 2]| (*first..=*last).contains(&f64::from(*frame));
            assert_eq!(report.spreads.iter().any(covers), is_told, "frame {frame}: {:?}", report.spreads);
            is_told
        };
        (1..=9).filter(is_spread).count()
    };
    // A weight that is large enough spreads it by itself.
    let found = [0.3, 0.001].map(told);
    assert!(found[0] == 0 && found[1] > 0, "{found:?}");
}

#[test]
fn drawings_on_twos_are_tied_to_each_other_and_still_within_themselves() {
    let mut studio = swing("temporal = 0.3");
    studio.shot.layers[0].step = 2;
    let prepared = studio.prepared();
    // Drawings 1, 3, 5, 7 are held for two frames each; the pins jump between them, half way from frame to frame.
    for first in [1.0, 3.0, 5.0, 7.0] {
        let within = jump(&prepared, [first - 0.49, first + 1.49]);
        assert!(within <= 1.0, "drawing {first}: {within} px");
    }
    assert!(moved(&lattice(&prepared, 4.49), &lattice(&prepared, 4.5)) > 10.0, "the pins do jump");
    let again = studio.prepared();
    for time in [7.0, 4.0, 6.25, 1.0] {
        assert_eq!(lattice(&again, time), lattice(&prepared, time));
    }
    assert!(report(&prepared, 4, &prepared.mid_exposure(4).expect("it is solved")).layers[0].solve.is_converged);
}

/// Places on the strip in the scene, as its layer moves them.
fn in_scene(prepared: &PreparedShot, frame: f64) -> Vec<DVec3> {
    let sample = prepared.sample_at(frame).expect("it is solved");
    let lattice = &sample.layers[0].world.as_ref().expect("it has pins").lattice;
    let place = |k: u32| DVec3::new(-0.04 + 0.04 * f64::from(k % 3), -0.4 + 0.8 * f64::from(k / 3) / 10.0, 0.0);
    (0..33).map(|k| lattice.warp(place(k))).collect()
}

#[test]
fn a_layer_in_the_scene_is_solved_over_time_too() {
    let mut studio = swing("temporal = 0.3");
    studio.shot.layers[0].space = LayerSpace::World { dims: [4, 8, 4], bounds: WorldBoxRule::Follow };
    let prepared = studio.prepared();
    let moved = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max) * 1080.0;
    for frame in 1..9 {
        let [mut low, mut high] = [f64::from(frame), f64::from(frame + 1)];
        let [mut from, mut to] = [low, high].map(|time| in_scene(&prepared, time));
        while moved(&from, &to) > 1.0 && high - low > 1e-6 {
            let time = f64::midpoint(low, high);
            let middle = in_scene(&prepared, time);
            if moved(&from, &middle) > moved(&middle, &to) {
                (high, to) = (time, middle);
            } else {
                (low, from) = (time, middle);
            }
        }
        assert!(moved(&from, &to) <= 1.0, "a jump of {} px at {low}", moved(&from, &to));
    }
    let again = studio.prepared();
    for time in [7.5, 2.0] {
        assert_eq!(in_scene(&again, time), in_scene(&prepared, time));
    }
    studio.shot.layers[0].settings.temporal = 0.0;
    assert_ne!(in_scene(&studio.prepared(), 4.5), in_scene(&prepared, 4.5));
}
