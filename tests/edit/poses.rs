//! Keyed poses stay while another frame is edited: first rotations, late pins.

use super::stage::{PINS, REACH, Stage, TIMEOUT, at, drag, press, until};
use glam::DVec2;
use pinwarp::edit::{Held, Ring, Session};
use pinwarp::pipeline::PreparedShot;
use pinwarp::shot::edit::Setting;
use pinwarp::shot::{PinKey, Rotation, Shot};

/// Pins a and b, both keyed in frames 1, 3 and 5, which turn what is between them.
const TURNED: &str = "coarse on purpose

[[layer.pin]]
name   = \"a\"
anchor = { screen = [0.3, 0.5], frame = 1 }
keys   = [{ frame = 1, offset = [0.0, 0.0] }, { frame = 3, offset = [0.05, -0.15] }, { frame = 5, offset = [0.0, 0.1] }]

[[layer.pin]]
name   = \"b\"
anchor = { screen = [0.6, 0.5], frame = 1 }
keys   = [{ frame = 1, offset = [0.0, 0.0] }, { frame = 3, offset = [-0.1, 0.15] }, { frame = 5, offset = [0.0, -0.1] }]
";

fn handles(session: &mut Session, frame: i32) -> Vec<DVec2> {
    session.go(frame);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    session.marks()[0].handles.iter().flatten().map(|handle| handle.0).collect()
}

fn poses(session: &mut Session, frames: &[i32]) -> Vec<Vec<DVec2>> {
    frames.iter().map(|&frame| handles(session, frame)).collect()
}

/// The mean distance of handles.
fn apart(a: &[DVec2], b: &[DVec2]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).sum::<f64>() / a.len() as f64
}

/// Frames are solved alone, so that a frame shows its keys and nothing of others.
fn alone(stage: &Stage) -> Session {
    let mut session = stage.session();
    session.set_layer("Solve alone", &["solve", "temporal"], &Setting::Number(0.0), None);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    session
}

fn turn(session: &mut Session, pin: [usize; 2], turns: f64) {
    session.selection.only_pin(pin);
    let mark = session.marks()[pin[0]].pins.iter().find(|mark| mark.pin == pin[1]).expect("seen");
    let center = mark.target.0;
    let on = |turns: f64| {
        at(center.x, center.y) + pinwarp::space::ScreenVector(0.2 * DVec2::from_angle(turns * std::f64::consts::TAU))
    };
    session.press(on(0.3), (REACH, Ring { radius: 0.2, reach: 0.02 }), Held::default());
    (1..=8).for_each(|step| session.motion(on(0.3 + turns * f64::from(step) / 8.0)));
    // Questions are answered before the drag is drawn.
    until(session, "the drag is drawn", Session::is_idle);
    session.motion(on(0.3 + turns));
    session.release();
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
}

#[test]
fn a_first_rotation_in_one_frame_leaves_the_other_keyed_poses() {
    let stage = Stage::with(TURNED);
    let mut session = alone(&stage);
    let before = poses(&mut session, &[1, 3, 5]);
    let turned = apart(&before[1], &before[2]);
    let text = session.document().text().to_owned();
    let shown = handles(&mut session, 2);
    turn(&mut session, [0, 0], 0.15);
    assert!(apart(&shown, &handles(&mut session, 2)) > 0.01, "it turns");
    let after = poses(&mut session, &[1, 3, 5]);
    for (frame, (before, after)) in [1, 3, 5].iter().zip(before.iter().zip(&after)) {
        assert!(apart(before, after) < 0.05 * turned, "frame {frame}: {} of {turned}", apart(before, after));
    }
    session.undo();
    assert_eq!(session.document().text(), text, "one step");
}

#[test]
fn a_turn_goes_on_from_the_rotation_that_is_seen() {
    let stage = Stage::with(TURNED);
    let mut session = alone(&stage);
    handles(&mut session, 3);
    // By less than 4 degrees.
    turn(&mut session, [0, 0], 0.01);
    let Some(Rotation::InView(angle)) = session.document().shot().layers[0].pins[0].keys[1].rotate_degrees else {
        panic!("{}", session.document().text())
    };
    assert!(angle > 20.0, "{angle}");
}

#[test]
fn a_typed_first_scale_leaves_the_other_keyed_poses() {
    let stage = Stage::with(TURNED);
    let mut session = alone(&stage);
    let before = handles(&mut session, 3);
    let mut change = |knows: bool| {
        session.go(5);
        assert!(session.settle(TIMEOUT), "{:?}", session.fault());
        if knows {
            session.want_turns_when_drawn([0, 1]);
            session.go(5);
            until(&mut session, "it is drawn", Session::is_idle);
        }
        let key = session.key_here([0, 1]).expect("a pin");
        session.put_key([0, 1], PinKey { scale: Some(1.5), ..key });
        let changed = apart(&before, &handles(&mut session, 3));
        let keys = session.document().shot().layers[0].pins[1].keys.clone();
        session.undo();
        (changed, keys)
    };
    // Before anything is known, other frames are neither turned nor scaled.
    let ((blind, _), (held, keys)) = (change(false), change(true));
    assert!(held < 0.5 * blind, "{held} of {blind}");
    assert!(keys.iter().all(|key| key.scale.is_some() && key.rotate_degrees.is_some()), "{keys:?}");
    assert_eq!((keys[2].frame, keys[2].scale), (5.0, Some(1.5)));
}

#[test]
fn a_pin_that_is_placed_and_dragged_late_leaves_the_other_keyed_poses() {
    let stage = Stage::with(PINS);
    let mut session = alone(&stage);
    let before = poses(&mut session, &[1, 2, 3, 5, 6]);
    let text = session.document().text().to_owned();
    session.go(4);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    press(&mut session, at(0.55, 0.62));
    session.release();
    until(&mut session, "a pin is placed", |session| session.document().shot().layers[0].pins.len() == 3);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    drag(&mut session, [0.55, 0.62], [0.6, 0.75]);
    let after = poses(&mut session, &[1, 2, 3, 5, 6]);
    for (before, after) in before.iter().zip(&after) {
        assert!(apart(before, after) < 1e-3, "{}", apart(before, after));
    }
    let keys: Vec<f64> = session.document().shot().layers[0].pins[2].keys.iter().map(|key| key.frame).collect();
    assert_eq!(keys, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    session.undo();
    session.undo();
    assert_eq!(session.document().text(), text, "one step for the pin and one for the drag");
}

#[test]
fn the_part_that_differs_between_two_solves_is_found_in_pixels() {
    let stage = Stage::with(PINS);
    let prepared = PreparedShot::new(Shot::read(&stage.shot()).expect("a shot")).expect("it loads");
    let [rest, pulled] = [1, 3].map(|frame| prepared.provisional(frame).expect("solved"));
    let shifts = prepared.layer_shifts([&rest, &pulled]);
    assert_eq!(shifts.iter().map(|shift| (&shift.layer[..], &shift.node[..])).collect::<Vec<_>>(), [("left", "Left")]);
    // A tenth of 54 lines and more, as the card moves, too.
    assert!((5.0..30.0).contains(&shifts[0].pixels), "{shifts:?}");
    assert_eq!(prepared.layer_shifts([&pulled, &pulled]), []);
}
