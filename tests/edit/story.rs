//! One sitting with a model of others, from opening it to rendered frames, by clicks, drags and keys alone.

use super::acts::{click, drag, press, write};
use super::assets::asset;
use super::window::{Window, changes, place, pointer, session, settled, until, window};
use eframe::egui::{self, Key, Modifiers, Pos2, Rect};
use egui_kittest::kittest::Queryable;
use pinwarp::edit::{RunState, open};
use pinwarp::image::{Existing, read_exr};
use pinwarp::pipeline::{PreparedShot, RenderOptions, render};
use pinwarp::raster::DeviceChoice;
use pinwarp::scene::FileAccess;
use pinwarp::shot::Shot;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use toml_edit::{Array, DocumentMut};

/// Width and height of the frame.
const SIZE: [f64; 2] = [96.0, 54.0];

/// A point of the frame in the window, in parts of its width and height.
fn at(window: &Window, x: f64, y: f64) -> Pos2 {
    place(window, x * SIZE[0] / SIZE[1], y)
}

fn pins(window: &Window) -> Vec<Vec<f64>> {
    let layers = &session(window).document().shot().layers;
    layers.iter().flat_map(|layer| &layer.pins).map(|pin| pin.keys.iter().map(|key| key.frame).collect()).collect()
}

/// Where the last pin is seen in the window.
fn last_pin(window: &Window) -> Pos2 {
    let marks = session(window).marks();
    let target = marks.iter().flat_map(|marks| &marks.pins).last().expect("a pin").target.0;
    place(window, target.x, target.y)
}

/// Clicks the model, and waits for the pin.
fn place_pin(window: &mut Window, x: f64, y: f64) {
    let (count, at) = (pins(window).len(), at(window, x, y));
    pointer(window, at, Some(true));
    pointer(window, at, Some(false));
    until(window, "a pin is placed", |window| pins(window).len() == count + 1);
}

/// The two frames of a shot as the library renders them.
fn rendered(shot: &str, path: &Path, name: &str) -> Vec<PathBuf> {
    let shot = shot.replace("render/frame", &format!("render/{name}"));
    let prepared = PreparedShot::new(Shot::parse(&shot, path).expect("a shot")).expect("it loads");
    let options = RenderOptions {
        frames: vec![1, 2],
        device: DeviceChoice::Cpu,
        existing: Existing::Overwrite,
        ..RenderOptions::default()
    };
    render(&prepared, &options, &AtomicBool::new(false), &|_| ()).expect("rendered");
    [1, 2].map(|frame| path.with_file_name(format!("render/{name}.{frame:04}.exr"))).to_vec()
}

#[test]
fn a_model_is_opened_pinned_keyed_played_saved_and_rendered() {
    let Some(knight) = asset("kaykit/Knight.glb") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("Knight.glb");
    fs::copy(knight, &scene).expect("copied");
    // The shot beside it is the one that the editor writes, but small, so that it is drawn in no time.
    let shot = scene.with_extension("toml");
    let text = open(&scene, FileAccess::SceneFolder).expect("it opens").text().to_owned();
    let mut text: DocumentMut = text.parse().expect("TOML");
    text["size"] = SIZE.map(|side| side as i64).into_iter().collect::<Array>().into();
    text["samples"] = 2.into();
    text["frames"]["last"] = 4.into();
    text["solve_range"] = [1, 4].into_iter().collect::<Array>().into();
    text["output"]["path"] = "render/frame.####.exr".into();
    text["layer"][0]["lattice"]["dims"] = [8, 8].into_iter().collect::<Array>().into();
    let text = text.to_string();
    fs::write(&shot, &text).expect("written");

    let mut window = window(&folder.path().join("state"), None);
    click(&mut window, &["Open\u{2026}"]);
    write(&mut window, "Path", &scene.display().to_string());
    click(&mut window, &["Choose"]);
    settled(&mut window);
    for (x, y) in [(0.505, 0.33), (0.47, 0.45), (0.53, 0.6)] {
        place_pin(&mut window, x, y);
    }
    settled(&mut window);
    // Off the model.
    let (from, to) = (last_pin(&window), at(&window, 0.7, 0.8));
    drag(&mut window, [from, to]);
    settled(&mut window);
    assert!(last_pin(&window).distance(to) < 2.0, "the pin is where it was dragged");
    assert_eq!(pins(&window), [vec![1.0], vec![1.0], vec![1.0]]);
    // The second of four frames.
    let ruler: Rect = window.get_by_label("Frames").rect();
    let (left, right) = (ruler.left() + 150.0, ruler.right() - 16.0);
    let second = egui::pos2(left + 1.5 / 4.0 * (right - left), ruler.center().y);
    pointer(&mut window, second, Some(true));
    pointer(&mut window, second, Some(false));
    settled(&mut window);
    assert_eq!(session(&window).playhead.frame(), 2);
    let from = last_pin(&window);
    drag(&mut window, [from, from + egui::vec2(-60.0, 30.0)]);
    settled(&mut window);
    assert_eq!(pins(&window)[2], [1.0, 2.0], "it was keyed");
    press(&mut window, Modifiers::NONE, Key::Space);
    until(&mut window, "it plays", |window| session(window).playhead.frame() != 2);
    press(&mut window, Modifiers::NONE, Key::Space);
    assert!(window.query_by_label("Play").is_some(), "it is stopped");
    let edited = session(&window).document().text().to_owned();
    let made = changes(&window);
    assert_eq!(made, ["Add pin", "Add pin", "Add pin", "Move pin", "Move pin"]);
    for _ in 0..made.len() {
        press(&mut window, Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(session(&window).document().text(), text, "all is undone to the byte");
    for _ in 0..made.len() {
        press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    }
    assert_eq!(session(&window).document().text(), edited);
    press(&mut window, Modifiers::COMMAND, Key::S);
    assert_eq!(fs::read_to_string(&shot).expect("saved"), edited);
    press(&mut window, Modifiers::NONE, Key::Home);
    press(&mut window, Modifiers::NONE, Key::I);
    press(&mut window, Modifiers::NONE, Key::Period);
    press(&mut window, Modifiers::NONE, Key::O);
    press(&mut window, Modifiers::COMMAND, Key::R);
    until(&mut window, "the render ends", |window| {
        session(window).run().is_some_and(|run| run.state != RunState::Running)
    });
    drop(window);

    let (own, unwarped) = (rendered(&edited, &shot, "library"), rendered(&text, &shot, "unwarped"));
    for (frame, (own, unwarped)) in (1..).zip(own.iter().zip(&unwarped)) {
        let file = folder.path().join(format!("render/frame.{frame:04}.exr"));
        let [seen, own, unwarped] = [&file, own, unwarped].map(|path| read_exr(path).expect("a frame"));
        assert!(seen == own, "frame {frame} has the pixels of the library, bit for bit");
        assert!(seen != unwarped, "frame {frame} is warped");
    }
    assert!(!folder.path().join("render/frame.0003.exr").exists(), "two frames were asked for");
}
