//! What pins do to the picture.

use super::support::{Studio, count_differences, hold, pinned_layer};
use super::tiny::{Tiny, grid};

const STILL: [&str; 9] = ["R", "G", "B", "A", "depth.Z", "N.X", "N.Y", "N.Z", "id.object"];

/// The teapot and its table in one layer.
fn whole_teapot() -> Studio {
    let mut studio = Studio::teapot(108, 60);
    studio.shot.layers[0].nodes.clear();
    studio.shot.layers[0].pins.truncate(1);
    studio
}

#[test]
fn a_single_pin_carries_the_picture_along() {
    let mut studio = whole_teapot();
    hold(&mut studio.shot.layers[0].pins[0], [0.1, 0.0]);
    let moved = studio.frame(1);
    studio.shot.layers[0].pins.clear();
    let still = studio.frame(1);
    let (different, compared) = count_differences(&still, &moved, &STILL, [6, 0]);
    assert!(compared > 1000 && different == 0, "{different} of {compared} pixels differ");
    // The comparison can fail: half a pixel's neighbour is another picture.
    for wrong in [[5, 0], [7, 0], [6, 1], [0, 0]] {
        assert!(count_differences(&still, &moved, &STILL, wrong).0 > 100, "{wrong:?}");
    }
}

#[test]
fn up_is_up() {
    let mut studio = whole_teapot();
    hold(&mut studio.shot.layers[0].pins[0], [-0.05, 0.1]);
    let moved = studio.frame(1);
    studio.shot.layers[0].pins.clear();
    let (different, compared) = count_differences(&studio.frame(1), &moved, &STILL, [-3, -6]);
    assert!(compared > 1000 && different == 0, "{different} of {compared} pixels differ");
}

#[test]
fn no_strength_is_no_pins() {
    let mut studio = Studio::teapot(96, 54);
    let warped = studio.frame(12);
    studio.shot.layers[0].strength = 0.0;
    let weak = studio.frame(12);
    studio.shot.layers[0].pins.clear();
    let none = studio.frame(12);
    let (different, compared) = count_differences(&none, &weak, &STILL, [0, 0]);
    assert!(compared > 1000 && different == 0, "{different} of {compared} pixels differ");
    assert!(count_differences(&none, &warped, &STILL, [0, 0]).0 > 100);
}

#[test]
fn half_the_strength_is_half_the_way() {
    let mut studio = whole_teapot();
    hold(&mut studio.shot.layers[0].pins[0], [0.2, 0.0]);
    studio.shot.layers[0].strength = 0.5;
    let moved = studio.frame(1);
    studio.shot.layers[0].pins.clear();
    assert_eq!(count_differences(&studio.frame(1), &moved, &STILL, [6, 0]).0, 0);
}

/// Left edge of the square in frames 1 to 6, pixels.
fn left_edges(studio: &Studio) -> Vec<i32> {
    studio.frames(&[1, 2, 3, 4, 5, 6]).iter().map(|frame| frame.data_window.x).collect()
}

#[test]
fn offsets_are_held_on_twos_and_anchors_are_not() {
    // Two pixels a frame by the pin, from column 24 on.
    let keys = "{ frame = 1, offset = [0.0, 0.0] }, { frame = 9, offset = [0.4, 0.0] }";
    let mut quad = grid("Quad", [-0.2, -0.2, 0.2, 0.2], 2);
    let mut studio = Studio::tiny(&Tiny::of(vec![quad.clone()]), &pinned_layer(keys));
    assert_eq!(left_edges(&studio), [24, 26, 28, 30, 32, 34]);
    studio.shot.layers[0].step = 2;
    assert_eq!(left_edges(&studio), [24, 24, 28, 28, 32, 32]);
    studio.shot.layers[0].step = 3;
    assert_eq!(left_edges(&studio), [24, 24, 24, 30, 30, 30]);
    // One pixel a frame by the animation, which goes on every frame.
    quad.velocity = [24.0 / 40.0, 0.0, 0.0];
    let mut studio = Studio::tiny(&Tiny::of(vec![quad]), &pinned_layer(keys));
    studio.shot.layers[0].step = 2;
    assert_eq!(left_edges(&studio), [24, 25, 30, 31, 36, 37]);
}

#[test]
fn keys_hold_before_the_first_and_after_the_last() {
    let keys = "{ frame = 3, offset = [0.1, 0.0] }, { frame = 4, offset = [0.2, 0.0] }";
    let tiny = Tiny::of(vec![grid("Quad", [-0.2, -0.2, 0.2, 0.2], 2)]);
    assert_eq!(left_edges(&Studio::tiny(&tiny, &pinned_layer(keys))), [28, 28, 28, 32, 32, 32]);
}

#[test]
fn a_target_is_a_place_on_the_screen() {
    // The square's lower left corner, which animation takes along, is called to one place.
    let mut quad = grid("Quad", [-0.2, -0.2, 0.2, 0.2], 2);
    quad.velocity = [24.0 / 40.0, 0.0, 0.0];
    let studio = Studio::tiny(&Tiny::of(vec![quad]), &pinned_layer("{ frame = 1, target = [0.25, 0.5] }"));
    let windows: Vec<_> = studio.frames(&[1, 4]).iter().map(|frame| frame.data_window).collect();
    assert_eq!((windows[0].x, windows[0].y), (10, 40 - 20 - 16));
    assert_eq!(windows[0], windows[1]);
}
