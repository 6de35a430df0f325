//! Pixels: every depth, components and row order; tiles; fields; threads; giving up.

use crate::host::api::RectI;
use crate::host::api::names::image;
use crate::host::profile::BOOK;
use crate::host::{Depth, Frame, Host, Pixels, Profile, Rows, Which, feed};
use crate::{SIZE, pull, pulled};

/// The pulled picture, rendered whole from floats.
fn rendered(profile: &Profile, pixels: &Pixels) -> Pixels {
    let mut host = Host::start(profile, Which::PinWarp);
    let node = pulled(&mut host, pixels);
    let result = host.render(node, Frame::default()).expect("it renders");
    host.finish();
    result
}

#[test]
fn pins_move_the_picture() {
    let pixels = Pixels::scenery(SIZE, 4);
    let moved = rendered(&BOOK, &pixels);
    // What was under the first pin is now under its target, what is under the second stays.
    for channel in 0..4 {
        assert!((moved.at(95, 53, channel) - pixels.at(79, 44, channel)).abs() < 0.02, "channel {channel}");
        assert!((moved.at(40, 45, channel) - pixels.at(40, 45, channel)).abs() < 0.02, "channel {channel}");
    }
    assert!(moved.distance(&pixels) > 0.2);
}

#[test]
fn every_depth_gives_the_same_picture_within_its_steps() {
    for channels in [4, 3, 1] {
        let pixels = Pixels::scenery(SIZE, channels);
        let expected = rendered(&BOOK, &pixels);
        for depth in Depth::ALL {
            let mut host = Host::start(&BOOK, Which::PinWarp);
            let node = host.node();
            for clip in [image::SOURCE_CLIP, image::OUTPUT_CLIP] {
                host.feed_as(node, clip, feed(Some(pixels.clone()), pixels.bounds, channels).with_depth(depth));
            }
            pull(&host, node);
            let found = host.render(node, Frame::default()).expect("it renders");
            let mut expected = expected.clone();
            if matches!(depth, Depth::Byte | Depth::Short) {
                // Integers end where the filter rings beyond white and black.
                expected.samples.iter_mut().for_each(|sample| *sample = sample.clamp(0.0, 1.0));
            }
            let distance = found.distance(&expected);
            assert!(distance <= 2.0 * depth.step(), "{channels} channels, {depth:?}: {distance} off");
            host.finish();
        }
    }
}

#[test]
fn the_order_of_rows_does_not_matter() {
    for channels in [4, 1] {
        let pixels = Pixels::scenery(SIZE, channels);
        let expected = rendered(&BOOK, &pixels);
        for rows in [Rows::Up, Rows::Down] {
            assert!(rendered(&Profile { rows, ..BOOK }, &pixels) == expected, "{rows:?}");
        }
    }
}

#[test]
fn tiles_are_parts_of_the_whole_also_where_the_source_holds_only_what_was_asked_for() {
    let pixels = Pixels::scenery(SIZE, 4);
    let whole = rendered(&BOOK, &pixels);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    let [width, height] = SIZE;
    let tiles = [[0, 0, 61, 37], [61, 0, width, 37], [0, 37, 61, height], [61, 37, width, height], [77, 40, 78, 41]];
    for [x1, y1, x2, y2] in tiles {
        let tile = RectI { x1, y1, x2, y2 };
        let expected = Pixels::new(tile, 4, |x, y, channel| whole.at(x, y, channel));
        host.feed_as(node, image::OUTPUT_CLIP, feed(None, tile, 4));
        assert!(host.render(node, Frame::default()).expect("it renders") == expected, "{tile:?}");
        // Only what the plugin asks for, as hosts with tiles give it.
        let [left, low, right, high] = host.interest(node, [x1, y1, x2, y2].map(f64::from)).expect("it asks");
        let part = RectI {
            x1: (left.floor() as i32).clamp(0, width - 1),
            y1: (low.floor() as i32).clamp(0, height - 1),
            x2: (right.ceil() as i32).clamp(1, width),
            y2: (high.ceil() as i32).clamp(1, height),
        };
        host.crop(node, image::SOURCE_CLIP, part);
        assert!(host.render(node, Frame::default()).expect("it renders") == expected, "{tile:?} of {part:?}");
        host.through(node, &pixels);
    }
    host.finish();
}

#[test]
fn only_the_window_is_written() {
    let pixels = Pixels::scenery(SIZE, 4);
    let whole = rendered(&BOOK, &pixels);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    let window = RectI { x1: 20, y1: 10, x2: 70, y2: 30 };
    let part = host.render(node, Frame { window: Some(window), ..Frame::default() }).expect("it renders");
    assert_eq!(part.at(20, 10, 0), whole.at(20, 10, 0));
    assert_eq!(part.at(69, 29, 1), whole.at(69, 29, 1));
    for (x, y) in [(19, 10), (20, 9), (70, 29), (69, 30), (0, 0), (159, 89)] {
        let untouched = f32::from_ne_bytes([0xA5; 4]);
        assert_eq!(part.at(x, y, 0), untouched, "{x}, {y} lies outside the window");
    }
    host.finish();
}

#[test]
fn straight_alpha_is_multiplied_and_divided_again() {
    let pixels = Pixels::scenery(SIZE, 4);
    let expected = rendered(&BOOK, &pixels);
    let divided = |pixels: &Pixels| {
        Pixels::new(pixels.bounds, 4, |x, y, channel| {
            let (value, alpha) = (pixels.at(x, y, channel), pixels.at(x, y, 3));
            if channel < 3 && alpha > 0.0 { value / alpha } else { value }
        })
    };
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = host.node();
    let straight = divided(&pixels);
    for clip in [image::SOURCE_CLIP, image::OUTPUT_CLIP] {
        let mut form = feed(Some(straight.clone()), straight.bounds, 4);
        form.premultiplication = image::UNPREMULTIPLIED;
        host.feed_as(node, clip, form);
    }
    pull(&host, node);
    let found = host.render(node, Frame::default()).expect("it renders");
    let expected = divided(&expected);
    let solid =
        (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))).filter(|(x, y)| expected.at(*x, *y, 3) > 0.05);
    for (x, y) in solid {
        for channel in 0..4 {
            let [found, expected] = [&found, &expected].map(|pixels| pixels.at(x, y, channel));
            assert!((found - expected).abs() < 2e-4, "{x}, {y}, {channel}: {found}, not {expected}");
        }
    }
    host.finish();
}

#[test]
fn a_field_is_every_other_row() {
    let pixels = Pixels::scenery(SIZE, 4);
    let whole = rendered(&BOOK, &pixels);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    let lower = host.render(node, Frame { field: image::FIELD_LOWER, ..Frame::default() }).expect("it renders");
    let upper = host.render(node, Frame { field: image::FIELD_UPPER, ..Frame::default() }).expect("it renders");
    for y in 0..SIZE[1] {
        let drawn = if y % 2 == 0 { &lower } else { &upper };
        assert_eq!(drawn.at(80, y, 0), whole.at(80, y, 0), "row {y}");
    }
    let differs = |field: &Pixels, parity: u32| {
        (0..SIZE[1]).any(|y| y as u32 % 2 == parity && (0..SIZE[0]).any(|x| field.at(x, y, 0) != whole.at(x, y, 0)))
    };
    assert!(differs(&lower, 1) && differs(&upper, 0), "rows of the other field are not drawn");
    host.finish();
}

#[test]
fn eight_threads_give_identical_pixels() {
    let pixels = Pixels::scenery(SIZE, 4);
    let expected = rendered(&BOOK, &pixels);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    let renderer = host.renderer();
    std::thread::scope(|scope| {
        for _ in 0..8 {
            let expected = &expected;
            scope.spawn(move || {
                for _ in 0..4 {
                    assert!(renderer.render(node, Frame::default()).expect("it renders") == *expected);
                }
            });
        }
    });
    host.finish();
}

#[test]
fn a_render_that_is_given_up_ends_quietly() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &pixels);
    for question in 1..=3 {
        host.abort_at(Some(question));
        let _any_status_will_do = host.try_render(node, Frame::default());
        assert!(host.abort_at(None) > 0, "nobody asked whether to stop");
        assert!(host.said().is_empty(), "stopping is no news");
    }
    assert!(host.render(node, Frame::default()).is_ok());
    host.finish();
}

#[test]
fn a_mask_selects_what_moves_and_the_background_is_seen_where_it_was() {
    let pixels = Pixels::scenery(SIZE, 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = host.node();
    host.through(node, &pixels);
    host.pin(node, 1, [70.0, 45.0], [105.0, 45.0]);
    let mask = Pixels::new(
        pixels.bounds,
        1,
        |x, y, _| {
            if f64::from(x - 70).hypot(f64::from(y - 45)) < 12.0 { 1.0 } else { 0.0 }
        },
    );
    let blue = Pixels::new(pixels.bounds, 4, |_, _, channel| [0.0, 0.0, 1.0, 1.0][channel]);
    host.feed(node, c"Mask", Some(&mask));
    host.feed(node, c"Background", Some(&blue));
    let found = host.render(node, Frame::default()).expect("it renders");
    let near = |x, y, expected: [f32; 4]| {
        let found = [0, 1, 2, 3].map(|channel| found.at(x, y, channel));
        let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.02);
        assert!(is_near, "{x}, {y}: {found:?}, not {expected:?}");
    };
    let source = |x, y| [0, 1, 2, 3].map(|channel| pixels.at(x, y, channel));
    near(40, 45, source(40, 45));
    near(104, 44, source(69, 44));
    near(66, 45, [0.0, 0.0, 1.0, 1.0]);
    host.finish();
}
