//! What the window remembers from one session to the next.

use super::stage::Stage;
use super::window::{Window, pointer, settled, window};
use eframe::egui::{self, Key, Modifiers, Rect, Theme};
use egui_kittest::kittest::Queryable;
use std::fs;

fn opened(stage: &Stage) -> Window {
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window
}

/// The left edge of the picture: where the panel of the layers ends.
fn left(window: &Window) -> f32 {
    let picture: Rect = window.get_by_label("Viewport").rect();
    picture.left()
}

#[test]
fn theme_overlays_and_panels_are_as_they_were_left() {
    let stage = Stage::new();
    let mut window = opened(&stage);
    let file = stage.state().join("view.json");
    assert!(!file.exists(), "nothing was changed yet");
    window.key_press(Key::A);
    window.key_press(Key::N);
    window.run_steps(2);
    let before = left(&window);
    let middle = window.get_by_label("Viewport").rect().center().y;
    let edge = egui::pos2(before - 3.0, middle);
    pointer(&mut window, edge, None);
    pointer(&mut window, edge, Some(true));
    for step in 1..=4 {
        pointer(&mut window, edge + egui::vec2(10.0 * step as f32, 0.0), None);
    }
    pointer(&mut window, edge + egui::vec2(40.0, 0.0), Some(false));
    window.run_steps(3);
    let after = left(&window);
    assert!(after > before + 20.0, "{before} to {after}");
    window.get_by_label("View").click();
    window.run_steps(3);
    window.get_by_label("Light").click();
    window.run_steps(3);
    drop(window);

    let window = opened(&stage);
    assert!((left(&window) - after).abs() < 1.5, "{} instead of {after}", left(&window));
    assert_eq!(window.ctx.theme(), Theme::Light);
    let text = fs::read_to_string(&file).expect("it is kept");
    for part in ["\"theme\": \"light\"", "\"safe_areas\": true", "\"count\": 2", "\"timeline\": null"] {
        assert!(text.contains(part), "{part} in {text}");
    }
    drop(window);
    assert_eq!(fs::read_to_string(&file).expect("as it was"), text, "a start alone writes nothing");
}

#[test]
fn a_broken_file_is_told_and_replaced_by_the_next_change() {
    let stage = Stage::new();
    fs::create_dir_all(stage.state()).expect("a folder");
    let file = stage.state().join("view.json");
    fs::write(&file, "{ \"theme\": \"light\", broken").expect("written");
    let mut window = opened(&stage);
    assert!(window.query_by_label_contains("view.json").is_some(), "it is told");
    assert!(fs::read_to_string(&file).expect("there").contains("broken"));
    window.key_press(Key::A);
    window.run_steps(3);
    assert!(fs::read_to_string(&file).expect("there").contains("\"safe_areas\": true"));
}

/// The value of the edge of a panel, in points.
fn points(window: &Window, edge: &str) -> f32 {
    let value = window.get_by_label(edge).value().expect("screen readers know it");
    value.trim_end_matches(" points").parse().expect("a number of points")
}

#[test]
fn panels_are_resized_by_keyboard_and_by_screen_readers() {
    let stage = Stage::new();
    let mut window = opened(&stage);
    let edges = ["Height of the timeline", "Width of the layers", "Width of the numbers"];
    let before = edges.map(|edge| points(&window, edge));
    let margin = left(&window) - before[1];
    for (edge, key) in edges.into_iter().zip([Key::ArrowUp, Key::ArrowRight, Key::ArrowLeft]) {
        window.get_by_label(edge).focus();
        window.run_steps(2);
        window.key_press(key);
        window.run_steps(2);
    }
    let grown = edges.map(|edge| points(&window, edge));
    assert!((0..3).all(|edge| grown[edge] == before[edge] + 10.0), "{before:?} to {grown:?}");
    assert!((left(&window) - grown[1] - margin).abs() < 1.0, "the value is the width");
    // The last one still has the focus, and stops at its limit.
    for _ in 0..3 {
        window.key_press_modifiers(Modifiers::SHIFT, Key::ArrowLeft);
        window.run_steps(2);
    }
    assert_eq!(points(&window, edges[2]), (grown[2] + 150.0).min(420.0));
    window.get_by_label(edges[1]).decrement_accesskit();
    window.run_steps(3);
    let after = edges.map(|edge| points(&window, edge));
    assert!(after[1] < grown[1] && after[0] == grown[0], "{grown:?} to {after:?}");
    let labels = super::window::session(&window).document().history().labels().count();
    assert_eq!(labels, 0, "arrows nudge nothing meanwhile");
    drop(window);
    let window = opened(&stage);
    assert_eq!(edges.map(|edge| points(&window, edge)), after, "remembered");
}
