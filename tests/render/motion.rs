//! Motion vectors and motion blur.

use super::support::{Studio, at, is_interior, pinned_layer, pixels};
use super::tiny::{Part, Tiny, grid};
use pinwarp::image::Frame;
use pinwarp::shot::Shutter;

const VECTORS: [&str; 4] = ["forward.u", "forward.v", "backward.u", "backward.v"];

/// A square that moves by whole pixels a frame, x right, y up.
fn moving(pixels: [f32; 2]) -> Part {
    let velocity = [pixels[0] * 24.0 / 40.0, pixels[1] * 24.0 / 40.0, 0.0];
    Part { velocity, ..grid("Quad", [-0.2, -0.2, 0.2, 0.2], 2) }
}

/// Every vector of the square is the given one, forwards and backwards; nothing stands beside it.
#[track_caller]
fn assert_motion(frame: &Frame, [u, v]: [f32; 2]) {
    let mut seen = 0;
    for (x, y) in pixels(frame) {
        let is_covered = at(frame, "A", x, y) > 0.0;
        let expected = if is_covered { [u, v, -u, -v] } else { [0.0; 4] };
        let found = VECTORS.map(|name| at(frame, name, x, y));
        let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3);
        assert!(is_near, "{found:?} at {x}, {y}, expected {expected:?}");
        seen += usize::from(is_covered);
    }
    assert!(seen > 200, "{seen} pixels");
}

#[test]
fn vectors_follow_the_animation() {
    let mut studio = Studio::tiny(&Tiny::of(vec![moving([3.0, 1.0])]), "");
    assert_motion(&studio.frame(3), [3.0, 1.0]);
    // In pixels of the output.
    studio.shot.size.width *= 2;
    studio.shot.size.height *= 2;
    assert_motion(&studio.frame(3), [6.0, 2.0]);
    // Wide pixels: half as many of them.
    studio.shot.size.width /= 2;
    studio.shot.size.pixel_aspect = 2.0;
    assert_motion(&studio.frame(3), [3.0, 2.0]);
}

#[test]
fn vectors_end_where_the_clip_does() {
    // Before the clip begins nothing moves: backwards there is no motion in the first frame.
    let frame = Studio::tiny(&Tiny::of(vec![moving([3.0, 1.0])]), "").frame(1);
    assert!((at(&frame, "forward.u", 32, 20) - 3.0).abs() < 1e-3);
    assert_eq!(at(&frame, "backward.u", 32, 20), 0.0);
}

#[test]
fn vectors_follow_pins_and_camera_too() {
    // Two pixels left and one up a frame by the pin, one to the right by the animation, half a pixel by the camera.
    let keys = "{ frame = 1, offset = [0.0, 0.0] }, { frame = 9, offset = [-0.4, 0.2] }";
    let mut tiny = Tiny::of(vec![moving([1.0, 0.0])]);
    assert_motion(&Studio::tiny(&tiny, &pinned_layer(keys)).frame(4), [-1.0, 1.0]);
    tiny.camera_velocity = [-0.5 * 24.0 / 40.0, 0.0, 0.0];
    assert_motion(&Studio::tiny(&tiny, &pinned_layer(keys)).frame(4), [-0.5, 1.0]);
}

/// Bilinear sample between pixel centres; `None` beside the interior of one object.
fn between(frame: &Frame, channel: &str, x: f32, y: f32) -> Option<f32> {
    let (left, top) = (x.floor(), y.floor());
    let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (left as i32 + dx, top as i32 + dy));
    let weight = |dx: f32, dy: f32| (1.0 - (x - left - dx).abs()) * (1.0 - (y - top - dy).abs());
    let weights = [weight(0.0, 0.0), weight(1.0, 0.0), weight(0.0, 1.0), weight(1.0, 1.0)];
    let is_inside = corners.iter().all(|&(x, y)| is_interior(frame, x, y));
    is_inside.then(|| corners.iter().zip(weights).map(|(&(x, y), weight)| at(frame, channel, x, y) * weight).sum())
}

/// Median difference of the depth at the two ends of a vector, scaled by `factor`, over pixels that move.
fn depth_error(from: &Frame, to: &Frame, [u, v]: [&str; 2], factor: f32) -> f32 {
    let mut errors: Vec<f32> = pixels(from)
        .filter(|&(x, y)| is_interior(from, x, y))
        .filter_map(|(x, y)| {
            let (right, up) = (at(from, u, x, y), at(from, v, x, y));
            let there = between(to, "depth.Z", x as f32 + factor * right, y as f32 - factor * up)?;
            (right.hypot(up) > 0.75).then(|| (there - at(from, "depth.Z", x, y)).abs())
        })
        .collect();
    assert!(errors.len() > 300, "{} pixels move", errors.len());
    errors.sort_by(f32::total_cmp);
    errors[errors.len() / 2]
}

#[test]
fn vectors_lead_to_the_same_surface_point() {
    // Nothing but the warp moves, and the warp leaves depth as it was: depth tells surface points apart.
    let frames = Studio::teapot(240, 135).frames(&[6, 7]);
    let [now, next] = [&frames[0], &frames[1]];
    for (from, to, vector) in [(now, next, ["forward.u", "forward.v"]), (next, now, ["backward.u", "backward.v"])] {
        let right = depth_error(from, to, vector, 1.0);
        for wrong in [-1.0, 0.0, 0.5, 2.0] {
            let wrong_error = depth_error(from, to, vector, wrong);
            assert!(right * 4.0 < wrong_error, "{vector:?}: {right} m, with a wrong vector {wrong_error} m");
        }
    }
}

/// Width of the moving box, pixels.
const BOX: f64 = 32.0;
/// Its speed, pixels a frame.
const SPEED: f64 = 16.0;

/// What moves the box: in frame 5 it stands in the middle of 128 columns.
fn animated() -> Studio {
    let mut part = grid("Quad", [-0.4, -0.3, 0.4, 0.3], 2);
    part.place = [-4.0 * 16.0 / 40.0, 0.0, 0.0];
    part.velocity = [16.0 * 24.0 / 40.0, 0.0, 0.0];
    Studio::tiny(&Tiny::of(vec![part]), "")
}

/// The same way, by a pin.
fn carried() -> Studio {
    let keys = "{ frame = 1, offset = [-1.6, 0.0] }, { frame = 9, offset = [1.6, 0.0] }";
    Studio::tiny(&Tiny::of(vec![grid("Quad", [-0.4, -0.3, 0.4, 0.3], 2)]), &pinned_layer(keys))
}

/// Frame 5, and alpha along its middle row.
fn blurred(mut studio: Studio, angle: f64, phase: f64) -> (Frame, Vec<f64>) {
    studio.shot.size.width = 128;
    studio.shot.samples = 64;
    studio.shot.shutter = Shutter { angle, phase };
    let frame = studio.frame(5);
    let row = (0..128).map(|x| f64::from(at(&frame, "A", x, 20))).collect();
    (frame, row)
}

/// Share of the shutter's opening for which the box covers a column's centre.
fn expected(angle: f64, phase: f64) -> Vec<f64> {
    let share = |x: i32| {
        let from_center = f64::from(x) + 0.5 - 64.0;
        // The box covers the column while its own centre is within half a box of it.
        let (open, close) = (SPEED * phase / 360.0, SPEED * (phase + angle) / 360.0);
        let covered = (from_center + BOX / 2.0).min(close) - (from_center - BOX / 2.0).max(open);
        (covered / (close - open)).clamp(0.0, 1.0)
    };
    (0..128).map(share).collect()
}

fn largest_gap(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn a_box_spreads_over_half_its_way() {
    // The pixel filter rounds the ends of the ramp a little.
    let limit = 0.07;
    let (frame, row) = blurred(animated(), 180.0, -90.0);
    assert!(largest_gap(&row, &expected(180.0, -90.0)) < limit, "{row:?}");
    assert!(row.iter().filter(|&&alpha| alpha > 0.02 && alpha < 0.98).count() >= 14, "two ramps of 8 pixels: {row:?}");
    let (_, later) = blurred(animated(), 180.0, 0.0);
    assert!(largest_gap(&later, &expected(180.0, 0.0)) < limit, "{later:?}");
    // The comparison can fail.
    assert!(largest_gap(&row, &expected(180.0, 0.0)) > 0.3);
    assert!(largest_gap(&blurred(animated(), 0.0, 0.0).1, &expected(180.0, -90.0)) > 0.3);
    // Data come from mid-shutter: the ramp's outer part has none.
    for (x, is_covered) in [(44, false), (50, true), (77, true), (83, false)] {
        assert_eq!(at(&frame, "depth.Z", x, 20) < 1e10, is_covered, "column {x}");
        assert_eq!(at(&frame, "forward.u", x, 20) > 15.0, is_covered, "column {x}");
    }
    assert!(row[45] > 0.02 && row[82] > 0.02);
}

#[test]
fn pins_blur_unless_they_are_held() {
    let limit = 0.07;
    let (_, row) = blurred(carried(), 180.0, -90.0);
    assert!(largest_gap(&row, &expected(180.0, -90.0)) < limit, "{row:?}");
    // On twos the drawing stands still while the shutter is open: only the pixel filter softens its edges.
    let mut held = carried();
    held.shot.layers[0].step = 2;
    let (_, row) = blurred(held, 180.0, -90.0);
    assert!(row.iter().filter(|&&alpha| alpha > 0.02 && alpha < 0.98).count() <= 8, "{row:?}");
    assert!(largest_gap(&row, &expected(180.0, -90.0)) > 0.3);
}
