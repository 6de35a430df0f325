//! The brush for stiffness, without a window: strokes, what is seen meanwhile, erasing, undo.

use super::stage::{REACH, SHOT, Stage, TIMEOUT, at, place_pin, until};
use pinwarp::edit::{Held, PinPart, Ring, Session};
use pinwarp::pipeline::PreparedShot;
use pinwarp::shot::Shot;
use std::fs;

/// A ring that cannot be grabbed.
const RING: Ring = Ring { radius: 9.0, reach: 0.0 };

fn press(session: &mut Session, point: [f64; 2], erases: bool) {
    let held = Held { part: PinPart::Stiffness, adds: erases, ..Held::default() };
    session.press(at(point[0], point[1]), (REACH, RING), held);
}

fn strokes(session: &Session) -> usize {
    session.document().shot().layers.iter().map(|layer| layer.strokes.len()).sum()
}

/// Paints along a way, and waits until the frame is drawn.
fn paint(session: &mut Session, way: &[[f64; 2]], erases: bool) {
    let before = session.document().history().labels().count();
    press(session, way[0], erases);
    way[1..].iter().for_each(|point| session.motion(at(point[0], point[1])));
    session.release();
    until(session, "the stroke is written", |session| session.document().history().labels().count() > before);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
}

/// The greatest stiffness on the screen left and right of the middle of the left card.
fn stiffest(session: &Session) -> [f64; 2] {
    let shot = Shot::parse(session.document().text(), session.document().path()).expect("a shot");
    let prepared = PreparedShot::new(shot).expect("it loads");
    let sample = prepared.sample_at(1.0).expect("solved");
    let triangles = prepared.stiff_triangles(&sample);
    let side = |triangle: &&pinwarp::pipeline::StiffTriangle| triangle.corners[0].0.x < 0.49;
    let most = |triangles: Vec<&pinwarp::pipeline::StiffTriangle>| {
        triangles.iter().map(|triangle| triangle.stiffness).fold(1.0, f64::max)
    };
    let (left, right) = triangles.iter().partition(side);
    [most(left), most(right)]
}

#[test]
fn a_stroke_is_one_change_that_is_seen_at_once_and_kept_in_the_file() {
    let (stage, mut session) = Stage::open();
    session.brush.radius = 0.12;
    press(&mut session, [0.3, 0.4], false);
    session.motion(at(0.3, 0.6));
    until(&mut session, "the paint is seen", |session| !session.painted().is_empty());
    assert_eq!(session.document().text(), SHOT, "nothing is written before the pen is up");
    session.release();
    until(&mut session, "the stroke is written", |session| strokes(session) == 1);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    let labels: Vec<&str> = session.document().history().labels().collect();
    assert_eq!(labels, ["Paint stiffness"]);
    let stroke = &session.document().shot().layers[0].strokes[0];
    assert_eq!((stroke.value, &stroke.nodes[..]), (8.0, &["Left".to_owned()][..]));
    assert!(stroke.points.len() > 2, "{stroke:?}");
    let [left, right] = stiffest(&session);
    assert!(left > 4.0 && right == 1.0, "{left} {right}");
    let text = session.document().text().to_owned();
    session.save().expect("writable");
    assert_eq!(fs::read_to_string(stage.shot()).expect("saved"), text);
    session.undo();
    assert_eq!(session.document().text(), SHOT);
    session.redo();
    assert_eq!(session.document().text(), text);
}

#[test]
fn what_is_erased_is_as_the_rest_and_all_painting_can_be_removed() {
    let (_stage, mut session) = Stage::open();
    session.brush.radius = 0.12;
    paint(&mut session, &[[0.3, 0.5], [0.65, 0.5]], false);
    assert!(stiffest(&session).iter().all(|most| *most > 4.0), "{:?}", stiffest(&session));
    session.brush.radius = 0.3;
    paint(&mut session, &[[0.7, 0.5]], true);
    let [left, right] = stiffest(&session);
    assert!(left > 4.0 && right < 2.0, "{left} {right}");
    assert_eq!(session.document().history().labels().last(), Some("Erase stiffness"));
    session.selection.clear();
    session.clear_painting();
    assert_eq!(session.document().text(), SHOT);
    session.clear_painting();
    assert_eq!(session.message(), Some("Nothing is painted on this layer."));
}

#[test]
fn paint_stiffens_what_pins_pull() {
    let (_stage, mut session) = Stage::open();
    for (x, y) in [(0.25, 0.5), (0.7, 0.5)] {
        place_pin(&mut session, at(x, y));
    }
    session.press(at(0.7, 0.5), (REACH, RING), Held::default());
    session.motion(at(0.6, 0.62));
    session.release();
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    let before = session.picture().expect("drawn").rgba.clone();
    session.brush.radius = 0.2;
    session.brush.stiffness = 50.0;
    paint(&mut session, &[[0.35, 0.35], [0.35, 0.7]], false);
    assert_ne!(session.picture().expect("drawn").rgba, before);
}

#[test]
fn the_brush_beside_the_model_writes_nothing_and_says_so() {
    let (_stage, mut session) = Stage::open();
    press(&mut session, [0.02, 0.97], false);
    session.release();
    until(&mut session, "it says so", |session| session.message().is_some());
    assert!(session.message().is_some_and(|text| text.contains("under the brush")), "{:?}", session.message());
    paint_nothing(&mut session);
    assert_eq!(session.document().text(), SHOT);
}

/// Erases where nothing is painted, and gives a stroke up.
fn paint_nothing(session: &mut Session) {
    press(session, [0.4, 0.5], true);
    session.release();
    until(session, "it says so", |session| session.message() == Some("Nothing is painted there."));
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    press(session, [0.4, 0.5], false);
    until(session, "the paint is seen", |session| !session.painted().is_empty());
    session.cancel();
    session.release();
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
}

#[test]
fn a_held_key_sizes_the_brush_beside_pins() {
    let (_stage, mut session) = Stage::open();
    let held = Held { part: PinPart::Radius, ..Held::default() };
    session.press(at(0.4, 0.5), (REACH, RING), held);
    session.motion(at(0.4, 0.65));
    session.release();
    assert!((session.brush.radius - 0.15).abs() < 1e-9, "{:?}", session.brush);
    assert_eq!(session.document().text(), SHOT);
}

#[test]
fn with_mirrored_edits_the_brush_paints_both_sides_at_once() {
    let (_stage, mut session) = Stage::open();
    session.brush.radius = 0.06;
    session.mirrors = true;
    // The left card stands about x = -0.4; its middle is at 0.49 of the frame's height.
    paint(&mut session, &[[0.3, 0.5], [0.35, 0.5]], false);
    let strokes = &session.document().shot().layers[0].strokes;
    assert_eq!(strokes.len(), 2, "{strokes:?}");
    let [own, mirrored] = [0, 1].map(|index| &strokes[index].points);
    assert_eq!(own.len(), mirrored.len());
    for (a, b) in own.iter().zip(mirrored) {
        assert!((a[0] + b[0] + 0.8).abs() < 5e-3 && (a[1] - b[1]).abs() < 5e-3, "{a:?} {b:?}");
    }
    assert!(stiffest(&session).iter().all(|most| *most > 4.0), "{:?}", stiffest(&session));
    session.undo();
    assert_eq!(session.document().text(), SHOT, "one change");
}
