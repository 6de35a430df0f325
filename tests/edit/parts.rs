//! Pins and handles of the picture as screen readers find them, and pins that are hard or soft.

use super::acts::{click, number, press};
use super::stage::PINS;
use super::window::{Window, changes, opened_with, place, session, settled};
use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;

fn weights(window: &Window) -> Vec<f64> {
    session(window).document().shot().layers[0].pins.iter().map(|pin| pin.weight).collect()
}

#[test]
fn pins_are_named_where_they_are_and_chosen_and_nudged_through_the_accessibility_tree() {
    let (_stage, mut window) = opened_with(PINS);
    let target = session(&window).marks()[0].pins[0].target.0;
    let node = window.get_by_label("Pin a of left, keyed in this frame");
    assert!(node.rect().center().distance(place(&window, target.x, target.y)) < 0.5, "{:?}", node.rect());
    assert!(window.query_by_label("Pin b of left").is_some(), "it has no key here");
    window.get_by_label("Keys of b").focus();
    window.run_steps(3);
    window.get_by_label("Pin a of left, keyed in this frame").click_accesskit();
    window.run_steps(3);
    assert_eq!(session(&window).selection.single_pin(), Some([0, 0]));
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    assert_eq!(changes(&window), ["Nudge pin"], "the viewport has the focus");
    settled(&mut window);
    let moved = window.get_by_label("Pin a of left, keyed in this frame").rect().center().x;
    assert!(moved > place(&window, target.x, target.y).x + 1.0, "it is where the pin is now");
    window.get_by_label("Pin b of left").focus();
    window.run_steps(3);
    assert_eq!(session(&window).selection.single_pin(), Some([0, 1]));
    press(&mut window, Modifiers::NONE, Key::P);
    assert!(window.query_by_label("Pin b of left").is_none(), "hidden pins are not there");
}

#[test]
fn handles_that_are_shown_are_named_and_chosen() {
    let (_stage, mut window) = opened_with(PINS);
    assert!(window.query_by_label("Handle 2, 3 of left").is_none());
    press(&mut window, Modifiers::NONE, Key::L);
    settled(&mut window);
    window.get_by_label("Handle 2, 3 of left").click_accesskit();
    window.run_steps(3);
    assert!(session(&window).selection.handles.contains(&(0, [2, 3, 0])));
    press(&mut window, Modifiers::NONE, Key::ArrowUp);
    assert_eq!(changes(&window), ["Nudge handles"]);
    assert_eq!(session(&window).document().shot().layers[0].handles[0].index, [2, 3, 0]);
}

#[test]
fn pins_are_made_hard_and_soft_by_a_box_and_a_key() {
    let (_stage, mut window) = opened_with(PINS);
    click(&mut window, &["a"]);
    let hard = |window: &mut Window| {
        window.get_by_role_and_label(Role::CheckBox, "Hard").click_accesskit();
        window.run_steps(3);
    };
    hard(&mut window);
    assert_eq!(weights(&window), [0.5, 1.0]);
    number(&mut window, "Weight", 0.2);
    hard(&mut window);
    hard(&mut window);
    assert_eq!(weights(&window), [0.2, 1.0], "it is as soft as it was");
    // Of several pins all become alike.
    press(&mut window, Modifiers::COMMAND, Key::A);
    press(&mut window, Modifiers::NONE, Key::E);
    assert_eq!(weights(&window), [1.0, 1.0]);
    hard(&mut window);
    assert_eq!(weights(&window), [0.2, 0.5]);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(weights(&window), [1.0, 1.0]);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(weights(&window), [0.2, 1.0]);
    press(&mut window, Modifiers::NONE, Key::F1);
    assert!(window.query_by_label("Key of Hard or soft pins").is_some());
}
