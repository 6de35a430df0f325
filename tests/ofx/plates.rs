//! Plates that are larger or smaller than the project, or lie elsewhere.

use crate::host::api::RectI;
use crate::host::api::names::image;
use crate::host::profile::{BOOK, NATRON, NUKE};
use crate::host::{Frame, Host, Node, Pixels, Which, feed};

/// A plate of 160 x 90 pixels whose lower left corner lies at `corner`, in a project of `project` pixels.
fn plate(host: &mut Host, corner: [i32; 2], project: [f64; 2]) -> (Node, Pixels) {
    let [x, y] = corner;
    let scenery = Pixels::scenery([160, 90], 4);
    let bounds = RectI { x1: x, y1: y, x2: x + 160, y2: y + 90 };
    let pixels = Pixels::new(bounds, 4, |px, py, channel| scenery.at(px - x, py - y, channel));
    let node = host.node();
    host.through(node, &pixels);
    host.project(node, project);
    (node, pixels)
}

#[test]
fn a_plate_is_warped_alike_in_every_project() {
    for profile in [&BOOK, &NATRON, &NUKE] {
        let mut reference = None;
        for (corner, project) in [
            ([0, 0], [160.0, 90.0]),
            ([0, 0], [100.0, 50.0]),
            ([-30, -20], [100.0, 50.0]),
            ([0, 0], [640.0, 360.0]),
            ([200, 100], [640.0, 360.0]),
            ([700, 400], [640.0, 360.0]),
        ] {
            let mut host = Host::start(profile, Which::PinWarp);
            let (node, _) = plate(&mut host, corner, project);
            let shifted = |at: [f64; 2]| [at[0] + f64::from(corner[0]), at[1] + f64::from(corner[1])];
            // The second one lies outside small projects.
            host.pin(node, 1, shifted([80.0, 45.0]), shifted([96.0, 54.0]));
            host.pin(node, 2, shifted([140.0, 80.0]), shifted([135.0, 70.0]));
            let found = host.render(node, Frame::default()).expect("it renders");
            let samples = reference.get_or_insert_with(|| found.samples.clone());
            let worst = samples.iter().zip(&found.samples).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 1e-4, "{}: {corner:?} in {project:?}: {worst}", profile.name);
            host.finish();
        }
    }
}

#[test]
fn the_plate_s_own_border_is_held() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let (node, pixels) = plate(&mut host, [40, 30], [640.0, 360.0]);
    host.pin(node, 1, [120.0, 75.0], [140.0, 84.0]);
    let found = host.render(node, Frame::default()).expect("it renders");
    for (x, y) in [(40, 30), (199, 30), (40, 119), (199, 119), (120, 30), (40, 75)] {
        assert!((found.at(x, y, 0) - pixels.at(x, y, 0)).abs() < 0.02, "{x}, {y}");
        assert!((found.at(x, y, 3) - pixels.at(x, y, 3)).abs() < 0.02, "{x}, {y}: nothing is pulled away");
    }
    let region = host.region(node, [1.0, 1.0]).expect("it has its own");
    let grown = [40.0 - region[0], 30.0 - region[1], region[2] - 200.0, region[3] - 120.0];
    assert!(grown.iter().all(|by| (0.0..=4.0).contains(by)), "the border is held, so nothing grows: {region:?}");
    host.finish();
}

#[test]
fn the_region_grows_by_what_moves() {
    for shape in [0, 1] {
        for project in [[160.0, 90.0], [640.0, 360.0]] {
            let mut host = Host::start(&BOOK, Which::PinWarp);
            let (node, _) = plate(&mut host, [0, 0], project);
            host.set(node, "shape", shape);
            host.set(node, "holdBorder", 0);
            host.pin(node, 1, [80.0, 45.0], [89.0, 45.0]);
            host.pin(node, 2, [20.0, 45.0], [20.0, 45.0]);
            let region = host.region(node, [1.0, 1.0]).expect("it has its own");
            let grown = [-region[0], -region[1], region[2] - 160.0, region[3] - 90.0];
            assert!(grown.iter().all(|by| *by <= 30.0), "shape {shape} in {project:?}: by {grown:?} for a move of 9");
            host.finish();
        }
    }
}

#[test]
fn maps_of_a_plate_are_measured_by_the_project() {
    let mut host = Host::start(&BOOK, Which::StMap);
    let (node, _) = plate(&mut host, [40, 30], [640.0, 360.0]);
    host.pin(node, 1, [120.0, 75.0], [140.0, 84.0]);
    let found = host.render(node, Frame::default()).expect("it renders");
    // The target shows what the pin holds, and a corner itself.
    for (x, y, from) in [(140, 84, [120.5, 75.5]), (40, 30, [40.5, 30.5])] {
        let [u, v] = [found.at(x, y, 0) * 640.0, found.at(x, y, 1) * 360.0];
        assert!((u - from[0]).abs() < 0.6 && (v - from[1]).abs() < 0.6, "{x}, {y} comes from {u}, {v}, not {from:?}");
    }
    host.finish();
}

#[test]
fn a_proxy_of_a_plate_is_the_plate() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let (node, pixels) = plate(&mut host, [40, 30], [640.0, 360.0]);
    host.pin(node, 1, [120.0, 75.0], [140.0, 84.0]);
    let whole = host.render(node, Frame::default()).expect("it renders");
    let RectI { x1, y1, x2, y2 } = pixels.bounds;
    let bounds = RectI { x1: x1 / 2, y1: y1 / 2, x2: x2 / 2, y2: y2 / 2 };
    let half = |pixels: &Pixels| {
        Pixels::new(bounds, 4, |x, y, c| {
            [(0, 0), (1, 0), (0, 1), (1, 1)].iter().map(|(dx, dy)| pixels.at(2 * x + dx, 2 * y + dy, c)).sum::<f32>()
                / 4.0
        })
    };
    for clip in [image::SOURCE_CLIP, image::OUTPUT_CLIP] {
        let mut form = feed(Some(half(&pixels)), bounds, 4);
        form.scale = [0.5, 0.5];
        host.feed_as(node, clip, form);
    }
    host.project(node, [640.0, 360.0]);
    let found = host.render(node, Frame { scale: [0.5, 0.5], ..Frame::default() }).expect("it renders");
    let expected = half(&whole);
    let total: f32 = found.samples.iter().zip(&expected.samples).map(|(a, b)| (a - b).abs()).sum();
    let mean = total / found.samples.len() as f32;
    assert!(mean < 6e-3, "{mean}");
    host.finish();
}
