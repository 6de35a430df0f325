//! The window of an export has the options of its format, and a running one is asked about.

use super::acts::{Handed, click};
use super::stage::{SHOT, Stage};
use super::window::{Window, session, settled, window};
use eframe::egui;
use egui_kittest::kittest::{NodeT, Queryable};
use pinwarp::edit::EXPORTS;
use pinwarp::edit::ui::Editor;
use std::fs;
use std::path::Path;
use std::sync::Arc;

fn order(window: &mut Window, format: &str) {
    for entry in ["File", "Export", format] {
        window.get_by_label(entry).click();
        window.run_steps(3);
    }
}

#[test]
fn an_export_is_ordered_with_the_options_of_its_format() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    order(&mut window, "glTF with shape keys");
    let has = |window: &Window, label: &str| window.query_all_by_label(label).next().is_some();
    assert!(has(&window, "Export Frames") && has(&window, "Replace existing files"));
    assert!(!has(&window, "Overscan") && !has(&window, "Export layer left"), "it has neither maps nor layers");
    order(&mut window, "STMaps (EXR)");
    for label in ["Export Output", "Width of the maps", "Overscan", "Inverse maps, which undo the warp", "Start export"]
    {
        assert!(has(&window, label), "{label}");
    }
    window.get_by_label("Export layer left").click();
    window.run_steps(2);
    assert!(!window.get_by_label("Start export").accesskit_node().is_disabled());
    window.get_by_label("Export layer right").click();
    window.run_steps(2);
    assert!(window.get_by_label("Start export").accesskit_node().is_disabled(), "no layer is left");
    assert_eq!(session(&window).document().text(), SHOT, "options of an export are not saved");
}

#[test]
fn an_export_that_runs_is_asked_about_when_another_shot_is_opened() {
    let stage = Stage::new();
    let other = stage.folder.path().join("other.toml");
    fs::write(&other, SHOT).expect("written");
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let begin = |window: &mut Window| {
        let session = window.state_mut().as_mut().and_then(Editor::session_mut).expect("a shot is open");
        session.pretend_export(&EXPORTS[0])
    };
    let leave = |window: &mut Window, file: &Path| {
        window.input_mut().dropped_files.push(Arc::new(Handed(file.to_owned())) as egui::DroppedFileHandle);
        window.run_steps(3);
    };
    let _end = begin(&mut window);
    leave(&mut window, &other);
    assert_eq!(session(&window).document().path(), stage.shot(), "it is asked first");
    click(&mut window, &["Stay here"]);
    assert!(session(&window).is_exporting() && session(&window).document().path() == stage.shot());
    // A file that cannot be opened leaves it alone.
    leave(&mut window, &stage.folder.path().join("none.toml"));
    click(&mut window, &["Cancel the export"]);
    assert!(session(&window).is_exporting() && session(&window).document().path() == stage.shot());
    leave(&mut window, &other);
    click(&mut window, &["Cancel the export"]);
    assert!(!session(&window).is_exporting() && session(&window).document().path() == other);
    // It ends by itself while the question is open.
    let end = begin(&mut window);
    leave(&mut window, &stage.shot());
    assert!(window.query_by_label("Cancel the export").is_some());
    end(true);
    window.run_steps(3);
    assert!(window.query_by_label("Stay here").is_none() && session(&window).document().path() == stage.shot());
}
