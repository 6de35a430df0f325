//! Pins that follow others, mirrored by the model's own symmetry.

use super::support::Studio;
use super::tiny::{Lens, Part, Tiny, grid};
use glam::DQuat;
use pinwarp::pipeline::{PinState, PipelineError, PreparedShot};
use pinwarp::shot::Shot;
use std::f64::consts::FRAC_PI_2;
use std::path::Path;

/// A bent sheet that is its own mirror image across x, and across nothing else.
fn sheet() -> Part {
    let mut part = grid("Quad", [-0.6, -0.5, 0.6, 0.5], 8);
    for point in &mut part.positions {
        point[2] = 0.3 * (2.0 * point[0]).cos() + 0.2 * point[1] + 0.3 * point[1] * point[1];
    }
    part
}

/// A pin on the sheet's lower left corner with keys, one that follows it, and one in the middle that rests.
fn pins(keys: &str) -> String {
    format!(
        "[[layer.pin]]\nname = \"hand.L\"\nanchor = {{ node = \"Quad\", triangle = 0, barycentric = [1.0, 0.0, 0.0] }}\n\
         keys = [{keys}]\n[[layer.pin]]\nname = \"hand.R\"\nmirror = \"hand.L\"\n[[layer.pin]]\n\
         anchor = {{ node = \"Quad\", triangle = 72, barycentric = [1.0, 0.0, 0.0] }}\n"
    )
}

fn layer(keys: &str) -> String {
    format!("[[layer]]\nname = \"all\"\nlattice = {{ dims = [6, 6] }}\n{}", pins(keys))
}

fn seen(lens: Lens) -> Tiny {
    Tiny { lens, ..Tiny::of(vec![sheet()]) }
}

/// The pins of a frame, the model turned about y.
fn states(layer: &str, angle: f64) -> (PreparedShot, Vec<PinState>) {
    let mut studio = Studio::tiny(&seen(Lens::Parallel), layer);
    let nodes =
        studio.shot.scene().map(|path| std::fs::read_to_string(path).expect("the scene is there")).expect("a scene");
    let scene: serde_json::Value = serde_json::from_str(&nodes).expect("JSON");
    let node =
        scene["nodes"].as_array().expect("nodes").iter().position(|node| node["name"] == "Quad").expect("the sheet");
    studio.turn_node(node, DQuat::from_rotation_y(angle));
    let prepared = studio.prepared();
    let states = prepared.sample_at(1.0).expect("the frame is solved").layers[0].pins.clone();
    (prepared, states)
}

#[test]
fn the_other_hand_makes_the_mirrored_move() {
    let (prepared, states) = states(&layer("{ frame = 1, offset = [0.05, 0.1], rotate = 20 }"), 0.0);
    let [left, right] = [states[0], states[1]];
    let moves = [left, right].map(|state| (state.target - state.rest).0);
    assert!((left.rest.0.y - right.rest.0.y).abs() < 1e-6, "the mirrored point is level with the other");
    let middle = states[2].rest.0.x;
    assert!((left.rest.0.x + right.rest.0.x - 2.0 * middle).abs() < 1e-6, "and as far from the middle");
    assert!((moves[0] - glam::DVec2::new(0.05, 0.1)).length() < 1e-12);
    assert!((moves[1] - glam::DVec2::new(-0.05, 0.1)).length() < 1e-6, "{:?}", moves[1]);
    let note = prepared.notes.iter().find(|note| note.contains("mirrored pins")).expect("the plane is named");
    assert!(note.contains("the plane x = 0, which maps 100 % of the surface"), "{note}");
    // The warp itself is the mirror image: two points of the model beside the middle move alike.
    let sample = prepared.sample_at(1.0).expect("the frame is solved");
    let lattice = &sample.layers[0].solution.as_ref().expect("solved").lattice;
    for (x, y) in [(0.1, 0.2), (0.2, -0.1), (0.3, 0.3)] {
        let at = |x: f64| glam::DVec2::from(lattice.deform([middle + x, 0.5 + y]));
        let [one, other] = [at(-x), at(x)];
        assert!((one.x + other.x - 2.0 * middle).abs() < 1e-5 && (one.y - other.y).abs() < 1e-5, "{one} {other}");
    }
}

#[test]
fn a_model_seen_from_its_side_moves_both_hands_alike() {
    let (_, states) = states(&layer("{ frame = 1, offset = [0.05, 0.1], rotate = 20 }"), FRAC_PI_2);
    let moves = [states[0], states[1]].map(|state| (state.target - state.rest).0);
    assert!((moves[0] - moves[1]).length() < 1e-6, "{moves:?}");
}

#[test]
fn targets_and_box_offsets_are_mirrored_as_moves() {
    let (_, states) = states(&layer("{ frame = 1, target = [0.3, 0.4] }"), 0.0);
    let moves = [states[0], states[1]].map(|state| (state.target - state.rest).0);
    assert!((moves[0].x + moves[1].x).abs() < 1e-6 && (moves[0].y - moves[1].y).abs() < 1e-6, "{moves:?}");
    assert!((states[0].target.0 - glam::DVec2::new(0.3, 0.4)).length() < 1e-12);
}

#[test]
fn in_the_scene_the_move_is_reflected_in_depth_too() {
    let text = layer("{ frame = 1, offset = [0.1, 0.2, 0.3] }").replace("dims = [6, 6]", "space = \"world\"");
    for angle in [0.0, 0.6] {
        let mut studio = Studio::tiny(&seen(Lens::Parallel), &text);
        let scene = studio.prepared().scene;
        studio.turn_node(scene.node_named("Quad").expect("the sheet"), DQuat::from_rotation_y(angle));
        let sample = studio.prepared().sample_at(1.0).expect("the frame is solved");
        let pins = &sample.layers[0].world.as_ref().expect("solved").pins;
        let [left, right] = [0, 1].map(|pin| pins[pin].target - pins[pin].rest);
        let across = DQuat::from_rotation_y(angle) * glam::DVec3::X;
        let reflected = left - 2.0 * across.dot(left) * across;
        assert!(right.distance(reflected) < 1e-4, "{angle}: {right} is not {reflected}");
    }
}

#[test]
fn a_plane_of_the_shot_is_used_and_weight_and_region_go_along() {
    let text = layer("{ frame = 1, offset = [0.05, 0.1] }").replace(
        "[[layer.pin]]\nname = \"hand.L\"",
        "symmetry = { axis = \"y\", at = 0.0 }\n[[layer.pin]]\nname = \"hand.L\"\nweight = 0.5",
    );
    let (prepared, states) = states(&text, 0.0);
    let moves = [states[0], states[1]].map(|state| (state.target - state.rest).0);
    assert!((moves[1] - glam::DVec2::new(0.05, -0.1)).length() < 1e-6, "{moves:?}");
    assert_eq!(prepared.shot.layers[0].pins[1].weight, 0.5);
    assert!(prepared.notes.iter().all(|note| !note.contains("mirrored pins are reflected")), "{:?}", prepared.notes);
}

#[test]
fn a_plate_is_mirrored_about_its_middle() {
    let text = "plate = \"a.####.png\"\nframes = { first = 1, last = 4 }\nsize = [192, 108]\n[[layer]]\n[[layer.pin]]\nname = \"a\"\n\
                anchor = { screen = [0.4, 0.5] }\nkeys = [{ frame = 1, offset = [0.05, 0.1], rotate = 30 }]\n\
                [[layer.pin]]\nname = \"b\"\nmirror = \"a\"\n";
    let shot = Shot::parse(text, Path::new("plate.toml")).expect("a right shot");
    let prepared = PreparedShot::new(shot).expect("a plate needs no scene");
    let states = prepared.sample_at(1.0).expect("solved").layers[0].pins.clone();
    let middle = 192.0 / 108.0 / 2.0;
    assert!((states[1].rest.0.x - (2.0 * middle - 0.4)).abs() < 1e-6, "{:?}", states[1]);
    let moved = (states[1].target - states[1].rest).0;
    assert!((moved - glam::DVec2::new(-0.05, 0.1)).length() < 1e-9, "{moved}");
    let whole = prepared.sample_at(1.0).expect("solved").layers[0].whole.clone().expect("the border rests");
    assert!(whole.ends.iter().zip(&states).all(|(end, state)| (*end - state.target).0.length() < 1e-9));
}

#[test]
fn a_plate_has_no_plane_in_depth() {
    let text = "plate = \"a.####.png\"\nframes = { first = 1, last = 4 }\nsize = [192, 108]\n[[layer]]\n\
                symmetry = { axis = \"z\", at = 0.5 }\n";
    let error = fault(text);
    assert!(error.contains("symmetry.axis: pictures and plates have no depth"), "{error}");
}

fn fault(text: &str) -> String {
    Shot::parse(text, Path::new("shot.toml")).expect_err(text).to_string()
}

#[test]
fn what_cannot_be_followed_is_named() {
    let head = "scene = 'a.glb'\nframes = { first = 1, last = 2 }\n";
    let text = |layers: &str| format!("{head}{layers}");
    let good = layer("");
    assert!(Shot::parse(&text(&good), Path::new("shot.toml")).is_ok());
    for (from, to, says) in [
        ("mirror = \"hand.L\"", "mirror = \"hand.M\"", "layer 'all' has no pin 'hand.M'; did you mean \"hand."),
        ("mirror = \"hand.L\"", "mirror = \"hand.R\"", "a pin cannot follow itself"),
        ("mirror = \"hand.L\"", "mirror = { layer = \"leg\", pin = \"hand.L\" }", "there is no layer 'leg'"),
        (
            "mirror = \"hand.L\"",
            "mirror = \"hand.L\"\nkeys = [{ frame = 1 }]",
            "takes this from the pin that it follows",
        ),
        ("name = \"hand.L\"", "name = \"hand.L\"\nmirror = \"hand.R\"", "the pin that it names is mirrored itself"),
        ("mirror = \"hand.L\"", "", "layer[0].pin[1].anchor: is missing"),
        ("name = \"all\"", "name = \"all\"\nsymmetry = { axis = \"w\", at = 0 }", "symmetry.axis"),
    ] {
        let error = fault(&text(&good.replacen(from, to, 1)));
        assert!(error.contains(says), "{to}: {says:?} is not in: {error}");
    }
}

#[test]
fn a_model_without_symmetry_asks_for_a_plane() {
    // A spiral staircase.
    let mut part = grid("Quad", [0.0, 0.0, 1.0, 1.0], 8);
    for point in &mut part.positions {
        let (angle, radius) = (3.0 * point[0], (0.1 + 0.3 * point[0]) * (0.4 + 0.6 * point[1]));
        *point = [radius * angle.cos(), radius * angle.sin() - 0.1, 0.5 * point[0] * point[0] + 0.2 * point[1]];
    }
    let studio = Studio::tiny(&Tiny::of(vec![part]), &layer("{ frame = 1, offset = [0.05, 0.1] }"));
    let error = PreparedShot::new(studio.shot.clone()).expect_err("a twisted sheet");
    assert!(matches!(error, PipelineError::Mismatch { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("layer[0].pin[1].mirror") && text.contains("symmetry = { axis"), "{text}");
}
