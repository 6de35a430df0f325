//! Keys at a time: interpolation, holds, `step`, `strength`.

use super::parse;
use pinwarp::shot::{Goal, PinTarget, PinTargets, Rotation};
use pinwarp::space::ScreenPoint;
use std::f64::consts::{LN_2, PI};

/// A shot of frames 1 to 24 with one pin of these keys.
fn targets(keys: &str, more: &str, frame: f64) -> PinTargets {
    let text = format!(
        "scene = 'a.glb'\nframes = {{ first = 1, last = 24 }}\n{more}\n[[layer]]\n[[layer.pin]]\n\
         anchor = {{ screen = [0, 0] }}\nkeys = [{keys}]\n[[layer.handle]]\nindex = [1, 2]\n\
         keys = [{{ frame = 1, offset = [0, 0] }}, {{ frame = 5, offset = [0.4, -0.8] }}]"
    );
    parse(&text).unwrap().pin_targets(0, frame)
}

fn pin(keys: &str, more: &str, frame: f64) -> PinTarget {
    targets(keys, more, frame).pins[0]
}

/// Angle as seen, radians.
#[track_caller]
fn in_view(target: PinTarget) -> f64 {
    let Some(Rotation::InView(angle)) = target.rotation else { panic!("{target:?}") };
    angle
}

#[track_caller]
fn assert_offset(target: PinTarget, x: f64, y: f64) {
    let Goal::Offset(offset) = target.goal else { panic!("{target:?}") };
    assert!((offset.0.x - x).abs() < 1e-12 && (offset.0.y - y).abs() < 1e-12, "{offset:?}");
}

const MOVE: &str = "{ frame = 3, offset = [0.1, 0.2] }, { frame = 7, offset = [0.5, -0.2] }";

#[test]
fn values_hold_outside_their_keys_and_run_straight_between() {
    assert_offset(pin(MOVE, "", -100.0), 0.1, 0.2);
    assert_offset(pin(MOVE, "", 3.0), 0.1, 0.2);
    assert_offset(pin(MOVE, "", 4.0), 0.2, 0.1);
    assert_offset(pin(MOVE, "", 6.5), 0.45, -0.15);
    assert_offset(pin(MOVE, "", 7.0), 0.5, -0.2);
    assert_offset(pin(MOVE, "", 1e9), 0.5, -0.2);
    assert_offset(pin("", "", 4.0), 0.0, 0.0);
}

#[test]
fn an_ease_shapes_the_segment_that_leaves_its_key() {
    let keys = |ease: &str| {
        format!("{{ frame = 0, offset = [0, 0], ease = {ease} }}, {{ frame = 4, offset = [1, 0] }}, {{ frame = 8 }}")
    };
    assert_offset(pin(&keys("\"hold\""), "", 3.9), 0.0, 0.0);
    assert_offset(pin(&keys("\"hold\""), "", 4.0), 1.0, 0.0);
    assert_offset(pin(&keys("\"smooth\""), "", 1.0), 0.15625, 0.0);
    // x = 3s² − 2s³ meets 0.15625 at s = ¼, where y = s³.
    assert_offset(pin(&keys("{ bezier = [0, 0, 1, 0] }"), "", 0.625), 0.015625, 0.0);
    assert_offset(pin(&keys("\"hold\""), "", 6.0), 0.5, 0.0);
}

#[test]
fn rotation_is_an_angle_and_scale_a_logarithm() {
    let keys = "{ frame = 0, rotate = 0, scale = 1 }, { frame = 10, rotate = 350, scale = 4 }";
    let target = pin(keys, "", 5.0);
    assert!((in_view(target) - 175.0 * PI / 180.0).abs() < 1e-12, "the long way round");
    assert!((target.log_scale.unwrap() - LN_2).abs() < 1e-12, "the middle of 1 and 4 is 2");
    let free = pin(MOVE, "", 5.0);
    assert_eq!((free.rotation, free.log_scale), (None, None));
}

#[test]
fn a_silent_key_means_no_rotation_and_scale_1_where_another_key_speaks() {
    let target = pin("{ frame = 0 }, { frame = 4, rotate = 90, scale = 2 }, { frame = 8 }", "", 2.0);
    assert!((in_view(target) - PI / 4.0).abs() < 1e-12);
    assert!((target.log_scale.unwrap() - LN_2 / 2.0).abs() < 1e-12);
    let target = pin("{ frame = 0 }, { frame = 4, rotate = 90 }, { frame = 8 }", "", 8.0);
    assert_eq!((target.rotation, target.log_scale), (Some(Rotation::InView(0.0)), None));
}

#[test]
fn step_holds_from_the_first_frame_on_between_frames_too() {
    for (frame, x) in [(3.0, 0.1), (4.0, 0.1), (4.99, 0.1), (5.0, 0.3), (5.3, 0.3), (6.7, 0.3), (7.0, 0.5)] {
        assert_offset(pin(MOVE, "step = 2", frame), x, 0.4 - 2.0 * x / 2.0 - 0.1);
    }
    // Before the first frame steps go on: frame 0 belongs to the step that began at -1.
    let keys = "{ frame = -1, offset = [0, 0] }, { frame = 1, offset = [1, 0] }";
    assert_offset(pin(keys, "step = 2", 0.5), 0.0, 0.0);
    assert_offset(pin(keys, "step = 1", 0.5), 0.75, 0.0);
}

#[test]
fn strength_scales_offsets_rotations_and_log_scales() {
    let keys = "{ frame = 1, offset = [0.2, 0.4], rotate = 90, scale = 2 }";
    let target = pin(keys, "strength = 0.5", 1.0);
    assert_offset(target, 0.1, 0.2);
    assert!((in_view(target) - PI / 4.0).abs() < 1e-12);
    assert!((target.log_scale.unwrap() - LN_2 / 2.0).abs() < 1e-12);
    let handle = targets(keys, "strength = 0.5", 3.0).handles[0];
    assert!((handle[0] - 0.1).abs() < 1e-12 && (handle[1] + 0.2).abs() < 1e-12, "{handle:?}");
}

#[test]
fn targets_are_places_and_strength_leaves_them() {
    let keys = "{ frame = 1, target = [0.2, 0.4] }, { frame = 3, target = [0.4, 0.8] }";
    let Goal::Target(at) = pin(keys, "strength = 0.5", 2.0).goal else { panic!("a target") };
    assert!((at - ScreenPoint::new(0.3, 0.6)).0.length() < 1e-12);
}

#[test]
fn a_layer_that_is_not_there_has_no_pins() {
    let shot = parse("scene = 'a.glb'\nframes = { first = 1, last = 2 }").unwrap();
    assert_eq!(shot.pin_targets(0, 1.0), PinTargets::default());
}

#[test]
fn a_way_has_a_place_a_frame_and_more_where_a_pin_turns_far() {
    let places = |keys: &str, frame: f64| {
        let text = format!(
            "scene = 'a.glb'\nframes = {{ first = 1, last = 99 }}\n[[layer]]\n[[layer.pin]]\n\
             anchor = {{ screen = [0, 0] }}\nkeys = [{keys}]"
        );
        let shot = parse(&text).unwrap();
        let path = shot.pin_path(0, frame);
        assert_eq!(path.last(), Some(&shot.pin_targets(0, frame)));
        path.len()
    };
    let baked: String = (1..=40).map(|frame| format!("{{ frame = {frame}, offset = [0.0, 0.1] }},")).collect();
    assert_eq!(places(&baked, 40.0), 40);
    assert_eq!((places(MOVE, 7.0), places(MOVE, 5.5), places(MOVE, 3.0)), (5, 4, 1));
    let far = "{ frame = 1, offset = [0, 0] }, { frame = 60, offset = [1, 0] }";
    assert_eq!(places(far, 60.0), 9);
    let turned = "{ frame = 1, rotate = 0 }, { frame = 2, rotate = 720 }";
    assert_eq!(places(turned, 2.0), 25);
}
