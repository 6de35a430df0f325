//! Layers with lattices of their own.

use super::support::{Studio, at, pixels};
use super::tiny::{Part, Tiny, grid};
use pinwarp::image::Frame;

/// Three squares side by side; two layers claim the outer ones.
fn three() -> Tiny {
    let square = |name, x: f32, color| Part { color, ..grid(name, [x - 0.12, -0.12, x + 0.12, 0.12], 2) };
    Tiny::of(vec![
        square("Left", -0.4, [1.0, 0.0, 0.0]),
        square("Middle", 0.0, [0.0, 1.0, 0.0]),
        square("Right", 0.4, [0.0, 0.0, 1.0]),
    ])
}

fn layer(name: &str, offset: [f64; 2]) -> String {
    // A box around everything: a lattice moves what it claims, not what lies in its box.
    format!(
        "[[layer]]\nname = \"{name}\"\nnodes = [\"{name}\"]\nlattice = {{ dims = [4, 4], box = \"frame\" }}\n\
         [[layer.pin]]\nanchor = {{ node = \"{name}\", triangle = 0, barycentric = [1.0, 0.0, 0.0] }}\n\
         keys = [{{ frame = 1, offset = [{}, {}] }}]\n",
        offset[0], offset[1]
    )
}

/// Smallest and largest column and row of the pixels of an object.
fn extent(frame: &Frame, object: f32) -> [i32; 4] {
    let mine = pixels(frame).filter(|&(x, y)| at(frame, "id.object", x, y) == object);
    mine.fold([i32::MAX, i32::MIN, i32::MAX, i32::MIN], |[x0, x1, y0, y1], (x, y)| {
        [x0.min(x), x1.max(x), y0.min(y), y1.max(y)]
    })
}

#[test]
fn layers_move_what_they_claim() {
    let at_rest = Studio::tiny(&three(), "").frame(1);
    let layers = layer("Left", [0.05, 0.25]) + &layer("Right", [0.0, -0.1]);
    let warped = Studio::tiny(&three(), &layers).frame(1);
    let moved = |object: f32, [dx, dy]: [i32; 2]| {
        let [x0, x1, y0, y1] = extent(&at_rest, object);
        assert!(x1 > x0 && y1 > y0, "object {object} is there");
        assert_eq!(extent(&warped, object), [x0 + dx, x1 + dx, y0 + dy, y1 + dy], "object {object}");
    };
    moved(1.0, [2, -10]);
    moved(2.0, [0, 0]);
    moved(3.0, [0, 4]);
    for (x, y) in pixels(&warped) {
        let (object, layer) = (at(&warped, "id.object", x, y), at(&warped, "id.layer", x, y));
        let expected = match object as i32 {
            1 => 1.0,
            3 => 2.0,
            _ => 0.0,
        };
        assert_eq!(layer, expected, "object {object}");
    }
}

#[test]
fn one_layer_does_not_change_the_other() {
    let both = Studio::tiny(&three(), &(layer("Left", [0.05, 0.25]) + &layer("Right", [0.0, -0.1]))).frame(1);
    let alone = Studio::tiny(&three(), &layer("Right", [0.0, -0.1])).frame(1);
    let right = |frame: &Frame| -> Vec<[f32; 5]> {
        let mine = pixels(frame).filter(|&(x, y)| at(frame, "id.object", x, y) == 3.0);
        mine.map(|(x, y)| ["R", "G", "B", "depth.Z", "N.Z"].map(|name| at(frame, name, x, y))).collect()
    };
    assert!(right(&both).len() > 50);
    assert_eq!(right(&both), right(&alone));
}

#[test]
fn depth_decides_between_layers() {
    // The left square is carried in front of, or behind, the middle one.
    for (z, front) in [(0.5, 1.0), (-0.5, 2.0)] {
        let mut tiny = three();
        tiny.parts[0].place = [0.0, 0.0, z];
        let frame = Studio::tiny(&tiny, &layer("Left", [0.4, 0.0])).frame(1);
        assert_eq!(at(&frame, "id.object", 32, 20), front);
    }
}
