//! Keys of pins and handles, without a window: copied, pasted, moved, raised, as curves.

use super::stage::{PINS, SHOT, Stage};
use pinwarp::edit::{Channel, EasePreset, KeyStep, Session, Track};
use pinwarp::shot::{Ease, HandleKey};

/// A handle of the left layer that was moved, to be put into it.
const HANDLE: &str = "coarse on purpose

[[layer.handle]]
index = [2, 3]
keys  = [{ frame = 1, offset = [0.0, 0.0] }, { frame = 4, offset = [0.05, 0.1], ease = \"hold\" }]
";

const MOVED: (usize, [usize; 3]) = (0, [2, 3, 0]);

fn handle_keys(session: &Session, layer: usize, index: [usize; 3]) -> Vec<HandleKey> {
    let handles = &session.document().shot().layers[layer].handles;
    handles.iter().find(|handle| handle.index == index).map_or_else(Vec::new, |handle| handle.keys.clone())
}

fn times(session: &Session, track: impl Into<Track>) -> Vec<f64> {
    session.curve_keys(track, Channel::X).iter().map(|key| key[0]).collect()
}

#[test]
fn keys_of_a_handle_are_pasted_into_others_and_undone_at_once() {
    let stage = Stage::with(HANDLE);
    let mut session = stage.session();
    let before = session.document().text().to_owned();
    let own = handle_keys(&session, 0, MOVED.1);
    session.choose_key(MOVED, 4.0, false);
    session.copy_keys();
    assert_eq!(session.message(), Some("Copied 1 key"));
    // A later frame of the same handle.
    session.go(6);
    session.paste_keys();
    assert_eq!(times(&session, MOVED), [1.0, 4.0, 6.0]);
    assert_eq!(handle_keys(&session, 0, MOVED.1)[2], HandleKey { frame: 6.0, ..own[1] });
    session.undo();
    // Two handles that rest: they rest in the first frame from then on.
    session.selection.clear();
    for index in [[0, 0, 0], [5, 5, 0]] {
        session.selection.handles.insert((1, index));
    }
    session.go(3);
    session.paste_keys();
    for index in [[0, 0, 0], [5, 5, 0]] {
        let keys = handle_keys(&session, 1, index);
        assert_eq!(
            keys.iter().map(|key| (key.frame, key.offset)).collect::<Vec<_>>(),
            [(1.0, [0.0; 3]), (3.0, [0.05, 0.1, 0.0])]
        );
        assert_eq!(keys[1].ease, Ease::Hold);
    }
    session.undo();
    assert_eq!(session.document().text(), before);
}

#[test]
fn keys_of_handles_and_pins_are_pasted_to_those_of_their_names() {
    let stage = Stage::with(&[PINS, HANDLE.trim_start_matches("coarse on purpose")].concat());
    let mut session = stage.session();
    for (track, time) in [(Track::from(MOVED), 4.0), (Track::from([0, 0]), 3.0)] {
        session.choose_key(track, time, true);
    }
    session.copy_keys();
    assert_eq!(session.message(), Some("Copied 2 keys"));
    session.selection.clear();
    session.go(4);
    session.paste_keys();
    // The pin's key comes first, a frame before that of the handle.
    assert_eq!((times(&session, [0, 0]), times(&session, MOVED)), (vec![1.0, 3.0, 4.0, 6.0], vec![1.0, 4.0, 5.0]));
    let labels: Vec<&str> = session.document().history().labels().collect();
    assert_eq!(labels, ["Paste keys"]);
    // Keys of pins alone do not fit handles.
    session.choose_key([0, 0], 3.0, false);
    session.copy_keys();
    session.selection.clear();
    session.selection.handles.insert(MOVED);
    let text = session.document().text().to_owned();
    session.paste_keys();
    assert!(session.message().is_some_and(|text| text.contains("has the name")), "{:?}", session.message());
    assert_eq!(session.document().text(), text);
}

#[test]
fn without_a_selected_key_those_of_the_selected_pins_in_this_frame_are_copied() {
    let stage = Stage::with(PINS);
    let mut session = stage.session();
    session.selection.pins.extend([[0, 0], [0, 1]]);
    session.go(4);
    session.copy_keys();
    assert!(session.message().is_some_and(|text| text.contains("pins that have keys")), "{:?}", session.message());
    session.go(3);
    session.copy_keys();
    assert_eq!(session.message(), Some("Copied 2 keys"));
    session.go(4);
    session.paste_keys();
    let keys = |pin: usize| &session.document().shot().layers[0].pins[pin].keys;
    assert_eq!(
        (times(&session, [0, 0]), times(&session, [0, 1])),
        (vec![1.0, 3.0, 4.0, 6.0], vec![2.0, 3.0, 4.0, 5.0])
    );
    assert_eq!((keys(0)[2].goal, keys(1)[2].goal), (keys(0)[1].goal, keys(1)[1].goal));
}

#[test]
fn a_handle_has_curves_in_per_cent_of_the_box() {
    let stage = Stage::with(HANDLE);
    let mut session = stage.session();
    let near = |session: &Session, channel: Channel, wanted: &[[f64; 2]]| {
        let keys = session.curve_keys(MOVED, channel);
        let is_near = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-9;
        assert!(keys.len() == wanted.len() && keys.iter().zip(wanted).all(is_near), "{keys:?}");
    };
    near(&session, Channel::Y, &[[1.0, 0.0], [4.0, 10.0]]);
    assert!(session.curve_keys(MOVED, Channel::Z).is_empty() && session.curve_keys(MOVED, Channel::Scale).is_empty());
    let halfway = session.curve(MOVED, Channel::Y, &[2.5])[0][1];
    assert!(halfway > 2.0 && halfway < 8.0, "{halfway}");
    session.move_curve_key((MOVED, 4.0), Channel::Y, [5.0, -20.0]);
    near(&session, Channel::Y, &[[1.0, 0.0], [5.0, -20.0]]);
    near(&session, Channel::X, &[[1.0, 0.0], [5.0, 5.0]]);
    session.choose_key(MOVED, 1.0, false);
    session.ease_keys(EasePreset::Linear);
    let [tangent] = session.tangents(MOVED, Channel::Y)[..] else { panic!("one leaves the first key") };
    session.bend_curve(MOVED, tangent.end, Channel::Y, [3.0, 0.0]);
    assert!(matches!(handle_keys(&session, 0, MOVED.1)[0].ease, Ease::Bezier(_)));
    session.raise_keys(Channel::X, 10.0);
    near(&session, Channel::X, &[[1.0, 1.0], [5.0, 5.0]]);
}

#[test]
fn keys_are_stepped_through_and_do_not_land_on_each_other() {
    let stage = Stage::with(PINS);
    let mut session = stage.session();
    let chosen = |session: &Session| session.selection.keys.iter().map(|(_, time)| *time).collect::<Vec<_>>();
    session.go(2);
    session.step_key([0, 0], true, KeyStep::Only);
    assert_eq!((chosen(&session), session.message()), (vec![3.0], Some("Key of a, frame 3")));
    session.step_key([0, 0], true, KeyStep::Add);
    assert_eq!(chosen(&session), [3.0, 6.0]);
    session.step_key([0, 0], true, KeyStep::Only);
    assert_eq!(chosen(&session), [3.0, 6.0], "there is none after the last");
    session.step_key([0, 0], false, KeyStep::Only);
    assert_eq!(chosen(&session), [3.0]);
    for _ in 0..2 {
        session.nudge_keys(1);
    }
    assert_eq!((times(&session, [0, 0]), chosen(&session)), (vec![1.0, 5.0, 6.0], vec![5.0]));
    session.nudge_keys(1);
    assert_eq!(times(&session, [0, 0]), [1.0, 5.0, 6.0]);
    assert!(session.message().is_some_and(|text| text.contains("Another key is there")), "{:?}", session.message());
    session.raise_keys(Channel::Y, 3.0);
    session.raise_keys(Channel::Y, -1.0);
    let y = session.curve_keys([0, 0], Channel::Y)[1];
    assert!((y[1] - 2.0).abs() < 1e-3, "a step is a pixel: {y:?}");
    assert_eq!(session.document().history().labels().collect::<Vec<_>>(), ["Move keys", "Change keys"]);
    session.undo();
    session.undo();
    assert_eq!(session.document().text(), SHOT.replacen("coarse on purpose\n", PINS, 1));
}
