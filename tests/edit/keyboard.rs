//! The timeline and its curves without a pointer: by keyboard, and as screen readers see them.

use crate::stage::{PINS, Stage};
use crate::window::{Window, session, settled, window};
use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use pinwarp::edit::Channel;
use std::fs;

/// A window on a shot whose left layer has two pins with keys, and the folder of both.
fn opened() -> (Stage, Window) {
    let stage = Stage::with(PINS);
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    (stage, window)
}

fn press(window: &mut Window, modifiers: Modifiers, key: Key) {
    window.key_press_modifiers(modifiers, key);
    window.run_steps(2);
}

fn keys(window: &Window, pin: usize, channel: Channel) -> Vec<[f64; 2]> {
    session(window).curve_keys([0, pin], channel)
}

fn times(window: &Window, pin: usize) -> Vec<f64> {
    keys(window, pin, Channel::X).iter().map(|key| key[0]).collect()
}

fn chosen(window: &Window) -> Vec<f64> {
    session(window).selection.keys.iter().map(|(_, time)| *time).collect()
}

fn focus(window: &mut Window, label: &str) {
    window.get_by_label(label).focus();
    window.run_steps(3);
}

#[test]
fn keys_in_a_row_are_chosen_moved_and_deleted_by_keyboard() {
    let (_stage, mut window) = opened();
    focus(&mut window, "Keys of a");
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    assert_eq!(chosen(&window), [3.0]);
    press(&mut window, Modifiers::ALT, Key::ArrowRight);
    assert_eq!(times(&window, 0), [1.0, 4.0, 6.0]);
    press(&mut window, Modifiers::SHIFT, Key::ArrowRight);
    assert_eq!(chosen(&window), [4.0, 6.0]);
    press(&mut window, Modifiers::NONE, Key::Delete);
    assert_eq!(times(&window, 0), [1.0]);
    // Nothing is selected any more: another press means no pin.
    press(&mut window, Modifiers::NONE, Key::Delete);
    assert_eq!(session(&window).document().shot().layers[0].pins.len(), 2);
    press(&mut window, Modifiers::NONE, Key::ArrowDown);
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    assert_eq!(session(&window).selection.keys, [([0, 1].into(), 3.0)]);
    let labels: Vec<&str> = session(&window).document().history().labels().collect();
    assert_eq!(labels, ["Move keys", "Delete keys"], "arrows nudge no pin meanwhile");
}

#[test]
fn every_key_is_named_and_chosen_through_the_accessibility_tree() {
    let (_stage, mut window) = opened();
    for (pin, frames) in [("a", [1, 3, 6]), ("b", [2, 3, 5])] {
        for frame in frames {
            let label = format!("Key of {pin}, frame {frame}, Linear");
            assert!(window.query_by_label(&label).is_some(), "{label}");
        }
    }
    window.get_by_label("Key of b, frame 5, Linear").click_accesskit();
    window.run_steps(3);
    assert_eq!(session(&window).selection.keys, [([0, 1].into(), 5.0)]);
    press(&mut window, Modifiers::NONE, Key::ArrowLeft);
    assert_eq!(chosen(&window), [3.0], "the row has the focus");
    press(&mut window, Modifiers::NONE, Key::C);
    assert!(window.query_by_label("y of b, frame 3: 5.4").is_some(), "in curves, too");
    focus(&mut window, "x of b, frame 2: 0");
    assert_eq!(chosen(&window), [2.0]);
}

#[test]
fn keys_in_curves_are_raised_and_moved_by_keyboard() {
    let (_stage, mut window) = opened();
    press(&mut window, Modifiers::NONE, Key::C);
    focus(&mut window, "Curves of keys");
    // The first curve is x of the first pin; another one is y.
    press(&mut window, Modifiers::ALT, Key::ArrowDown);
    for _ in 0..2 {
        press(&mut window, Modifiers::NONE, Key::ArrowRight);
    }
    assert_eq!(session(&window).selection.keys, [([0, 0].into(), 3.0)]);
    press(&mut window, Modifiers::SHIFT, Key::ArrowUp);
    press(&mut window, Modifiers::NONE, Key::ArrowDown);
    let [_, key, _] = keys(&window, 0, Channel::Y)[..] else { panic!("three") };
    assert!(key[0] == 3.0 && (key[1] - 9.0).abs() < 1e-3, "{key:?}");
    assert_eq!(keys(&window, 0, Channel::X)[1], [3.0, 0.1 * 54.0]);
    press(&mut window, Modifiers::ALT, Key::ArrowLeft);
    assert_eq!(times(&window, 0), [1.0, 2.0, 6.0]);
    press(&mut window, Modifiers::NONE, Key::Delete);
    assert_eq!(times(&window, 0), [1.0, 6.0]);
    let labels: Vec<&str> = session(&window).document().history().labels().collect();
    assert_eq!(labels, ["Change keys", "Move keys", "Delete keys"]);
}

#[test]
fn nudges_have_keys_of_their_own_and_arrow_keys_other_actions() {
    let stage = Stage::with(PINS);
    fs::create_dir_all(stage.state()).expect("a folder");
    let own = "{ \"nudge_right\": \"J\", \"nudge_far_right\": \"Shift+J\", \"forward\": \"Right\" }";
    fs::write(stage.state().join("keys.json"), own).expect("written");
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.get_by_label("a").click();
    window.run_steps(3);
    let x = |window: &Window| keys(window, 0, Channel::X)[0][1];
    let before = x(&window);
    press(&mut window, Modifiers::NONE, Key::J);
    assert!((x(&window) - before - 1.0).abs() < 1e-3, "{} from {before}", x(&window));
    press(&mut window, Modifiers::SHIFT, Key::J);
    press(&mut window, Modifiers::NONE, Key::ArrowLeft);
    assert!((x(&window) - before - 10.0).abs() < 1e-3, "{} from {before}", x(&window));
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    assert!((x(&window) - before - 10.0).abs() < 1e-3, "it nudges nothing");
    assert_eq!(session(&window).playhead.frame(), 2);
}
