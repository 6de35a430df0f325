//! Playback, its range, and exposure in the real interface. The clock of the window is the test's own.

use super::acts::{choose, click, drag, press};
use super::seen::{fills, segments};
use super::stage::{PINS, Stage, until as until_known};
use super::window::{Window, changes, opened_with, place, session, settled, until, window};
use eframe::egui::{Color32, Key, Modifiers, Rect, Shape, ViewportId};
use egui_kittest::kittest::Queryable;
use pinwarp::edit::ui::Editor;
use pinwarp::edit::{Channel, Document, Figure, RunState, Session};
use pinwarp::raster::DeviceChoice;
use pinwarp::shot::Ease;
use std::fs;
use std::time::Duration;

const RATE: f64 = 24.0;

/// One pass at a time, in seconds.
fn pass(window: &mut Window, secs: f64) {
    window.input_mut().time = Some(secs);
    window.step();
}

fn frame(window: &Window) -> i32 {
    session(window).playhead.frame()
}

/// The time after which the window draws itself again.
fn delay(window: &Window) -> Duration {
    window.output().viewport_output[&ViewportId::ROOT].repaint_delay
}

#[test]
fn playback_in_real_time_drops_frames_and_that_of_every_frame_does_not() {
    let (_stage, mut window) = opened_with(PINS);
    let begun = 1000.0;
    pass(&mut window, begun);
    press(&mut window, Modifiers::NONE, Key::Space);
    assert!(window.query_by_label("Stop").is_some());
    for (passed, seen) in [(0.5, 1), (2.5, 3), (4.5, 5), (6.5, 1), (11.5, 6)] {
        pass(&mut window, begun + passed / RATE);
        assert_eq!(frame(&window), seen, "after {passed} frames");
    }
    assert!(delay(&window) <= Duration::from_secs_f64(1.0 / RATE), "it wakes for the next frame");
    press(&mut window, Modifiers::NONE, Key::Space);
    pass(&mut window, begun + 8.0);
    assert_eq!(frame(&window), 6, "stopped");
    click(&mut window, &["Every frame", "First frame", "Play"]);
    let mut shown = vec![frame(&window)];
    let mut now = begun + 10.0;
    // Whole seconds pass, and each frame is shown all the same.
    while shown.len() < 9 {
        now += 3.0;
        pass(&mut window, now);
        assert!(now < begun + 60_000.0, "{shown:?}");
        match frame(&window) {
            same if shown.last() == Some(&same) => std::thread::sleep(Duration::from_millis(1)),
            next => shown.push(next),
        }
    }
    assert_eq!(shown, [1, 2, 3, 4, 5, 6, 1, 2, 3]);
    click(&mut window, &["Stop"]);
    settled(&mut window);
}

#[test]
fn in_and_out_bound_what_is_played_and_rendered() {
    let (stage, mut window) = opened_with(PINS);
    let ruler: Rect = window.get_by_label("Frames").rect();
    let accent = |window: &Window| -> Vec<f32> {
        let bars = fills(window).into_iter().filter(|(rect, fill)| {
            *fill == Color32::from_rgb(232, 146, 36) && rect.height() == 4.0 && ruler.contains(rect.center())
        });
        bars.map(|(rect, _)| rect.width()).collect()
    };
    assert!(accent(&window).is_empty());
    click(&mut window, &["Frame forward"]);
    press(&mut window, Modifiers::NONE, Key::I);
    click(&mut window, &["Frame forward", "Frame forward"]);
    press(&mut window, Modifiers::NONE, Key::O);
    let [width] = accent(&window)[..] else { panic!("{:?}", accent(&window)) };
    assert!((width - 0.5 * (ruler.width() - 166.0)).abs() < 1.0, "three of six frames: {width}");
    for (label, seen) in [("First frame", 2), ("Frame back", 4), ("Frame forward", 2), ("Last frame", 4)] {
        click(&mut window, &[label]);
        assert_eq!(frame(&window), seen, "{label}");
    }
    pass(&mut window, 1000.0);
    press(&mut window, Modifiers::NONE, Key::Space);
    for (passed, seen) in [(0.5, 4), (1.5, 2), (2.5, 3), (5.5, 3)] {
        pass(&mut window, 1000.0 + passed / RATE);
        assert_eq!(frame(&window), seen, "after {passed} frames");
    }
    press(&mut window, Modifiers::NONE, Key::Space);
    press(&mut window, Modifiers::COMMAND, Key::R);
    until(&mut window, "the render ends", |window| {
        session(window).run().is_some_and(|run| run.state != RunState::Running)
    });
    let rendered: Vec<i32> = (1..=6).filter(|&frame| is_rendered(&stage, frame)).collect();
    assert_eq!(rendered, [2, 3, 4]);
    press(&mut window, Modifiers::SHIFT, Key::O);
    assert!(accent(&window).is_empty());
    press(&mut window, Modifiers::NONE, Key::End);
    assert_eq!(frame(&window), 6);
    assert!(changes(&window).is_empty(), "the shot is as it was");
}

fn is_rendered(stage: &Stage, frame: i32) -> bool {
    stage.folder.path().join(format!("out/frame.{frame:04}.exr")).exists()
}

#[test]
fn on_twos_and_threes_a_drawing_is_held() {
    let (_stage, mut window) = opened_with(PINS);
    // Pin a moves by 0.1 from frame 1 to 3.
    let moved = |window: &mut Window, frames: usize| {
        click(window, &["First frame"]);
        (1..frames).for_each(|_| click(window, &["Frame forward"]));
        settled(window);
        let pin = &session(window).marks()[0].pins[0];
        (1e3 * (pin.target - pin.rest).0.x).round()
    };
    let step = |window: &Window| session(window).document().shot().layers[0].step;
    let expose = |window: &mut Window, name: &str| choose(window, "Exposure", name);
    assert_eq!([2, 3].map(|frame| moved(&mut window, frame)), [50.0, 100.0]);
    expose(&mut window, "On twos");
    assert_eq!(step(&window), 2);
    assert_eq!([2, 3].map(|frame| moved(&mut window, frame)), [0.0, 100.0]);
    expose(&mut window, "On threes");
    assert_eq!(step(&window), 3);
    assert_eq!([2, 3].map(|frame| moved(&mut window, frame)), [0.0, 0.0]);
    // A key is set where the drawing began.
    window.get_by_label("b").click();
    window.run_steps(3);
    press(&mut window, Modifiers::NONE, Key::K);
    let keys = &session(&window).document().shot().layers[0].pins[1].keys;
    assert_eq!(keys[0].frame, 1.0, "{keys:?}");
    expose(&mut window, "On ones");
    assert_eq!(step(&window), 1);
    assert_eq!([2, 3].map(|frame| moved(&mut window, frame)), [50.0, 100.0]);
    assert_eq!(changes(&window).iter().filter(|change| *change == "Change exposure").count(), 3);
}

#[test]
fn without_auto_key_a_drag_shifts_all_keys_and_eases_are_chosen_from_the_list() {
    let (_stage, mut window) = opened_with(PINS);
    let keys = |window: &Window| session(window).document().shot().layers[0].pins[0].keys.clone();
    let moved = |window: &mut Window| {
        let pin = session(window).marks()[0].pins[0].target.0;
        let ends = [[pin.x, pin.y], [pin.x, pin.y + 0.1]].map(|[x, y]| place(window, x, y));
        drag(window, ends);
        settled(window);
    };
    click(&mut window, &["Frame forward", "Auto key"]);
    settled(&mut window);
    moved(&mut window);
    assert_eq!(keys(&window).iter().map(|key| key.frame).collect::<Vec<_>>(), [1.0, 3.0, 6.0]);
    let heights: Vec<f64> = session(&window).curve_keys([0, 0], Channel::Y).iter().map(|key| key[1].round()).collect();
    assert_eq!(heights, [5.0; 3], "a tenth of 54 lines");
    click(&mut window, &["Auto key"]);
    moved(&mut window);
    assert_eq!(keys(&window).iter().map(|key| key.frame).collect::<Vec<_>>(), [1.0, 2.0, 3.0, 6.0]);
    window.get_by_label("Key of a, frame 3, Linear").click_accesskit();
    window.run_steps(3);
    choose(&mut window, "Ease", "Hold");
    assert_eq!(keys(&window)[2].ease, Ease::Hold);
    assert!(window.query_by_label("Key of a, frame 3, Hold").is_some());
}

#[test]
fn frames_that_were_drawn_before_the_solve_over_time_are_reported_after_it() {
    let stage = Stage::with(PINS);
    let mut session = Session::new(Document::open(&stage.shot()).expect("a shot"), DeviceChoice::Cpu, || ());
    // Playback draws each frame for itself, before anything is solved over time.
    session.toggle_play(0.0);
    until_known(&mut session, "all frames are drawn", |session| {
        (1..=6).all(|frame| session.picture_of(frame).is_some())
    });
    session.toggle_play(0.0);
    until_known(&mut session, "all frames are reported", |session| session.reported() == [6, 6]);
    assert!(session.worst(Figure::PinError).is_some());
}

/// The texts and the ticks of the ruler, by their places.
fn ruler_marks(window: &Window) -> (Rect, Vec<Rect>, Vec<f32>) {
    let ruler: Rect = window.get_by_label("Frames").rect();
    let shapes = window.output().shapes.iter().map(|clipped| &clipped.shape);
    let texts = shapes.filter_map(|shape| match shape {
        Shape::Text(text) => Some(text.visual_bounding_rect()).filter(|rect| ruler.contains(rect.center())),
        _ => None,
    });
    let ticks = segments(window, 1.0).into_iter().map(|[from, to]| (from, to));
    let ticks = ticks.filter(|(from, to)| from.x == to.x && ruler.contains(*from) && (to.y - from.y).abs() == 5.0);
    (ruler, texts.collect(), ticks.map(|(from, _)| from.x).collect())
}

#[test]
fn the_ruler_of_ten_thousand_frames_has_as_many_marks_as_there_is_room_for() {
    let stage = Stage::with(PINS);
    let text = fs::read_to_string(stage.shot()).expect("there").replace("last = 6", "last = 10000");
    fs::write(stage.shot(), text).expect("written");
    let mut window = window(&stage.state(), Some(&stage.shot()));
    for frame in [1, 5000, 10_000] {
        window.state_mut().as_mut().and_then(Editor::session_mut).expect("open").go(frame);
        window.run_steps(2);
        let (ruler, texts, ticks) = ruler_marks(&window);
        let most = (ruler.width() / 60.0) as usize + 1;
        assert!((5..=most).contains(&ticks.len()), "{ticks:?}");
        // The frame that is seen is named, too.
        assert_eq!(texts.len(), ticks.len() + 1);
        assert!(ticks.windows(2).skip(1).all(|pair| pair[1] - pair[0] >= 60.0), "{ticks:?}");
        assert!(texts.iter().all(|rect| ruler.expand(16.0).contains_rect(*rect)), "{texts:?}");
        let heads = segments(&window, 1.5).into_iter().filter(|[from, to]| from.x == to.x);
        assert!(heads.map(|[from, _]| from.x).all(|x| ruler.x_range().contains(x)));
    }
}

#[test]
fn a_shot_that_becomes_shorter_on_disk_keeps_the_playhead_in_the_ruler() {
    let (stage, mut window) = opened_with(PINS);
    click(&mut window, &["Last frame"]);
    settled(&mut window);
    let text = fs::read_to_string(stage.shot()).expect("there").replace("last = 6", "last = 3");
    fs::write(stage.shot(), text).expect("written");
    until(&mut window, "the last frame is shown", |window| frame(window) == 3);
    settled(&mut window);
    let ruler: Rect = window.get_by_label("Frames").rect();
    let heads = segments(&window, 1.5).into_iter().filter(|[from, to]| from.x == to.x && ruler.contains(*from));
    let heads: Vec<f32> = heads.map(|[from, _]| from.x).collect();
    let middle_of_last = ruler.left() + 150.0 + (ruler.width() - 166.0) * 2.5 / 3.0;
    assert!(heads.len() == 1 && (heads[0] - middle_of_last).abs() < 1.0, "{heads:?} instead of {middle_of_last}");
}
