//! The layout: panels keep their sizes, words do not lie over each other, edges are caught easily.

use super::acts::{choose, click, drag, press};
use super::seen::{says, texts};
use super::stage::{PINS, Stage};
use super::window::{Window, changes, opened_with, place, pointer, session, settled, window};
use eframe::egui::{Color32, Key, Modifiers, Rect, Shape, vec2};
use egui_kittest::kittest::Queryable;

fn picture(window: &Window) -> Rect {
    window.get_by_label("Viewport").rect()
}

/// Texts and where they are.
fn placed(window: &Window) -> Vec<(String, Rect)> {
    let placed = |shape: &Shape| match shape {
        Shape::Text(text) => Some((text.galley.text().to_owned(), text.galley.rect.translate(text.pos.to_vec2()))),
        _ => None,
    };
    window.output().shapes.iter().filter_map(|clipped| placed(&clipped.shape)).collect()
}

/// The colours of filled circles in the picture.
fn discs(window: &Window) -> Vec<Color32> {
    let disc = |shape: &Shape| match shape {
        Shape::Circle(circle) if circle.radius < 7.0 => Some(circle.fill),
        _ => None,
    };
    window.output().shapes.iter().filter_map(|clipped| disc(&clipped.shape)).collect()
}

#[test]
fn panels_keep_their_widths_whatever_they_contain() {
    let (_stage, mut window) = opened_with(PINS);
    let before = picture(&window);
    click(&mut window, &["a"]);
    assert_eq!(picture(&window), before, "with the numbers of a pin");
    window.query_all_by_label("Shot").next().expect("the settings of the shot").click_accesskit();
    window.run_steps(3);
    assert_eq!(picture(&window), before, "with the settings of the shot");
    window.get_by_label("Stiffness brush").click_accesskit();
    window.run_steps(3);
    assert_eq!(picture(&window), before);
    let is_cut = |(_, rect): &(String, Rect)| {
        let is_in_panels = rect.center().y < before.bottom() && rect.top() > before.top();
        is_in_panels && (rect.left() < before.left() && rect.right() > before.left() || rect.right() > 1280.0)
    };
    let cut: Vec<_> = placed(&window).into_iter().filter(is_cut).collect();
    assert!(cut.is_empty(), "{cut:?}");
    click(&mut window, &["Settings of 'left'"]);
    assert_eq!(picture(&window), before);
}

#[test]
fn the_report_of_a_narrow_panel_is_readable() {
    let (_stage, mut window) = opened_with(PINS);
    let edge = picture(&window).right_center();
    drag(&mut window, [edge + vec2(3.0, 0.0), edge + vec2(200.0, 0.0)]);
    settled(&mut window);
    let panel = picture(&window).right();
    let words: Vec<_> = placed(&window).into_iter().filter(|(_, rect)| rect.left() > panel).collect();
    assert!(words.iter().filter(|(text, _)| text == "worst").count() > 1, "{words:?}");
    for (k, (text, rect)) in words.iter().enumerate() {
        let over = words[k + 1..].iter().find(|(_, other)| other.shrink(1.0).intersects(rect.shrink(1.0)));
        assert!(over.is_none(), "'{text}' lies over {over:?}");
    }
}

#[test]
fn the_edge_of_the_timeline_is_caught_from_six_points() {
    let (_stage, mut window) = opened_with(PINS);
    let before = picture(&window).bottom();
    let beside = picture(&window).center_bottom() + vec2(0.0, 6.0);
    drag(&mut window, [beside, beside - vec2(0.0, 60.0)]);
    assert!(picture(&window).bottom() < before - 30.0, "{} and {before}", picture(&window).bottom());
}

#[test]
fn the_ease_that_is_shown_is_that_of_the_keys_which_are_chosen() {
    let (_stage, mut window) = opened_with(PINS);
    assert!(says(&window, "Ease: no key"), "{:?}", texts(&window));
    choose(&mut window, "Ease", "Hold");
    assert!(says(&window, "No key is selected") && changes(&window).is_empty(), "{:?}", texts(&window));
    click(&mut window, &["a"]);
    assert!(says(&window, "Smooth") && !says(&window, "Ease: no key"), "{:?}", texts(&window));
    choose(&mut window, "Ease", "Hold");
    assert_eq!(changes(&window), ["Hold keys"]);
    assert!(says(&window, "Hold"), "{:?}", texts(&window));
}

#[test]
fn pins_of_muted_layers_are_dim_and_after_the_last_key_is_no_between() {
    let (_stage, mut window) = opened_with(PINS);
    let bright = discs(&window);
    click(&mut window, &["Mute the layer \"left\""]);
    settled(&mut window);
    let dim = discs(&window);
    let lost = bright.iter().filter(|color| !dim.contains(color)).count();
    assert!(lost > 0, "{bright:?} and {dim:?}");
    click(&mut window, &["Unmute the layer \"left\"", "b"]);
    for (frame, words) in [(1, "before the first key"), (4, "between keys"), (6, "after the last key")] {
        let session = window.state_mut().as_mut().and_then(pinwarp::edit::ui::Editor::session_mut);
        session.expect("a shot is open").go(frame);
        settled(&mut window);
        assert!(says(&window, words), "{words}: {:?}", texts(&window));
    }
}

#[test]
fn the_way_of_the_brush_is_seen_before_its_surface_is_known() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let way = [0.3, 0.4, 0.5].map(|x| place(&window, x, 0.5));
    pointer(&mut window, way[0], None);
    super::acts::hold(&mut window, Key::S, true);
    // Replies of the worker are left unread.
    window.state_mut().as_mut().and_then(pinwarp::edit::ui::Editor::session_mut).expect("a shot is open").hold();
    let wide = |window: &Window| {
        let is_wide =
            |shape: &Shape| matches!(shape, Shape::Circle(circle) if circle.radius > 8.0 && circle.fill.a() > 0);
        window.output().shapes.iter().filter(|clipped| is_wide(&clipped.shape)).count()
    };
    assert_eq!(wide(&window), 0);
    pointer(&mut window, way[0], Some(true));
    way.iter().for_each(|&at| pointer(&mut window, at, None));
    assert!(wide(&window) > 2, "{}", wide(&window));
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert_eq!((wide(&window), session(&window).is_painting()), (0, false));
}
