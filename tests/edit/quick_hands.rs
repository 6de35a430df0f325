//! A pen that is ahead of the worker: clicks and strokes that follow each other before the first one is answered.

use super::stage::{PINS, REACH, Stage, TIMEOUT, at, press, until};
use pinwarp::edit::{Held, PinPart, Ring, Session};
use pinwarp::space::ScreenPoint;

fn click(session: &mut Session, point: ScreenPoint) {
    press(session, point);
    session.release();
}

fn pins(session: &Session) -> usize {
    session.document().shot().layers[0].pins.len()
}

#[test]
fn every_click_of_a_quick_row_places_its_pin() {
    let (_stage, mut session) = Stage::open();
    let places = [[0.3, 0.3], [0.5, 0.3], [0.3, 0.6], [0.5, 0.6]];
    places.iter().for_each(|place| click(&mut session, at(place[0], place[1])));
    until(&mut session, "all are placed", |session| pins(session) == 4);
    assert_eq!(session.selection.single_pin(), Some([0, 3]), "the last one is chosen");
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    for (mark, place) in session.marks()[0].pins.iter().zip(places) {
        assert!((mark.target - at(place[0], place[1])).0.length() < 1e-6, "{mark:?} {place:?}");
    }
}

#[test]
fn a_click_is_no_less_a_pin_if_another_pin_is_dragged_at_once() {
    let stage = Stage::with(PINS);
    let mut session = stage.session();
    session.go(1);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    click(&mut session, at(0.45, 0.3));
    press(&mut session, at(0.3, 0.5));
    session.motion(at(0.3, 0.55));
    // Questions are answered first, so the answer is there once the drag is drawn.
    until(&mut session, "the drag is drawn", Session::is_idle);
    assert!(session.is_dragging() && pins(&session) == 2, "the drag goes on");
    session.motion(at(0.3, 0.6));
    session.release();
    until(&mut session, "the pin is placed", |session| pins(session) == 3);
    let labels: Vec<&str> = session.document().history().labels().collect();
    assert_eq!(labels, ["Move pin", "Add pin"]);
    assert_eq!(session.selection.single_pin(), Some([0, 0]), "the dragged pin stays chosen");
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    assert!((session.marks()[0].pins[0].target - at(0.3, 0.6)).0.length() < 1e-6);
}

#[test]
fn an_undo_takes_back_a_click_that_waits_and_nothing_else() {
    let stage = Stage::with(PINS);
    let mut session = stage.session();
    session.toggle_pin_mute(&[[0, 0]]);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    click(&mut session, at(0.45, 0.3));
    click(&mut session, at(0.45, 0.7));
    session.undo();
    session.undo();
    let muted = session.document().shot().layers[0].pins[0].is_muted;
    assert!(muted, "{:?}", session.message());
    click(&mut session, at(0.5, 0.4));
    until(&mut session, "a pin is placed", |session| pins(session) == 3);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    assert_eq!(pins(&session), 3, "what was taken back is not placed later");
    session.undo();
    session.undo();
    assert!(pins(&session) == 2 && !session.document().shot().layers[0].pins[0].is_muted);
}

#[test]
fn strokes_that_follow_each_other_at_once_are_all_painted() {
    let (_stage, mut session) = Stage::open();
    session.brush.radius = 0.1;
    let held = Held { part: PinPart::Stiffness, ..Held::default() };
    for x in [0.25, 0.45, 0.65] {
        session.press(at(x, 0.4), (REACH, Ring { radius: 9.0, reach: 0.0 }), held);
        session.motion(at(x, 0.6));
        session.release();
    }
    let count = |session: &Session| session.document().shot().layers[0].strokes.len();
    until(&mut session, "all are painted", |session| count(session) == 3);
    for stroke in &session.document().shot().layers[0].strokes {
        assert!(stroke.points.len() > 2, "all of it: {stroke:?}");
    }
    assert_eq!(session.document().history().labels().count(), 3, "each is undone separately");
}
