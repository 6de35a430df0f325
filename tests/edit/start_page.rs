//! Ways between the start page, recent shots and files, and what is asked on them.

use super::acts::click;
use super::seen::{says, texts};
use super::stage::{SHOT, Stage};
use super::window::{Window, pointer, session, settled, window};
use egui_kittest::kittest::Queryable;
use pinwarp::edit::ui::Editor;
use std::fs;

fn is_open(window: &Window) -> bool {
    window.state().as_ref().and_then(Editor::session).is_some()
}

#[test]
fn the_file_menu_leads_back_to_the_start_page_and_to_recent_shots() {
    let stage = Stage::new();
    let other = stage.folder.path().join("other.toml");
    fs::write(&other, SHOT).expect("written");
    drop(window(&stage.state(), Some(&other)));
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    click(&mut window, &["File", "Open recent", "other.toml"]);
    assert_eq!(session(&window).document().path(), other);
    window.get_by_label("File").click();
    window.run_steps(3);
    window.get_by_label_contains("New, from the start page").click();
    window.run_steps(3);
    assert!(!is_open(&window) && says(&window, "Or begin with one of these"), "{:?}", texts(&window));
    click(&mut window, &["Teapot"]);
    assert!(session(&window).document().path().ends_with("teapot/shot.toml"));
}

#[test]
fn a_model_that_was_only_opened_is_left_without_a_question() {
    let stage = Stage::new();
    let model = stage.folder.path().join("cards.gltf");
    let mut window = window(&stage.state(), Some(&model));
    window.get_by_label("File").click();
    window.run_steps(3);
    window.get_by_label_contains("New, from the start page").click();
    window.run_steps(3);
    assert!(!is_open(&window) && !says(&window, "Save the changes?"), "{:?}", texts(&window));
}

#[test]
fn a_double_click_opens_a_file_however_slow_the_window_is() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    fs::write(stage.folder.path().join("other.toml"), SHOT).expect("written");
    window.key_press_modifiers(eframe::egui::Modifiers::COMMAND, eframe::egui::Key::O);
    window.run_steps(3);
    let entry = window.get_by_label("other.toml").rect().center();
    for pressed in [true, false, true, false] {
        pointer(&mut window, entry, Some(pressed));
    }
    window.run_steps(3);
    assert!(session(&window).document().path().ends_with("other.toml"), "{:?}", texts(&window));
}
