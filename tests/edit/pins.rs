//! What a pin can be told beside where it goes: weight, rest, stiffness, its other side; and what becomes of keys and handles.

use super::stage::{PINS, REACH, SHOT, Stage, TIMEOUT, at, drag, place_pin, press, until};
use pinwarp::edit::{Channel, Held, PinPart, Ring, Session};
use pinwarp::shot::{Goal, Pin, Rotation};

fn pin(session: &Session, layer: usize, pin: usize) -> &Pin {
    &session.document().shot().layers[layer].pins[pin]
}

/// How far the picture is from the one at rest: mean difference of its bytes.
fn change(session: &Session, rest: &[u8]) -> f64 {
    let seen = &session.picture().expect("drawn").rgba;
    seen.iter().zip(rest).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / rest.len() as f64
}

#[test]
fn a_soft_pin_gives_way_and_a_muted_one_rests() {
    let (_stage, mut session) = Stage::open();
    for (x, y) in [(0.25, 0.3), (0.7, 0.3), (0.45, 0.75)] {
        place_pin(&mut session, at(x, y));
    }
    let rest = session.picture().expect("drawn").rgba.clone();
    drag(&mut session, [0.45, 0.75], [0.55, 0.9]);
    let hard = change(&session, &rest);
    let error = |session: &Session| session.solve().expect("solved").report.layers[0].pin_error_px;
    assert!(hard > 0.5 && error(&session) < 0.01, "{hard}, {}", error(&session));
    let text = session.document().text().to_owned();
    session.set_weight([0, 2], 0.2);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    let soft = change(&session, &rest);
    assert!(soft < 0.9 * hard && error(&session) > 1.0, "{soft} of {hard}, {}", error(&session));
    session.toggle_pin_mute(&[[0, 2]]);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    assert_eq!((change(&session, &rest), session.marks()[0].pins.len()), (0.0, 2));
    assert!(session.document().text().contains("mute = true"));
    session.toggle_pin_mute(&[[0, 2]]);
    session.set_weight([0, 2], 1.0);
    assert_eq!(session.document().text(), text, "what is usual is not written");
}

#[test]
fn edits_are_mirrored_to_the_other_side() {
    let (_stage, mut session) = Stage::open();
    for (index, (x, name)) in [(0.3, "ear left"), (0.65, "ear right")].into_iter().enumerate() {
        place_pin(&mut session, at(x, 0.5));
        session.rename_pin([0, index], name);
    }
    assert!(session.settle(TIMEOUT));
    session.mirrors = true;
    drag(&mut session, [0.3, 0.5], [0.25, 0.6]);
    let offset = |session: &Session, index: usize| match pin(session, 0, index).keys[0].goal {
        Goal::Offset(offset) => offset.0.to_array(),
        other => panic!("{other:?}"),
    };
    let (left, right) = (offset(&session, 0), offset(&session, 1));
    assert!((left[0] + 0.05).abs() < 1e-6 && (left[1] - 0.1).abs() < 1e-6, "{left:?}");
    assert!((right[0] + left[0]).abs() < 1e-9 && (right[1] - left[1]).abs() < 1e-9, "{right:?}");
    let labels: Vec<&str> = session.document().history().labels().collect();
    assert_eq!(labels.last(), Some(&"Move pins"), "both are undone at once");
    session.mirrors = false;
    session.undo();
    assert!(session.settle(TIMEOUT));
    drag(&mut session, [0.3, 0.5], [0.25, 0.6]);
    assert_eq!(offset(&session, 1), [0.0, 0.0]);
}

#[test]
fn regions_and_weights_are_mirrored_to_the_other_side_at_once() {
    let (_stage, mut session) = Stage::open();
    for (index, (x, name)) in [(0.3, "ear left"), (0.65, "ear right")].into_iter().enumerate() {
        place_pin(&mut session, at(x, 0.5));
        session.rename_pin([0, index], name);
    }
    assert!(session.settle(TIMEOUT));
    let both = |session: &Session| [0, 1].map(|index| (pin(session, 0, index).region, pin(session, 0, index).weight));
    let before = session.document().text().to_owned();
    let size = |session: &mut Session, part: PinPart, to: [f64; 2]| {
        let ring = Ring { radius: 9.0, reach: 0.0 };
        session.press(at(0.3, 0.5), (REACH, ring), Held { part, ..Held::default() });
        session.motion(at(to[0], to[1]));
        session.release();
        assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    };
    session.mirrors = true;
    size(&mut session, PinPart::Radius, [0.42, 0.5]);
    size(&mut session, PinPart::Stiffness, [0.3, 0.6]);
    session.set_weight([0, 1], 0.5);
    let [(left, left_weight), (right, right_weight)] = both(&session);
    let region = left.expect("it has one");
    assert!((region.radius - 0.12).abs() < 1e-3 && region.stiffness > 3.0 && left == right, "{left:?} {right:?}");
    assert_eq!([left_weight, right_weight], [0.5; 2]);
    for _ in 0..3 {
        session.undo();
    }
    assert_eq!(session.document().text(), before, "each is one step");
    session.mirrors = false;
    session.set_weight([0, 0], 0.5);
    assert_eq!(both(&session)[1].1, 1.0);
}

#[test]
fn a_held_key_and_a_drag_stiffen_a_region() {
    let (_stage, mut session) = Stage::open();
    place_pin(&mut session, at(0.4, 0.5));
    let mut held = |part: PinPart, to: [f64; 2]| {
        let ring = Ring { radius: 9.0, reach: 0.0 };
        session.press(at(0.4, 0.5), (REACH, ring), Held { part, ..Held::default() });
        session.motion(at(to[0], to[1]));
        session.release();
        assert!(session.settle(TIMEOUT), "{:?}", session.fault());
        pin(&session, 0, 0).region.expect("it has one")
    };
    let region = held(PinPart::Radius, [0.6, 0.5]);
    assert!((region.radius - 0.2).abs() < 1e-3, "{region:?}");
    let stiffer = held(PinPart::Stiffness, [0.4, 0.6]);
    assert!(stiffer.stiffness > 3.0 && stiffer.radius == region.radius, "{stiffer:?}");
    let softer = held(PinPart::Stiffness, [0.4, 0.2]);
    assert!(softer.stiffness < 0.5, "{softer:?}");
}

#[test]
fn a_handle_of_a_layer_without_pins_is_dragged_and_kept_in_other_dims() {
    let (_stage, mut session) = Stage::open();
    session.shown.handles = true;
    // The third of six columns and rows.
    let handle = session.marks()[0].handles[2 + 6 * 3].expect("seen").0;
    drag(&mut session, handle.to_array(), [handle.x + 0.05, handle.y + 0.08]);
    let handles = |session: &Session| session.document().shot().layers[0].handles.clone();
    assert_eq!(handles(&session).iter().map(|track| track.index).collect::<Vec<_>>(), [[2, 3, 0]]);
    let moved = session.marks()[0].handles[2 + 6 * 3].expect("seen").0;
    assert!((moved - handle - glam::DVec2::new(0.05, 0.08)).length() < 1e-6, "{moved} from {handle}");
    let keys = handles(&session)[0].keys.clone();
    session.set_dims(&[11, 11]);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    let finer = handles(&session);
    assert_eq!((finer.len(), &finer[0].keys), (1, &keys));
    let [column, row, _] = finer[0].index;
    let there = session.marks()[0].handles[column + 11 * row].expect("seen").0;
    assert!((there - moved).length() < 0.06, "{there} instead of {moved}");
    session.undo();
    assert_eq!(handles(&session)[0].index, [2, 3, 0]);
}

#[test]
fn a_curve_s_key_goes_to_another_time_and_number_at_once() {
    let (_stage, mut session) = Stage::open();
    place_pin(&mut session, at(0.4, 0.5));
    session.go(4);
    session.insert_keys();
    let times: Vec<f64> = (1..=6).map(f64::from).collect();
    assert_eq!(session.curve([0, 0], Channel::Y, &times).len(), 6);
    let before = session.document().text().to_owned();
    for value in [2.0, 5.0, 10.8] {
        let time = if value > 6.0 { 5.0 } else { 4.0 };
        session.move_curve_key(([0, 0], 4.0), Channel::Y, [time, value]);
    }
    let last = |session: &Session| session.curve_keys([0, 0], Channel::Y)[1];
    assert!(last(&session)[0] == 5.0 && (last(&session)[1] - 10.8).abs() < 1e-3, "{:?}", last(&session));
    // A key does not pass another.
    session.move_curve_key(([0, 0], 5.0), Channel::Y, [1.0, 3.0]);
    assert!(last(&session)[0] == 5.0 && (last(&session)[1] - 3.0).abs() < 1e-3, "{:?}", last(&session));
    assert!(session.curve([0, 0], Channel::Rotation, &times).is_empty());
    session.undo();
    assert_eq!(session.document().text(), before);
}

#[test]
fn keys_of_many_pins_are_copied_to_pins_of_their_names() {
    let (_stage, mut session) = Stage::open();
    for x in [0.3, 0.6] {
        place_pin(&mut session, at(x, 0.5));
    }
    session.nudge(glam::DVec2::new(0.1, 0.0));
    for index in [0, 1] {
        session.choose_key([0, index], 1.0, true);
    }
    session.copy_keys();
    assert_eq!(session.message(), Some("Copied 2 keys"));
    session.go(5);
    session.selection.clear();
    session.paste_keys();
    let keys = |index: usize| pin(&session, 0, index).keys.iter().map(|key| (key.frame, key.goal)).collect::<Vec<_>>();
    for index in [0, 1] {
        assert_eq!((keys(index).len(), keys(index)[1].0, keys(index)[1].1), (2, 5.0, keys(index)[0].1));
    }
    assert_ne!(keys(0)[1].1, keys(1)[1].1);
    session.undo();
    assert!(session.document().text().starts_with(&SHOT[..60]));
    assert_eq!(pin(&session, 0, 1).keys.len(), 1);
}

#[test]
fn the_whole_range_is_no_range() {
    let (_stage, mut session) = Stage::open();
    session.playhead.set_range(Some([2, 5]));
    assert!(session.playhead.has_range());
    session.playhead.set_range(Some([1, 6]));
    assert!(!session.playhead.has_range());
}

#[test]
fn tangents_of_chosen_keys_bend_the_curve() {
    let (_stage, mut session) = Stage::open();
    place_pin(&mut session, at(0.4, 0.5));
    session.go(5);
    session.insert_keys();
    session.move_curve_key(([0, 0], 5.0), Channel::X, [5.0, 20.0]);
    session.choose_key([0, 0], 1.0, false);
    let [tangent] = session.tangents([0, 0], Channel::X)[..] else { panic!("one leaves the first key") };
    let middle = |session: &Session| session.curve([0, 0], Channel::X, &[3.0])[0][1];
    let before = middle(&session);
    session.bend_curve([0, 0], tangent.end, Channel::X, [3.0, 20.0]);
    assert!(middle(&session) > before + 2.0, "{} from {before}", middle(&session));
    session.undo();
    assert_eq!(middle(&session), before);
    session.put_key([0, 0], pinwarp::shot::PinKey { scale: Some(1.5), ..pin(&session, 0, 0).keys[0] });
    session.free_channel([0, 0], Channel::Scale);
    assert!(pin(&session, 0, 0).keys.iter().all(|key| key.scale.is_none()));
}

#[test]
fn a_pin_is_mirrored_once_even_into_another_layer() {
    let (stage, mut session) = Stage::open();
    place_pin(&mut session, at(0.4, 0.5));
    let follower = "[output]\n";
    let text = session.document().text().replace(
        follower,
        "  [[layer.pin]]\n  name   = \"other\"\n  mirror = { layer = \"left\", pin = \"Left\" }\n  anchor = { screen = [1.2, 0.5], frame = 1 }\n\n[output]\n",
    );
    std::fs::write(stage.shot(), &text).expect("written");
    let mut session = stage.session();
    session.selection.pins = [[0, 0]].into();
    session.mirror_pins();
    assert!(
        session.message().is_some_and(|text| text.contains("No pin without a mirrored one")),
        "{:?}",
        session.message()
    );
    assert_eq!(session.document().text(), text);
    // What is deleted takes its follower along.
    session.delete_pins();
    assert_eq!(session.document().shot().layers.iter().map(|layer| layer.pins.len()).collect::<Vec<_>>(), [0, 0]);
}

#[test]
fn a_click_right_after_a_drag_or_another_frame_places_a_pin_where_it_is_seen() {
    let (_stage, mut session) = Stage::open();
    place_pin(&mut session, at(0.3, 0.5));
    let count = |session: &Session| session.document().shot().layers[0].pins.len();
    // The worker has solved the drag alone when it is asked.
    press(&mut session, at(0.3, 0.5));
    let before = session.solve().cloned().expect("solved");
    session.motion(at(0.3, 0.52));
    until(&mut session, "the drag is solved", |session| {
        session.solve().is_some_and(|now| !std::sync::Arc::ptr_eq(now, &before))
    });
    session.release();
    press(&mut session, at(0.6, 0.5));
    session.release();
    until(&mut session, "a pin is placed", |session| count(session) == 2);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    // The card moves from frame to frame, so its point under the pen is another one.
    session.go(6);
    press(&mut session, at(0.7, 0.4));
    session.release();
    until(&mut session, "a pin is placed", |session| count(session) == 3);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    let mark = session.marks()[0].pins[2].clone();
    assert!((mark.target.0 - glam::DVec2::new(0.7, 0.4)).length() < 1e-4, "{mark:?}");
}

#[test]
fn a_ring_can_be_dragged_around_more_than_once() {
    let (_stage, mut session) = Stage::open();
    place_pin(&mut session, at(0.4, 0.5));
    let center = session.marks()[0].pins[0].target.0;
    let on = |turns: f64| {
        let (sin, cos) = (turns * std::f64::consts::TAU).sin_cos();
        at(center.x + 0.2 * cos, center.y + 0.2 * sin)
    };
    for [from, to, turned] in [[0.0, 1.5, 540.0], [0.0, -2.0, -180.0]] {
        session.press(on(from), (REACH, Ring { radius: 0.2, reach: 0.02 }), Held::default());
        (1..=16).for_each(|step| session.motion(on(from + (to - from) * f64::from(step) / 16.0)));
        session.release();
        assert!(session.settle(TIMEOUT), "{:?}", session.fault());
        let key = pin(&session, 0, 0).keys[0];
        assert_eq!(key.rotate_degrees, Some(Rotation::InView(turned)), "{from} to {to} turns");
    }
}

#[test]
fn a_ring_turns_the_keys_that_a_rotation_has_of_its_own() {
    let own = "frame = 6, offset = [0.0, 0.0] }]\n\
               rotate_keys = [{ frame = 1, value = 0 }, { frame = 5, value = 40, ease = \"smooth\" }] # apart\n";
    let stage = Stage::with(&PINS.replacen("frame = 6, offset = [0.0, 0.0] }]\n", own, 1));
    let mut session = stage.session();
    let (text, before) = (session.document().text().to_owned(), pin(&session, 0, 0).clone());
    session.go(5);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    session.selection.pins = [[0, 0]].into();
    let center = session.marks()[0].pins[0].target.0;
    let on = |turns: f64| {
        let (sin, cos) = (turns * std::f64::consts::TAU).sin_cos();
        at(center.x + 0.2 * cos, center.y + 0.2 * sin)
    };
    session.press(on(0.0), (REACH, Ring { radius: 0.2, reach: 0.02 }), Held::default());
    (1..=4).for_each(|step| session.motion(on(0.0625 * f64::from(step))));
    session.release();
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    let after = pin(&session, 0, 0);
    assert_eq!((&after.keys, after.rotate_keys[0]), (&before.keys, before.rotate_keys[0]));
    let turned = pinwarp::shot::ChannelKey { value: Rotation::InView(130.0), ..before.rotate_keys[1] };
    assert_eq!(after.rotate_keys[1..], [turned]);
    assert_eq!(session.document().history().labels().last(), Some("Turn pin"));
    assert_eq!(
        session.document().text(),
        text.replace("value = 40", "value = 130.0").replace("\"smooth\" }]", "\"smooth\" } ]")
    );
    session.undo();
    assert_eq!(session.document().text(), text);
}
