//! Line drawings: drawn, warped and kept in shape by `stroke`.

use super::support::{Studio, at, pixels};
use super::tiny::{Part, Tiny, grid};
use pinwarp::image::Frame;
use serde_json::{Value, json};

/// A horizontal line of nine points across the middle of the frame.
fn drawing() -> Value {
    let positions = (0..9).map(|k| [0.1 * (k as f32) - 0.4, 0.0125, 0.0]).collect();
    let part = Part { positions, triangles: vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]], ..grid("Line", [0.0; 4], 1) };
    let mut scene = Tiny::of(vec![part]).json();
    scene["meshes"][0]["primitives"][0]["mode"] = json!(3);
    scene
}

const STILL: &str = "{ frame = 1, offset = [0.0, 0.0] }";

/// Pins at the ends of the line with their keys.
fn layer(solve: &str, [left, right]: [&str; 2]) -> String {
    let pin = |x: f64, keys: &str| format!("[[layer.pin]]\nanchor = {{ screen = [{x}, 0.5125] }}\nkeys = [{keys}]\n");
    format!(
        "[[layer]]\nname = \"all\"\nlattice = {{ dims = [6, 6], box = \"frame\" }}\n{solve}{}{}",
        pin(0.4, left),
        pin(1.2, right)
    )
}

/// Rows of the line in a column.
fn rows(frame: &Frame, column: i32) -> Vec<i32> {
    pixels(frame).filter(|&(x, y)| x == column && at(frame, "id.object", x, y) > 0.0).map(|(_, y)| y).collect()
}

#[test]
fn a_line_is_drawn_in_its_colour() {
    let frame = Studio::of_json(&drawing(), "").frame(1);
    assert_eq!(rows(&frame, 32), [19], "one pixel high, half a pixel above the middle");
    assert_eq!((rows(&frame, 14), rows(&frame, 50)), (vec![], vec![]));
    assert_eq!(["R", "G", "B", "A"].map(|name| at(&frame, name, 32, 19)), [0.5, 0.25, 0.125, 1.0]);
    assert_eq!(at(&frame, "depth.Z", 32, 19), 5.0);
    assert_eq!(["N.X", "N.Y", "N.Z"].map(|name| at(&frame, name, 32, 19)), [0.0, 0.0, 1.0]);
}

#[test]
fn pins_bend_a_line_that_keeps_its_shape() {
    let up = "{ frame = 1, offset = [0.0, 0.25] }";
    for solve in
        ["", "solve = { energy = \"stroke\" }\n", "solve = { energy = \"stroke\", regularizer = \"affine\" }\n"]
    {
        let frame = Studio::of_json(&drawing(), &layer(solve, [STILL, up])).frame(1);
        let (left, right) = (rows(&frame, 17), rows(&frame, 46));
        assert!(left.iter().all(|y| (18..=20).contains(y)) && !left.is_empty(), "{solve} {left:?}");
        assert!(right.iter().all(|y| (9..=11).contains(y)) && !right.is_empty(), "{solve} {right:?}");
    }
}

#[test]
fn the_motion_of_a_line_is_that_of_its_pins() {
    // Both pins climb 0.2 frame heights, 8 pixels, in 8 frames.
    let keys = "{ frame = 1, offset = [0.0, 0.0], ease = \"linear\" }, { frame = 9, offset = [0.0, 0.2] }";
    let frame = Studio::of_json(&drawing(), &layer("", [keys, keys])).frame(5);
    let (x, y) = (32, rows(&frame, 32)[0]);
    for (name, wanted) in [("forward.u", 0.0), ("forward.v", 1.0), ("backward.v", -1.0)] {
        let found = at(&frame, name, x, y);
        assert!((found - wanted).abs() < 1e-3, "{name} is {found}");
    }
}
