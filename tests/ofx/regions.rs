//! Where there is output, what it needs, and when there is nothing to do.

use crate::host::api::RectI;
use crate::host::api::names::image;
use crate::host::profile::BOOK;
use crate::host::{Frame, Host, Pixels, Which, feed};
use crate::{SIZE, pulled};

#[test]
fn identity_warps_are_announced_and_change_nothing() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = host.node();
    host.through(node, &pixels);
    assert!(host.is_identity(node), "no pins");
    assert!(host.render(node, Frame::default()).expect("it renders").distance(&pixels) < 1e-6);
    host.pin(node, 1, [80.0, 45.0], [80.0, 45.0]);
    assert!(host.is_identity(node), "a pin that stays");
    host.set(node, "pin1Target", [90.0, 45.0]);
    assert!(!host.is_identity(node), "a pin that moves");
    host.set(node, "strength", 0.0);
    assert!(host.is_identity(node), "no strength");
    host.set(node, "strength", 1.0);
    host.set(node, "pin1On", 0);
    assert!(host.is_identity(node), "a pin that is off");
    host.finish();
}

#[test]
fn keys_make_frames_differ() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    host.key(node, "pin1Target", 0.0, [80.0, 45.0]);
    host.key(node, "pin1Target", 10.0, [100.0, 45.0]);
    let at = |time| host.render(node, Frame { time, ..Frame::default() }).expect("it renders");
    assert!(at(0.0).distance(&pixels) < 1e-5);
    assert!(at(5.0).distance(&at(10.0)) > 0.1);
    assert!((at(5.0).at(89, 44, 0) - pixels.at(79, 44, 0)).abs() < 0.02);
    host.finish();
}

#[test]
fn the_region_grows_with_the_picture() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = host.node();
    host.through(node, &pixels);
    let [width, height] = SIZE.map(f64::from);
    let covers = |region: [f64; 4]| region[0] <= 0.0 && region[1] <= 0.0 && region[2] >= width && region[3] >= height;
    host.set(node, "holdBorder", 0);
    host.pin(node, 1, [80.0, 45.0], [140.0, 45.0]);
    let free = host.region(node, [1.0, 1.0]).expect("it has its own");
    assert!(free[2] > width + 30.0, "all is moved to the right, and not cut there: {free:?}");
    assert_eq!(free, host.region(node, [0.5, 0.5]).expect("it has its own"), "regions do not depend on the scale");
    // And what is there can be rendered.
    let bounds = RectI { x1: free[0] as i32, y1: free[1] as i32, x2: free[2] as i32, y2: free[3] as i32 };
    host.feed_as(node, image::OUTPUT_CLIP, feed(None, bounds, 4));
    let moved = host.render(node, Frame::default()).expect("it renders");
    assert!((moved.at(140, 44, 3) - 1.0).abs() < 0.05);
    host.set(node, "holdBorder", 1);
    let held = host.region(node, [1.0, 1.0]).expect("the plugin answers");
    assert!(covers(held), "{held:?}");
    host.finish();
}

#[test]
fn the_region_of_a_shape_from_alpha_grows_only_where_the_picture_goes() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = host.node();
    host.through(node, &Pixels::scenery(SIZE, 4));
    host.set(node, "shape", 1);
    host.pin(node, 1, [80.0, 45.0], [110.0, 35.0]);
    let [width, height] = SIZE.map(f64::from);
    let region = host.region(node, [1.0, 1.0]).expect("it has its own");
    // The picture goes 30 pixels to the right and 10 down; a filter reaches three pixels further.
    assert_eq!([region[0], region[3]], [0.0, height], "{region:?}");
    assert!((width + 30.0..=width + 34.0).contains(&region[2]), "{region:?}");
    assert!((-14.0..=-10.0).contains(&region[1]), "{region:?}");
    host.finish();
}

#[test]
fn what_is_needed_holds_where_pixels_come_from() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    let needed = host.interest(node, [95.0, 53.0, 97.0, 55.0]).expect("it asks");
    assert!(needed[0] <= 79.0 && needed[2] >= 81.0, "{needed:?} misses (80, 45)");
    assert!(needed[1] <= 44.0 && needed[3] >= 46.0, "{needed:?} misses (80, 45)");
    host.finish();
}
