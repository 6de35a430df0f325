//! The timeline and its curves without a pointer: by keyboard, and as screen readers see them.

use super::acts::{click, hold, press};
use super::seen::says;
use super::stage::{PINS, Stage};
use super::window::{Window, changes, opened_with, session, settled, window};
use eframe::egui::{self, Event, Key, Modifiers};
use egui_kittest::kittest::Queryable;
use pinwarp::edit::Channel;
use std::fs;

/// A window on a shot whose left layer has two pins with keys, and the folder of both.
fn opened() -> (Stage, Window) {
    opened_with(PINS)
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
fn a_key_that_is_bound_anew_acts_and_the_old_one_does_not() {
    let (_stage, mut window) = opened();
    let is_shown = |window: &Window| says(window, "action");
    press(&mut window, Modifiers::NONE, Key::F1);
    click(&mut window, &["Key of Safe areas"]);
    assert!(says(&window, "press a key"));
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(!says(&window, "press a key") && window.query_by_label("Key of Safe areas").is_some(), "given up");
    click(&mut window, &["Key of Safe areas"]);
    press(&mut window, Modifiers::ALT, Key::J);
    assert!(!is_shown(&window) && says(&window, "Alt+J"), "it is bound, and does nothing yet");
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(window.query_by_label("Key of Safe areas").is_none(), "the list is closed");
    press(&mut window, Modifiers::NONE, Key::A);
    assert!(!is_shown(&window));
    press(&mut window, Modifiers::ALT, Key::J);
    assert!(is_shown(&window));
    press(&mut window, Modifiers::ALT, Key::J);
    click(&mut window, &["View"]);
    assert!(says(&window, "Alt+J"), "menus name it");
}

#[test]
fn a_rotation_is_keyed_separately_in_a_row_of_its_own() {
    let turned = PINS.replacen("frame = 1, offset = [0.0, 0.0] }", "frame = 1, offset = [0.0, 0.0], rotate = 20 }", 1);
    let (_stage, mut window) = opened_with(&turned);
    let text = session(&window).document().text().to_owned();
    focus(&mut window, "Keys of a");
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert!(window.query_by_label("Keys of a rotation").is_none());
    window.get_by_label("Key rotation separately").click_accesskit();
    window.run_steps(3);
    let own = |window: &Window| -> Vec<f64> {
        let pin = &session(window).document().shot().layers[0].pins[0];
        pin.rotate_keys.iter().map(|key| key.frame).collect()
    };
    assert_eq!(own(&window), [1.0, 3.0, 6.0]);
    focus(&mut window, "Keys of a rotation");
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    press(&mut window, Modifiers::ALT, Key::ArrowRight);
    assert_eq!((own(&window), times(&window, 0)), (vec![1.0, 4.0, 6.0], vec![1.0, 3.0, 6.0]));
    assert!(window.query_by_label("Key of a rotation, frame 4, Linear").is_some());
    // Frames that differ cannot be joined.
    window.get_by_label("Join rotation with the keys of the pin").click_accesskit();
    window.run_steps(3);
    assert!(session(&window).message().is_some_and(|text| text.contains("a key in frame 4")));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    window.get_by_label("Join rotation with the keys of the pin").click_accesskit();
    window.run_steps(3);
    assert_eq!(own(&window), [0.0; 0]);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(session(&window).document().text(), text);
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

#[test]
fn arrow_keys_move_a_slider_and_nothing_else() {
    let (_stage, mut window) = opened();
    window.get_by_label("a").click();
    window.run_steps(3);
    let (before, x) = (changes(&window).len(), keys(&window, 0, Channel::X));
    window.get_by_role_and_label(egui::accesskit::Role::Slider, "Strength").focus();
    window.run_steps(3);
    press(&mut window, Modifiers::NONE, Key::ArrowLeft);
    assert_eq!((changes(&window).len(), keys(&window, 0, Channel::X)), (before + 1, x), "only the strength changes");
}

#[test]
fn escape_leaves_a_name_or_a_list_first_and_then_the_selection() {
    let (_stage, mut window) = opened();
    click(&mut window, &["a"]);
    let is_chosen = |window: &Window| session(window).selection.pins.contains(&[0, 0]);
    focus(&mut window, "Pin name");
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(is_chosen(&window) && !window.ctx.text_edit_focused(), "the name is left");
    click(&mut window, &["View"]);
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(is_chosen(&window), "the menu is left");
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(!is_chosen(&window));
}

/// A slow window gets several presses of a key at once.
#[test]
fn steps_that_come_at_once_all_count_and_switches_only_once() {
    let (_stage, mut window) = opened();
    click(&mut window, &["Mute pin a", "Mute pin b"]);
    let twice = |window: &mut Window, modifiers: Modifiers, key: Key| {
        // In one pass: the harness itself would give each event one of its own.
        let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
        window.input_mut().events.extend([true, false, true, false].map(event));
        window.run_steps(2);
    };
    twice(&mut window, Modifiers::NONE, Key::Period);
    assert_eq!(session(&window).playhead.frame(), 3);
    twice(&mut window, Modifiers::NONE, Key::Comma);
    assert_eq!(session(&window).playhead.frame(), 1);
    twice(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(changes(&window).is_empty(), "both are undone: {:?}", changes(&window));
    let was_handles = session(&window).shown.handles;
    twice(&mut window, Modifiers::NONE, Key::L);
    assert_ne!(session(&window).shown.handles, was_handles, "a switch that is hit twice at once is meant");
}

#[test]
fn a_path_is_typed_as_soon_as_files_are_to_be_chosen() {
    let (stage, mut window) = opened();
    fs::copy(stage.shot(), stage.folder.path().join("other.toml")).expect("copied");
    let typed = |window: &mut Window, key: Key, modifiers: Modifiers, text: &str| {
        press(window, modifiers, key);
        window.run_steps(2);
        window.event(Event::Text(text.to_owned()));
        window.run_steps(2);
        hold(window, Key::Enter, true);
        hold(window, Key::Enter, false);
        window.run_steps(3);
        session(window).document().path().to_owned()
    };
    assert!(typed(&mut window, Key::O, Modifiers::COMMAND, "other.toml").ends_with("other.toml"));
    settled(&mut window);
    let path = typed(&mut window, Key::S, Modifiers::COMMAND | Modifiers::SHIFT, "third");
    assert!(path == stage.folder.path().canonicalize().expect("there").join("third.toml") && path.exists(), "{path:?}");
}
