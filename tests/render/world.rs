//! Lattices of the scene: pins in metres and pins dragged on the screen move the meshes themselves.

use super::support::{Studio, at, count_differences, is_interior, pixels};
use super::tiny::{Lens, Part, Tiny, grid};
use glam::{DQuat, DVec3};
use pinwarp::pipeline::{PreparedShot, TimeSample, WorldSolution, report};
use pinwarp::space::{ScreenPoint, ScreenVector};

const ALL: [&str; 9] = ["R", "G", "B", "A", "depth.Z", "N.X", "N.Y", "N.Z", "id.object"];

/// A bent sheet, so that depths and normals differ all over it.
fn sheet() -> Part {
    let mut part = grid("Quad", [-0.6, -0.5, 0.6, 0.5], 8);
    for point in &mut part.positions {
        point[2] = 0.3 * (2.0 * point[0]).cos() + 0.1 * point[1];
    }
    part
}

/// A closed ball of 8 x 8 cells, poles up and down.
fn ball() -> Part {
    let mut part = grid("Quad", [-1.0, -0.5, 1.0, 0.5], 8);
    for point in &mut part.positions {
        let [around, up] = [point[0], point[1]].map(|share| share * std::f32::consts::PI);
        *point = [0.5 * up.cos() * around.sin(), 0.5 * up.sin(), 0.5 * up.cos() * around.cos()];
    }
    part
}

/// Pins of the ball: at its back, which goes where `keys` say, on both sides, in front and near the north pole.
fn ball_pins(keys: &str) -> String {
    let at = |triangle: usize, keys: &str| pin(keys).replace("triangle = 0", &format!("triangle = {triangle}"));
    at(64, keys) + &[68, 72, 76, 112].map(|triangle| at(triangle, "")).concat()
}

fn seen(part: Part, lens: Lens) -> Tiny {
    Tiny { lens, ..Tiny::of(vec![part]) }
}

const NEAR: Lens = Lens::Perspective(0.35);

/// A pin of the sheet's lower left corner.
fn pin(keys: &str) -> String {
    format!(
        "[[layer.pin]]\nanchor = {{ node = \"Quad\", triangle = 0, barycentric = [1.0, 0.0, 0.0] }}\nkeys = [{keys}]\n"
    )
}

/// Pins of its upper right and lower right corner.
fn far_pins([upper, lower]: [&str; 2]) -> String {
    let at = |triangle: usize, keys: &str| {
        pin(keys).replace("triangle = 0", &format!("triangle = {triangle}")).replace("[1.0, 0.0", "[0.0, 1.0")
    };
    at(127, upper) + &at(14, lower)
}

fn world_layer(pins: &str) -> String {
    format!("[[layer]]\nname = \"all\"\nlattice = {{ space = \"world\" }}\n{pins}")
}

fn solved(sample: &TimeSample) -> &WorldSolution {
    sample.layers[0].world.as_ref().expect("the layer is warped")
}

#[test]
fn a_single_pin_carries_the_mesh_along() {
    let by = [0.1, -0.05, -0.7];
    let keys = format!("{{ frame = 1, offset = {by:?} }}");
    let warped = Studio::tiny(&seen(sheet(), NEAR), &world_layer(&pin(&keys))).frame(2);
    let moved = Part { place: by.map(|x: f64| x as f32), ..sheet() };
    let expected = Studio::tiny(&seen(moved, NEAR), "").frame(2);
    let (different, compared) = count_differences(&expected, &warped, &ALL, [0, 0]);
    assert!(compared > 200 && different == 0, "{different} of {compared} pixels differ");
    // The comparison can fail: the depth of the sheet that stayed is another.
    let still = Studio::tiny(&seen(sheet(), NEAR), "").frame(2);
    assert!(count_differences(&still, &warped, &ALL, [0, 0]).0 > 100);
}

#[test]
fn a_dragged_pin_lands_on_its_pixel_at_its_depth() {
    for lens in [NEAR, Lens::Parallel] {
        let keys = "{ frame = 1, offset = [0.2, 0.1] }";
        let studio = Studio::tiny(&seen(ball(), lens), &world_layer(&ball_pins(keys)));
        let prepared = studio.prepared();
        let sample = prepared.sample_at(3.0).expect("the frame is solved");
        let state = sample.layers[0].pins[0];
        assert!((state.target - (state.rest + ScreenVector::new(0.2, 0.1))).0.length() < 1e-12);
        // The vertex itself, as it is drawn at 1080 lines.
        let unwarped = sample.camera.project_exact(solved(&sample).pins[0].rest);
        let corner = sample.mesh().parts[0].vertices[3 * 64];
        assert!((corner.point() - state.target).0.length() * 1080.0 < 0.05, "{lens:?}: {:?}", corner.point());
        assert!((corner.depth - unwarped.depth).abs() < 1e-5, "{lens:?}");
        let report = report(&prepared, 3, &sample);
        // A ball that is pulled this far folds, which is warned of; nothing else is.
        let is_of_folds = |warning: &String| warning.contains("folds over itself");
        assert!(report.layers[0].pin_error_px < 0.05, "{:?}", report.layers[0]);
        assert!(report.warnings.iter().all(is_of_folds), "{:?}", report.warnings);
        assert!(report.layers[0].pin_error_metres.is_some_and(|error| error < 1e-5));
    }
}

#[test]
fn a_target_is_a_pixel_or_a_point_of_the_scene() {
    let on_screen = Studio::tiny(&seen(sheet(), NEAR), &world_layer(&pin("{ frame = 1, target = [0.3, 0.4] }")));
    let sample = on_screen.prepared().sample_at(1.0).expect("the frame is solved");
    let corner = sample.mesh().parts[0].vertices[0].point();
    assert!((corner - ScreenPoint::new(0.3, 0.4)).0.length() < 1e-5, "{corner:?}");
    let in_scene = Studio::tiny(&seen(sheet(), NEAR), &world_layer(&pin("{ frame = 1, target = [0.1, 0.2, 0.3] }")));
    let sample = in_scene.prepared().sample_at(1.0).expect("the frame is solved");
    let corner = sample.pose.parts[0].positions[0].0.as_dvec3();
    assert!(corner.distance(DVec3::new(0.1, 0.2, 0.3)) < 1e-5, "{corner}");
}

#[test]
fn targets_in_metres_are_independent_of_the_camera_and_dragged_ones_are_not() {
    let mut tiny = seen(sheet(), NEAR);
    // A tenth of a metre nearer a frame.
    tiny.camera_velocity = [1.0, 0.5, -2.4];
    let handles = |keys: &str, frame: f64| {
        let mut studio = Studio::tiny(&tiny, &world_layer(&(pin(keys) + &far_pins(["", ""]))));
        // Over time, what a knot starts from differs in the last digits.
        studio.shot.layers[0].settings.temporal = 0.0;
        solved(&studio.prepared().sample_at(frame).expect("the frame is solved")).lattice.lattice.handles.clone()
    };
    let in_metres = "{ frame = 1, offset = [0.2, 0.1, 0.3] }";
    assert_eq!(handles(in_metres, 1.0), handles(in_metres, 9.0));
    let dragged = "{ frame = 1, offset = [0.2, 0.1] }";
    assert_ne!(handles(dragged, 1.0), handles(dragged, 9.0));
}

#[test]
fn depth_goes_along() {
    let keys = "{ frame = 1, offset = [0.0, 0.0, 1.0] }";
    let layer = world_layer(&(pin(keys) + &far_pins([keys, keys])));
    let [still, near] = ["", &layer].map(|layer| Studio::tiny(&seen(sheet(), Lens::Parallel), layer).frame(1));
    let inner: Vec<_> = pixels(&still).filter(|&(x, y)| is_interior(&still, x, y)).collect();
    assert!(inner.len() > 500);
    for (x, y) in inner {
        let gap = at(&still, "depth.Z", x, y) - at(&near, "depth.Z", x, y);
        assert!((gap - 1.0).abs() < 1e-4, "{gap} at {x}, {y}");
    }
}

#[test]
fn normals_turn_with_the_mesh() {
    // Three pins turn the sheet by 30 degrees about y.
    let turn = DQuat::from_rotation_y(30.0_f64.to_radians());
    let part = sheet();
    let target = |corner: usize| {
        let at = part.positions[corner].map(f64::from);
        format!("{{ frame = 1, target = {:?} }}", (turn * DVec3::from(at)).to_array())
    };
    let pins = pin(&target(0)) + &far_pins([&target(80), &target(8)]);
    let warped = Studio::tiny(&seen(part.clone(), NEAR), &world_layer(&pins)).frame(1);
    let mut turned = Studio::tiny(&seen(part, NEAR), "");
    turned.turn_node(0, turn);
    let (different, compared) = count_differences(&turned.frame(1), &warped, &ALL, [0, 0]);
    assert!(compared > 200 && different == 0, "{different} of {compared} pixels differ");
}

#[test]
fn motion_is_that_of_the_moved_mesh() {
    // Two pixels left and one up a frame by the pin, one to the right by the animation.
    let keys = "{ frame = 1, offset = [0.0, 0.0, 0.0] }, { frame = 9, offset = [-0.4, 0.2, 0.5] }";
    let part = Part { velocity: [24.0 / 40.0, 0.0, 0.0], ..sheet() };
    let frame = Studio::tiny(&seen(part, Lens::Parallel), &world_layer(&pin(keys))).frame(4);
    let mut compared = 0;
    for (x, y) in pixels(&frame).filter(|&(x, y)| is_interior(&frame, x, y)) {
        let found = ["forward.u", "forward.v", "backward.u", "backward.v"].map(|name| at(&frame, name, x, y));
        let is_near = found.iter().zip([-1.0, 1.0, 1.0, -1.0]).all(|(a, b)| (a - b).abs() < 1e-3);
        assert!(is_near, "{found:?} at {x}, {y}");
        compared += 1;
    }
    assert!(compared > 500);
}

/// Handles in the frame of the box, per unit of its diagonal, and the box.
fn in_box(studio: &Studio, frame: f64) -> Vec<f64> {
    let sample = studio.prepared().sample_at(frame).expect("the frame is solved");
    let lattice = &solved(&sample).lattice.lattice;
    let numbers = lattice.handles.iter().flatten().chain(&lattice.grid.lo).chain(&lattice.grid.hi);
    numbers.map(|x| x / lattice.grid.diagonal()).collect()
}

#[test]
fn a_rigidly_moving_model_has_a_rigidly_moving_lattice() {
    let keys = "{ frame = 1, offset = [0.2, 0.1, -0.3] }";
    let pins = ball_pins(keys).replacen("keys", "unit = \"box\"\nkeys", 1);
    let still = in_box(&Studio::tiny(&seen(ball(), NEAR), &world_layer(&pins)), 3.0);
    let largest = |other: Vec<f64>| still.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let moving = Part { place: [0.3, -0.2, -1.0], velocity: [1.0, 2.0, -3.0], ..ball() };
    let moving = Studio::tiny(&seen(moving, NEAR), &world_layer(&pins));
    for frame in [1.0, 3.5, 8.0] {
        let gap = largest(in_box(&moving, frame));
        // Places in the scene are single precision, and a solve in space ends on a step of 1e-6.
        assert!(gap < 3e-6, "frame {frame}: {gap}");
    }
    let mut turned = Studio::tiny(&seen(ball(), NEAR), &world_layer(&pins));
    for angle in [0.3, 1.7, 3.1] {
        turned.turn_node(0, DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), angle));
        let gap = largest(in_box(&turned, 3.0));
        assert!(gap < 1e-6, "turned by {angle}: {gap}");
    }
    // The comparison can fail: along the scene's axes the same offset is another edit of a turned model.
    let mut fixed = Studio::tiny(&seen(ball(), NEAR), &world_layer(&ball_pins(keys)));
    let before = in_box(&fixed, 3.0);
    fixed.turn_node(0, DQuat::from_rotation_y(1.7));
    let after = in_box(&fixed, 3.0);
    assert!(before.iter().zip(after).any(|(a, b)| (a - b).abs() > 1e-2));
}

#[test]
fn rotations_are_seen_or_about_axes() {
    // A quarter turn about the view axis, as seen counter-clockwise, and the same about z.
    let as_seen = pin("{ frame = 1, offset = [0.0, 0.0, 0.0], rotate = 90 }");
    let about_z = pin("{ frame = 1, rotate = [0, 0, 90] }");
    let images = [as_seen, about_z].map(|pins| {
        let studio = Studio::tiny(&seen(sheet(), NEAR), &world_layer(&pins));
        let sample = studio.prepared().sample_at(1.0).expect("the frame is solved");
        // Parts without normals are shaded flat: three vertices a triangle.
        sample.pose.parts[0].positions[3 * 14 + 1].0.as_dvec3()
    });
    // The lower right corner, 1.2 m to the right of the pin, goes 1.2 m above it.
    let corner = |x: f64| DVec3::new(x, -0.5, 0.3 * (2.0 * x).cos() - 0.05);
    let expected = corner(-0.6) + DVec3::new(0.0, 1.2, 0.0);
    assert!(images.iter().all(|image| image.distance(expected) < 1e-4), "{images:?} {expected}");
}

#[test]
fn handles_move_in_box_sizes() {
    let layer = "[[layer]]\nlattice = { space = \"world\", dims = [2, 2, 2], basis = \"bilinear\", \
                 box = { fixed = [-1, -1, -1, 1, 1, 1] } }\n[[layer.handle]]\nindex = [1, 1, 1]\n\
                 keys = [{ frame = 1, offset = [0.5, 0.0, -0.25] }]\n";
    let studio = Studio::tiny(&seen(sheet(), NEAR), layer);
    let sample = studio.prepared().sample_at(1.0).expect("the frame is solved");
    let lattice = &solved(&sample).lattice;
    let moved = lattice.warp(DVec3::ONE) - DVec3::ONE;
    assert!(moved.distance(DVec3::new(1.0, 0.0, -0.5)) < 1e-3, "{moved}");
    assert!(sample.layers[0].solution.is_none());
}

#[test]
fn world_and_screen_layers_work_side_by_side() {
    let left = Part { name: "Left", place: [-0.4, 0.0, 0.0], ..grid("Left", [-0.1, -0.1, 0.1, 0.1], 4) };
    let right = Part { name: "Right", place: [0.4, 0.0, 0.0], ..grid("Right", [-0.1, -0.1, 0.1, 0.1], 4) };
    let layer = |name: &str, space: &str, offset: &str| {
        format!(
            "[[layer]]\nname = \"{name}\"\nnodes = [\"{name}\"]\n{space}[[layer.pin]]\n\
             anchor = {{ node = \"{name}\", triangle = 0, barycentric = [1.0, 0.0, 0.0] }}\n\
             keys = [{{ frame = 1, offset = {offset} }}]\n"
        )
    };
    let both = layer("Left", "lattice = { space = \"world\" }\n", "[0.0, 0.2, 0.0]")
        + &layer("Right", "lattice = { dims = [4, 4] }\n", "[0.0, -0.2]");
    let frame = Studio::tiny(&Tiny::of(vec![left, right]), &both).frame(1);
    // One metre is 40 pixels: eight up, eight down.
    assert_eq!([at(&frame, "id.object", 16, 12), at(&frame, "id.object", 48, 28)], [1.0, 2.0]);
    assert_eq!([at(&frame, "id.layer", 16, 12), at(&frame, "id.layer", 48, 28)], [1.0, 2.0]);
    assert_eq!([at(&frame, "id.object", 16, 22), at(&frame, "id.object", 48, 18)], [0.0, 0.0]);
}

#[test]
fn meshes_too_coarse_for_their_lattice_are_reported() {
    let layer = world_layer(&pin("")).replace("\"world\"", "\"world\", dims = [8, 8, 4]");
    let notes = |part: Part| Studio::tiny(&seen(part, NEAR), &layer).prepared().notes;
    let coarse = notes(grid("Quad", [-0.6, -0.5, 0.6, 0.5], 1));
    assert!(coarse.iter().any(|note| note.contains("edges of 'Quad' are up to") && note.contains("subdivide")));
    assert!(!notes(sheet()).iter().any(|note| note.contains("edges of")));
}

/// Two boards side by side, one of which is pulled away from the other, with a gap of 3 % of their size.
fn boards(topology: &str) -> Studio {
    let board = |name: &'static str, left: f32| grid(name, [left, -0.5, left + 0.2, 0.5], 16);
    let boards = Tiny::of(vec![board("Left", -0.215), board("Right", 0.015)]);
    let pin = |node: &str, triangle: usize, offset: [f64; 3]| {
        format!(
            "[[layer.pin]]\nanchor = {{ node = '{node}', triangle = {triangle}, barycentric = [1.0, 0.0, 0.0] }}\n\
             keys = [{{ frame = 1, offset = {offset:?} }}]\n"
        )
    };
    // Three pins, so that the left board cannot turn about two.
    let left = [8, 30, 488].map(|triangle| pin("Left", triangle, [0.0; 3])).concat();
    let pins = left + &pin("Right", 488, [0.0; 3]);
    let pulled = pin("Right", 8, [0.25, 0.0, 0.1]);
    let radius = if topology == "plain" { "" } else { ", island_radius = 0.01" };
    let lattice = format!("lattice = {{ space = 'world', dims = [10, 20, 4], topology = '{topology}'{radius} }}");
    Studio::tiny(&boards, &format!("[[layer]]\n{lattice}\n{pins}{pulled}"))
}

#[test]
fn parts_that_are_apart_in_the_scene_stay_apart() {
    let moves = |topology: &str, prepared: &PreparedShot| {
        let sample = prepared.sample_at(1.0).expect("solvable");
        let (rest, _) = prepared.view(1.0);
        let moves: Vec<f32> = rest
            .parts
            .iter()
            .zip(&sample.pose.parts)
            .map(|(rest, moved)| {
                let moves = rest.positions.iter().zip(&moved.positions).map(|(rest, moved)| rest.0.distance(moved.0));
                moves.fold(0.0, f32::max)
            })
            .collect();
        let pin_errors = &solved(&sample).report.pin_errors;
        assert!(pin_errors.iter().all(|error| *error < 1e-6), "{topology}: {pin_errors:?}");
        (moves, solved(&sample).branches.is_some())
    };
    let (plain, _) = moves("plain", &boards("plain").prepared());
    let studio = boards("branching");
    let prepared = studio.prepared();
    let (branching, has_branches) = moves("branching", &prepared);
    println!("left and right board move by {plain:?} m, branching by {branching:?} m");
    assert!(has_branches && branching[1] > 0.25, "the right board is pulled");
    assert!(branching[0] < 0.002 && plain[0] > 0.05, "{branching:?} against {plain:?}");
    let path = std::env::temp_dir().join("pinwarp-no-such-folder/boards.lattice.json");
    let file = pinwarp::pipeline::lattices(&prepared, &[1], |_| ()).expect("solvable");
    let told = file.write(&path).expect_err("files do not hold branches in the scene").to_string();
    assert!(told.contains("branches in the scene") && told.contains("--to gltf"), "{told}");
}
