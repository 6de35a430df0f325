//! Wrong parameters and the ways of hosts: a message and a status, never a crash.

use crate::host::api::names::image;
use crate::host::profile::{BARE, BOOK, MLT, RUNNER};
use crate::host::{Frame, Host, Pixels, Which, feed};
use crate::{SIZE, pull, pulled};

#[test]
fn non_finite_numbers_are_ignored() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    host.set(node, "pin3On", 1);
    for bad in [f64::NAN, f64::INFINITY, -1e300, 1e7] {
        for id in ["pin3Rest", "pin3Target"] {
            host.set(node, "pin3Rest", [60.0, 40.0]);
            host.set(node, "pin3Target", [60.0, 40.0]);
            host.set(node, id, [bad, 30.0]);
            if let Err(status) = host.render(node, Frame::default()) {
                assert!(!host.said().is_empty(), "{id} = {bad}: {status:?} without a word");
            }
            host.region(node, [1.0, 1.0]);
            host.interest(node, [0.0, 0.0, 10.0, 10.0]);
            host.is_identity(node);
        }
    }
    host.finish();
}

#[test]
fn settings_out_of_range_are_brought_back_or_refused_in_words() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let try_out = |host: &Host, node, what: &str| {
        if let Err(status) = host.render(node, Frame::default()) {
            assert!(!host.said().is_empty(), "{what}: {status:?} without a word");
        }
        host.region(node, [1.0, 1.0]);
    };
    for (id, values) in [
        ("columns", [i32::MIN, -1, 0, 1]),
        ("rows", [2, 3, 64, 5000]),
        ("basis", [-1, 3, 4, i32::MAX]),
        ("shape", [-5, 1, 0, 0]),
        ("filter", [-1, 3, 4, 99]),
    ] {
        for value in values {
            let node = pulled(&mut host, &pixels);
            host.set(node, id, value);
            try_out(&host, node, &format!("{id} = {value}"));
            host.destroy(node);
        }
    }
    for (id, values) in [("smoothness", [f64::NAN, -1.0, 0.0, 1e9]), ("strength", [f64::NAN, f64::INFINITY, 1e9, -1.0])]
    {
        for value in values {
            let node = pulled(&mut host, &pixels);
            host.set(node, id, value);
            try_out(&host, node, &format!("{id} = {value}"));
            host.destroy(node);
        }
    }
    host.finish();
}

#[test]
fn a_missing_shot_is_reported_once_and_forgotten_when_restored() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    host.set(node, "shape", 2);
    assert!(host.render(node, Frame::default()).is_err(), "a shot without a name");
    assert_eq!(host.said().len(), 1, "{:?}", host.said());
    host.set(node, "shotFile", "/nowhere/100% gone.toml");
    for _ in 0..3 {
        assert!(host.render(node, Frame::default()).is_err());
    }
    let said = host.said();
    assert!(said.iter().any(|said| said.text.contains("/nowhere/100% gone.toml")), "{said:?}");
    assert!(said.len() <= 2, "the same words come once: {said:?}");
    host.set(node, "shape", 0);
    assert!(host.render(node, Frame::default()).is_ok());
    assert!(host.said().is_empty(), "what was mended is not an error any more");
    host.finish();
}

#[test]
fn hosts_without_messages_get_a_status() {
    for profile in [&BARE, &RUNNER] {
        let mut host = Host::start(profile, Which::PinWarp);
        let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
        host.set(node, "shape", 2);
        assert!(host.render(node, Frame::default()).is_err());
        host.finish();
    }
}

#[test]
fn clips_without_an_image_are_transparent() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    host.feed_as(node, image::SOURCE_CLIP, feed(None, pixels.bounds, 4));
    match host.render(node, Frame::default()) {
        Ok(found) => assert!(found.samples.iter().all(|sample| *sample == 0.0)),
        Err(status) => assert!(!host.said().is_empty(), "{status:?} without a word"),
    }
    host.finish();
}

#[test]
fn an_stmap_in_bytes_is_refused_in_words() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::StMap);
    let node = host.node();
    for clip in [image::SOURCE_CLIP, image::OUTPUT_CLIP] {
        let form = feed(Some(pixels.clone()), pixels.bounds, 4).with_depth(crate::host::Depth::Byte);
        host.feed_as(node, clip, form);
    }
    pull(&host, node);
    assert!(host.render(node, Frame::default()).is_err());
    assert!(host.said()[0].text.contains("float"), "{:?}", host.said());
    host.finish();
}

#[test]
fn new_instances_for_every_frame_give_the_same_frames() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&MLT, Which::PinWarp);
    let mut first = None;
    for _ in 0..12 {
        // MLT loads and describes anew for every frame, too.
        host.load_again();
        let node = pulled(&mut host, &pixels);
        let frame = host.render(node, Frame::default()).expect("it renders");
        assert!(first.get_or_insert_with(|| frame.clone()) == &frame);
        host.destroy(node);
    }
    host.finish();
}
