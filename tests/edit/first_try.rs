//! What a person tries who has read nothing: quick drags, clicks beside what was meant.

use super::acts::{click, press};
use super::seen::{says, texts};
use super::stage::{PINS, REACH, Stage, TIMEOUT, at, drag, place_pin, until};
use super::window::{self, changes, opened_with, place, pointer, session, settled};
use eframe::egui::epaint::ClippedShape;
use eframe::egui::{Event, Key, Modifiers, PointerButton, Rect, Shape, pos2, vec2};
use egui_kittest::kittest::Queryable;
use pinwarp::edit::{Held, Ring, Session, open};
use pinwarp::image::{Preview, write_png};
use pinwarp::raster::DeviceChoice;
use pinwarp::scene::FileAccess;

#[test]
fn a_drag_that_is_quicker_than_the_window_moves_the_pin_under_the_press() {
    let (_stage, mut window) = opened_with(PINS);
    let target = session(&window).marks()[0].pins[0].target.0;
    let from = place(&window, target.x, target.y);
    let button = |pos, pressed| {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        Event::PointerButton { pos, button, pressed, modifiers }
    };
    window.event(Event::PointerMoved(from));
    window.step();
    // Farther than a pin can be caught from, before the next pass.
    let far = from + vec2(16.0, -12.0);
    window.event(button(from, true));
    window.event(Event::PointerMoved(far));
    window.step();
    window.event(Event::PointerMoved(far + vec2(20.0, 0.0)));
    window.event(button(far + vec2(20.0, 0.0), false));
    window.event(Event::PointerMoved(far + vec2(90.0, 0.0)));
    window.step();
    assert_eq!(changes(&window), ["Move pin"]);
    settled(&mut window);
    let moved = session(&window).marks()[0].pins[0].target.0;
    let moved = place(&window, moved.x, moved.y) - from;
    assert!((moved - vec2(36.0, -12.0)).length() < 0.5, "{moved:?}");
    // A whole drag within one pass.
    window.event(button(from + moved, true));
    window.event(button(from, false));
    window.step();
    assert_eq!(changes(&window), ["Move pin", "Move pin"]);
}

/// The ring as the window draws it.
const RING: Ring = Ring { radius: 0.12, reach: 0.02 };

fn pins(session: &Session) -> usize {
    session.document().shot().layers[0].pins.len()
}

#[test]
fn a_click_on_a_ring_places_a_pin_and_turns_nothing() {
    let stage = Stage::with(PINS);
    let mut session = stage.session();
    session.selection.only_pin([0, 0]);
    let (text, center) = (session.document().text().to_owned(), session.marks()[0].pins[0].target.0);
    let up = |radius: f64| at(center.x, center.y + radius);
    session.press(up(RING.radius), (REACH, RING), Held::default());
    // A hand shakes.
    session.motion(at(center.x + 0.005, center.y + RING.radius));
    session.release();
    until(&mut session, "a pin is placed under the ring", |session| pins(session) == 3);
    assert_eq!(session.document().history().labels().collect::<Vec<_>>(), ["Add pin"]);
    session.undo();
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    session.selection.only_pin([0, 0]);
    // Nothing can be pinned there.
    session.press(up(0.9), (REACH, Ring { radius: 0.9, reach: 0.02 }), Held::default());
    session.release();
    // Questions are answered before frames are drawn.
    session.go(1);
    until(&mut session, "the click is answered", Session::is_idle);
    assert_eq!(session.document().text(), text);
    assert_eq!(session.selection.single_pin(), Some([0, 0]), "a click on nothing changes nothing");
}

#[test]
fn a_pin_that_lies_on_the_ring_of_another_is_dragged() {
    let stage = Stage::with(PINS);
    let mut session = stage.session();
    session.selection.only_pin([0, 0]);
    let [a, b] = [0, 1].map(|pin| session.marks()[0].pins[pin].target.0);
    let ring = Ring { radius: (b - a).length(), reach: 0.02 };
    session.press(at(b.x, b.y), (REACH, ring), Held::default());
    session.motion(at(b.x + 0.03, b.y));
    session.release();
    assert_eq!(session.document().history().labels().collect::<Vec<_>>(), ["Move pin"]);
    assert_eq!(session.selection.single_pin(), Some([0, 1]));
}

#[test]
fn a_drag_of_the_only_pin_says_how_the_rest_stays_and_that_works() {
    let (_stage, mut session) = Stage::open();
    place_pin(&mut session, at(0.3, 0.5));
    drag(&mut session, [0.3, 0.5], [0.35, 0.6]);
    let told = session.message().unwrap_or_default().to_owned();
    assert!(told.contains("Ctrl+Z, click where the model should stay, then drag"), "{told}");
    session.undo();
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    place_pin(&mut session, at(0.6, 0.5));
    drag(&mut session, [0.3, 0.5], [0.35, 0.6]);
    let pin = &session.marks()[0].pins[1];
    assert!((pin.target - pin.rest).0.length() < 1e-9, "it stays: {pin:?}");
}

#[test]
fn who_deletes_a_layer_is_told_what_went_and_how_it_comes_back() {
    let stage = Stage::with(PINS);
    let mut session = stage.session();
    session.delete_layer();
    let told = session.message().unwrap_or_default().to_owned();
    assert_eq!(told, "Deleted: layer 'left' with 2 pins and 6 keys. Ctrl+Z brings it back.");
    session.undo();
    assert_eq!(session.document().shot().layers[0].pins.len(), 2);
}

#[test]
fn a_render_is_begun_by_a_button_that_says_where_frames_go_and_its_end_is_told() {
    let (stage, mut window) = opened_with(PINS);
    let folder = stage.folder.path().join("out");
    let button = window.get_by_label("Render frames").rect().center();
    pointer(&mut window, button, None);
    window.run_steps(8);
    let hint = format!("Writes the frames to {}", folder.join("frame.####.exr").display());
    assert!(says(&window, &hint), "its tool tip: {:?}", texts(&window));
    click(&mut window, &["Render frames"]);
    let shown = format!("Frames go to {}", folder.join("frame.####.exr").display());
    assert!(says(&window, &shown));
    click(&mut window, &["Close window"]);
    window::until(&mut window, "the render ends", |window| !session(window).is_rendering());
    let told = session(&window).message().unwrap_or_default().to_owned();
    assert_eq!(told, format!("Rendered: 6 EXR frames and 6 PNG previews in {}", folder.display()));
    assert!(!says(&window, &shown), "its window is closed");
    click(&mut window, &["Show the render"]);
    assert!(says(&window, &shown) && window.query_by_label("Show the render").is_none());
}

#[test]
fn the_list_of_keys_fits_a_small_window() {
    let (_stage, mut window) = opened_with(PINS);
    window.set_size(vec2(1100.0, 700.0));
    press(&mut window, Modifiers::NONE, Key::F1);
    window.run_steps(4);
    let close = window.get_by_label("Close window").rect();
    let screen = Rect::from_min_size(pos2(0.0, 0.0), vec2(1100.0, 700.0));
    assert!(screen.contains_rect(close), "{close:?}");
    click(&mut window, &["Close window"]);
    assert!(window.query_by_label("Key of Undo").is_none(), "it is closed");
}

#[test]
fn pins_of_drawings_are_named_pin_and_hints_say_drawing() {
    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("puppet.png");
    write_png(&picture, &Preview { width: 64, height: 64, rgba: vec![255; 64 * 64 * 4] }).expect("written");
    let document = open(&picture, FileAccess::SceneFolder).expect("a picture");
    let mut session = Session::new(document, DeviceChoice::Cpu, || ());
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    assert_eq!(session.subject(), "drawing");
    place_pin(&mut session, at(0.3, 0.5));
    place_pin(&mut session, at(0.6, 0.5));
    let names: Vec<&str> = session.document().shot().layers[0].pins.iter().map(|pin| pin.name.as_str()).collect();
    assert_eq!(names, ["pin", "pin 2"]);
}

#[test]
fn a_scene_that_is_opened_says_which_shot_it_is_of() {
    let stage = Stage::new();
    std::fs::rename(stage.shot(), stage.folder.path().join("cards.toml")).expect("renamed");
    let mut window = window::window(&stage.state(), Some(&stage.folder.path().join("cards.gltf")));
    assert_eq!(session(&window).message(), Some("cards.toml opened, the shot of cards.gltf"));
    click(&mut window, &["left"]);
    assert!(says(&window, "Click the model to place one"));
}

#[test]
fn the_line_between_keys_leaves_the_name_of_the_row_alone() {
    let stage = Stage::with(&PINS.replacen("frame = 1, offset", "frame = -40, offset", 1));
    let mut window = window::window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let row = window.get_by_label("Keys of a").rect();
    let crosses = |clipped: &ClippedShape| match &clipped.shape {
        Shape::LineSegment { points, .. } => {
            let is_in_row = row.y_range().contains(points[0].y) && points[0].y == points[1].y;
            is_in_row && clipped.clip_rect.left().max(points[0].x.min(points[1].x)) < row.left() + 100.0
        }
        _ => false,
    };
    let lines = window.output().shapes.iter().filter(|clipped| crosses(clipped) && clipped.clip_rect.width() > 0.0);
    // The line below the row runs through.
    assert!(lines.clone().all(|clipped| clipped.shape.visual_bounding_rect().center().y > row.center().y + 5.0));
}

#[test]
fn the_start_page_lists_shots_that_were_open() {
    let (stage, window) = opened_with(PINS);
    drop(window);
    let mut window = window::window(&stage.state(), None);
    click(&mut window, &[&stage.shot().display().to_string()]);
    assert_eq!(session(&window).document().path(), stage.shot());
    drop(window);
    std::fs::remove_file(stage.shot()).expect("removed");
    let window = window::window(&stage.state(), None);
    assert!(!says(&window, "Recent shots"));
}

#[test]
fn the_tour_points_at_the_hand_and_says_where_the_work_is_kept() {
    let stage = Stage::new();
    let mut window = window::window(&stage.state(), None);
    click(&mut window, &["Take the tour of two minutes"]);
    let pointed = session(&window).shown.pointed.expect("it points at a pin");
    assert_eq!(session(&window).shot().layers[pointed[0]].pins[pointed[1]].name, "near hand");
    click(&mut window, &["Skip this step"]);
    assert_eq!(session(&window).shown.pointed, None);
    click(&mut window, &["Skip this step"]);
    assert!(says(&window, "on twos") && session(&window).shown.pointed == Some(pointed));
    click(&mut window, &["Skip this step", "Skip this step", "Skip this step"]);
    let folder = session(&window).shot().output.path.parent().expect("a folder").display().to_string();
    assert!(says(&window, "Ctrl+S saves the shot") && says(&window, &folder));
    click(&mut window, &["End the tour"]);
    assert_eq!(session(&window).shown.pointed, None);
}

#[test]
fn tool_tips_say_what_a_widget_does() {
    let (_stage, mut window) = opened_with(PINS);
    click(&mut window, &["a"]);
    let tips = [
        ("Space", "Where the lattice lies"),
        ("Basis", "How handles pull"),
        ("Box", "What the lattice covers"),
        ("Nodes", "The parts of the scene"),
        ("Rotation", "Turns what surrounds the pin"),
        ("Exposure", "a drag in frame 12 keys frame 11"),
        ("Strength", "How much of the warp"),
        ("Smoothness", "a pin pulls more of the layer along"),
        ("Pin error, px", "Above 0.05"),
        ("Distortion", "Above 1 the shape looks sheared"),
    ];
    for (label, words) in tips {
        let places: Vec<Rect> = window.query_all_by_label(label).map(|node| node.rect()).collect();
        let is_told = places.iter().any(|place| {
            pointer(&mut window, place.center(), None);
            window.run_steps(6);
            texts(&window).iter().any(|text| text.replace('\n', " ").contains(words))
        });
        assert!(is_told, "{label}: {words}");
    }
}

#[test]
fn a_mark_of_the_ruler_says_its_frame_and_figure() {
    let (_stage, mut window) = opened_with(PINS);
    window::until(&mut window, "all frames are reported", |window| session(window).reported() == [6, 6]);
    let mark = window.query_all_by_label_contains("Worst by ").next().map(|node| node.rect().center()).expect("a mark");
    assert!(!says(&window, "Worst by "));
    pointer(&mut window, mark, None);
    window.run_steps(6);
    assert!(says(&window, "Worst by "), "its tool tip");
}
