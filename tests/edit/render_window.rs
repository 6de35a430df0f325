//! Renders from the window: what is ordered is what is written, and the look at the frames ends as it began.

use super::acts::{choose, click, number, press, write};
use super::seen::{pictures, says, texts};
use super::stage::{PINS, Stage};
use super::window::{Window, changes, opened_with, place, pointer, session, settled, until};
use eframe::egui::{Key, Modifiers};
use pinwarp::pipeline::{Pause, PreparedShot, RenderOptions, render};
use pinwarp::raster::DeviceChoice;
use pinwarp::shot::Shot;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Waits until the render has ended.
fn ended(window: &mut Window) {
    until(window, "the render ends", |window| session(window).run().is_some() && !session(window).is_rendering());
}

fn files(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("one").file_name());
    let mut names: Vec<String> = names.map(|name| name.to_string_lossy().into_owned()).collect();
    names.retain(|name| name.starts_with("frame."));
    names.sort();
    names
}

#[test]
fn what_is_ordered_is_rendered_and_told() {
    let (stage, mut window) = opened_with(PINS);
    let text = session(&window).document().text().to_owned();
    click(&mut window, &["Render options"]);
    assert!(session(&window).run().is_none(), "nothing is begun yet");
    choose(&mut window, "Frames to render", "the one shown: 1");
    number(&mut window, "Size in per cent", 50.0);
    number(&mut window, "Samples of the render", 1.0);
    click(&mut window, &["and PNG previews", "Motion blur of the render"]);
    write(&mut window, "Folder of the render", "small");
    assert!(says(&window, "48 x 27 pixels"), "{:?}", texts(&window));
    let folder = stage.folder.path().join("small");
    assert!(says(&window, &format!("Frames go to {}", folder.join("frame.####.exr").display())));
    click(&mut window, &["Start render"]);
    ended(&mut window);
    assert_eq!(files(&folder), ["frame.0001.exr"]);
    let told = session(&window).message().unwrap_or_default();
    assert_eq!(told, format!("Rendered: 1 EXR frame in {}", folder.display()));
    assert!(says(&window, "1 EXR frame to draw"), "{:?}", texts(&window));
    let usual = stage.folder.path().join("out");
    assert!(!usual.exists() && session(&window).document().text() == text);
    // Another shot is rendered as it says.
    let ctx = window.ctx.clone();
    window.state_mut().as_mut().expect("open").open(&ctx, &stage.shot()).expect("it opens");
    settled(&mut window);
    press(&mut window, Modifiers::COMMAND, Key::R);
    ended(&mut window);
    assert_eq!(files(&usual).iter().filter(|name| name.ends_with(".exr")).count(), 6);
}

#[test]
fn a_render_offers_to_wait_before_each_sample() {
    let stage = Stage::with(PINS);
    let count = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&count);
    let pause = Pause::new(move || _ = counted.fetch_add(1, Ordering::Relaxed));
    let options = RenderOptions { frames: vec![3], device: DeviceChoice::Cpu, pause, ..RenderOptions::default() };
    let prepared = PreparedShot::new(Shot::read(&stage.shot()).expect("a shot")).expect("prepared");
    render(&prepared, &options, &AtomicBool::new(false), &|_| ()).expect("rendered");
    let waits = count.load(Ordering::Relaxed);
    assert!(waits > 4, "{waits} for four samples");
}

#[test]
fn the_look_at_rendered_frames_ends_by_button_escape_click_undo_and_edit() {
    let (_stage, mut window) = opened_with(PINS);
    let spot = place(&window, 0.45, 0.35);
    // The names of pins are in the panel, in the timeline and in the picture.
    let names = |window: &Window| texts(window).iter().filter(|text| *text == "b").count();
    let (count, named) = (pictures(&window).len(), names(&window));
    for way in ["button", "Escape", "click", "undo", "edit"] {
        click(&mut window, &["Render frames"]);
        ended(&mut window);
        click(&mut window, &["Look at the frames"]);
        assert!(session(&window).shows_rendered(), "{way}");
        until(&mut window, "they are shown", |window| says(window, "Showing rendered frames: frame.####.exr"));
        assert_eq!(pictures(&window).len(), count, "one figure is seen, not two");
        assert!(names(&window) < named && says(&window, "file of the render"), "{:?}", texts(&window));
        match way {
            "button" => click(&mut window, &["Back to editing"]),
            "Escape" => press(&mut window, Modifiers::NONE, Key::Escape),
            "click" => [true, false].into_iter().for_each(|pressed| pointer(&mut window, spot, Some(pressed))),
            "undo" => press(&mut window, Modifiers::COMMAND, Key::Z),
            _ => click(&mut window, &["Mute pin a"]),
        }
        window.run_steps(3);
        assert!(!session(&window).shows_rendered() && !says(&window, "Showing rendered frames"), "{way}");
        let changed: &[&str] = if way == "edit" { &["Mute pin"] } else { &[] };
        assert_eq!(changes(&window), changed, "{way}");
    }
}
