//! Lattices in the scene: their handles and pins in metres follow the pen; their dims change without losing the edit.

use super::stage::{REACH, SHOT, Stage, TIMEOUT, at, drag};
use pinwarp::edit::{Channel, EasePreset, Held, Ring, Session, Space};
use pinwarp::shot::{Goal, Rotation};
use std::fs;

/// The stage with a lattice in the scene under the left card, and more text in its layer.
fn in_scene(stage: &Stage, more: &str) -> Session {
    let lattice = "lattice = { space = \"world\", dims = [4, 4, 4] }   #";
    let text = SHOT.replacen("lattice = { dims = [6, 6] }   #", lattice, 1);
    let text = text.replacen("coarse on purpose\n", &format!("coarse on purpose\n{more}\n"), 1);
    fs::write(stage.shot(), text).expect("written");
    stage.session()
}

#[test]
fn a_handle_in_the_scene_follows_the_pen_and_is_undone() {
    let stage = Stage::new();
    let mut session = in_scene(&stage, "");
    session.shown.handles = true;
    let untouched = session.document().text().to_owned();
    let marks = session.marks().iter().find(|marks| marks.layer == 0).expect("at rest, but seen").clone();
    assert_eq!((marks.handles.len(), marks.handle_steps.len()), (64, 64));
    let number = 21;
    let from = marks.handles[number].expect("seen").0;
    drag(&mut session, from.to_array(), (from + glam::DVec2::new(0.05, 0.08)).to_array());
    let tracks = session.document().shot().layers[0].handles.clone();
    let [x, y, z] = tracks[0].index;
    let chosen = x + 4 * (y + 4 * z);
    let was = marks.handles[chosen].expect("seen").0;
    let now = session.marks()[0].handles[chosen].expect("seen").0;
    assert!((now - was - glam::DVec2::new(0.05, 0.08)).length() < 1e-4, "{was} to {now}");
    assert!(session.document().text().contains("[[layer.handle]]"));
    let text = session.document().text().to_owned();
    // Twice as many spans keep what was moved.
    session.set_dims(&[7, 7, 7]);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    assert_eq!(session.document().shot().layers[0].handles[0].keys, tracks[0].keys);
    session.undo();
    assert_eq!(session.document().text(), text);
    session.undo();
    assert_eq!(session.document().text(), untouched);
}

#[test]
fn a_moved_handle_is_eased_moved_in_time_and_put_back() {
    let (_stage, mut session) = Stage::open();
    session.shown.handles = true;
    let untouched = session.document().text().to_owned();
    let handle = session.marks()[0].handles[2 + 6 * 3].expect("seen").0;
    session.go(4);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    let seen = session.marks()[0].handles[2 + 6 * 3].expect("seen").0;
    drag(&mut session, seen.to_array(), (seen + glam::DVec2::new(0.03, 0.04)).to_array());
    assert!(handle.is_finite());
    let at = (0, [2, 3, 0]);
    let keys = |session: &Session| session.document().shot().layers[0].handles[0].keys.clone();
    assert_eq!(keys(&session).iter().map(|key| key.frame).collect::<Vec<_>>(), [1.0, 4.0]);
    session.choose_key(at, 4.0, false);
    session.shift_keys(1);
    session.ease_keys(EasePreset::Hold);
    assert_eq!(keys(&session).iter().map(|key| key.frame).collect::<Vec<_>>(), [1.0, 5.0]);
    assert_eq!(keys(&session)[1].ease, EasePreset::Hold.ease());
    session.delete_keys();
    assert_eq!(keys(&session).len(), 1);
    session.delete_pins();
    assert_eq!(session.document().text(), untouched);
    assert_eq!(session.document().history().labels().last(), Some("Reset handle"));
}

#[test]
fn pins_in_metres_and_in_sizes_of_the_box_follow_the_pen() {
    for unit in ["frame", "box"] {
        let stage = Stage::new();
        let pin = format!(
            "\n[[layer.pin]]\nname = \"p\"\nunit = \"{unit}\"\nanchor = {{ screen = [0.4, 0.5], frame = 1 }}\nkeys = [{{ frame = 1, offset = [0.0, 0.0, 0.0] }}]\n"
        );
        let mut session = in_scene(&stage, &pin);
        let from = session.marks()[0].pins[0].target.0;
        drag(&mut session, from.to_array(), (from + glam::DVec2::new(0.06, 0.1)).to_array());
        let to = session.marks()[0].pins[0].target.0;
        assert!((to - from - glam::DVec2::new(0.06, 0.1)).length() < 1e-4, "{unit}: {from} to {to}");
        let key = session.document().shot().layers[0].pins[0].keys[0];
        let Goal::SceneOffset([x, y, _]) = key.goal else { panic!("{key:?}") };
        assert!(x > 0.0 && y > 0.0, "{key:?}");
        assert_eq!(session.curve_keys([0, 0], Channel::Y), [[1.0, y]]);
    }
}

#[test]
fn a_pin_in_the_scene_is_turned_by_a_ring_about_each_axis() {
    let pin = "\n[[layer.pin]]\nname = \"p\"\nanchor = { screen = [0.4, 0.5], frame = 1 }\n\
               keys = [{ frame = 1, offset = [0.0, 0.0, 0.0] }]\n";
    let stage = Stage::new();
    let mut session = in_scene(&stage, pin);
    session.selection.pins.insert([0, 0]);
    let mark = session.marks()[0].pins[0].clone();
    let axes = mark.turn_axes.expect("it has three angles");
    // The camera looks along z: that ring is a circle, the others are seen from their edges.
    assert!((axes[2].z - 1.0).abs() < 1e-6 && (axes[0].x - 1.0).abs() < 1e-6, "{axes:?}");
    let radius = 0.2;
    let mut turn = |from: [f64; 2], to: [f64; 2]| {
        let place = |[x, y]: [f64; 2]| at(mark.target.0.x + radius * x, mark.target.0.y + radius * y);
        session.press(place(from), (REACH, Ring { radius, reach: 0.02 }), Held::default());
        session.motion(place(to));
        session.release();
        assert!(session.settle(TIMEOUT), "{:?}", session.fault());
        session.document().shot().layers[0].pins[0].keys[0].rotate_degrees
    };
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // A quarter of the circle, from upper right to upper left.
    let about_z = turn([half, half], [-half, half]);
    assert_eq!(about_z, Some(Rotation::Axes([0.0, 0.0, 90.0])));
    // The axis of y was turned by that of z: its ring now stands upright, and its near side is pulled up.
    let Some(Rotation::Axes([x, y, z])) = turn([0.0, 0.5], [0.0, 1.0]) else { panic!("three angles") };
    assert!(x == 0.0 && z == 90.0 && (y.abs() - 28.648).abs() < 0.1, "{x} {y} {z}");
    let labels: Vec<&str> = session.document().history().labels().collect();
    assert_eq!(labels, ["Turn pin", "Turn pin"]);
    let before = session.picture().expect("drawn").rgba.clone();
    session.undo();
    session.undo();
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    assert_ne!(session.picture().expect("drawn").rgba, before);
}

#[test]
fn rotations_about_three_axes_have_curves() {
    let pin = "\n[[layer.pin]]\nname = \"p\"\nanchor = { screen = [0.4, 0.5], frame = 1 }\n\
               keys = [{ frame = 1, offset = [0.0, 0.0, 0.0], rotate = [10.0, 20.0, 30.0], ease = \"linear\" },\
               { frame = 5, offset = [0.0, 0.0, 0.0], rotate = [50.0, 20.0, -30.0] }]\n";
    let stage = Stage::new();
    let mut session = in_scene(&stage, pin);
    let axes = [Channel::RotationX, Channel::RotationY, Channel::RotationZ];
    let values = |session: &Session| axes.map(|axis| session.curve_keys([0, 0], axis));
    assert_eq!(values(&session), [[[1.0, 10.0], [5.0, 50.0]], [[1.0, 20.0], [5.0, 20.0]], [[1.0, 30.0], [5.0, -30.0]]]);
    assert!(session.curve_keys([0, 0], Channel::Rotation).is_empty(), "it has no angle in the view");
    let halfway = axes.map(|axis| session.curve([0, 0], axis, &[3.0])[0][1]);
    assert!((halfway[0] - 30.0).abs() < 1e-6 && halfway[2].abs() < 1e-6, "{halfway:?}");
    session.move_curve_key(([0, 0], 5.0), Channel::RotationX, [4.0, -15.0]);
    session.raise_keys(Channel::RotationZ, 2.0);
    let keys = session.document().shot().layers[0].pins[0].keys.clone();
    assert_eq!((keys[1].frame, keys[1].rotate_degrees), (4.0, Some(Rotation::Axes([-15.0, 20.0, -28.0]))));
    assert_eq!(keys[0].rotate_degrees, Some(Rotation::Axes([10.0, 20.0, 30.0])));
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
}

#[test]
fn numbers_in_sizes_of_the_box_are_per_cent_and_regions_keep_their_unit() {
    let pin = "coarse on purpose\n\n[[layer.pin]]\nname = \"p\"\nunit = \"box\"\nanchor = { screen = [0.4, 0.5], frame = 1 }\n\
               region = { radius = 0.25, rigidity = 1.0 }\nkeys = [{ frame = 1, offset = [0.125, -0.5] }]\n";
    let stage = Stage::with(pin);
    let mut session = stage.session();
    assert_eq!(session.curve_keys([0, 0], Channel::X), [[1.0, 12.5]]);
    session.move_curve_key(([0, 0], 1.0), Channel::Y, [1.0, 20.0]);
    let own = |session: &Session| session.document().shot().layers[0].pins[0].clone();
    assert_eq!(own(&session).keys[0].goal, Goal::Offset(pinwarp::space::ScreenVector::new(0.125, 0.2)));
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    // Half a frame height from the point at rest, in diagonals of the box.
    let (marks, mark) = (session.marks()[0].clone(), session.marks()[0].pins[0].clone());
    let diagonal = marks.rest_box.expect("on the screen").upright.size().length();
    let ring = Ring { radius: 9.0, reach: 0.0 };
    session.press(mark.target, (REACH, ring), Held { part: pinwarp::edit::PinPart::Radius, ..Held::default() });
    session.motion(at(mark.rest.0.x, mark.rest.0.y + 0.5));
    session.release();
    let radius = own(&session).region.expect("a region").radius;
    assert!((radius - 0.5 / diagonal).abs() < 1e-3, "{radius} of {diagonal}");
    assert!((radius - 0.5).abs() > 5e-3, "the box is no frame height across: {diagonal}");
}

#[test]
fn a_lattice_in_the_scene_shows_its_distortion_and_where_it_folds() {
    let stage = Stage::new();
    let mut session = in_scene(&stage, "");
    let stretches =
        |session: &Session| -> Vec<f64> { session.marks()[0].distortion.iter().flatten().copied().collect() };
    let points = session.marks()[0].lines.iter().map(Vec::len).sum::<usize>();
    assert_eq!((points, stretches(&session).len()), (60, 60), "one for each of five points on twelve edges");
    assert!(stretches(&session).iter().all(|stretch| (stretch - 1.0).abs() < 1e-6), "at rest");
    assert!(session.marks()[0].folded.is_empty());
    // The middle passes its neighbour to the right, whose other neighbours stay.
    let handle = |index: [usize; 3], x: f64| {
        format!("\n[[layer.handle]]\nindex = {index:?}\nkeys = [{{ frame = 1, offset = [{x:?}, 0.0, 0.0] }}]\n")
    };
    let still = [[2, 1, 1], [2, 2, 1], [2, 0, 1], [2, 1, 2], [2, 1, 0]].map(|index| handle(index, 0.0)).concat();
    let text = fs::read_to_string(stage.shot()).expect("there");
    let text = text.replacen("dims = [4, 4, 4]", "dims = [3, 3, 3], basis = \"bilinear\"", 1);
    let more = format!("coarse on purpose\nsolve = {{ guard = \"report\" }}\n{}{still}", handle([1, 1, 1], 1.5));
    fs::write(stage.shot(), text.replacen("coarse on purpose\n", &more, 1)).expect("written");
    session = stage.session();
    let marks = &session.marks()[0];
    assert!(stretches(&session).iter().any(|stretch| *stretch > 1.5), "{:?}", stretches(&session));
    assert!(!marks.folded.is_empty() && marks.folded.iter().all(|face| face.len() == 16), "{:?}", marks.folded);
}

#[test]
fn a_layer_that_moves_into_the_scene_and_back_keeps_its_pins_as_they_are_seen() {
    let pins = "coarse on purpose
solve = { temporal = 0.0 }

[[layer.pin]]
name = \"p\"
anchor = { screen = [0.6, 0.5], frame = 1 }
region = { radius = 0.1, rigidity = 1.0 }
keys = [{ frame = 1, offset = [0.05, 0.1], rotate = 15 }]

[[layer.pin]]
name = \"b\"
unit = \"box\"
anchor = { screen = [0.75, 0.45], frame = 1 }
region = { radius = 0.1, rigidity = 1.0 }
keys = [{ frame = 1, offset = [0.1, 0.05] }]
";
    let stage = Stage::with(pins);
    // A frame height is two metres.
    let scene = stage.folder.path().join("cards.gltf");
    let far = fs::read_to_string(&scene).expect("there").replace("mag\":0.5", "mag\":1.0");
    fs::write(&scene, far).expect("written");
    let mut session = stage.session();
    let targets = |session: &Session| session.marks()[0].pins.iter().map(|pin| pin.target.0).collect::<Vec<_>>();
    let seen = targets(&session);
    let diagonal = session.marks()[0].rest_box.expect("on the screen").upright.size().length();
    session.set_space(Space::Scene);
    assert!(session.message().is_some_and(|told| told.contains("Not kept: the dims. ")), "{:?}", session.message());
    session.set_dims(&[4, 4, 4]);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    let are_seen_alike = |session: &Session| {
        let now = targets(session);
        now.len() == 2 && now.iter().zip(&seen).all(|(now, was)| (*now - *was).length() < 1e-3)
    };
    assert!(are_seen_alike(&session), "{:?} was {seen:?}", targets(&session));
    let radii = |session: &Session| {
        let pins = &session.document().shot().layers[0].pins;
        pins.iter().map(|pin| pin.region.expect("a region").radius).collect::<Vec<_>>()
    };
    let metres = session.marks()[0].pins[0].metres_per_height.expect("on the model");
    assert!(metres > 1.5 && (radii(&session)[0] - 0.1 * metres).abs() < 2e-3, "{:?} of {metres}", radii(&session));
    assert!((radii(&session)[1] - 0.1 * diagonal * metres).abs() < 2e-3, "{:?}", radii(&session));
    // Offsets in metres come back as they are seen.
    let by = glam::DVec2::new(0.06, 0.1);
    let text = session.document().text().replace("offset = [0.05, 0.1]", "offset = [0.05, 0.1, 0.0]");
    fs::write(stage.shot(), text.replace(", rotate = 15", "")).expect("written");
    let mut session = stage.session();
    let from = session.marks()[0].pins[0].target.0;
    drag(&mut session, from.to_array(), (from + by).to_array());
    let seen = targets(&session);
    session.set_space(Space::Screen);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    let now = targets(&session);
    assert!(now.iter().zip(&seen).all(|(now, was)| (*now - *was).length() < 1e-3), "{now:?} was {seen:?}");
    assert!((radii(&session)[0] - 0.1).abs() < 2e-3, "{:?}", radii(&session));
    assert_eq!(session.document().shot().layers[0].space.dims(), [10, 10, 1]);
}

#[test]
fn a_box_in_the_scene_is_fixed_where_it_is() {
    let stage = Stage::new();
    let mut session = in_scene(&stage, "");
    let handles = |session: &Session| session.marks()[0].handles.clone();
    let (before, untouched) = (handles(&session), session.document().text().to_owned());
    session.fix_box();
    assert!(session.settle(TIMEOUT), "{:?} {:?}", session.fault(), session.message());
    assert!(session.document().text().contains("box = { fixed = ["), "{}", session.document().text());
    let far = |(a, b): (&Option<_>, &Option<_>)| -> f64 {
        let [a, b]: [pinwarp::space::ScreenPoint; 2] = [a, b].map(|place| place.expect("seen"));
        (a - b).0.length()
    };
    let now = handles(&session);
    assert!(before.iter().zip(&now).map(far).fold(0.0, f64::max) < 1e-3, "{before:?} {now:?}");
    // It stands still though the card moves.
    session.go(6);
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    assert!(now.iter().zip(&handles(&session)).map(far).fold(0.0, f64::max) < 1e-9);
    session.undo();
    assert_eq!(session.document().text(), untouched);
}
