//! Shapes from shot files: lattices follow the model, pins stick to it, the shot's own pins act.

use pinwarp::live::{Controls, LiveError, OwnPins, Pin, ShapeSource, ShotShape, Warning, warp};
use pinwarp::pipeline::PreparedShot;
use pinwarp::shot::Shot;
use pinwarp::space::{FrameSize, ScreenPoint};
use std::path::PathBuf;

/// The walker's legs, on twos, pinned by name.
pub(crate) fn legs(frame: f64) -> ShotShape {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenes/walker/shot.toml");
    ShotShape { path, camera: None, layer: Some("legs".into()), frame, pin_frame: 1, own_pins: OwnPins::Act }
}

pub(crate) const SIZE: FrameSize = FrameSize::new(1280, 720);

#[test]
fn a_shots_own_pins_act_as_in_the_program() {
    let shape = legs(7.0);
    let mut shot = Shot::read(&shape.path).expect("a good shot");
    // A host solves each frame alone.
    shot.layers.iter_mut().for_each(|layer| layer.settings.temporal = 0.0);
    let prepared = PreparedShot::new(shot).expect("fits");
    let cold = prepared.mid_exposure(7).expect("solves");
    let cold = &cold.layers[0].solution.as_ref().expect("pins act").lattice;
    let controls = Controls { dims: [10, 8], ..Controls::default() };
    let live = warp(&controls, &ShapeSource::Shot(shape.clone()), SIZE).expect("solves");
    let live = live.lattice.as_ref().expect("a lattice");
    assert_eq!((&cold.grid, &cold.handles), (&live.grid, &live.handles));
    let without = ShotShape { own_pins: OwnPins::LeftOut, ..shape };
    assert!(warp(&controls, &ShapeSource::Shot(without), SIZE).expect("solves").is_identity());
}

#[test]
fn a_pin_follows_the_animated_surface() {
    let prepared = PreparedShot::new(Shot::read(&legs(1.0).path).expect("a good shot")).expect("fits");
    // A point of the near toe, as the camera sees it in frame 1.
    let rests = prepared.rests_of(0, 1.0);
    let seen = prepared.cast(1, &rests.iter().map(|rest| rest.point).collect::<Vec<_>>());
    let on_legs = |cast: &Option<pinwarp::pipeline::PinAnchor>| cast.is_some();
    let index = seen.iter().position(on_legs).expect("a pin that can be seen");
    let rest = rests[index].point;
    let pin = Pin::new(rest, ScreenPoint::new(rest.0.x + 0.03, rest.0.y + 0.01));
    let controls = Controls { dims: [10, 8], pins: vec![pin], ..Controls::default() };
    let at = |frame: f64| {
        let shape = ShotShape { own_pins: OwnPins::LeftOut, ..legs(frame) };
        warp(&controls, &ShapeSource::Shot(shape), SIZE).expect("solves")
    };
    let mut places = Vec::new();
    for frame in [1.0, 9.0, 20.5, 33.0] {
        let warp = at(frame);
        let place = warp.pins[0];
        let off = (place.moved.0 - place.rest.0 - (pin.target.0 - pin.rest.0)).length();
        assert!(off * 720.0 < 0.05 && place.presence == 1.0, "frame {frame}: {place:?}");
        assert!(warp.warnings.is_empty(), "{:?}", warp.warnings);
        places.push(place.rest.0);
    }
    assert!((places[0] - rest.0).length() < 1e-5, "it begins where it was placed");
    assert!(places.windows(2).all(|pair| (pair[0] - pair[1]).length() > 0.01), "it walks: {places:?}");
    let lattices = [at(1.0), at(33.0)].map(|warp| warp.lattice.as_ref().expect("a lattice").grid.lo);
    assert!((lattices[0][0] - lattices[1][0]).abs() > 0.01, "the lattice walks, too");
}

#[test]
fn pins_beside_the_model_stay_on_the_screen() {
    let sky = ScreenPoint::new(20.0, 20.0);
    let controls = Controls { dims: [10, 8], pins: vec![Pin::new(sky, sky)], ..Controls::default() };
    let warp = warp(&controls, &ShapeSource::Shot(legs(9.0)), SIZE).expect("solves");
    assert_eq!(warp.pins[0].rest, sky);
    assert_eq!(warp.warnings, [Warning::OffModel { pin: 0, at: sky, frame: 1 }]);
}

/// A triangle whose points lie in a file beside the scene.
const BESIDE: &str = r#"{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
  "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }], "buffers": [{ "byteLength": 36, "uri": "points.bin" }],
  "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
  "accessors": [{ "bufferView": 0, "type": "VEC3", "componentType": 5126, "count": 3 }] }"#;

#[test]
fn a_buffer_that_is_saved_again_is_read_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let save = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).expect("written");
    let points = |width: f32| [0.0, 0.0, 0.0, width, 0.0, 0.0, 0.0, 1.0, 0.0_f32].map(f32::to_le_bytes).concat();
    save("scene.gltf", BESIDE.as_bytes());
    save("shot.toml", b"version = 1\nscene = \"scene.gltf\"\nframes = { first = 1, last = 1 }\nsize = [1280, 720]\n");
    let shape = ShotShape { path: folder.path().join("shot.toml"), layer: None, ..legs(1.0) };
    let width = || {
        let live = warp(&Controls::default(), &ShapeSource::Shot(shape.clone()), SIZE).expect("solves");
        let grid = &live.lattice.as_ref().expect("a lattice").grid;
        grid.size(0) / grid.size(1)
    };
    save("points.bin", &points(1.0));
    let before = width();
    assert_eq!(before, width());
    // Longer than what is read: its length tells where its time does not.
    save("points.bin", &[points(0.25), vec![0; 4]].concat());
    assert!(width() < 0.6 * before, "{} of {before}", width());
}

#[test]
fn shots_that_do_not_fit_are_refused() {
    let of = |shape: ShotShape, size| warp(&Controls::default(), &ShapeSource::Shot(shape), size).expect_err("a fault");
    assert!(matches!(of(legs(1.0), FrameSize::new(720, 720)), LiveError::Aspect { .. }));
    let missing = of(ShotShape { layer: Some("wings".into()), ..legs(1.0) }, SIZE).to_string();
    assert!(missing.contains("'wings'") && missing.contains("legs, body, head"), "{missing}");
    let camera = of(ShotShape { camera: Some("Shotcam".into()), ..legs(1.0) }, SIZE).to_string();
    assert!(camera.contains("ShotCam"), "{camera}");
    assert!(matches!(of(ShotShape { path: "no.toml".into(), ..legs(1.0) }, SIZE), LiveError::Shot(_)));
}
