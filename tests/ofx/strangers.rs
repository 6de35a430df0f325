//! Ways of hosts that others wrote: openfx-runner, pyofx, Natron.

use crate::host::api::Status;
use crate::host::api::names::{action, image};
use crate::host::profile::{BOOK, NATRON, PYOFX, RUNNER, Regions};
use crate::host::{Frame, Host, Pixels, Profile, Which, feed};
use crate::{SIZE, pulled};

#[test]
fn openfx_runner_is_not_asked_for_keys() {
    let folder = tempfile::tempdir().expect("a folder for files");
    let mut host = Host::start(&RUNNER, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    // A pin in the corner might have keys: that it was never placed is seen without asking.
    host.set(node, "pin3On", 1);
    assert_eq!(host.press(node, "pin3On"), Status::OK);
    assert_eq!(host.point(node, "pin3Rest", 0.0), [80.0, 45.0], "it comes to the middle");
    host.set(node, "pin4On", 1);
    host.render(node, Frame::default()).expect("it renders");
    host.set(node, "writePath", folder.path().join("pins.toml").to_str().expect("plain letters"));
    assert_eq!(host.press(node, "writeShot"), Status::OK);
    host.finish();
}

#[test]
fn pyofx_gets_the_picture_of_other_hosts() {
    let pixels = Pixels::scenery(SIZE, 4);
    let [expected, found] = [&BOOK, &PYOFX].map(|profile| {
        let mut host = Host::start(profile, Which::PinWarp);
        let node = pulled(&mut host, &pixels);
        let found = host.render(node, Frame::default()).expect("it renders");
        host.finish();
        found
    });
    assert!(found == expected && found.distance(&pixels) > 0.2);
}

#[test]
fn straight_colour_is_known_by_the_name_that_pyofx_gives_it() {
    let pixels = Pixels::scenery(SIZE, 4);
    let rendered = |kind| {
        let mut host = Host::start(&PYOFX, Which::PinWarp);
        let node = pulled(&mut host, &pixels);
        for clip in [image::SOURCE_CLIP, image::OUTPUT_CLIP] {
            let mut form = feed(Some(pixels.clone()), pixels.bounds, 4);
            form.premultiplication = kind;
            host.feed_as(node, clip, form);
        }
        let found = host.render(node, Frame::default()).expect("it renders");
        host.finish();
        found
    };
    let straight = rendered(image::UNPREMULTIPLIED);
    assert!(rendered(c"OfxImageUnPreMultiplied") == straight && straight != rendered(image::PREMULTIPLIED));
}

#[test]
fn an_endless_source_has_an_endless_region_and_a_finite_need() {
    let pixels = Pixels::scenery(SIZE, 4);
    let endless = Profile { regions: Regions::Endless, ..NATRON };
    let without_project = &[image::PROJECT_SIZE, image::PROJECT_EXTENT, image::PROJECT_OFFSET];
    for profile in [endless.clone(), Profile { refuses: without_project, ..endless }] {
        let mut host = Host::start(&profile, Which::PinWarp);
        let node = pulled(&mut host, &pixels);
        let [from, to] = [i32::MIN, i32::MAX].map(f64::from);
        for shape in [0, 1] {
            host.set(node, "shape", shape);
            assert_eq!(host.region(node, [1.0, 1.0]), Some([from, from, to, to]), "shape {shape}");
            let needed = host.interest(node, [0.0, 0.0, 160.0, 90.0]).expect("it asks");
            assert!(needed.iter().all(|side| side.abs() < 1e5), "shape {shape}: {needed:?}");
        }
        host.set(node, "shape", 0);
        let found = host.render(node, Frame::default()).expect("it renders");
        assert!((found.at(95, 53, 0) - pixels.at(79, 44, 0)).abs() < 0.02);
        host.finish();
    }
}

#[test]
fn a_frame_is_the_same_after_the_caches_were_emptied() {
    let mut host = Host::start(&NATRON, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    let before = host.render(node, Frame::default()).expect("it renders");
    for (name, short) in [(action::PURGE_CACHES, "PurgeCaches"), (action::SYNC_PRIVATE_DATA, "SyncPrivateData")] {
        assert_eq!(host.ask((name, short), node.0, Vec::new()).0, Status::OK, "{short}");
    }
    assert!(host.render(node, Frame::default()).expect("it renders") == before);
    host.finish();
}
