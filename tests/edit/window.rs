//! The real interface, driven through its accessibility tree and by a pointer: what a person does in the first three minutes.

use super::seen::Textures;
use super::stage::{SHOT, Stage, TIMEOUT};
use eframe::egui::{self, Event, Key, Modifiers, PointerButton, Pos2, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use pinwarp::edit::Session;
use pinwarp::edit::ui::{Editor, EditorOptions};
use pinwarp::raster::DeviceChoice;
use pinwarp::scene::FileAccess;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// The editor, which is made in its first pass.
pub(crate) type Window = Harness<'static, Option<Editor>>;

pub(crate) fn window(state: &Path, file: Option<&Path>) -> Window {
    let options =
        EditorOptions { device: DeviceChoice::Cpu, access: FileAccess::SceneFolder, folder: state.to_owned() };
    let file = file.map(Path::to_owned);
    let show = move |ui: &mut egui::Ui, editor: &mut Option<Editor>| {
        let editor = editor.get_or_insert_with(|| {
            let mut editor = Editor::new(ui.ctx(), options.clone());
            if let Some(file) = &file {
                editor.open(ui.ctx(), file).expect("it opens");
            }
            editor
        });
        editor.ui(ui);
    };
    let textures = Textures::default();
    let builder = Harness::builder().with_size(egui::vec2(1280.0, 800.0)).renderer(textures.clone());
    let mut window = builder.with_context_setup(move |ctx| textures.install(ctx)).build_ui_state(show, None);
    window.run_steps(3);
    window
}

/// A window on a shot whose left layer has more, its first frame drawn.
pub(crate) fn opened_with(more: &str) -> (Stage, Window) {
    let stage = Stage::with(more);
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    (stage, window)
}

pub(crate) fn session(window: &Window) -> &Session {
    window.state().as_ref().and_then(Editor::session).expect("a shot is open")
}

pub(crate) fn until(window: &mut Window, what: &str, holds: impl Fn(&Window) -> bool) {
    let begun = Instant::now();
    while !holds(window) {
        let fault = window.state().as_ref().and_then(Editor::session).and_then(Session::fault);
        assert!(begun.elapsed() < TIMEOUT, "{what}: {fault:?}");
        window.step();
        std::thread::sleep(Duration::from_millis(2));
    }
    window.run_steps(2);
}

pub(crate) fn settled(window: &mut Window) {
    until(window, "the frame is drawn", |window| session(window).is_final());
}

pub(crate) fn pointer(window: &mut Window, at: Pos2, pressed: Option<bool>) {
    window.event(Event::PointerMoved(at));
    if let Some(pressed) = pressed {
        let modifiers = Modifiers::NONE;
        window.event(Event::PointerButton { pos: at, button: PointerButton::Primary, pressed, modifiers });
    }
    window.step();
}

/// The changes that can be undone.
pub(crate) fn changes(window: &Window) -> Vec<String> {
    session(window).document().history().labels().map(str::to_owned).collect()
}

/// A point of the picture in the window, in frame heights from its lower left corner.
pub(crate) fn place(window: &Window, x: f64, y: f64) -> Pos2 {
    let rect: Rect = window.get_by_label("Viewport").rect();
    let session = session(window);
    let viewport = glam::DVec2::new(rect.width().into(), rect.height().into());
    let lens = session.zoom.lens(session.shot().size, viewport);
    let at = lens.viewport_from_screen(pinwarp::space::ScreenPoint::new(x, y));
    rect.min + egui::vec2(at.x as f32, at.y as f32)
}

fn pins(window: &Window) -> usize {
    session(window).document().shot().layers.iter().map(|layer| layer.pins.len()).sum()
}

/// Opens, pins, drags, keys, undoes, saves.
#[test]
fn a_pose_is_keyed_and_saved_with_the_pointer() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let on_card = place(&window, 0.4, 0.5);
    pointer(&mut window, on_card, Some(true));
    pointer(&mut window, on_card, Some(false));
    until(&mut window, "a click places a pin", |window| pins(window) == 1);
    settled(&mut window);
    window.get_by_label("Frame forward").click();
    window.step();
    until(&mut window, "the next frame is seen", |window| session(window).playhead.frame() == 2);
    settled(&mut window);
    let pin = session(&window).marks()[0].pins[0].target.0;
    let (from, to) = (place(&window, pin.x, pin.y), place(&window, pin.x + 0.1, pin.y + 0.15));
    pointer(&mut window, from, Some(true));
    pointer(&mut window, from + 0.5 * (to - from), None);
    pointer(&mut window, to, None);
    pointer(&mut window, to, Some(false));
    settled(&mut window);
    let keys = &session(&window).document().shot().layers[0].pins[0].keys;
    assert_eq!(keys.iter().map(|key| key.frame).collect::<Vec<_>>(), [1.0, 2.0]);
    let mark = &session(&window).marks()[0].pins[0];
    assert!(((mark.target - mark.rest).0 - glam::DVec2::new(0.1, 0.15)).length() < 5e-3, "{mark:?}");
    assert!(session(&window).document().is_dirty());
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    window.run_steps(2);
    assert!(!session(&window).document().is_dirty(), "{:?}", session(&window).message());
    assert_eq!(fs::read_to_string(stage.shot()).expect("saved"), session(&window).document().text());
    for _ in 0..2 {
        window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        window.run_steps(2);
    }
    assert_eq!(session(&window).document().text(), SHOT);
}

/// What a killed editor leaves is offered again, on the start page and with its shot.
#[test]
fn a_kill_loses_nothing() {
    let stage = Stage::new();
    let left = stage.state().join("journals/killed.pinwarp-journal");
    let (text, journal) = {
        let mut window = window(&stage.state(), Some(&stage.shot()));
        settled(&mut window);
        let on_card = place(&window, 0.4, 0.5);
        pointer(&mut window, on_card, Some(true));
        pointer(&mut window, on_card, Some(false));
        until(&mut window, "a click places a pin", |window| pins(window) == 1);
        // As it is on disk in the moment of the kill.
        let mut journals = fs::read_dir(stage.state().join("journals")).expect("a folder");
        let path = journals.next().expect("a journal").expect("readable").path();
        (session(&window).document().text().to_owned(), fs::read(path).expect("a journal"))
    };
    fs::write(&left, &journal).expect("written");
    let mut window = window(&stage.state(), None);
    window.get_by_label("Recover").click();
    window.run_steps(3);
    assert_eq!(session(&window).document().text(), text);
    assert!(session(&window).document().is_dirty());
    settled(&mut window);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(2);
    assert_eq!(session(&window).document().text(), SHOT, "its history came back, too");
    drop(window);
    assert!(!left.exists(), "it went on with that journal, and closed it");
    fs::write(&left, &journal).expect("written");
    let mut window = self::window(&stage.state(), Some(&stage.shot()));
    assert_eq!(session(&window).document().text(), SHOT);
    window.get_by_label("Recover").click();
    window.run_steps(3);
    assert_eq!(session(&window).document().text(), text);
}

/// Another file is overwritten by a shot only after a question.
#[test]
fn saving_over_another_file_is_asked_about() {
    let stage = Stage::new();
    let other = stage.folder.path().join("other.toml");
    fs::write(&other, "mine").expect("written");
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    for (answer, is_saved) in [("Cancel", false), ("Overwrite", true)] {
        window.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
        window.run_steps(3);
        assert!(window.query_by_label("cards.gltf").is_none(), "only shots are listed");
        window.get_by_label("other.toml").click();
        window.run_steps(2);
        window.get_by_label("Choose").click();
        window.run_steps(3);
        assert_eq!(fs::read_to_string(&other).expect("there"), "mine");
        window.get_by_label(answer).click();
        window.run_steps(3);
        assert_eq!(fs::read_to_string(&other).expect("there"), if is_saved { SHOT } else { "mine" });
        assert_eq!(session(&window).document().path().ends_with("other.toml"), is_saved);
    }
}

/// The bundled scenes open, and a render begins and ends.
#[test]
fn a_bundled_scene_is_rendered_from_the_window() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.key_press_modifiers(Modifiers::COMMAND, Key::R);
    window.run_steps(2);
    until(&mut window, "the render ends", |window| {
        let run = session(window).run();
        run.is_some_and(|run| run.state != pinwarp::edit::RunState::Running)
    });
    for frame in 1..=6 {
        assert!(stage.folder.path().join(format!("out/frame.{frame:04}.exr")).is_file());
    }
    window.get_by_label("Look at the frames").click();
    window.run_steps(3);
    assert!(session(&window).shows_rendered());
    let mut start = self::window(&stage.state(), None);
    start.get_by_label("Teapot").click();
    start.run_steps(3);
    assert!(session(&start).document().path().ends_with("teapot/shot.toml"));
}

/// Curves take the place of rows; a key is dragged up in them; weight and rest of a pin are set beside the picture.
#[test]
fn a_curve_is_dragged_and_a_pin_is_muted() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let on_card = place(&window, 0.4, 0.5);
    pointer(&mut window, on_card, Some(true));
    pointer(&mut window, on_card, Some(false));
    until(&mut window, "a click places a pin", |window| pins(window) == 1);
    settled(&mut window);
    window.get_by_label("Curves").click();
    window.run_steps(2);
    let plot: Rect = window.get_by_label("Curves of keys").rect();
    // The only key of x and y stands in the first of six frames, in the middle of the height.
    let frames = egui::Rect::from_min_max(plot.min + egui::vec2(150.0, 0.0), plot.max - egui::vec2(16.0, 0.0));
    let key = egui::pos2(frames.left() + frames.width() / 12.0, plot.center().y);
    pointer(&mut window, key, Some(true));
    for step in 1..=4 {
        pointer(&mut window, key - egui::vec2(0.0, 5.0 * step as f32), None);
    }
    pointer(&mut window, key - egui::vec2(0.0, 20.0), Some(false));
    let moved = |window: &Window| session(window).document().shot().layers[0].pins[0].keys[0].goal;
    let pinwarp::shot::Goal::Offset(offset) = moved(&window) else { panic!("{:?}", moved(&window)) };
    assert!(offset.0.length() > 1e-3, "{offset:?}");
    let labels: Vec<&str> = session(&window).document().history().labels().collect();
    assert_eq!(labels, ["Add pin", "Move key"], "a drag is undone at once");
    window.get_by_label("Mute").click();
    window.run_steps(2);
    assert!(session(&window).document().shot().layers[0].pins[0].is_muted);
    window.get_by_label("Unmute").click();
    window.run_steps(2);
    assert!(!session(&window).document().shot().layers[0].pins[0].is_muted);
    assert!(window.query_all_by_label("Weight").next().is_some());
}

/// Every control that is seen has a name.
#[test]
fn clickable_widgets_have_names() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let nameless: Vec<String> = window
        .query_all(egui_kittest::kittest::by().predicate(|node| {
            let is_control = matches!(node.role(), egui::accesskit::Role::Button | egui::accesskit::Role::CheckBox);
            is_control && node.label().is_none_or(|label| label.trim().is_empty())
        }))
        .map(|node| format!("{node:?}"))
        .collect();
    assert!(nameless.is_empty(), "{nameless:?}");
    for name in
        ["Play", "Frame", "Strength", "Smoothness", "Layer name", "Viewport", "Frames", "Mute the layer \"left\""]
    {
        // A slider and its number share a name.
        assert!(window.query_all_by_label(name).next().is_some(), "{name}");
    }
}
