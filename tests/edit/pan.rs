//! Panning without a middle button: with a held key, and with two fingers on a trackpad.

use super::acts::{click, drag, hold, press};
use super::seen::pictures;
use super::stage::{PINS, Stage};
use super::window::{Window, changes, opened_with, place, pointer, session, settled, window};
use eframe::egui::{Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, Rect, TouchPhase, Vec2, vec2};
use egui_kittest::kittest::Queryable;
use std::fs;

fn seen(window: &Window) -> Rect {
    pictures(window)[0].rect
}

fn plays(window: &Window) -> bool {
    window.query_by_label("Stop").is_some()
}

fn wheel(window: &mut Window, unit: MouseWheelUnit, source: MouseWheelSource, delta: Vec2) {
    let (phase, modifiers) = (TouchPhase::Move, Modifiers::NONE);
    window.event(Event::MouseWheel { unit, delta, phase, source, modifiers });
    window.run_steps(12);
}

#[test]
fn a_drag_with_the_space_key_pans_and_a_tap_plays() {
    let (_stage, mut window) = opened_with(PINS);
    let target = session(&window).marks()[0].pins[0].target.0;
    let on_pin = place(&window, target.x, target.y);
    let before = seen(&window);
    hold(&mut window, Key::Space, true);
    drag(&mut window, [on_pin, on_pin + vec2(30.0, 12.0)]);
    hold(&mut window, Key::Space, false);
    window.run_steps(2);
    assert!((seen(&window).min - before.min - vec2(30.0, 12.0)).length() < 0.1, "{:?}", seen(&window));
    assert!(!plays(&window) && changes(&window).is_empty(), "neither a frame nor the pin moved");
    assert!(session(&window).selection.pins.is_empty());
    // The key is let go before the pen.
    let now = on_pin + vec2(30.0, 12.0);
    hold(&mut window, Key::Space, true);
    pointer(&mut window, now, Some(true));
    hold(&mut window, Key::Space, false);
    pointer(&mut window, now - vec2(30.0, 12.0), None);
    pointer(&mut window, now - vec2(30.0, 12.0), Some(false));
    assert!((seen(&window).min - before.min).length() < 0.1 && !plays(&window) && changes(&window).is_empty());
    // While it is down nothing plays yet, though the key repeats.
    hold(&mut window, Key::Space, true);
    let (physical_key, modifiers) = (None, Modifiers::NONE);
    window.event(Event::Key { key: Key::Space, physical_key, pressed: true, repeat: true, modifiers });
    window.run_steps(2);
    assert!(!plays(&window));
    hold(&mut window, Key::Space, false);
    window.run_steps(2);
    assert!(plays(&window));
    press(&mut window, Modifiers::NONE, Key::Space);
    assert!(!plays(&window));
    // A drag without it moves the pin.
    settled(&mut window);
    drag(&mut window, [on_pin, on_pin + vec2(30.0, 12.0)]);
    assert_eq!(changes(&window), ["Move pin"]);
}

#[test]
fn a_tap_during_a_drag_of_a_pin_does_not_play() {
    let (_stage, mut window) = opened_with(PINS);
    let target = session(&window).marks()[0].pins[0].target.0;
    let on_pin = place(&window, target.x, target.y);
    pointer(&mut window, on_pin, Some(true));
    pointer(&mut window, on_pin + vec2(20.0, 0.0), None);
    press(&mut window, Modifiers::NONE, Key::Space);
    assert!(!plays(&window) && session(&window).is_dragging());
    pointer(&mut window, on_pin + vec2(40.0, 0.0), Some(false));
    assert_eq!(changes(&window), ["Move pin"]);
}

#[test]
fn the_key_that_pans_and_the_one_that_plays_can_be_two() {
    let stage = Stage::with(PINS);
    fs::create_dir_all(stage.state()).expect("a folder");
    fs::write(stage.state().join("keys.json"), "{ \"pan\": \"V\" }").expect("written");
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let (before, empty) = (seen(&window), place(&window, 0.05, 0.05));
    hold(&mut window, Key::V, true);
    drag(&mut window, [empty, empty + vec2(10.0, 20.0)]);
    hold(&mut window, Key::V, false);
    assert!((seen(&window).min - before.min - vec2(10.0, 20.0)).length() < 0.1);
    hold(&mut window, Key::Space, true);
    assert!(plays(&window), "it plays at once");
    hold(&mut window, Key::Space, false);
    press(&mut window, Modifiers::NONE, Key::F1);
    assert!(window.query_by_label("Key of Drag the picture; a tap plays").is_some());
}

#[test]
fn two_fingers_pan_and_a_wheel_zooms() {
    let (_stage, mut window) = opened_with(PINS);
    click(&mut window, &["Viewport"]);
    let at = place(&window, 0.9, 0.05);
    pointer(&mut window, at, None);
    use {MouseWheelSource as Source, MouseWheelUnit as Unit};
    for (unit, source) in
        [(Unit::Point, Source::Unknown), (Unit::Point, Source::Trackpad), (Unit::Point, Source::Momentum)]
    {
        let before = seen(&window);
        wheel(&mut window, unit, source, vec2(5.0, -6.0));
        let now = seen(&window);
        assert!((now.size() - before.size()).length() < 0.1, "{source:?} zooms");
        assert!((now.min - before.min - vec2(5.0, -6.0)).length() < 0.1, "{source:?}: {before:?} {now:?}");
    }
    for (unit, source) in [(Unit::Line, Source::Unknown), (Unit::Point, Source::Wheel)] {
        let before = seen(&window);
        wheel(&mut window, unit, source, vec2(0.0, 2.0));
        assert!(seen(&window).width() > 1.005 * before.width(), "{source:?} pans");
    }
    let before = seen(&window);
    window.event(Event::Zoom(1.5));
    window.run_steps(2);
    assert!((seen(&window).width() / before.width() - 1.5).abs() < 0.01, "a pinch zooms");
}
