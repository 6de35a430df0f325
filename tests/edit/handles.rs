//! Handles of a lattice: chosen by a box, nudged, typed, put back.

use super::stage::{REACH, SHOT, Stage, TIMEOUT, at};
use super::window::{Window, session, settled, window};
use eframe::egui::Key;
use egui_kittest::kittest::Queryable;
use pinwarp::edit::{Held, Ring, Session};

/// Draws a box around two handles in the middle of the left lattice.
fn choose_two(session: &mut Session) {
    let handles = session.marks()[0].handles.clone();
    let middle = |[a, b]: [usize; 2]| {
        let middle = 0.5 * (handles[a].expect("seen").0 + handles[b].expect("seen").0);
        at(middle.x, middle.y)
    };
    let held = Held { adds: true, ..Held::default() };
    session.press(middle([13, 20]), (REACH, Ring { radius: 9.0, reach: 0.0 }), held);
    session.motion(middle([21, 28]));
    session.release();
}

#[test]
fn a_box_chooses_handles_that_are_shown_which_are_nudged_and_put_back() {
    let (_stage, mut session) = Stage::open();
    choose_two(&mut session);
    assert!(session.selection.handles.is_empty(), "they are hidden");
    session.shown.handles = true;
    choose_two(&mut session);
    // The lattice of the other card lies over this one.
    session.selection.handles.retain(|(layer, _)| *layer == 0);
    let chosen: Vec<_> = session.selection.handles.iter().copied().collect();
    assert_eq!(chosen, [(0, [2, 3, 0]), (0, [3, 3, 0])]);
    session.nudge(glam::DVec2::new(0.0, 0.05));
    assert!(session.settle(TIMEOUT), "{:?}", session.fault());
    let moved: Vec<_> = session.document().shot().layers[0].handles.iter().map(|track| track.index).collect();
    assert_eq!(moved, [[2, 3, 0], [3, 3, 0]]);
    session.delete_pins();
    assert_eq!(session.document().text(), SHOT);
    assert_eq!(session.document().history().labels().collect::<Vec<_>>(), ["Nudge handles", "Reset handles"]);
}

#[test]
fn a_handle_is_chosen_and_moved_by_numbers() {
    let stage = Stage::new();
    let mut window = window(&stage.state(), Some(&stage.shot()));
    settled(&mut window);
    let number = |window: &mut Window, label: &str, value: f64| {
        window.get_all_by_label(label).next().expect("it is there").set_value_accesskit(value);
        window.run_steps(3);
    };
    assert!(window.query_by_label("Select the first").is_none(), "handles are hidden");
    window.key_press(Key::L);
    window.run_steps(2);
    window.get_by_label("Select the first").click();
    window.run_steps(3);
    number(&mut window, "Handle column", 2.0);
    number(&mut window, "Handle row", 3.0);
    assert_eq!(session(&window).selection.handles.iter().copied().collect::<Vec<_>>(), [(0, [2, 3, 0])]);
    number(&mut window, "Handle offset y", 12.5);
    let tracks = session(&window).document().shot().layers[0].handles.clone();
    assert_eq!((tracks.len(), tracks[0].index, tracks[0].keys[0].offset), (1, [2, 3, 0], [0.0, 0.125, 0.0]));
    assert!(window.query_by_label("Handle offset z").is_none(), "the lattice is on the screen");
    window.get_by_label("Reset").click();
    window.run_steps(3);
    assert_eq!(session(&window).document().text(), SHOT);
}
