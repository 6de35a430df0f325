//! Shot files: what is written solves to the same lattices; what stands there already stays.

use super::shots::{SIZE, legs};
use super::support::{HD, eight_pins};
use crate::internal::numbers::distance;
use pinwarp::live::{
    Controls, LiveError, NewShot, OwnPins, Pin, PinTrack, ShapeSource, ShotShape, Subject, TrackKey, WriteShot,
    read_shot, warp, write_shot,
};
use pinwarp::pipeline::PreparedShot;
use pinwarp::shot::{Ease, Shot};
use pinwarp::space::FrameSize;
use std::path::Path;

/// Tracks of pins that go from rest at frame 1 to where the controls have them at frame 9.
fn tracks(controls: &Controls) -> Vec<PinTrack> {
    let key = |frame: f64, pin: &Pin, share: f64| TrackKey {
        frame,
        target: pin.rest + pinwarp::space::ScreenVector((pin.target - pin.rest).0 * share),
        rotation: pin.rotation.map(|angle| angle * share),
        scale: pin.scale.map(|scale| scale.powf(share)),
        ease: Ease::Linear,
    };
    let named = controls.pins.iter().enumerate();
    named
        .map(|(k, pin)| PinTrack {
            name: format!("pin{}", k + 1),
            rest: pin.rest,
            keys: vec![key(1.0, pin, 0.0), key(9.0, pin, 1.0)],
            region: None,
        })
        .collect()
}

/// Handles of the first layer at a frame, as the program solves them.
fn solved(path: &Path, frame: i32) -> Vec<[f64; 2]> {
    let prepared = PreparedShot::new(Shot::read(path).expect("a good shot")).expect("fits");
    let moment = prepared.mid_exposure(frame).expect("solves");
    moment.layers[0].solution.as_ref().expect("pins act").lattice.handles.clone()
}

/// Targets that were read are sums of a place and an offset, which are rounded: the lattices are close, not the same.
fn assert_close(a: &[[f64; 2]], b: &[[f64; 2]], tolerance: f64) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert!(distance(*a, *b) < tolerance, "{a:?} {b:?}");
    }
}

fn new_shot(size: FrameSize) -> NewShot<'static> {
    NewShot { subject: Subject::Plate(Path::new("plate.####.exr")), frames: [1, 12], rate: 24.0, size }
}

#[test]
fn a_new_file_solves_to_the_same_lattice() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("new.toml");
    let mut controls = Controls { smoothness: 2.0, strength: 0.75, dims: [11, 9], ..eight_pins() };
    controls.pins[1].rotation = Some(-0.4);
    controls.pins[5].scale = Some(1.2);
    let tracks = tracks(&controls);
    let job = WriteShot {
        path: &path,
        base: None,
        controls: &controls,
        tracks: &tracks,
        layer: None,
        filter: None,
        pin_frame: 1,
        new: new_shot(HD),
    };
    write_shot(&job).expect("written");
    let text = std::fs::read_to_string(&path).expect("there");
    write_shot(&job).expect("written again");
    assert_eq!(text, std::fs::read_to_string(&path).expect("there"), "the same is written again");
    let live = warp(&controls, &ShapeSource::Frame, HD).expect("solves");
    let live = &live.lattice.as_ref().expect("a lattice").handles;
    assert_eq!(&solved(&path, 9), live);

    let shape = ShotShape { path, camera: None, layer: None, frame: 9.0, pin_frame: 1, own_pins: OwnPins::LeftOut };
    let read = read_shot(&shape, HD).expect("read");
    assert_eq!((read.controls.dims, read.frames, read.warnings.len()), ([11, 9], [1, 12], 0), "{:?}", read.warnings);
    for (read, track) in read.tracks.iter().zip(&tracks) {
        assert!((read.rest.0 - track.rest.0).length() < 1e-12 && read.keys.len() == 2);
        assert!((read.keys[1].target.0 - track.keys[1].target.0).length() < 1e-12);
    }
    let again = warp(&read.controls, &ShapeSource::Shot(shape), HD).expect("solves");
    assert_close(&again.lattice.as_ref().expect("a lattice").handles, live, 1e-12);
}

#[test]
fn a_file_that_is_there_keeps_what_it_says() {
    let folder = tempfile::tempdir().expect("a folder");
    let source = legs(7.0).path;
    let scene = source.with_file_name("walker.glb");
    std::fs::copy(&scene, folder.path().join("walker.glb")).expect("copied");
    let [base, path] = ["shot.toml", "bent.toml"].map(|name| folder.path().join(name));
    // Fewer frames than the scene's own are solved together.
    let text = std::fs::read_to_string(&source).expect("there");
    assert!(text.contains("last = 48"), "{text}");
    std::fs::write(&base, text.replace("last = 48", "last = 12")).expect("written");
    let before = solved(&base, 7);

    let shape = ShotShape { path: base.clone(), ..legs(7.0) };
    let read = read_shot(&shape, SIZE).expect("read");
    let mut job = WriteShot {
        path: &path,
        base: Some(&base),
        controls: &read.controls,
        tracks: &read.tracks,
        layer: Some("legs"),
        filter: None,
        pin_frame: 1,
        new: new_shot(SIZE),
    };
    write_shot(&job).expect("written");
    // An iteration over all frames goes a little another way.
    assert_close(&solved(&path, 7), &before, 1e-9);
    let text = std::fs::read_to_string(&path).expect("there");
    for comment in ["# A gnome strolls", "# the meadow is not claimed", "# smears are drawn on twos"] {
        assert!(text.contains(comment), "{comment} is lost:\n{text}");
    }
    assert!(text.contains("triangle = 1788"), "anchors stay on their triangles:\n{text}");

    job.tracks = &read.tracks[1..];
    let fault = write_shot(&job).expect_err("a pin would act beside the new ones");
    assert!(matches!(&fault, LiveError::Layer { what, .. } if what.contains("'near heel'")), "{fault}");
    assert_eq!(text, std::fs::read_to_string(&path).expect("there"), "nothing was written");

    let original = std::fs::read_to_string(&base).expect("there");
    for path in [base.clone(), source] {
        let fault = write_shot(&WriteShot { path: &path, tracks: &read.tracks, ..job }).expect_err("the wrong place");
        assert!(fault.to_string().contains("in the folder of"), "{fault}");
    }
    assert_eq!(original, std::fs::read_to_string(&base).expect("there"), "what is read is never written");
}
