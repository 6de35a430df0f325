//! Wrong parameters and the ways of hosts: a message and a status, never a crash.

use crate::host::api::names::image;
use crate::host::profile::{BARE, BOOK, MLT, RUNNER};
use crate::host::{Frame, Host, Pixels, Set, Which, feed};
use crate::{SIZE, pull, pulled};

#[test]
fn a_pin_without_a_finite_place_is_left_out_and_a_far_one_is_refused_in_words() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    let without = host.render(node, Frame::default()).expect("two good pins");
    host.set(node, "pin3On", 1);
    for bad in [f64::NAN, f64::INFINITY, -1e300, 1e7] {
        for id in ["pin3Rest", "pin3Target"] {
            host.set(node, "pin3Rest", [60.0, 40.0]);
            host.set(node, "pin3Target", [60.0, 40.0]);
            host.set(node, id, [bad, 30.0]);
            let found = host.render(node, Frame::default());
            if bad.is_finite() {
                assert!(found.is_err(), "{id} = {bad}");
                assert!(host.said().iter().any(|said| said.text.contains("pin 3")), "{id} = {bad}: {:?}", host.said());
            } else {
                assert!(found.expect("two good pins") == without, "{id} = {bad}: pin 3 acts");
            }
            host.region(node, [1.0, 1.0]);
            host.interest(node, [0.0, 0.0, 10.0, 10.0]);
            host.is_identity(node);
        }
    }
    host.finish();
}

/// Renders with a parameter at a value.
fn frame_with(host: &mut Host, pixels: &Pixels, id: &str, value: impl Into<Set>) -> Pixels {
    let node = pulled(host, pixels);
    host.set(node, id, value);
    let frame = host.render(node, Frame::default()).unwrap_or_else(|status| panic!("{id}: {status:?}"));
    host.region(node, [1.0, 1.0]);
    host.destroy(node);
    frame
}

#[test]
fn settings_out_of_range_act_as_the_nearest_one_in_range() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    // B-splines need four handles an axis.
    for (id, values) in [
        ("columns", [(i32::MIN, 4), (-1, 4), (0, 4), (1, 4), (3, 4), (5000, 64)]),
        ("rows", [(i32::MIN, 4), (-1, 4), (0, 4), (2, 4), (3, 4), (i32::MAX, 64)]),
        ("basis", [(i32::MIN, 0), (-1, 0), (4, 3), (5, 3), (99, 3), (i32::MAX, 3)]),
        ("shape", [(i32::MIN, 0), (-100, 0), (-5, 0), (-3, 0), (-2, 0), (-1, 0)]),
        ("filter", [(i32::MIN, 0), (-1, 0), (4, 3), (5, 3), (99, 3), (i32::MAX, 3)]),
    ] {
        for (value, kept) in values {
            let [found, expected] = [value, kept].map(|value| frame_with(&mut host, &pixels, id, value));
            assert!(found == expected, "{id} = {value} does not act as {kept}");
        }
    }
    // What is not finite acts as the default.
    for (id, values) in [
        ("smoothness", [(f64::NAN, 1.0), (f64::INFINITY, 1.0), (-1.0, 0.1), (0.0, 0.1), (1e9, 10.0)]),
        ("strength", [(f64::NAN, 1.0), (f64::INFINITY, 1.0), (f64::NEG_INFINITY, 1.0), (1e9, 10.0), (-1e9, -10.0)]),
    ] {
        for (value, kept) in values {
            let [found, expected] = [value, kept].map(|value| frame_with(&mut host, &pixels, id, value));
            assert!(found == expected, "{id} = {value} does not act as {kept}");
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
    let found = host.render(node, Frame::default()).expect("an empty picture is one, too");
    assert!(found.samples.iter().all(|sample| *sample == 0.0));
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
