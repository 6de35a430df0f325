//! The overlay: what is drawn, and what the pen does.

use crate::host::api::Status;
use crate::host::api::names::{interact, param};
use crate::host::profile::{BOOK, NATRON};
use crate::host::{Host, Pixels, Profile, Value, Which};
use crate::{SIZE, pulled};

#[test]
fn pins_and_lattice_are_drawn() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    let overlay = host.overlay(node, 1.0).expect("there is one");
    let drawn = overlay.draw();
    let near = |place: [f64; 2]| {
        let is_near = |point: &[f64; 2]| (point[0] - place[0]).hypot(point[1] - place[1]) < 12.0;
        drawn.iter().any(|drawn| !drawn.points.is_empty() && drawn.points.iter().all(is_near))
    };
    assert!(near([80.0, 45.0]) && near([96.0, 54.0]) && near([40.0, 45.0]), "pins and targets are marked");
    assert!(!near([20.0, 80.0]), "nothing is marked where no pin is");
    assert!(drawn.iter().filter(|drawn| drawn.points.len() > 10).count() >= 14, "the lines of the lattice");
    overlay.close();
    host.finish();
}

#[test]
fn a_drag_moves_one_target_and_is_undone_in_one_step() {
    for profile in [&BOOK, &NATRON] {
        let mut host = Host::start(profile, Which::PinWarp);
        let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
        let overlay = host.overlay(node, 1.0).expect("there is one");
        overlay.drag([97.0, 53.0], [107.0, 73.0]);
        let moved = host.point(node, "pin1Target", 0.0);
        assert!((moved[0] - 106.0).abs() < 1e-6 && (moved[1] - 74.0).abs() < 1e-6, "{moved:?}");
        assert_eq!(host.point(node, "pin1Rest", 0.0), [80.0, 45.0]);
        assert_eq!(host.point(node, "pin2Target", 0.0), [40.0, 45.0]);
        let undo = host.undo();
        assert_eq!(undo.len(), 1, "{undo:?}");
        assert!(undo[0].params.iter().all(|id| id == "pin1Target") && !undo[0].label.is_empty(), "{undo:?}");
        overlay.close();
        host.finish();
    }
}

#[test]
fn a_pen_that_hits_nothing_is_left_to_the_host() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = host.node();
    host.through(node, &Pixels::scenery(SIZE, 4));
    host.set(node, "clickAdds", 0);
    let overlay = host.overlay(node, 1.0).expect("there is one");
    overlay.draw();
    for (name, short) in
        [(interact::PEN_DOWN, "PenDown"), (interact::PEN_MOTION, "PenMotion"), (interact::PEN_UP, "PenUp")]
    {
        assert_eq!(overlay.pen(name, short, [10.0, 10.0]), Status::REPLY_DEFAULT, "{short}");
    }
    assert!(host.undo().is_empty());
    overlay.close();
    host.finish();
}

#[test]
fn several_pins_are_dragged_together() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    let overlay = host.overlay(node, 1.0).expect("there is one");
    // One pin is chosen by a click, another with Shift; then both go.
    overlay.drag([40.0, 45.0], [40.0, 45.0]);
    overlay.key(interact::KEY_DOWN, interact::KEY_SHIFT_LEFT);
    overlay.drag([96.0, 54.0], [96.0, 54.0]);
    overlay.key(interact::KEY_UP, interact::KEY_SHIFT_LEFT);
    overlay.drag([96.0, 54.0], [101.0, 64.0]);
    let [first, second] = ["pin1Target", "pin2Target"].map(|id| host.point(node, id, 0.0));
    assert!((first[0] - 101.0).abs() < 1e-6 && (first[1] - 64.0).abs() < 1e-6, "{first:?}");
    assert!((second[0] - 45.0).abs() < 1e-6 && (second[1] - 55.0).abs() < 1e-6, "{second:?}");
    overlay.close();
    host.finish();
}

#[test]
fn an_overlay_that_closes_in_a_drag_ends_the_edit() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    let overlay = host.overlay(node, 1.0).expect("there is one");
    overlay.pen(interact::PEN_DOWN, "PenDown", [96.0, 54.0]);
    overlay.pen(interact::PEN_MOTION, "PenMotion", [99.0, 58.0]);
    overlay.close();
    // The overlay must not touch the host any more; the next action may. An open edit fails `finish`.
    host.press(node, "strength");
    host.finish();
}

#[test]
fn hosts_without_overlays_have_their_own_handles() {
    for (overlays, wants_handles) in [(0, 1), (1, 0)] {
        let host = Host::start(&Profile { overlays, ..BOOK }, Which::PinWarp);
        let is_point = |kind: &str| kind.as_bytes() == param::TYPE_DOUBLE_2D.to_bytes();
        let points: Vec<_> = host.parameters().into_iter().filter(|(_, kind, _)| is_point(kind)).collect();
        assert_eq!(points.len(), 64);
        for (id, ..) in points {
            let of = |name| host.described_of(&id, name);
            assert_eq!(of(param::USE_HOST_OVERLAY_HANDLE), [Value::Int(wants_handles)], "{id}");
            assert_eq!(of(param::DOUBLE_TYPE), [Value::Text(param::DOUBLE_XY_ABSOLUTE.into())], "{id}");
            assert_eq!(of(param::DEFAULT_COORDINATES), [Value::Text(param::COORDINATES_CANONICAL.into())], "{id}");
            assert_ne!(of(param::SECRET), [Value::Int(1)], "{id} can be seen");
        }
        host.finish();
    }
}
