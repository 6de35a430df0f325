//! Mix, matte, motion blur; weight and neighbourhood of pins.

use crate::host::api::names::{action, image};
use crate::host::api::{RectI, Status};
use crate::host::profile::BOOK;
use crate::host::{Frame, Host, Pixels, Which, feed};
use crate::{SIZE, pulled};

/// A matte that is white to the right of a column.
fn matte(column: i32) -> Pixels {
    let bounds = RectI { x1: 0, y1: 0, x2: SIZE[0], y2: SIZE[1] };
    Pixels::new(bounds, 1, |x, _, _| if x >= column { 1.0 } else { 0.0 })
}

#[test]
fn a_mix_goes_from_the_source_to_the_warp() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    let whole = host.render(node, Frame::default()).expect("it renders");
    host.set(node, "mix", 0.5);
    let half = host.render(node, Frame::default()).expect("it renders");
    let mean = |x, y, channel| 0.5 * (pixels.at(x, y, channel) + whole.at(x, y, channel));
    let expected = Pixels::new(pixels.bounds, 4, mean);
    assert!(half.distance(&expected) < 1e-5 && half.distance(&whole) > 0.1);
    host.set(node, "mix", 0.0);
    assert!(host.is_identity(node));
    assert!(host.render(node, Frame::default()).expect("it renders").distance(&pixels) < 1e-6);
    host.finish();
}

#[test]
fn a_matte_shows_the_warp_where_it_is_white() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    let whole = host.render(node, Frame::default()).expect("it renders");
    host.feed(node, c"Matte", Some(&matte(90)));
    for straight in [false, true] {
        for clip in [image::SOURCE_CLIP, image::OUTPUT_CLIP] {
            let mut form = feed(Some(pixels.clone()), pixels.bounds, 4);
            form.premultiplication = if straight { image::UNPREMULTIPLIED } else { image::PREMULTIPLIED };
            host.feed_as(node, clip, form);
        }
        let found = host.render(node, Frame::default()).expect("it renders");
        for (x, y) in [(20, 40), (89, 44), (60, 60)] {
            assert_eq!(found.at(x, y, 0), pixels.at(x, y, 0), "left of the matte's edge the source shows: {x}, {y}");
        }
        if !straight {
            for (x, y) in [(90, 44), (96, 50), (140, 60)] {
                assert_eq!(found.at(x, y, 0), whole.at(x, y, 0), "right of it the warp: {x}, {y}");
            }
        }
    }
    let needed = host.interest(node, [0.0, 0.0, 20.0, 20.0]).expect("it asks");
    assert!(needed[0] <= 0.0 && needed[2] >= 20.0, "{needed:?}");
    host.finish();
}

#[test]
fn motion_blur_is_the_mean_over_the_shutter() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    host.key(node, "pin1Target", 0.0, [80.0, 45.0]);
    host.key(node, "pin1Target", 10.0, [120.0, 45.0]);
    let at = |host: &Host, time| host.render(node, Frame { time, ..Frame::default() }).expect("it renders");
    let sharp = at(&host, 5.0);
    // The shutter is open for a frame, from the frame on, in two samples: a quarter and three quarters into it.
    let ends = [5.25, 5.75].map(|time| at(&host, time));
    for (id, value) in [("shutter", 360.0), ("shutterPhase", 0.0)] {
        host.set(node, id, value);
    }
    host.set(node, "blurSamples", 2);
    let blurred = at(&host, 5.0);
    let expected = Pixels::new(pixels.bounds, 4, |x, y, c| 0.5 * (ends[0].at(x, y, c) + ends[1].at(x, y, c)));
    let distance = blurred.distance(&expected);
    assert!(distance < 1e-5 && blurred.distance(&sharp) > 0.01, "{distance}");
    // Where nothing moves there is no blur, to the bit.
    host.set(node, "blurSamples", 1);
    let still = at(&host, 20.0);
    host.set(node, "blurSamples", 16);
    assert!(at(&host, 20.0) == still);
    host.finish();
}

#[test]
fn straight_colour_is_blurred_by_its_alpha() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let bounds = RectI { x1: 0, y1: 0, x2: SIZE[0], y2: SIZE[1] };
    // A white disc; the colour that its alpha hides is black.
    let disc = |x: i32, y: i32| f64::from((x - 80).pow(2) + (y - 45).pow(2)).sqrt() < 15.0;
    let pixels = Pixels::new(bounds, 4, |x, y, _| if disc(x, y) { 1.0 } else { 0.0 });
    let node = host.node();
    for clip in [image::SOURCE_CLIP, image::OUTPUT_CLIP] {
        let mut form = feed(Some(pixels.clone()), bounds, 4);
        form.premultiplication = image::UNPREMULTIPLIED;
        host.feed_as(node, clip, form);
    }
    host.pin(node, 1, [80.0, 45.0], [80.0, 45.0]);
    host.key(node, "pin1Target", 0.0, [60.0, 45.0]);
    host.key(node, "pin1Target", 2.0, [100.0, 45.0]);
    host.set(node, "blurSamples", 8);
    let found = host.render(node, Frame { time: 1.0, ..Frame::default() }).expect("it renders");
    let soft: Vec<[f32; 2]> = (0..SIZE[0]).map(|x| [found.at(x, 45, 0), found.at(x, 45, 3)]).collect();
    let half = soft.iter().filter(|[_, alpha]| (0.2..0.8).contains(alpha));
    assert!(half.clone().count() > 4 && half.clone().all(|[white, _]| *white > 0.9), "{soft:?}");
    host.finish();
}

#[test]
fn a_host_is_asked_within_solves_and_may_give_up() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let solve = |host: &mut Host| {
        let node = host.node();
        host.through(node, &pixels);
        for (id, value) in [("basis", 1), ("columns", 14), ("rows", 12)] {
            host.set(node, id, value);
        }
        for pin in 0..12_usize {
            let rest = [10.0 + 12.0 * pin as f64, 20.0 + 4.0 * pin as f64];
            let away = [7.0, -5.0, 3.0][pin % 3];
            host.pin(node, pin + 1, rest, [rest[0] + away, rest[1] + 2.0 * away]);
        }
        node
    };
    let node = solve(&mut host);
    host.abort_at(Some(3));
    let given_up = host.try_render(node, Frame::default());
    let asked = host.abort_at(None);
    assert!(given_up == Status::OK && asked <= 6, "{given_up:?} after {asked} questions");
    let found = host.render(node, Frame::default()).expect("it renders");
    let asked = host.abort_at(None);
    assert!(asked >= 8, "asked {asked} times only: not within the solve");
    // What was given up left nothing behind: the frame is that of a host that never did.
    assert_eq!(host.ask((action::PURGE_CACHES, "PurgeCaches"), node.0, Vec::new()).0, Status::OK);
    assert!(host.render(node, Frame::default()).expect("it renders") == found);
    host.finish();
}

#[test]
fn weights_and_neighbourhoods_of_pins_act() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    let plain = host.render(node, Frame::default()).expect("it renders");
    // Without a radius there is nothing to be rigid or stiff.
    host.set(node, "pin1Stiffness", 5.0);
    host.set(node, "pin1Rigidity", 0.5);
    assert!(host.render(node, Frame::default()).expect("it renders") == plain);
    host.set(node, "pin1Radius", 25.0);
    let along = host.render(node, Frame::default()).expect("it renders");
    assert!(along.distance(&plain) > 0.01, "what lies around the pin goes along");
    host.set(node, "pin1Radius", 0.0);
    host.set(node, "pin1Weight", 0.0);
    let free = host.render(node, Frame::default()).expect("it renders");
    assert!(free.distance(&pixels) < 0.1 && free.distance(&plain) > 0.1, "a pin without weight pulls nothing");
    assert!(host.heard().is_empty(), "and is not said to miss: {:?}", host.heard());
    host.finish();
}
