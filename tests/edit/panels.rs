//! The brush, the timeline, the tour and the list of keys in the real interface.

use super::acts::{Handed, hold};
use super::stage::{PINS, SHOT, Stage};
use super::window::{Window, place, pointer, session, settled, until, window};
use eframe::egui::{self, Event, Key, Modifiers, PointerButton, Pos2, Rect};
use egui_kittest::kittest::Queryable;
use pinwarp::image::{Preview, write_png};
use std::fs;
use std::sync::Arc;

#[test]
fn of_files_dropped_at_once_one_is_opened_and_a_picture_lies_over_it() {
    let stage = Stage::new();
    let folder = stage.folder.path();
    let picture = Preview::transparent(16, 9);
    for name in ["draw.0001.png", "draw.0002.png", "other.png"] {
        write_png(&folder.join(name), &picture).expect("written");
    }
    fs::write(folder.join("broken.toml"), "scene = ").expect("written");
    let mut window = window(&stage.state(), None);
    let names = ["draw.0002.png", "notes.txt", "broken.toml", "cards.gltf", "draw.0001.png", "other.png", "shot.toml"];
    let files = names.map(|name| Arc::new(Handed(folder.join(name))) as egui::DroppedFileHandle);
    window.input_mut().dropped_files.extend(files);
    window.run_steps(3);
    assert_eq!(session(&window).document().path(), stage.shot());
    let told = session(&window).message().unwrap_or_default().to_owned();
    assert!(told.contains("draw.####.png, other.png lie over the picture"), "{told}");
    assert!(told.ends_with("Not used: broken.toml, notes.txt"), "{told}");
    assert_eq!(session(&window).reference_count(), 2);
}

#[test]
fn a_render_goes_on_in_the_background_or_is_cancelled_when_another_shot_is_opened() {
    let stage = Stage::new();
    let other = stage.folder.path().join("other.toml");
    fs::write(stage.shot(), SHOT.replace("last = 6", "last = 5000")).expect("written");
    fs::write(&other, SHOT.replace("out/frame", "out/other")).expect("written");
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.key_press_modifiers(Modifiers::COMMAND, Key::R);
    window.run_steps(2);
    for answer in ["Stay here", "Keep rendering"] {
        window.input_mut().dropped_files.push(Arc::new(Handed(other.clone())) as egui::DroppedFileHandle);
        window.run_steps(3);
        assert_eq!(session(&window).document().path(), stage.shot(), "it is asked first");
        window.get_by_label(answer).click();
        window.run_steps(3);
    }
    assert_eq!(session(&window).document().path(), other);
    assert!(session(&window).run().is_none(), "it is no render of this shot");
    window.get_by_label("Cancel the render of shot.toml").click();
    until(&mut window, "the render ends", |window| window.query_by_label("Cancel the render of shot.toml").is_none());
    assert!(
        session(&window).message().is_some_and(|told| told.contains("Cancelled")),
        "{:?}",
        session(&window).message()
    );
}

#[test]
fn a_render_is_cancelled_for_another_file_only_if_that_opens() {
    let stage = Stage::new();
    let [broken, other] = ["broken.toml", "other.toml"].map(|name| stage.folder.path().join(name));
    let many = SHOT.replace("last = 6", "last = 5000").replace("samples = 4", "samples = 64");
    fs::write(stage.shot(), many).expect("written");
    fs::write(&broken, "scene = ").expect("written");
    fs::write(&other, SHOT.replace("out/frame", "out/other")).expect("written");
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.key_press_modifiers(Modifiers::COMMAND, Key::R);
    window.run_steps(2);
    for (file, open) in [(&broken, stage.shot()), (&other, other.clone())] {
        window.input_mut().dropped_files.push(Arc::new(Handed(file.clone())) as egui::DroppedFileHandle);
        window.run_steps(3);
        // It is asked, because the render goes on.
        window.get_by_label("Cancel the render").click();
        window.run_steps(3);
        assert_eq!(session(&window).document().path(), open);
        // What had been cancelled would end after the frames in flight, which are far fewer.
        if open == stage.shot() {
            let done = |window: &Window| session(window).run().map_or(0, |run| run.done);
            let more = done(&window) + 16;
            until(&mut window, "the render goes on", |window| done(window) >= more);
        }
    }
    until(&mut window, "the render ends", |window| {
        session(window).message().is_some_and(|told| told.contains("Cancelled"))
    });
}

/// The pictures in the viewport in the order in which they are drawn: height in points, opacity.
fn drawn_pictures(window: &Window) -> Vec<[f32; 2]> {
    let mut found = Vec::new();
    for clipped in &window.output().shapes {
        if let egui::Shape::Mesh(mesh) = &clipped.shape
            && mesh.texture_id != egui::TextureId::default()
        {
            found.push([mesh.calc_bounds().height(), (f32::from(mesh.vertices[0].color.a()) / 2.55).round() / 100.0]);
        }
    }
    found
}

/// Lays a picture of the shot's folder over the frame.
fn lay_over(window: &mut Window, name: &str) {
    window.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::R);
    window.run_steps(2);
    window.get_by_label(name).click();
    window.run_steps(2);
    window.get_by_label("Choose").click();
    window.run_steps(3);
}

#[test]
fn reference_pictures_have_opacities_sizes_and_sides_of_their_own() {
    let stage = Stage::new();
    let [low, high] = ["low.png", "high.png"].map(|name| stage.folder.path().join(name));
    for path in [&low, &high] {
        write_png(path, &Preview::transparent(16, 9)).expect("written");
    }
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let [[frame, _]] = drawn_pictures(&window)[..] else { panic!("the frame alone") };
    for name in ["low.png", "high.png", "low.png"] {
        lay_over(&mut window, name);
    }
    for menu in ["View", "Reference pictures"] {
        window.get_by_label(menu).click();
        window.run_steps(3);
    }
    until(&mut window, "both are decoded", |window| drawn_pictures(window).len() > 2);
    assert_eq!(drawn_pictures(&window), [[frame, 1.0], [frame, 0.5], [frame, 0.5]], "what is there is not added again");
    let number = |window: &Window, label: &str, value: f64| {
        window.get_all_by_label(label).next().expect("it is there").set_value_accesskit(value);
    };
    number(&window, "Opacity of low.png", 0.2);
    number(&window, "Size of high.png", 0.5);
    window.get_by_label("low.png above the frame").click();
    window.run_steps(3);
    assert_eq!(drawn_pictures(&window), [[frame, 0.2], [frame, 1.0], [0.5 * frame, 0.5]]);
    window.get_by_label("Remove low.png").click();
    window.run_steps(3);
    assert_eq!(drawn_pictures(&window), [[frame, 1.0], [0.5 * frame, 0.5]]);
}

#[test]
fn menus_stay_open_at_switches_and_close_at_actions() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let shown = |window: &Window| window.query_by_label("Names of pins").is_some();
    window.get_by_label("View").click();
    window.run_steps(3);
    for switch in ["Names of pins", "Rest places", "Onion skin", "Tint before", "Light"] {
        window.get_by_label(switch).click();
        window.run_steps(3);
        assert!(shown(&window), "the menu closed at '{switch}'");
        if let Some(red) = window.query_all_by_label("Tint before, red").next() {
            red.set_value_accesskit(10.0);
        }
        window.run_steps(2);
    }
    window.get_by_label_contains("Fit the picture").click();
    window.run_steps(3);
    assert!(!shown(&window), "an action closes the menu");
    let kept =
        fs::read_to_string(stage.state().join("view.json")).expect("it is kept").replace(char::is_whitespace, "");
    for part in ["\"names\":false", "\"rest\":false", "\"count\":1", "[10,150,130]", "\"theme\":\"light\""] {
        assert!(kept.contains(part), "{part} in {kept}");
    }
}

#[test]
fn a_held_key_paints_stiffness_and_shift_erases_it() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let way: Vec<Pos2> = [0.3, 0.4, 0.5].iter().map(|&x| place(&window, x, 0.5)).collect();
    pointer(&mut window, way[0], None);
    hold(&mut window, Key::S, true);
    pointer(&mut window, way[0], Some(true));
    pointer(&mut window, way[1], None);
    until(&mut window, "the paint is seen", |window| !session(window).painted().is_empty());
    pointer(&mut window, way[2], None);
    pointer(&mut window, way[2], Some(false));
    let strokes = |window: &Window| session(window).document().shot().layers[0].strokes.len();
    until(&mut window, "the stroke is written", |window| strokes(window) == 1);
    settled(&mut window);
    until(&mut window, "the paint of the frame is known", |window| !session(window).painted().is_empty());
    window.event(Event::PointerMoved(way[1]));
    let modifiers = Modifiers::SHIFT;
    for pressed in [true, false] {
        window.event(Event::ModifiersChanged(modifiers));
        window.event(Event::PointerButton { pos: way[1], button: PointerButton::Primary, pressed, modifiers });
        window.step();
    }
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    until(&mut window, "the stroke is written", |window| strokes(window) == 2);
    assert_eq!(session(&window).document().shot().layers[0].strokes[1].value, 1.0);
    hold(&mut window, Key::S, false);
    for _ in 0..2 {
        window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        window.run_steps(2);
    }
    assert_eq!(session(&window).document().text(), SHOT);
    assert_eq!(session(&window).document().history().labels().count(), 0);
}

#[test]
fn a_box_in_the_timeline_chooses_keys_of_many_pins() {
    let stage = Stage::with(PINS);
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let rows = ["a", "b"].map(|name| -> Rect { window.get_by_label(&format!("Keys of {name}")).rect() });
    // Six frames between the names and the right end.
    let frames = rows[0].left() + 150.0..=rows[0].right() - 16.0;
    let x = |frame: f32| frames.start() + (frame - 0.5) / 6.0 * (frames.end() - frames.start());
    let (from, to) = (egui::pos2(x(3.5), rows[0].top() + 2.0), egui::pos2(x(2.5), rows[1].bottom() - 2.0));
    pointer(&mut window, from, Some(true));
    for step in 1..=5 {
        pointer(&mut window, from + (to - from) * (step as f32 / 5.0), None);
    }
    pointer(&mut window, to, Some(false));
    window.key_press(Key::Delete);
    window.run_steps(2);
    let times = |window: &Window, pin: usize| {
        let keys = &session(window).document().shot().layers[0].pins[pin].keys;
        keys.iter().map(|key| key.frame).collect::<Vec<_>>()
    };
    assert_eq!((times(&window, 0), times(&window, 1)), (vec![1.0, 6.0], vec![2.0, 5.0]));
    let labels: Vec<&str> = session(&window).document().history().labels().collect();
    assert_eq!(labels, ["Delete keys"], "they are undone at once");
}

#[test]
fn the_tour_opens_a_scene_and_leads_from_step_to_step() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), None);
    window.get_by_label("Take the tour of two minutes").click();
    window.run_steps(3);
    assert!(session(&window).document().path().ends_with("walker/shot.toml"));
    assert!(window.query_by_label("Drag a pin").is_some());
    window.get_by_label("Skip this step").click();
    window.run_steps(2);
    assert!(window.query_by_label("Go to another frame").is_some());
    window.get_by_label("Frame forward").click();
    window.run_steps(3);
    assert!(window.query_by_label("Drag the hand again").is_some(), "a step that is done is left");
    window.get_by_label("End the tour").click();
    window.run_steps(2);
    assert!(window.query_by_label("Drag the hand again").is_none());
}

#[test]
fn the_tour_takes_its_own_scene_and_asks_about_unsaved_work() {
    let stage = Stage::with(PINS);
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.get_by_label("Mute pin a").click();
    window.run_steps(3);
    window.key_press(Key::F2);
    window.run_steps(3);
    assert_eq!(session(&window).document().path(), stage.shot());
    window.get_by_label("Discard").click();
    window.run_steps(3);
    assert!(session(&window).document().path().ends_with("walker/shot.toml"));
    assert!(window.query_by_label("Drag a pin").is_some());
    // From a later frame it begins on the same document.
    window.get_by_label("End the tour").click();
    window.run_steps(2);
    window.get_by_label("Frame forward").click();
    window.run_steps(2);
    let frame = session(&window).playhead.frame();
    window.key_press(Key::F2);
    window.run_steps(3);
    assert!(window.query_by_label("Drag a pin").is_some() && session(&window).playhead.frame() == frame);
}

#[test]
fn a_key_is_bound_anew_in_the_list() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.key_press(Key::F1);
    window.run_steps(2);
    window.get_by_label("Key of Fit the picture").click();
    window.run_steps(2);
    window.key_press(Key::J);
    window.run_steps(3);
    let kept = fs::read_to_string(stage.state().join("keys.json")).expect("it is kept");
    assert_eq!(kept, "{\n  \"fit\": \"J\"\n}");
    window.get_by_label("Key of Fit the picture").click();
    window.run_steps(2);
    window.key_press(Key::K);
    window.run_steps(3);
    assert!(window.query_by_label_contains("both 'key' and 'fit'").is_some(), "a clash is told");
    assert_eq!(fs::read_to_string(stage.state().join("keys.json")).expect("as before"), kept);
}

#[test]
fn onion_skins_that_are_no_longer_seen_are_freed() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.key_press(Key::N);
    window.run_steps(2);
    let mut most = 0;
    for frame in 1..=6 {
        until(&mut window, "frames around it are drawn", |window| session(window).is_idle());
        most = most.max(window.ctx.tex_manager().read().num_allocated());
        assert_eq!(session(&window).playhead.frame(), frame);
        window.get_by_label("Frame forward").click();
        window.run_steps(3);
    }
    // The letters, the picture, and two frames on either side at most.
    assert!((3..=6).contains(&most), "{most} textures");
}

#[test]
fn numbers_of_a_pin_in_sizes_of_the_box_are_per_cent() {
    let pin = "coarse on purpose\n\n[[layer.pin]]\nname = \"p\"\nunit = \"box\"\nanchor = { screen = [0.4, 0.5], frame = 1 }\n\
               region = { radius = 0.25, rigidity = 1.0 }\nkeys = [{ frame = 1, offset = [0.125, -0.5] }]\n";
    let stage = Stage::with(pin);
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.get_by_label("p").click();
    window.run_steps(3);
    for (label, value) in [("Offset x", "12.5 %"), ("Offset y", "-50 %"), ("Radius", "25 %")] {
        let shown: Vec<String> = window.query_all_by_label(label).filter_map(|node| node.value()).collect();
        let is_said = |text: &String| text.replace(".0", "").replace('\u{2212}', "-") == value;
        assert!(shown.iter().any(is_said), "{label}: {shown:?}");
    }
    window.key_press(Key::C);
    window.run_steps(3);
    assert!(window.query_by_label("x, % of the box").is_some() && window.query_by_label("x, px").is_none());
}

/// Numbers that the sliders do not reach, or show rounded, stay as they are until somebody changes them.
#[test]
fn looking_at_numbers_does_not_change_them() {
    let pin = "coarse on purpose\nsolve = { smoothness = 0.125, temporal = 12.5 }\nstrength = 0.3333\n\n[[layer.pin]]\nname = \"p\"\nweight = 0.1234\n\
               anchor = { screen = [0.4, 0.5], frame = 1 }\nregion = { radius = 0.01, rigidity = 0.1234, stiffness = 0.00512 }\n\
               keys = [{ frame = 1, offset = [0.0123, 0.0], rotate = 0.12345, scale = 0.012 }]\n";
    let text = SHOT
        .replacen("coarse on purpose\n", pin, 1)
        .replace("dims = [6, 6] }   #", "dims = [3, 9], basis = \"bilinear\" }   #");
    let text = text.replace("samples = 4", "samples = 300");
    let stage = Stage::new();
    fs::write(stage.shot(), &text).expect("written");
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.query_all_by_label("Shot").next().expect("the settings of the shot").click_accesskit();
    window.run_steps(3);
    window.get_by_label("p").click();
    window.run_steps(3);
    assert_eq!(session(&window).document().text(), text, "opened and selected");
    // Tab enters the fields and leaves them.
    window.get_by_label("Pin name").focus();
    window.run_steps(2);
    for _ in 0..24 {
        window.key_press(Key::Tab);
        window.run_steps(2);
    }
    assert_eq!(session(&window).document().text(), text, "entered and left");
}

/// A touch screen reports the release and that the pointer is gone at once.
#[test]
fn a_drag_ends_where_a_finger_is_lifted() {
    let stage = Stage::with(PINS);
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let target = session(&window).marks()[0].pins[0].target.0;
    let (from, to) = (place(&window, target.x, target.y), place(&window, target.x + 0.1, target.y));
    pointer(&mut window, from, Some(true));
    pointer(&mut window, from + 0.5 * (to - from), None);
    pointer(&mut window, to, None);
    let release =
        Event::PointerButton { pos: to, button: PointerButton::Primary, pressed: false, modifiers: Modifiers::NONE };
    window.input_mut().events.extend([release, Event::PointerGone]);
    window.run_steps(2);
    let labels: Vec<&str> = session(&window).document().history().labels().collect();
    assert_eq!(labels, ["Move pin"]);
}

#[test]
fn a_box_chooses_keys_after_a_click_on_a_key() {
    let stage = Stage::with(PINS);
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let row: Rect = window.get_by_label("Keys of a").rect();
    let (left, right) = (row.left() + 150.0, row.right() - 16.0);
    let x = |frame: f32| left + (frame - 0.5) / 6.0 * (right - left);
    let key = egui::pos2(x(1.0), row.center().y);
    pointer(&mut window, key, Some(true));
    pointer(&mut window, key, Some(false));
    window.run_steps(2);
    let (from, to) = (egui::pos2(x(5.0), row.top() + 2.0), egui::pos2(x(2.0), row.bottom() - 2.0));
    pointer(&mut window, from, Some(true));
    for step in 1..=5 {
        pointer(&mut window, from + (to - from) * (step as f32 / 5.0), None);
    }
    pointer(&mut window, to, Some(false));
    window.run_steps(2);
    assert_eq!(session(&window).selection.keys, [([0, 0].into(), 3.0)]);
    assert_eq!(session(&window).document().history().labels().count(), 0, "no key was moved");
}

#[test]
fn a_name_is_taken_when_its_field_is_left() {
    let stage = Stage::with(PINS);
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let labels =
        |window: &Window| -> Vec<String> { session(window).document().history().labels().map(str::to_owned).collect() };
    let replace = |window: &mut Window, field: &str, text: &str| {
        window.get_by_label(field).focus();
        window.run_steps(2);
        window.key_press_modifiers(Modifiers::COMMAND, Key::A);
        window.run_steps(2);
        for letter in text.chars() {
            window.event(Event::Text(letter.to_string()));
            window.run_steps(2);
        }
    };
    // On the way it is the name of the other layer.
    replace(&mut window, "Layer name", "right arm");
    assert!(labels(&window).is_empty(), "{:?}", labels(&window));
    window.key_press(Key::Enter);
    window.run_steps(3);
    assert_eq!(session(&window).document().shot().layers[0].name, "right arm");
    window.get_by_label("a").click();
    window.run_steps(3);
    replace(&mut window, "Pin name", "tip");
    // The row of another pin selects it, and takes the name.
    window.get_by_label("b").click();
    window.run_steps(3);
    let names: Vec<String> =
        session(&window).document().shot().layers[0].pins.iter().map(|pin| pin.name.clone()).collect();
    assert_eq!(names, ["tip", "b"]);
    assert_eq!(labels(&window), ["Rename layer", "Rename pin"]);
}

#[test]
fn space_presses_the_button_that_has_the_focus_and_plays_elsewhere() {
    let stage = Stage::with(PINS);
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.get_by_label("a").click();
    window.run_steps(3);
    window.get_by_label("Mute").focus();
    window.run_steps(2);
    window.key_press(Key::Space);
    window.run_steps(2);
    assert!(session(&window).document().shot().layers[0].pins[0].is_muted);
    let plays = |window: &Window| window.query_by_label("Stop").is_some();
    assert!(!plays(&window));
    window.get_by_label("Viewport").focus();
    window.run_steps(2);
    window.key_press(Key::Space);
    window.run_steps(2);
    assert!(plays(&window));
}

#[test]
fn keys_of_the_clipboard_can_be_bound_to_other_actions() {
    let stage = Stage::with(PINS);
    fs::create_dir_all(stage.state()).expect("a folder");
    fs::write(stage.state().join("keys.json"), "{ \"curves\": \"Ctrl+X\", \"paste\": \"Alt+V\" }").expect("written");
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.event(Event::Paste("text".into()));
    window.run_steps(2);
    assert_eq!(session(&window).message(), None, "nothing is pasted");
    window.event(Event::Cut);
    window.run_steps(2);
    assert!(window.query_by_label("Curves of keys").is_some());
}

#[test]
fn hidden_pins_are_not_caught() {
    let stage = Stage::with(PINS);
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.key_press(Key::P);
    window.run_steps(2);
    let target = session(&window).marks()[0].pins[0].target.0;
    let at = place(&window, target.x, target.y);
    pointer(&mut window, at, Some(true));
    assert!(session(&window).selection.pins.is_empty());
}

#[test]
fn a_click_that_stops_playback_leaves_a_rendered_frame() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.get_by_label("Every frame").click();
    window.key_press(Key::Space);
    until(&mut window, "it plays", |window| session(window).playhead.frame() > 1);
    let empty = place(&window, 0.05, 0.05);
    pointer(&mut window, empty, Some(true));
    pointer(&mut window, empty, Some(false));
    assert!(window.query_by_label("Play").is_some());
    settled(&mut window);
}

/// Returns the shapes that are meshes of colours alone.
fn filled(window: &Window) -> usize {
    let is_filled = |shape: &egui::Shape| matches!(shape, egui::Shape::Mesh(mesh) if mesh.texture_id == egui::TextureId::default() && mesh.vertices.len() > 20);
    window.output().shapes.iter().filter(|clipped| is_filled(&clipped.shape)).count()
}

#[test]
fn distortion_fills_the_lattice_though_its_lines_are_hidden() {
    let stage = Stage::with(PINS);
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.key_press(Key::G);
    window.run_steps(2);
    let before = filled(&window);
    window.key_press(Key::D);
    window.run_steps(2);
    assert_eq!(filled(&window), before + 1);
}

#[test]
fn numbers_of_handles_can_be_chosen_automatically_again() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    window.get_by_label("auto").click();
    window.run_steps(3);
    assert!(session(&window).document().shot().layers[0].has_auto_dims);
    settled(&mut window);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(2);
    assert_eq!(session(&window).document().text(), SHOT);
}
