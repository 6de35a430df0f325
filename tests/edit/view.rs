//! What is laid over the picture and how it is shown: each switch is seen in what the window draws.

use super::acts::{click, drag, hold, number, press};
use super::seen::{beside_cards, curves, fills, meshes, pictures, says, segments, texts};
use super::stage::{PINS, Stage};
use super::window::{Window, changes, opened_with, place, pointer, session, settled};
use super::window::{until, window};
use eframe::egui::{
    self, Color32, Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Rect, Shape, TouchPhase,
};
use egui_kittest::kittest::Queryable;
use pinwarp::image::{Preview, write_png};

/// Pins of the left layer of which two pass each other between those that hold it.
fn crossing() -> String {
    let pins =
        [(0.35, 0.5, 0.3), (0.6, 0.5, -0.2), (0.25, 0.3, 0.0), (0.7, 0.3, 0.0), (0.25, 0.7, 0.0), (0.7, 0.7, 0.0)];
    let pin = |(place, (x, y, by)): (usize, (f64, f64, f64))| {
        format!(
            "\n[[layer.pin]]\nname = \"{place}\"\nanchor = {{ screen = [{x}, {y}], frame = 1 }}\n\
             keys = [{{ frame = 1, offset = [{by}, 0.0] }}]\n"
        )
    };
    let pins: Vec<String> = pins.into_iter().enumerate().map(pin).collect();
    ["coarse on purpose\nsolve = { guard = \"report\" }\n", &pins.concat()].concat()
}

/// The third frame of the shot with pins, in which both pull.
fn pulled() -> (Stage, Window) {
    let (stage, mut window) = opened_with(PINS);
    click(&mut window, &["Frame forward", "Frame forward"]);
    settled(&mut window);
    (stage, window)
}

/// Waits until so many pictures are drawn.
fn until_pictures(window: &mut Window, count: usize) {
    until(window, &format!("{count} pictures"), |window| pictures(window).len() == count);
}

fn viewport(window: &Window) -> Rect {
    window.get_by_label("Viewport").rect()
}

#[test]
fn the_wipe_divides_the_picture_at_a_line_that_is_dragged() {
    let (_stage, mut window) = pulled();
    press(&mut window, Modifiers::NONE, Key::W);
    until_pictures(&mut window, 2);
    let [after, before] = &pictures(&window)[..] else { panic!("two") };
    assert!(beside_cards(&after.image) > 20, "the pins pull it there");
    assert_eq!(beside_cards(&before.image), 0, "the frame without the warp");
    assert_eq!((after.part.width(), before.part.width()), (1.0, 0.5));
    assert_eq!((before.rect.left(), before.rect.right()), (after.rect.left(), after.rect.center().x));
    assert!(says(&window, "before") && says(&window, "after"));
    let frame = after.rect;
    // Where no pin is.
    let y = place(&window, 0.0, 0.1).y;
    let to = egui::pos2(frame.left() + 0.25 * frame.width(), y);
    drag(&mut window, [egui::pos2(frame.center().x + 2.0, y), to]);
    let share = pictures(&window)[1].part.width();
    assert!((share - 0.25).abs() < 0.01, "{share}");
    assert!(changes(&window).is_empty(), "the shot is as it was");
    // Another frame is compared, too.
    click(&mut window, &["Frame forward"]);
    settled(&mut window);
    until_pictures(&mut window, 2);
    press(&mut window, Modifiers::NONE, Key::W);
    assert!(pictures(&window).len() == 1 && !says(&window, "before"));
}

#[test]
fn a_held_key_shows_the_frame_without_the_warp_alone() {
    let (_stage, mut window) = pulled();
    assert!(beside_cards(&pictures(&window)[0].image) > 20);
    hold(&mut window, Key::B, true);
    until(&mut window, "the frame without the warp", |window| beside_cards(&pictures(window)[0].image) == 0);
    assert_eq!(pictures(&window).len(), 1);
    hold(&mut window, Key::B, false);
    window.run_steps(2);
    assert!(pictures(&window).len() == 1 && beside_cards(&pictures(&window)[0].image) > 20);
}

#[test]
fn the_ghost_of_the_rest_lies_over_the_picture_with_an_opacity() {
    let (_stage, mut window) = pulled();
    press(&mut window, Modifiers::SHIFT, Key::W);
    until_pictures(&mut window, 2);
    let [frame, ghost] = &pictures(&window)[..] else { panic!("two") };
    assert_eq!((beside_cards(&ghost.image), ghost.rect, ghost.part.width()), (0, frame.rect, 1.0));
    assert_eq!((frame.tint, ghost.tint), (Color32::WHITE, Color32::WHITE.gamma_multiply(0.4)));
    click(&mut window, &["View"]);
    let opacity = window.get_by_role_and_label(egui::Role::Slider, "opacity of the ghost");
    opacity.set_value_accesskit(0.75);
    window.run_steps(3);
    assert_eq!(pictures(&window)[1].tint, Color32::WHITE.gamma_multiply(0.75));
    // The wipe takes the place of the ghost.
    click(&mut window, &["Wipe before and after"]);
    assert!(pictures(&window)[1].part.width() == 0.5 && says(&window, "before"));
    click(&mut window, &["Wipe before and after"]);
    assert_eq!(pictures(&window).len(), 1);
}

#[test]
fn trails_lead_through_all_frames_of_the_chosen_pins() {
    let (_stage, mut window) = pulled();
    until(&mut window, "all frames are solved", |window| session(window).is_idle());
    let trails = |window: &Window| segments(window, 1.6);
    assert!(trails(&window).is_empty());
    press(&mut window, Modifiers::NONE, Key::T);
    // Two pins, five steps each.
    assert_eq!(trails(&window).len(), 10);
    for mark in &session(&window).marks()[0].pins {
        let here = place(&window, mark.target.0.x, mark.target.0.y);
        let ends = trails(&window).iter().filter(|[_, end]| end.distance(here) < 0.5).count();
        assert_eq!(ends, 1, "the way leads through this frame");
    }
    click(&mut window, &["a"]);
    assert_eq!(trails(&window).len(), 5, "of the chosen one alone");
    hold(&mut window, Key::H, true);
    assert!(trails(&window).is_empty() && curves(&window) == 0, "all is hidden");
    hold(&mut window, Key::H, false);
    assert_eq!(trails(&window).len(), 5);
    press(&mut window, Modifiers::NONE, Key::T);
    assert!(trails(&window).is_empty());
}

#[test]
fn onion_skins_show_frames_or_keys_on_either_side() {
    let (_stage, mut window) = pulled();
    // Frames that were never visited may be drawn so small that two of them look the same.
    for way in ["First frame", "Frame forward", "Frame forward", "Frame forward", "Frame forward", "Frame forward"] {
        click(&mut window, &[way]);
        settled(&mut window);
    }
    click(&mut window, &["First frame", "Frame forward", "Frame forward"]);
    settled(&mut window);
    press(&mut window, Modifiers::NONE, Key::N);
    // Two frames apart: of frames -1, 1, 5 and 7 the shot has two, behind the frame.
    let tints = |window: &Window| pictures(window).iter().map(|laid| laid.tint).collect::<Vec<_>>();
    let [before, after] = [Color32::from_rgb(255, 150, 130), Color32::from_rgb(130, 190, 255)];
    assert_eq!(tints(&window), [before.gamma_multiply(0.4), after.gamma_multiply(0.4), Color32::WHITE]);
    let [first, fifth, _] = &pictures(&window)[..] else { panic!("three") };
    assert_ne!(first.image.pixels, fifth.image.pixels);
    click(&mut window, &["View"]);
    let slider = |window: &mut Window, label: &str, value: f64| {
        window.get_by_role_and_label(egui::Role::Slider, label).set_value_accesskit(value);
        window.run_steps(3);
    };
    slider(&mut window, "frames apart", 1.0);
    slider(&mut window, "opacity", 0.8);
    let [far, near] = [0.4, 0.8];
    let expected = [(before, far), (after, far), (before, near), (after, near)];
    let expected: Vec<Color32> = expected.into_iter().map(|(color, opacity)| color.gamma_multiply(opacity)).collect();
    assert_eq!(tints(&window)[..4], expected, "the farthest first");
    let by_frames: Vec<Vec<Color32>> = pictures(&window).iter().map(|laid| laid.image.pixels.clone()).collect();
    slider(&mut window, "on either side", 1.0);
    assert_eq!(tints(&window).len(), 3);
    // Keys of a pin are in frames 1, 3 and 6.
    press(&mut window, Modifiers::NONE, Key::Escape);
    click(&mut window, &["a", "View", "by keys of what is selected"]);
    assert_eq!(tints(&window).len(), 3);
    assert_eq!(pictures(&window)[0].image.pixels, by_frames[0], "frame 1");
    assert!(!by_frames[1..].contains(&pictures(&window)[1].image.pixels), "frame 6 instead of 2, 4 or 5");
    press(&mut window, Modifiers::NONE, Key::N);
    assert_eq!(pictures(&window).len(), 1);
}

#[test]
fn safe_areas_lie_within_the_frame() {
    let (_stage, mut window) = opened_with(PINS);
    let named = |window: &Window| ["action", "title"].map(|name| texts(window).iter().any(|text| text == name));
    // Per cent of the frame's width, of rectangles about its middle.
    let shares = |window: &Window| -> Vec<f32> {
        let frame = pictures(window)[0].rect;
        let about = fills(window).into_iter().filter(|(rect, _)| rect.center().distance(frame.center()) < 0.1);
        about.map(|(rect, _)| (100.0 * rect.width() / frame.width()).round()).collect()
    };
    for is_shown in [false, true, false] {
        assert_eq!(named(&window), [is_shown; 2]);
        assert_eq!([93.0, 90.0].map(|share| shares(&window).contains(&share)), [is_shown; 2], "{:?}", shares(&window));
        press(&mut window, Modifiers::NONE, Key::A);
    }
}

#[test]
fn the_picture_is_seen_one_to_one_fitted_zoomed_and_panned() {
    let (_stage, mut window) = opened_with(PINS);
    let size = |window: &Window| pictures(window)[0].rect.size();
    let fitted = size(&window);
    let room = viewport(&window).shrink(16.0);
    assert!((fitted.x - room.width()).abs().min((fitted.y - room.height()).abs()) < 0.1, "{fitted:?} in {room:?}");
    assert!(says(&window, "%, fit"));
    press(&mut window, Modifiers::NONE, Key::Num1);
    assert_eq!(size(&window), egui::vec2(96.0, 54.0));
    assert!(says(&window, "   100 %") && !says(&window, ", fit"));
    for (key, width) in [(Key::Plus, 120.0), (Key::Plus, 150.0), (Key::Minus, 120.0)] {
        press(&mut window, Modifiers::NONE, key);
        assert!((size(&window).x - width).abs() < 0.01, "{} instead of {width}", size(&window).x);
    }
    // The wheel zooms about the pointer.
    let at = place(&window, 0.4, 0.3);
    pointer(&mut window, at, None);
    window.event(Event::MouseWheel {
        unit: MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 3.0),
        phase: TouchPhase::Move,
        source: MouseWheelSource::Unknown,
        modifiers: Modifiers::NONE,
    });
    window.run_steps(12);
    assert!(size(&window).x > 180.0, "{:?}", size(&window));
    assert!(place(&window, 0.4, 0.3).distance(at) < 0.1, "what is under the pointer stays there");
    let before = pictures(&window)[0].rect;
    for (pos, pressed) in [(at, Some(true)), (at + egui::vec2(20.0, 5.0), None), (at + egui::vec2(40.0, 10.0), None)] {
        window.event(Event::PointerMoved(pos));
        if let Some(pressed) = pressed {
            window.event(Event::PointerButton {
                pos,
                button: PointerButton::Middle,
                pressed,
                modifiers: Modifiers::NONE,
            });
        }
        window.step();
    }
    let moved = pictures(&window)[0].rect.min - before.min;
    assert!((moved - egui::vec2(40.0, 10.0)).length() < 0.1, "{moved:?}");
    press(&mut window, Modifiers::NONE, Key::F);
    assert_eq!(size(&window), fitted);
    assert!(changes(&window).is_empty());
}

#[test]
fn folded_cells_are_red_until_they_are_switched_off() {
    let (_stage, mut window) = opened_with(&crossing());
    let red = |window: &Window| meshes(window, Color32::from_rgba_premultiplied(150, 14, 14, 150));
    assert!(!session(&window).marks()[0].folded.is_empty(), "it folds");
    assert_eq!(red(&window), session(&window).marks()[0].folded.len());
    click(&mut window, &["View", "Folded cells"]);
    assert_eq!(red(&window), 0);
    click(&mut window, &["Folded cells"]);
    assert!(red(&window) > 0);
}

#[test]
fn lattices_handles_and_names_are_switched() {
    let (_stage, mut window) = opened_with(PINS);
    // Both lattices: seven lines each way or six.
    let lines: usize = session(&window).marks().iter().map(|marks| marks.lines.len()).sum();
    assert_eq!(curves(&window), lines);
    press(&mut window, Modifiers::NONE, Key::G);
    assert_eq!(curves(&window), 0);
    let handles =
        |window: &Window| fills(window).iter().filter(|(_, fill)| *fill == Color32::from_rgb(120, 200, 235)).count();
    assert_eq!(handles(&window), 0);
    press(&mut window, Modifiers::NONE, Key::L);
    assert_eq!(handles(&window), 72);
    let names = |window: &Window| texts(window).iter().filter(|text| *text == "a").count();
    let before = names(&window);
    click(&mut window, &["View", "Names of pins"]);
    assert_eq!(names(&window), before - 1, "not beside the pin");
}

/// The names beside pins of a heap, by their places.
fn heaped_names(window: &Window) -> Vec<(String, Rect)> {
    let name = |shape: &Shape| {
        let Shape::Text(text) = shape else { return None };
        let (name, rect) = (text.galley.text(), text.visual_bounding_rect());
        (name.starts_with("heap") && viewport(window).contains_rect(rect)).then(|| (name.to_owned(), rect))
    };
    window.output().shapes.iter().filter_map(|clipped| name(&clipped.shape)).collect()
}

#[test]
fn names_of_pins_in_a_heap_cover_nothing_and_those_that_are_wanted_are_there() {
    let pin = |place: usize| {
        let x = 0.4 + 0.01 * place as f64;
        format!("[[layer.pin]]\nname = \"heap{place}\"\nanchor = {{ screen = [{x}, 0.5], frame = 1 }}\n")
    };
    let (_stage, mut window) = opened_with(&format!("coarse\n{}", (0..8).map(pin).collect::<String>()));
    let assert_free = |window: &Window, count: std::ops::RangeInclusive<usize>| {
        let names = heaped_names(window);
        assert!(count.contains(&names.len()), "{names:?}");
        for (index, (_, rect)) in names.iter().enumerate() {
            assert!(names[..index].iter().all(|(_, other)| !other.intersects(*rect)), "{names:?}");
            let pins = &session(window).marks()[0].pins;
            assert!(pins.iter().all(|pin| !rect.contains(place(window, pin.target.0.x, pin.target.0.y))), "{names:?}");
        }
    };
    assert_free(&window, 3..=6);
    let named: Vec<String> = heaped_names(&window).into_iter().map(|(name, _)| name).collect();
    let left_out = (0..8).find(|index| !named.contains(&format!("heap{index}"))).expect("there is no room for all");
    let target = session(&window).marks()[0].pins[left_out].target.0;
    let on_pin = place(&window, target.x, target.y);
    pointer(&mut window, on_pin, None);
    window.run_steps(2);
    assert!(
        heaped_names(&window).iter().any(|(name, _)| *name == format!("heap{left_out}")),
        "it is under the pointer"
    );
    assert_free(&window, 3..=6);
    press(&mut window, Modifiers::COMMAND, Key::A);
    assert_free(&window, 8..=8);
}

#[test]
fn the_theme_is_switched_at_once() {
    let (_stage, mut window) = opened_with(PINS);
    let surroundings = |window: &Window| -> Vec<Color32> {
        let whole = fills(window).into_iter().filter(|(rect, _)| *rect == viewport(window));
        whole.map(|(_, color)| color).filter(|color| color.a() > 0).collect()
    };
    click(&mut window, &["View"]);
    for (name, gray) in [("Light", 150), ("Dark", 38), ("Light", 150)] {
        click(&mut window, &[name]);
        assert!(surroundings(&window).contains(&Color32::from_gray(gray)), "{name}: {:?}", surroundings(&window));
    }
}

#[test]
fn a_reference_picture_is_moved_to_the_right_and_up() {
    let stage = Stage::new();
    write_png(&stage.folder.path().join("low.png"), &Preview::transparent(16, 9)).expect("written");
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::R);
    click(&mut window, &["low.png", "Choose", "View", "Reference pictures"]);
    until_pictures(&mut window, 2);
    let place = |window: &Window| pictures(window)[1].rect;
    let (before, lines) = (place(&window), pictures(&window)[0].rect.height());
    number(&mut window, "Right of low.png", 0.25);
    number(&mut window, "Up of low.png", -0.5);
    let moved = place(&window).center() - before.center();
    assert!((moved - lines * egui::vec2(0.25, 0.5)).length() < 0.1, "{moved:?}");
    assert!(changes(&window).is_empty(), "the shot does not hold it");
}
