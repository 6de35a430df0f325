//! The window as a picture, against one that is kept beside this file: layout, letters, marks, the frame itself.
//!
//! All of it is drawn on the CPU by code of this program, with the toolkit's own fonts, so pictures hardly differ from machine to machine.
//! `UPDATE=1` writes them anew.

use super::stage::{PINS, Stage, TIMEOUT, at, place_pin, press};
use pinwarp::edit::ui::{EditorOptions, Screenshot, Theme, screenshot};
use pinwarp::image::{Plate, read_picture};
use pinwarp::raster::DeviceChoice;
use pinwarp::scene::FileAccess;
use std::path::{Path, PathBuf};

/// Differences up to this, of 1, are none: sines and roots may differ in their last bits.
const SAME: f32 = 0.04;

/// Pixels that may differ: a thousandth.
const MAX_DIFFERENCE: f64 = 1e-3;

fn kept(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/edit/pictures").join(name)
}

fn samples(plate: &Plate) -> Vec<&[f32]> {
    let channels = &plate.parts[0].channels;
    ["R", "G", "B"]
        .iter()
        .filter_map(|name| channels.iter().find(|channel| channel.name == *name))
        .map(|channel| &channel.samples[..])
        .collect()
}

/// The share of pixels that differ.
fn differing(a: &Plate, b: &Plate) -> f64 {
    assert_eq!(a.display, b.display);
    let (a, b) = (samples(a), samples(b));
    let count = a[0].len();
    let is_other = |&pixel: &usize| (0..3).any(|channel| (a[channel][pixel] - b[channel][pixel]).abs() > SAME);
    (0..count).filter(is_other).count() as f64 / count as f64
}

/// What the kept pictures show.
fn usual(theme: Theme) -> Screenshot {
    Screenshot { frame: Some(3), pins: Vec::new(), has_curves: false, size: [960, 600], theme }
}

fn drawn(shot: &Path, state: &Path, shown: &Screenshot) -> PathBuf {
    let output = state.join("window.png");
    std::fs::create_dir_all(state).expect("a folder");
    screenshot(shot, shown, &output, options(state)).expect("drawn");
    output
}

fn options(state: &Path) -> EditorOptions {
    EditorOptions { device: DeviceChoice::Cpu, access: FileAccess::SceneFolder, folder: state.to_owned() }
}

#[test]
fn the_window_looks_as_it_did() {
    let (stage, mut session) = Stage::open();
    for (x, y) in [(0.3, 0.35), (0.65, 0.35), (0.45, 0.7), (1.2, 0.5)] {
        place_pin(&mut session, at(x, y));
    }
    session.go(3);
    assert!(session.settle(TIMEOUT));
    let mark = session.marks()[0].pins[2].target.0;
    press(&mut session, at(mark.x, mark.y));
    session.motion(at(mark.x + 0.06, mark.y + 0.08));
    session.release();
    session.save().expect("writable");
    drop(session);
    for (theme, name) in [(Theme::Dark, "dark.png"), (Theme::Light, "light.png")] {
        let new = drawn(&stage.shot(), &stage.state(), &usual(theme));
        if std::env::var_os("UPDATE").is_some() {
            std::fs::create_dir_all(kept("")).expect("a folder");
            std::fs::copy(&new, kept(name)).expect("kept");
        }
        let [new, old] = [new, kept(name)].map(|path| read_picture(&path).expect("a picture; UPDATE=1 writes it"));
        let share = differing(&new, &old);
        assert!(share < MAX_DIFFERENCE, "{name}: {:.2} % of the pixels differ; UPDATE=1 writes it anew", 100.0 * share);
    }
}

#[test]
fn another_window_looks_different() {
    let stage = Stage::new();
    let [dark, light] = [Theme::Dark, Theme::Light]
        .map(|theme| read_picture(&drawn(&stage.shot(), &stage.state(), &usual(theme))).expect("a picture"));
    assert!(differing(&dark, &light) > 0.5);
    let kept = read_picture(&kept("dark.png")).expect("kept");
    assert!(differing(&dark, &kept) > MAX_DIFFERENCE, "without pins it is another picture");
}

#[test]
fn a_picture_shows_what_it_is_told_to() {
    let stage = Stage::with(PINS);
    let mut pictures: Vec<Plate> = Vec::new();
    for (pins, has_curves) in [(&[][..], false), (&["b"][..], false), (&["b"], true), (&["a", "b"], true)] {
        let pins = pins.iter().map(|&name| name.to_owned()).collect();
        let shown = Screenshot { pins, has_curves, ..usual(Theme::Dark) };
        let new = read_picture(&drawn(&stage.shot(), &stage.state(), &shown)).expect("a picture");
        assert!(pictures.iter().all(|old| differing(&new, old) > MAX_DIFFERENCE), "{shown:?}");
        pictures.push(new);
    }
    let (output, options) = (stage.state().join("none.png"), options(&stage.state()));
    let shown = Screenshot { pins: vec!["c".into()], ..usual(Theme::Dark) };
    let told = screenshot(&stage.shot(), &shown, &output, options).expect_err("there is none").to_string();
    assert!(told.contains("no layer has a pin 'c'") && !output.exists(), "{told}");
}
