//! Pins in the viewer: added by clicks, selected, deleted, reset; every change is one step to undo.

use crate::host::api::Status;
use crate::host::api::names::interact;
use crate::host::profile::{BOOK, NATRON};
use crate::host::{Frame, Host, Node, Pixels, Which};
use crate::{SIZE, pulled};

/// A node with a picture and no pins.
fn bare(host: &mut Host) -> Node {
    let node = host.node();
    host.through(node, &Pixels::scenery(SIZE, 4));
    node
}

fn on(host: &Host, node: Node) -> Vec<usize> {
    (1..=32).filter(|pin| host.int(node, &format!("pin{pin}On")) == 1).collect()
}

#[test]
fn a_click_where_no_pin_is_adds_the_first_free_one() {
    for profile in [&BOOK, &NATRON] {
        let mut host = Host::start(profile, Which::PinWarp);
        let node = bare(&mut host);
        let overlay = host.overlay(node, 1.0).expect("there is one");
        // Inside the frame, in its corner, outside of it.
        for (number, at) in [(1, [30.0, 40.0]), (2, [0.0, 0.0]), (3, [-25.0, 120.0])] {
            overlay.drag(at, at);
            let of = |end: &str| host.point(node, &format!("pin{number}{end}"), 0.0);
            assert_eq!([of("Rest"), of("Target")], [at; 2], "{}", profile.name);
            if number != 2 {
                assert_eq!(on(&host, node).last(), Some(&number));
            }
        }
        let undo = host.undo();
        assert!(
            undo.len() == 3 && undo.iter().all(|undo| !undo.label.is_empty() && undo.params.len() == 3),
            "{undo:?}"
        );
        assert!(host.is_identity(node), "a pin that was added holds the picture where it is");
        overlay.close();
        host.finish();
    }
}

#[test]
fn a_click_on_a_pin_a_box_and_shift_add_none() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    let overlay = host.overlay(node, 1.0).expect("there is one");
    overlay.drag([96.0, 54.0], [96.0, 54.0]);
    overlay.drag([10.0, 10.0], [30.0, 30.0]);
    overlay.key(interact::KEY_DOWN, interact::KEY_SHIFT_LEFT);
    overlay.drag([120.0, 70.0], [120.0, 70.0]);
    overlay.key(interact::KEY_UP, interact::KEY_SHIFT_LEFT);
    assert_eq!(on(&host, node), [1, 2]);
    host.set(node, "clickAdds", 0);
    overlay.drag([120.0, 70.0], [120.0, 70.0]);
    assert_eq!(on(&host, node), [1, 2]);
    overlay.close();
    host.finish();
}

#[test]
fn pins_that_were_switched_off_keep_their_places() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    host.set(node, "pin1On", 0);
    let overlay = host.overlay(node, 1.0).expect("there is one");
    overlay.drag([120.0, 70.0], [120.0, 70.0]);
    assert_eq!(on(&host, node), [2, 3]);
    assert_eq!(host.point(node, "pin1Target", 0.0), [96.0, 54.0]);
    overlay.close();
    host.finish();
}

#[test]
fn a_pin_too_many_is_reported() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = bare(&mut host);
    (1..=32).for_each(|pin| host.pin(node, pin, [2.0 * pin as f64, 10.0], [2.0 * pin as f64, 10.0]));
    let overlay = host.overlay(node, 1.0).expect("there is one");
    overlay.drag([120.0, 70.0], [120.0, 70.0]);
    assert!(host.said().iter().any(|said| said.text.contains("32 pins")), "{:?}", host.said());
    assert!(host.undo().is_empty());
    overlay.close();
    host.finish();
}

#[test]
fn selected_pins_are_deleted_with_all_that_they_had() {
    for (name, key) in [("Delete", interact::KEY_DELETE), ("Backspace", interact::KEY_BACKSPACE), ("button", 0)] {
        let mut host = Host::start(&BOOK, Which::PinWarp);
        let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
        host.key(node, "pin1Target", 0.0, [96.0, 54.0]);
        host.key(node, "pin1Target", 5.0, [20.0, 54.0]);
        host.set(node, "pin1Name", "nose");
        host.set(node, "pin1Radius", 30.0);
        let overlay = host.overlay(node, 1.0).expect("there is one");
        overlay.drag([96.0, 54.0], [96.0, 54.0]);
        let before = host.undo().len();
        if key == 0 {
            assert_eq!(host.press(node, "deletePins"), Status::OK);
        } else {
            overlay.key(interact::KEY_DOWN, key);
        }
        assert_eq!(on(&host, node), [2], "{name}");
        let ends = [0.0, 5.0].map(|time| host.point(node, "pin1Target", time));
        assert_eq!(ends, [[0.0, 0.0]; 2], "{name}: keys and places are gone");
        assert_eq!(host.undo().len(), before + 1, "{name}: one step to undo");
        // The slot is free again.
        overlay.drag([120.0, 70.0], [120.0, 70.0]);
        assert_eq!(host.point(node, "pin1Rest", 0.0), [120.0, 70.0], "{name}");
        overlay.close();
        host.finish();
    }
}

#[test]
fn pins_are_reset_copied_and_cleared() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    host.set(node, "pin1Turns", 1);
    host.set(node, "pin1Angle", 30.0);
    assert_eq!(host.press(node, "resetPins"), Status::OK);
    assert!(host.said().iter().any(|said| said.text.contains("no pin is selected")), "{:?}", host.said());
    host.set(node, "selected", 1);
    assert_eq!(host.press(node, "selected"), Status::OK);
    assert_eq!(host.press(node, "resetPins"), Status::OK);
    assert_eq!(host.point(node, "pin1Target", 0.0), [80.0, 45.0]);
    assert!(host.is_identity(node), "no rotation is left either");
    // Without a selection all targets are copied.
    host.set(node, "selected", 0);
    host.press(node, "selected");
    host.pin(node, 1, [80.0, 45.0], [96.0, 54.0]);
    host.pin(node, 2, [40.0, 45.0], [30.0, 40.0]);
    assert_eq!(host.press(node, "restToTargets"), Status::OK);
    assert_eq!([1, 2].map(|pin| host.point(node, &format!("pin{pin}Rest"), 0.0)), [[96.0, 54.0], [30.0, 40.0]]);
    assert!(host.is_identity(node));
    let before = host.undo().len();
    assert_eq!(host.press(node, "clearPins"), Status::OK);
    assert_eq!((on(&host, node), host.undo().len()), (Vec::new(), before + 1));
    host.finish();
}

#[test]
fn a_reset_of_an_animated_pin_is_of_this_frame() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    host.set(node, "selected", 1);
    host.press(node, "selected");
    assert_eq!(host.press(node, "resetPins"), Status::OK);
    let keys = host.undo().last().map(|undo| undo.params.clone()).unwrap_or_default();
    assert!(keys.contains(&"pin1Target".to_owned()) && !keys.contains(&"pin1Rest".to_owned()), "{keys:?}");
    host.finish();
}

#[test]
fn next_and_previous_go_round_the_pins_that_act() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = bare(&mut host);
    for pin in [3, 7, 20] {
        host.pin(node, pin, [10.0 * pin as f64 / 2.0, 45.0], [10.0 * pin as f64 / 2.0, 45.0]);
    }
    let press = |host: &Host, button| {
        assert_eq!(host.press(node, button), Status::OK);
        host.int(node, "selected")
    };
    assert_eq!([press(&host, "nextPin"), press(&host, "nextPin"), press(&host, "nextPin")], [3, 7, 20]);
    assert_eq!([press(&host, "nextPin"), press(&host, "previousPin")], [3, 20]);
    let overlay = host.overlay(node, 1.0).expect("there is one");
    overlay.key(interact::KEY_DOWN, interact::KEY_BRACKET_LEFT);
    overlay.key(interact::KEY_DOWN, interact::KEY_DELETE);
    assert_eq!(on(&host, node), [3, 20]);
    overlay.close();
    host.finish();
}

#[test]
fn a_pin_by_a_click_can_be_dragged_and_warps() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = bare(&mut host);
    let overlay = host.overlay(node, 1.0).expect("there is one");
    overlay.drag([80.0, 45.0], [80.0, 45.0]);
    overlay.drag([80.0, 45.0], [96.0, 54.0]);
    let found = host.render(node, Frame::default()).expect("it renders");
    let pixels = Pixels::scenery(SIZE, 4);
    assert!((found.at(95, 53, 0) - pixels.at(79, 44, 0)).abs() < 0.02);
    overlay.close();
    host.finish();
}

#[test]
fn the_second_viewer_shares_the_selection() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    let [first, second] = [1.0, 2.0].map(|pixel| host.overlay(node, pixel).expect("there is one"));
    first.drag([96.0, 54.0], [96.0, 54.0]);
    second.key(interact::KEY_DOWN, interact::KEY_DELETE);
    assert_eq!(on(&host, node), [2]);
    first.close();
    second.close();
    host.finish();
}
