//! A person's work without a window: place, drag, key, undo, save, render.

use super::stage::{SHOT, Stage, TIMEOUT, at, drag, place_pin, press, until};
use pinwarp::edit::{DiskChange, EasePreset, Picture, Quality, Session};
use pinwarp::image::{preview, read_exr};
use pinwarp::pipeline::{PreparedShot, RenderOptions, render};
use pinwarp::raster::DeviceChoice;
use pinwarp::shot::{Goal, Shot};
use std::fs;
use std::sync::atomic::AtomicBool;

/// A point on the left card in frame 1, which lies from 0.189 to 0.789 across.
const ON_LEFT: [f64; 2] = [0.4, 0.5];

#[test]
fn a_click_places_a_pin_and_a_drag_keys_it_in_the_frame_that_is_seen() {
    let (_stage, mut session) = Stage::open();
    place_pin(&mut session, at(ON_LEFT[0], ON_LEFT[1]));
    session.go(4);
    assert!(session.settle(TIMEOUT));
    let mark = session.marks()[0].pins[0].target;
    drag(&mut session, mark.0.to_array(), [mark.0.x, mark.0.y + 0.1]);
    let pin = &session.document().shot().layers[0].pins[0];
    assert_eq!((pin.name.as_str(), pin.keys.len()), ("Left", 2));
    let Goal::Offset(offset) = pin.keys[1].goal else { panic!("{:?}", pin.keys) };
    assert_eq!(pin.keys[1].frame, 4.0);
    assert!((offset.0.y - 0.1).abs() < 1e-6 && offset.0.x.abs() < 1e-6, "{offset:?}");
    // It lies where it was dragged to.
    let mark = &session.marks()[0].pins[0];
    assert!((mark.target.0.y - mark.rest.0.y - 0.1).abs() < 1e-6);
}

#[test]
fn everything_is_undone_to_the_byte_and_saved_with_comments() {
    let (stage, mut session) = Stage::open();
    place_pin(&mut session, at(ON_LEFT[0], ON_LEFT[1]));
    drag(&mut session, ON_LEFT, [0.5, 0.6]);
    session.nudge(glam::DVec2::new(0.01, 0.0));
    session.nudge(glam::DVec2::new(0.01, 0.0));
    let text = session.document().text().to_owned();
    let labels: Vec<&str> = session.document().history().labels().collect();
    assert_eq!(labels, ["Add pin", "Move pin", "Nudge pin"], "nudges in a row are one");
    session.save().expect("writable");
    assert!(!session.document().is_dirty());
    for _ in 0..3 {
        session.undo();
    }
    assert_eq!(session.document().text(), SHOT);
    for _ in 0..3 {
        session.redo();
    }
    assert_eq!(session.document().text(), text);
    let saved = fs::read_to_string(stage.shot()).expect("saved");
    assert_eq!(saved, text);
    for comment in ["# Two cards.", "# beside this file", "# coarse on purpose"] {
        assert!(saved.contains(comment), "{saved}");
    }
    Shot::read(&stage.shot()).expect("what is saved is a shot");
}

#[test]
fn what_is_seen_is_what_is_rendered_bit_for_bit() {
    let (stage, mut session) = Stage::open();
    session.set_layer("Solve over time", &["solve", "temporal"], &pinwarp::shot::edit::Setting::Number(0.3), None);
    place_pin(&mut session, at(ON_LEFT[0], ON_LEFT[1]));
    session.go(3);
    assert!(session.settle(TIMEOUT));
    let mark = session.marks()[0].pins[0].target.0;
    drag(&mut session, mark.to_array(), [mark.x + 0.06, mark.y + 0.12]);
    let seen = session.picture().expect("drawn").clone();
    assert_eq!((seen.quality, seen.frame), (Quality::Final, 3));
    session.save().expect("writable");
    let prepared = PreparedShot::new(Shot::read(&stage.shot()).expect("a shot")).expect("it loads");
    let options = RenderOptions { frames: vec![3], device: DeviceChoice::Cpu, ..RenderOptions::default() };
    render(&prepared, &options, &AtomicBool::new(false), &|_| ()).expect("rendered");
    let frame = read_exr(&stage.folder.path().join("out/frame.0003.exr")).expect("written");
    let rendered = Picture::of(&frame, (3, seen.revision), Quality::Final);
    let differing = seen.rgba.iter().zip(&rendered.rgba).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    // The file holds half floats; the picture in memory does not.
    assert_eq!(differing, 0);
    let rest = read_exr_at_rest(&stage);
    assert_ne!(preview(&frame), preview(&rest), "the pin moves something");
}

/// The same frame without pins.
fn read_exr_at_rest(stage: &Stage) -> pinwarp::image::Frame {
    let path = stage.folder.path().join("rest.toml");
    fs::write(&path, SHOT.replace("out/frame", "out/rest")).expect("written");
    let prepared = PreparedShot::new(Shot::read(&path).expect("a shot")).expect("it loads");
    let options = RenderOptions { frames: vec![3], device: DeviceChoice::Cpu, ..RenderOptions::default() };
    render(&prepared, &options, &AtomicBool::new(false), &|_| ()).expect("rendered");
    read_exr(&stage.folder.path().join("out/rest.0003.exr")).expect("written")
}

#[test]
fn a_late_pin_is_born_where_the_surface_is_seen() {
    let (_stage, mut session) = Stage::open();
    place_pin(&mut session, at(0.3, 0.5));
    drag(&mut session, [0.3, 0.5], [0.3, 0.65]);
    // The surface that is seen here now was elsewhere at rest.
    place_pin(&mut session, at(0.45, 0.7));
    let late = &session.marks()[0].pins[1];
    assert!((late.target.0 - glam::DVec2::new(0.45, 0.7)).length() < 1e-4, "{late:?}");
    assert!((late.target - late.rest).0.length() > 0.05, "{late:?}");
}

#[test]
fn empty_space_chooses_by_a_box_and_escape_gives_a_drag_up() {
    let (_stage, mut session) = Stage::open();
    place_pin(&mut session, at(0.3, 0.5));
    place_pin(&mut session, at(0.6, 0.5));
    press(&mut session, at(0.02, 0.95));
    session.motion(at(0.5, 0.05));
    until(&mut session, "a box is drawn", |session| session.choosing_box().is_some());
    session.motion(at(0.5, 0.05));
    session.release();
    assert_eq!(session.selection.pins.iter().copied().collect::<Vec<_>>(), [[0, 0]]);
    let before = session.document().text().to_owned();
    press(&mut session, at(0.3, 0.5));
    session.motion(at(0.35, 0.6));
    session.cancel();
    session.release();
    assert!(session.settle(TIMEOUT));
    assert_eq!(session.document().text(), before);
    let mark = &session.marks()[0].pins[0];
    assert!((mark.target - mark.rest).0.length() < 1e-6);
}

#[test]
fn keys_are_eased_copied_and_pasted_and_layers_are_muted() {
    let (_stage, mut session) = Stage::open();
    place_pin(&mut session, at(0.3, 0.5));
    session.go(3);
    session.insert_keys();
    let target = session.marks()[0].pins[0].target.0.to_array();
    drag(&mut session, target, [0.4, 0.7]);
    session.choose_key([0, 0], 1.0, false);
    session.ease_keys(EasePreset::Hold);
    session.copy_keys();
    place_pin(&mut session, at(1.2, 0.5));
    session.go(5);
    session.paste_keys();
    let pins =
        |session: &Session| session.document().shot().layers.iter().map(|layer| layer.pins.clone()).collect::<Vec<_>>();
    let of = pins(&session);
    assert_eq!(of[0][0].keys[0].ease, EasePreset::Hold.ease());
    assert_eq!(of[1][0].keys.iter().map(|key| key.frame).collect::<Vec<_>>(), [1.0, 5.0]);
    session.go(3);
    assert!(session.settle(TIMEOUT));
    let moved = session.picture().expect("drawn").rgba.clone();
    let text = session.document().text().to_owned();
    session.toggle_mute("left");
    assert!(session.settle(TIMEOUT));
    assert_ne!(session.picture().expect("drawn").rgba, moved);
    session.toggle_mute("left");
    assert!(session.settle(TIMEOUT));
    assert_eq!((&session.picture().expect("drawn").rgba, session.document().text()), (&moved, text.as_str()));
    let labels: Vec<&str> = session.document().history().labels().collect();
    assert_eq!(labels[labels.len() - 2..], ["Mute layer", "Unmute layer"]);
}

#[test]
fn a_faulty_edit_is_reported_and_changes_nothing() {
    let (_stage, mut session) = Stage::open();
    session.set_shot("Frames", &["frames", "last"], &pinwarp::shot::edit::Setting::Whole(-5), None);
    assert!(session.message().is_some_and(|text| text.contains("last")), "{:?}", session.message());
    assert_eq!(session.document().text(), SHOT);
    session.delete_pins();
    assert_eq!(session.message(), Some("No pin is selected: click one first."));
}

#[test]
fn changes_elsewhere_in_the_file_are_merged_and_those_in_one_place_are_asked_about() {
    let (stage, mut session) = Stage::open();
    place_pin(&mut session, at(ON_LEFT[0], ON_LEFT[1]));
    let own = session.document().text().to_owned();
    fs::write(stage.shot(), SHOT.replace("samples = 4", "samples = 5 # more")).expect("written");
    assert_eq!(session.document_mut().check_disk().expect("a shot"), DiskChange::Merged);
    let merged = session.document().text().to_owned();
    assert_eq!(merged, own.replace("samples = 4", "samples = 5 # more"));
    assert!(session.document().is_dirty() && session.document().shot().samples == 5);
    session.undo();
    assert_eq!(session.document().text(), own);
    session.redo();
    session.set_shot("Change samples", &["samples"], &pinwarp::shot::edit::Setting::Whole(7), None);
    let other = SHOT.replace("samples = 4", "samples = 6 # fewer");
    fs::write(stage.shot(), &other).expect("written");
    assert_eq!(session.document_mut().check_disk().expect("a shot"), DiskChange::Conflict(other));
}

#[test]
fn a_click_on_what_no_layer_moves_is_explained() {
    let stage = Stage::new();
    let end = SHOT.find("[[layer]]\nname    = \"right\"").expect("the other layer");
    let output = SHOT.find("[output]").expect("the output");
    fs::write(stage.shot(), [&SHOT[..end], &SHOT[output..]].concat()).expect("written");
    let mut session = stage.session();
    press(&mut session, at(1.35, 0.5));
    session.release();
    until(&mut session, "the click is answered", |session| session.message().is_some());
    assert!(session.message().is_some_and(|told| told.contains("No layer moves 'Right'")), "{:?}", session.message());
}

#[test]
fn a_click_in_a_shot_without_layers_is_explained_and_a_held_drag_is_a_box() {
    let stage = Stage::new();
    let [layers, output] = ["[[layer]]", "[output]"].map(|key| SHOT.find(key).expect("there"));
    fs::write(stage.shot(), [&SHOT[..layers], &SHOT[output..]].concat()).expect("written");
    let mut session = stage.session();
    press(&mut session, at(ON_LEFT[0], ON_LEFT[1]));
    session.motion(at(0.5, 0.6));
    until(&mut session, "a box is drawn", |session| session.choosing_box().is_some());
    let told = session.message().unwrap_or_default().to_owned();
    assert!(told.contains("No layer moves 'Left'") && told.contains("make one from it"), "{told}");
    session.release();
    assert!(session.choosing_box().is_none() && session.selection.pins.is_empty());
}
