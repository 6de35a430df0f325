//! Orders that nobody expects: what changes the document while the pen is down, and places beyond the shot.

use super::acts::{choose, click, number, press, write};
use super::stage::{PINS, Stage};
use super::window::{Window, changes, opened_with, place, pointer, session, settled, until};
use eframe::egui::{Key, Modifiers, Pos2, Rect, vec2};
use egui_kittest::kittest::Queryable;
use pinwarp::edit::{Document, Space};
use std::fs;

/// The pen down on a pin of the left layer, and moved.
fn dragging(more: &str) -> (Stage, Window, Pos2) {
    let (stage, mut window) = opened_with(more);
    let target = session(&window).marks()[0].pins[0].target.0;
    let on_pin = place(&window, target.x, target.y);
    pointer(&mut window, on_pin, Some(true));
    pointer(&mut window, on_pin + vec2(30.0, 0.0), None);
    assert!(session(&window).is_dragging());
    (stage, window, on_pin)
}

/// The pen goes on, and up.
fn finish(window: &mut Window, on_pin: Pos2) {
    pointer(window, on_pin + vec2(60.0, 0.0), None);
    pointer(window, on_pin + vec2(60.0, 0.0), Some(false));
    window.run_steps(2);
    settled(window);
}

fn text(window: &Window) -> String {
    session(window).document().text().to_owned()
}

#[test]
fn undo_during_a_drag_takes_that_drag_back_alone() {
    let (_stage, mut window, on_pin) = dragging(PINS);
    finish(&mut window, on_pin);
    let moved = text(&window);
    let on_pin = on_pin + vec2(60.0, 0.0);
    pointer(&mut window, on_pin, Some(true));
    pointer(&mut window, on_pin + vec2(0.0, 30.0), None);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(!session(&window).is_dragging());
    finish(&mut window, on_pin);
    assert_eq!((text(&window), changes(&window)), (moved, vec!["Move pin".to_owned()]));
}

#[test]
fn a_layer_that_is_deleted_under_the_pen_stays_deleted() {
    let (_stage, mut window, on_pin) = dragging(PINS);
    window.get_by_label("Delete layer").click_accesskit();
    window.run_steps(3);
    assert!(!session(&window).is_dragging());
    pointer(&mut window, on_pin + vec2(50.0, 0.0), None);
    assert_eq!(session(&window).shot().layers.len(), 1, "it is not shown, either");
    finish(&mut window, on_pin);
    assert_eq!(changes(&window), ["Delete layer"]);
    // The other one follows, and nothing is left to be chosen.
    click(&mut window, &["Delete layer"]);
    press(&mut window, Modifiers::NONE, Key::E);
    press(&mut window, Modifiers::COMMAND, Key::A);
    press(&mut window, Modifiers::NONE, Key::Delete);
    settled(&mut window);
    assert!(session(&window).document().shot().layers.is_empty());
}

#[test]
fn what_else_changes_during_a_drag_is_kept_with_it() {
    let (_stage, mut window, on_pin) = dragging(PINS);
    press(&mut window, Modifiers::NONE, Key::M);
    finish(&mut window, on_pin);
    assert_eq!(changes(&window), ["Mute pin", "Move pin"]);
    let pin = &session(&window).document().shot().layers[0].pins[0];
    assert!(pin.is_muted && pin.keys[0].goal != pin.keys[2].goal, "{pin:?}");
}

#[test]
fn a_drag_that_leaves_the_field_of_a_name_moves_and_renames() {
    let (_stage, mut window) = opened_with(PINS);
    let target = session(&window).marks()[0].pins[0].target.0;
    let on_pin = place(&window, target.x, target.y);
    click(&mut window, &["a"]);
    write(&mut window, "Pin name", "tip");
    pointer(&mut window, on_pin, Some(true));
    pointer(&mut window, on_pin + vec2(30.0, 0.0), None);
    finish(&mut window, on_pin);
    let pin = &session(&window).document().shot().layers[0].pins[0];
    assert!(pin.name == "tip" && pin.keys[0].goal != pin.keys[2].goal, "{pin:?}");
}

/// Another program removes the pin that is dragged: the next one takes its place in the list.
#[test]
fn a_drag_of_a_pin_that_another_program_removed_moves_no_other_pin() {
    let (stage, mut window, on_pin) = dragging(PINS);
    let (from, to) = (PINS.find("\n[[layer.pin]]").expect("a"), PINS.rfind("\n[[layer.pin]]").expect("b"));
    let without = fs::read_to_string(stage.shot()).expect("there").replace(&PINS[from..to], "");
    fs::write(stage.shot(), &without).expect("written");
    until(&mut window, "it is read again", |window| text(window) == without);
    finish(&mut window, on_pin);
    assert_eq!(text(&window), without);
    assert_eq!(Document::open(&stage.shot()).expect("a shot").shot().layers[0].pins.len(), 1);
}

#[test]
fn the_space_changes_during_playback_and_during_a_drag() {
    let (_stage, mut window, on_pin) = dragging(PINS);
    number(&mut window, "Over time", 0.0);
    window.state_mut().as_mut().and_then(pinwarp::edit::ui::Editor::session_mut).expect("open").set_space(Space::Scene);
    window.run_steps(2);
    finish(&mut window, on_pin);
    assert!(!changes(&window).contains(&"Move pin".to_owned()), "{:?}", changes(&window));
    for label in ["Columns", "Rows", "Layers of handles"] {
        number(&mut window, label, 4.0);
    }
    click(&mut window, &["Every frame"]);
    press(&mut window, Modifiers::NONE, Key::Space);
    until(&mut window, "it plays", |window| session(window).playhead.frame() > 1);
    choose(&mut window, "Space", "screen");
    assert!(text(&window).contains("dims = [10, 10]"), "{}", text(&window));
    press(&mut window, Modifiers::NONE, Key::Space);
    click(&mut window, &["First frame"]);
    settled(&mut window);
}

#[test]
fn a_scrub_beyond_the_shot_stays_within_it() {
    let (_stage, mut window) = opened_with(PINS);
    let ruler: Rect = window.get_by_label("Frames").rect();
    pointer(&mut window, ruler.center(), Some(true));
    for (x, frame) in [(ruler.right() + 900.0, 6), (ruler.left() - 900.0, 1), (1e9, 6)] {
        pointer(&mut window, Pos2::new(x, ruler.center().y), None);
        assert_eq!(session(&window).playhead.frame(), frame);
    }
    pointer(&mut window, ruler.center(), Some(false));
    settled(&mut window);
    let shown = session(&window).picture().expect("drawn").frame;
    assert_eq!(shown, session(&window).playhead.frame());
}
