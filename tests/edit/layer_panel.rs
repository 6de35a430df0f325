//! The list of layers and their settings in the real interface: each is seen in the picture, in the marks or in the file.

use super::acts::{choose, click, number, press};
use super::seen::{beside_cards, pictures, says};
use super::stage::{PINS, SHOT, Stage};
use super::window::{self, Window, changes, opened_with, session, settled, until};
use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use pinwarp::edit::Figure;
use std::fs;

/// The third frame of the shot with pins, in which the left layer is pulled.
fn pulled() -> (Stage, Window) {
    let (stage, mut window) = opened_with(PINS);
    click(&mut window, &["Frame forward", "Frame forward"]);
    settled(&mut window);
    (stage, window)
}

/// How much the pins pull beside the cards, once the frame is drawn.
fn pull(window: &mut Window) -> usize {
    settled(window);
    beside_cards(&pictures(window)[0].image)
}

fn text(window: &Window) -> String {
    session(window).document().text().to_owned()
}

fn undo(window: &mut Window) {
    press(window, Modifiers::COMMAND, Key::Z);
}

#[test]
fn muted_layers_rest_and_those_beside_a_solo_rest_in_the_picture_alone() {
    let (_stage, mut window) = pulled();
    let (whole, before) = (pull(&mut window), text(&window));
    assert!(whole > 20, "{whole}");
    // What is clicked, and whether the left layer acts then.
    for (label, acts) in [
        ("Mute the layer \"left\"", false),
        ("Unmute the layer \"left\"", true),
        ("Mute the layer \"right\"", true),
        ("Unmute the layer \"right\"", true),
        ("Solo right", false),
        ("Solo left", true),
        ("Mute the layer \"left\"", false),
        ("Solo left", false),
        ("Unmute the layer \"left\"", true),
    ] {
        click(&mut window, &[label]);
        assert_eq!(pull(&mut window), if acts { whole } else { 0 }, "{label}");
        let solo = session(&window).solo().map(str::to_owned);
        assert_eq!(says(&window, "but for the solo of"), solo.is_some(), "{label}");
        // Mute is of the shot, solo of the window.
        let muted = session(&window).document().shot().layers.iter().filter(|layer| layer.is_muted).count();
        assert_eq!(text(&window).matches("mute = true").count(), muted, "{label}");
        assert_eq!(label.starts_with("Mute"), muted == 1 && !label.starts_with("Solo"), "{label}");
    }
    assert_eq!(text(&window), before, "the file is as it was");
}

#[test]
fn the_strength_of_a_layer_scales_its_warp() {
    let (_stage, mut window) = pulled();
    let (whole, before) = (pull(&mut window), text(&window));
    number(&mut window, "Strength", 0.5);
    assert!(text(&window).contains("strength = 0.5"), "{}", text(&window));
    let half = pull(&mut window);
    assert!(0 < half && half < whole, "{half} of {whole}");
    number(&mut window, "Strength", 0.0);
    assert_eq!(pull(&mut window), 0);
    assert_eq!(changes(&window), ["Change strength"], "changes in a row are undone at once");
    undo(&mut window);
    assert_eq!((text(&window), pull(&mut window)), (before, whole));
}

#[test]
fn layers_change_their_order_are_added_and_deleted() {
    let (_stage, mut window) = pulled();
    let before = text(&window);
    let names = |window: &Window| -> Vec<String> {
        session(window).document().shot().layers.iter().map(|layer| layer.name.clone()).collect()
    };
    click(&mut window, &["Layer up"]);
    assert_eq!(names(&window), ["left", "right"], "it is the first");
    click(&mut window, &["Layer down"]);
    assert_eq!(names(&window), ["right", "left"]);
    assert_eq!(session(&window).document().shot().layers[1].pins.len(), 2, "its pins go with it");
    click(&mut window, &["Layer up"]);
    assert_eq!(names(&window), ["left", "right"]);
    click(&mut window, &["right", "Delete layer"]);
    assert_eq!(names(&window), ["left"]);
    settled(&mut window);
    click(&mut window, &["Add layer", "Right"]);
    assert_eq!(names(&window), ["left", "Right"]);
    assert_eq!(session(&window).document().shot().layers[1].nodes, ["Right"]);
    assert_eq!(changes(&window), ["Move layer", "Move layer", "Delete layer", "Add layer"]);
    for _ in 0..4 {
        undo(&mut window);
    }
    assert_eq!(text(&window), before);
}

#[test]
fn dims_basis_and_box_of_a_lattice_are_chosen() {
    let (_stage, mut window) = pulled();
    let before = text(&window);
    let handles = |window: &mut Window| {
        settled(window);
        session(window).marks()[0].handles.len()
    };
    assert_eq!(handles(&mut window), 36);
    number(&mut window, "Columns", 9.0);
    assert_eq!(handles(&mut window), 54);
    number(&mut window, "Rows", 4.0);
    assert_eq!(handles(&mut window), 36);
    assert!(text(&window).contains("dims = [9, 4]"), "{}", text(&window));
    let lines = session(&window).marks()[0].lines.len();
    choose(&mut window, "Basis", "bilinear");
    settled(&mut window);
    assert!(text(&window).contains("basis = \"bilinear\""), "{}", text(&window));
    assert_ne!(session(&window).marks()[0].lines.len(), lines, "its cells are others");
    let size = |window: &Window| session(window).marks()[0].rest_box.expect("on the screen").upright.max.0;
    let follows = size(&window);
    choose(&mut window, "Box", "frame");
    settled(&mut window);
    assert!((size(&window) - follows).length() > 0.1, "the box is the whole frame: {:?}", size(&window));
    click(&mut window, &["auto"]);
    settled(&mut window);
    assert!(session(&window).document().shot().layers[0].has_auto_dims);
    let automatic = handles(&mut window);
    assert!(automatic != 36 && says(&window, "auto: "), "{automatic}");
    let at = session(&window).marks()[0].handles.clone();
    click(&mut window, &["set"]);
    assert_eq!(handles(&mut window), automatic);
    assert_eq!(session(&window).marks()[0].handles, at, "the pose is as it was");
    assert!(!session(&window).document().shot().layers[0].has_auto_dims);
    for _ in 0..changes(&window).len() {
        undo(&mut window);
    }
    assert_eq!((text(&window), handles(&mut window)), (before, 36));
}

#[test]
fn smoothness_and_the_weight_over_time_change_the_solve() {
    let (_stage, mut window) = pulled();
    let marks = |window: &mut Window| {
        settled(window);
        session(window).marks()[0].handles.clone()
    };
    let mut known = vec![marks(&mut window)];
    for (label, value, words) in [("Smoothness", 5.0, "smoothness = 5"), ("Over time", 20.0, "temporal = 20")] {
        number(&mut window, label, value);
        assert!(text(&window).contains(words), "{}", text(&window));
        let new = marks(&mut window);
        assert!(!known.contains(&new), "{label}");
        known.push(new);
    }
}

#[test]
fn a_layer_is_moved_into_the_scene_and_its_box_fixed() {
    let (_stage, mut window) = pulled();
    let before = text(&window);
    // One frame is solved in no time, all of them are not.
    number(&mut window, "Over time", 0.0);
    choose(&mut window, "Space", "scene");
    assert!(text(&window).contains("space = \"world\""), "{}", text(&window));
    for label in ["Columns", "Rows", "Layers of handles"] {
        number(&mut window, label, 4.0);
    }
    settled(&mut window);
    assert_eq!(session(&window).marks()[0].handles.len(), 64);
    assert!(pull(&mut window) > 20, "its pins still pull");
    choose(&mut window, "Box", "fixed");
    settled(&mut window);
    number(&mut window, "Box z to", 3.0);
    settled(&mut window);
    choose(&mut window, "Space", "screen");
    settled(&mut window);
    assert!(says(&window, "Not kept: the dims, the fixed box"), "{:?}", session(&window).message());
    assert_eq!(session(&window).marks()[0].handles.len(), 100);
    for _ in 0..changes(&window).len() {
        undo(&mut window);
    }
    assert_eq!(text(&window), before);
}

#[test]
fn the_worst_frame_is_found_in_the_whole_range_and_marked_in_the_timeline() {
    // Pin a is pulled in frame 3, pin b in frame 3, too: the frames around it are drawn later than the first.
    let (_stage, mut window) =
        opened_with(&PINS.replace("frame = 3, offset = [0.1, 0.0]", "frame = 5, offset = [0.3, 0.2]"));
    until(&mut window, "all frames are known", |window| session(window).reported() == [6, 6]);
    assert!(!says(&window, "frames so far"));
    click(&mut window, &["Worst frame by Distortion"]);
    let (worst, _) = session(&window).worst(Figure::Distortion).expect("it is known");
    assert_eq!(session(&window).playhead.frame(), worst);
    assert!((4..=6).contains(&worst), "{worst}");
    assert!(window.query_by_label_contains("Distortion: frame").is_some_and(|node| node.rect().width() > 1.0));
    // In another range another frame is the worst.
    click(&mut window, &["First frame", "Frame forward"]);
    press(&mut window, Modifiers::NONE, Key::O);
    assert_eq!(session(&window).reported(), [2, 2]);
    let (worst, _) = session(&window).worst(Figure::Distortion).expect("it is known");
    assert!(worst <= 2, "{worst}");
    press(&mut window, Modifiers::SHIFT, Key::O);
    window.get_by_label_contains("Distortion: frame").click_accesskit();
    window.run_steps(3);
    assert!(session(&window).playhead.frame() > 2, "the mark is a way there");
}

/// A shot whose only layer moves everything.
fn only_all() -> (Stage, Window) {
    let stage = Stage::new();
    let [layers, output] = ["[[layer]]", "[output]"].map(|key| SHOT.find(key).expect("there"));
    let pins = "[[layer]]\nname = \"all\"\nstrength = 0.5\n\n\
        [[layer.pin]]\nname = \"l\"\nanchor = { node = \"Left\", triangle = 60, barycentric = [0.4, 0.3, 0.3] }\n\
        keys = [{ frame = 1, offset = [0.0, 0.0] }, { frame = 6, offset = [0.0, 0.1] }] # up\n\n\
        [[layer.pin]]\nname = \"r\"\nanchor = { node = \"Right\", triangle = 60, barycentric = [0.4, 0.3, 0.3] }\n\n";
    fs::write(stage.shot(), [&SHOT[..layers], pins, &SHOT[output..]].concat()).expect("written");
    let mut window = window::window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    (stage, window)
}

#[test]
fn layers_that_would_leave_another_nothing_are_not_offered() {
    let (_stage, mut window) = only_all();
    let before = text(&window);
    click(&mut window, &["Add layer"]);
    assert!(window.get_by_label("Everything").accesskit_node().is_disabled());
    window.get_by_label("Everything").hover();
    window.run_steps(6);
    assert!(says(&window, "Layer 'all' moves nothing else"));
    assert_eq!(text(&window), before);
    press(&mut window, Modifiers::NONE, Key::Escape);
    // Once a part has a layer, one for everything takes the rest, before it.
    let name = |window: &Window| -> Vec<String> {
        session(window).document().shot().layers.iter().map(|layer| layer.name.clone()).collect()
    };
    click(&mut window, &["Add layer", "Left"]);
    settled(&mut window);
    click(&mut window, &["all", "Delete layer"]);
    settled(&mut window);
    click(&mut window, &["Add layer", "Everything"]);
    settled(&mut window);
    assert_eq!((name(&window), session(&window).selection.layer), (vec!["layer".into(), "Left".into()], 0));
    assert_eq!(session(&window).fault(), None);
}

#[test]
fn pins_on_what_a_new_layer_takes_come_along_and_hold_it() {
    let (_stage, mut window) = only_all();
    let before = text(&window);
    click(&mut window, &["Last frame"]);
    settled(&mut window);
    let target = session(&window).marks()[0].pins[0].target;
    click(&mut window, &["Add layer", "Left"]);
    settled(&mut window);
    let layers = &session(&window).document().shot().layers;
    let pins = |layer: usize| layers[layer].pins.iter().map(|pin| pin.name.clone()).collect::<Vec<_>>();
    assert_eq!((pins(0), pins(1)), (vec!["r".to_owned()], vec!["l".to_owned()]));
    assert!(layers[1].has_auto_dims && layers[1].strength == 0.5, "as in a new shot, and as strong as before");
    let marks = session(&window).marks().iter().find(|marks| marks.layer == 1).expect("it moves");
    assert_eq!(marks.pins[0].target, target);
    assert!(session(&window).message().is_some_and(|told| told.contains("took 1 pin along from 'all': l")));
    assert!(text(&window).contains("# up"));
    undo(&mut window);
    assert_eq!(text(&window), before, "one step");
    // Without a pin on it, it rests, which is said.
    window.get_by_label("l").click();
    window.run_steps(3);
    press(&mut window, Modifiers::NONE, Key::Delete);
    settled(&mut window);
    click(&mut window, &["Add layer", "Left"]);
    assert!(
        session(&window).message().is_some_and(|told| told.contains("has no pins")),
        "{:?}",
        session(&window).message()
    );
}

#[test]
fn a_shot_that_cannot_be_drawn_says_so_over_the_picture_and_when_it_is_saved() {
    let (stage, mut window) = only_all();
    let broken = text(&window).replace("[output]", "[[layer]]\nname = \"more\"\n\n[output]");
    fs::write(stage.shot(), broken).expect("written");
    let mut window = {
        window.run_steps(1);
        drop(window);
        window::window(&stage.state(), Some(&stage.shot()))
    };
    until(&mut window, "it is a fault", |window| session(window).fault().is_some());
    window.run_steps(2);
    assert!(says(&window, "This shot cannot be drawn") && says(&window, "later layers take all"));
    assert_eq!(session(&window).corner(), "cannot be drawn");
    press(&mut window, Modifiers::COMMAND, Key::S);
    assert!(session(&window).message().is_some_and(|told| told.contains("but this shot cannot be drawn")));
}

#[test]
fn a_render_says_that_a_solo_is_not_rendered_and_leaves_muted_layers_at_rest() {
    let (stage, mut window) = pulled();
    click(&mut window, &["Solo right", "Render frames"]);
    assert!(says(&window, "Solo of 'right' is of the window alone"));
    until(&mut window, "it is rendered", |window| session(window).run().is_some_and(|run| !run.is_running()));
    let frame = || pinwarp::image::read_exr(&stage.folder.path().join("out/frame.0003.exr")).expect("rendered");
    let pulled = frame();
    click(&mut window, &["Close", "Solo right", "Mute the layer \"left\"", "Render frames"]);
    assert!(!says(&window, "Solo of"));
    until(&mut window, "it is rendered", |window| session(window).run().is_some_and(|run| !run.is_running()));
    assert_ne!(pinwarp::image::preview(&frame()), pinwarp::image::preview(&pulled), "the muted layer is at rest");
}
