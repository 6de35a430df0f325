//! What cannot be drawn is told in the window, and what mends it is noticed.

use super::acts::click;
use super::stage::{PINS, SHOT, Stage};
use super::window::{Window, opened_with, session, settled, until, window};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use eframe::egui::Shape;
use serde_json::Value;
use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the line below the panels tells a fault, in its own colour.
fn tells(window: &Window, words: &str) -> bool {
    let color = window.ctx.style_of(window.ctx.theme()).visuals.error_fg_color;
    window.output().shapes.iter().any(|clipped| {
        let Shape::Text(text) = &clipped.shape else { return false };
        let is_red = text.galley.job.sections.iter().any(|section| section.format.color == color);
        is_red && text.galley.job.text.contains(words)
    })
}

#[test]
fn a_scene_that_breaks_on_disk_is_told_and_drawn_again_once_it_is_whole() {
    let (stage, mut window) = opened_with(PINS);
    let scene = stage.folder.path().join("cards.gltf");
    let whole = fs::read(&scene).expect("there");
    fs::write(&scene, "{ \"asset\": ").expect("written");
    until(&mut window, "it is told", |window| tells(window, "cards.gltf"));
    fs::write(&scene, whole).expect("written");
    until(&mut window, "it is drawn again", |window| session(window).is_final());
    assert!(!tells(&window, ""), "{:?}", session(&window).fault());
}

#[test]
fn a_scene_or_a_shot_that_was_missing_at_the_start_is_noticed() {
    let stage = Stage::new();
    fs::write(stage.shot(), SHOT.replace("cards.gltf", "lost.gltf")).expect("written");
    let mut window = window(&stage.state(), Some(&stage.shot()));
    until(&mut window, "it is told", |window| tells(window, "lost.gltf"));
    fs::copy(stage.folder.path().join("cards.gltf"), stage.folder.path().join("lost.gltf")).expect("copied");
    settled(&mut window);
    assert!(!tells(&window, ""));
    fs::remove_file(stage.folder.path().join("lost.gltf")).expect("there");
    let mut window = self::window(&stage.state(), Some(&stage.shot()));
    until(&mut window, "it is told", |window| tells(window, "lost.gltf"));
    // Somebody names the right scene in a text editor.
    fs::write(stage.shot(), SHOT).expect("written");
    settled(&mut window);
    assert_eq!(session(&window).document().text(), SHOT);
}

#[test]
fn a_file_beside_the_scene_that_was_missing_at_the_start_is_noticed() {
    let stage = Stage::new();
    let [scene, beside] = ["cards.gltf", "cards.bin"].map(|name| stage.folder.path().join(name));
    let mut json: Value = serde_json::from_slice(&fs::read(&scene).expect("there")).expect("JSON");
    let uri = std::mem::replace(&mut json["buffers"][0]["uri"], "cards.bin".into());
    let (_, data) = uri.as_str().and_then(|uri| uri.split_once(',')).expect("its bytes");
    fs::write(&scene, json.to_string()).expect("written");
    let mut window = window(&stage.state(), Some(&stage.shot()));
    until(&mut window, "it is told", |window| tells(window, "cards.bin"));
    fs::write(&beside, STANDARD.decode(data).expect("base64")).expect("written");
    settled(&mut window);
    assert!(!tells(&window, ""), "{:?}", session(&window).fault());
}

#[test]
fn a_panic_while_drawing_is_told_and_the_next_frame_is_drawn() {
    let (_stage, mut window) = opened_with(PINS);
    until(&mut window, "all frames are drawn", |window| session(window).is_idle());
    let is_armed = Arc::new(AtomicBool::new(true));
    let own = Arc::clone(&is_armed);
    // Whoever draws frames wakes the window.
    window.ctx.set_repaint_observer(move |_| {
        let is_drawing = std::thread::current().name().is_some_and(|name| name.starts_with("edit: frames"));
        assert!(!(is_drawing && own.swap(false, Ordering::Relaxed)), "a panic of this test");
    });
    click(&mut window, &["Mute pin a"]);
    until(&mut window, "it is told", |window| tells(window, "internal error"));
    assert!(!is_armed.load(Ordering::Relaxed));
    click(&mut window, &["Frame forward"]);
    settled(&mut window);
    assert!(!tells(&window, ""), "{:?}", session(&window).fault());
    assert!(session(&window).document().shot().layers[0].pins[0].is_muted, "nothing is lost");
}
