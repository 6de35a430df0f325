//! Proxies, pixel aspects, hosts that announce another scale than their images have.

use crate::host::api::RectI;
use crate::host::api::names::image;
use crate::host::profile::{ALL, BOOK, MLT};
use crate::host::{Frame, Host, Pixels, Profile, Which, feed};
use crate::{SIZE, pull, pulled};

/// A picture of half the size: the mean of each four pixels.
fn half(pixels: &Pixels) -> Pixels {
    let RectI { x2, y2, .. } = pixels.bounds;
    Pixels::new(RectI { x1: 0, y1: 0, x2: x2 / 2, y2: y2 / 2 }, pixels.channels, |x, y, channel| {
        let near = [(0, 0), (1, 0), (0, 1), (1, 1)];
        near.iter().map(|(dx, dy)| pixels.at(2 * x + dx, 2 * y + dy, channel)).sum::<f32>() / 4.0
    })
}

/// The pulled picture at half the scale, with what the host announces.
fn proxy(profile: &Profile, pixels: &Pixels, announced: [f64; 2]) -> Pixels {
    let mut host = Host::start(profile, Which::PinWarp);
    let node = host.node();
    for clip in [image::SOURCE_CLIP, image::OUTPUT_CLIP] {
        let mut form = feed(Some(pixels.clone()), pixels.bounds, 4);
        form.scale = [0.5, 0.5];
        host.feed_as(node, clip, form);
    }
    pull(&host, node);
    let found = host.render(node, Frame { scale: announced, ..Frame::default() }).expect("it renders");
    host.finish();
    found
}

#[test]
fn a_proxy_is_the_picture_at_half_its_size() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    let whole = host.render(node, Frame::default()).expect("it renders");
    host.finish();
    let [found, expected] = [proxy(&BOOK, &half(&pixels), [0.5, 0.5]), half(&whole)];
    let mean = found.samples.iter().zip(&expected.samples).map(|(a, b)| (a - b).abs()).sum::<f32>()
        / found.samples.len() as f32;
    assert!(mean < 4e-3, "{mean}");
    assert!(found.distance(&half(&pixels)) > 0.2);
}

#[test]
fn the_scale_of_images_is_respected() {
    let pixels = half(&Pixels::scenery(SIZE, 4));
    let honest = proxy(&BOOK, &pixels, [0.5, 0.5]);
    assert!(proxy(&BOOK, &pixels, [1.0, 1.0]) == honest, "Fusion announces one scale and renders at another");
}

#[test]
fn previews_in_mlt_are_proxies_too() {
    let pixels = half(&Pixels::scenery(SIZE, 4));
    let expected = proxy(&BOOK, &pixels, [0.5, 0.5]);
    let distance = proxy(&MLT, &pixels, [0.5, 0.5]).distance(&expected);
    assert!(distance < 1e-5, "{distance}");
}

#[test]
fn all_hosts_show_the_same_picture() {
    let pixels = Pixels::scenery(SIZE, 4);
    let rendered = |profile: &Profile| {
        let mut host = Host::start(profile, Which::PinWarp);
        let node = pulled(&mut host, &pixels);
        let found = host.render(node, Frame::default()).expect("it renders");
        host.finish();
        found
    };
    let expected = rendered(&BOOK);
    for profile in ALL {
        let distance = rendered(profile).distance(&expected);
        assert!(distance < 1e-5, "{} ({:?}): {distance}", profile.name, profile.regions);
    }
}

#[test]
fn wide_pixels_bend_as_square_ones_do() {
    // The same scene in pixels twice as wide as high.
    let pixels = Pixels::scenery(SIZE, 4);
    let [width, height] = SIZE;
    let wide = Pixels::new(RectI { x1: 0, y1: 0, x2: width / 2, y2: height }, 4, |x, y, channel| {
        0.5 * (pixels.at(2 * x, y, channel) + pixels.at(2 * x + 1, y, channel))
    });
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    let square = host.render(node, Frame::default()).expect("it renders");
    for clip in [image::SOURCE_CLIP, image::OUTPUT_CLIP] {
        let mut form = feed(Some(wide.clone()), wide.bounds, 4);
        form.aspect = 2.0;
        host.feed_as(node, clip, form);
    }
    let found = host.render(node, Frame::default()).expect("it renders");
    let mean = |x: i32, y, channel| 0.5 * (square.at(2 * x, y, channel) + square.at(2 * x + 1, y, channel));
    for (x, y) in [(20, 45), (40, 45), (47, 53), (60, 30)] {
        assert!((found.at(x, y, 0) - mean(x, y, 0)).abs() < 0.02, "{x}, {y}");
    }
    host.finish();
}
