//! Layers of parts of meshes: by nodes, joints, materials, vertex colours and masks; what is left of them; and no seams.

use super::assets::asset;
use super::support::{Studio, at, pixels};
use super::tiny::{Part, Tiny, grid};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use pinwarp::export::gltf::BakedShape;
use pinwarp::image::Frame;
use pinwarp::pipeline::{BakeTimes, LayerAssignment, PreparedShot};
use pinwarp::shot::Shot;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::path::Path;

/// Metres from the middle of the mesh to its left border, and back: the mesh is 0.8 m wide.
const HALF: f32 = 0.4;

/// A mesh of 16 x 16 squares around the middle.
fn quad() -> Tiny {
    Tiny::of(vec![grid("Quad", [-HALF, -HALF, HALF, HALF], 16)])
}

/// A layer with a pin in the middle of its half of the mesh, moved sideways by a tenth of the frame.
fn layer(name: &str, keys: &str) -> String {
    format!("[[layer]]\nname = \"{name}\"\n{keys}\nlattice = {{ dims = [6, 6] }}\n")
}

/// Adds numbers a vertex to the only primitive of a mesh.
fn with_attribute(mut scene: Value, name: &str, kind: &str, numbers: &[f32]) -> Value {
    let list = |scene: &Value, name: &str| scene[name].as_array().map_or(0, Vec::len);
    let bytes: &[u8] = bytemuck::cast_slice(numbers);
    let (buffer, view, accessor) = (list(&scene, "buffers"), list(&scene, "bufferViews"), list(&scene, "accessors"));
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes));
    let vertices = scene["accessors"][0]["count"].clone();
    let mut push = |list: &str, item: Value| scene[list].as_array_mut().expect("a list").push(item);
    push("buffers", json!({ "byteLength": bytes.len(), "uri": uri }));
    push("bufferViews", json!({ "buffer": buffer, "byteLength": bytes.len() }));
    push("accessors", json!({ "bufferView": view, "componentType": 5126, "count": vertices, "type": kind }));
    scene["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
    scene
}

/// Places of the vertices of the mesh, left to right and up.
fn places(tiny: &Tiny) -> &[[f32; 3]] {
    &tiny.parts[0].positions
}

/// Red goes from 0 at the left border to 1 at the right one.
fn colored() -> Value {
    let tiny = quad();
    let colors: Vec<f32> = places(&tiny).iter().flat_map(|[x, ..]| [(x + HALF) / (2.0 * HALF), 0.0, 1.0]).collect();
    with_attribute(tiny.json(), "COLOR_0", "VEC3", &colors)
}

/// u goes from left to right, v from the upper to the lower border.
fn unwrapped() -> Value {
    let tiny = quad();
    let side = 2.0 * HALF;
    let uvs: Vec<f32> = places(&tiny).iter().flat_map(|[x, y, _]| [(x + HALF) / side, (HALF - y) / side]).collect();
    with_attribute(tiny.json(), "TEXCOORD_0", "VEC2", &uvs)
}

/// The weight of a layer at every vertex of the first part.
fn weights(assignment: &LayerAssignment, layer: usize) -> Vec<f32> {
    let shared = assignment.shared_parts[0].as_ref().expect("the mesh is shared");
    let column = shared.layers.iter().position(|&own| own == layer).expect("the layer has some of it");
    (0..shared.weights.len() / shared.layers.len()).map(|vertex| shared.at(vertex as u32)[column]).collect()
}

/// Places of the vertices of the first part, as the scene has them once it is loaded.
fn loaded(prepared: &PreparedShot) -> Vec<glam::Vec3> {
    prepared.scene.meshes[0].primitives[0].positions.clone()
}

fn fault(studio: &Studio) -> String {
    PreparedShot::new(studio.shot.clone()).expect_err("it does not fit").to_string()
}

/// Writes a picture of one channel beside the scene of a studio.
fn paint(studio: &Studio, size: [u32; 2], grey: impl Fn(u32, u32) -> u8) {
    let picture = image::GrayImage::from_fn(size[0], size[1], |x, y| image::Luma([grey(x, y)]));
    picture.save(studio.scene().with_file_name("mask.png")).expect("the folder can be written to");
}

#[test]
fn a_later_layer_takes_what_it_names_and_the_rest_is_what_is_left() {
    let square = |name, x: f32| Part { ..grid(name, [x - 0.1, -0.1, x + 0.1, 0.1], 2) };
    let tiny = Tiny::of(vec![square("arm_l", -0.4), square("arm_r", -0.1), square("body", 0.2), square("ground", 0.5)]);
    let owners = |layers: &str| Studio::tiny(&tiny, layers).prepared().assignment.layer_of_part;
    let [all, arms] = [layer("all", ""), layer("arms", "nodes = [\"arm_*\"]")];
    assert_eq!(owners(&(all.clone() + &arms)), [Some(1), Some(1), Some(0), Some(0)]);
    let but_one = layer("but", "nodes = [\"!arm_l\", \"!ground\"]");
    assert_eq!(owners(&but_one), [None, Some(0), Some(0), None]);
    let one_arm = layer("one", "nodes = [\"arm_*\", \"!arm_l\"]");
    let rest = layer("rest", "nodes = \"rest\"");
    assert_eq!(owners(&(one_arm.clone() + &rest)), [Some(1), Some(0), Some(1), Some(1)]);
    assert_eq!(owners(&(rest.clone() + &one_arm)), [Some(0), Some(1), Some(0), Some(0)]);
    let told = fault(&Studio::tiny(&tiny, &(arms.clone() + &all)));
    assert!(told.contains("layer 'arms': later layers take all that it names; move its [[layer]] behind"), "{told}");
    let told = fault(&Studio::tiny(&tiny, &(all + &rest)));
    assert!(told.contains("layer 'rest': nothing is left"), "{told}");
    let told = fault(&Studio::tiny(&tiny, &layer("a", "nodes = [\"arm_*\", \"!am_l\"]")));
    assert!(told.contains("layer[0].nodes: layer 'a': no node matches 'am_l'; did you mean \"arm_l\"?"), "{told}");
}

#[test]
fn vertex_colours_weigh_as_they_are_painted() {
    let studio = Studio::of_json(&colored(), &layer("right", "select = { vertex_color = \"r\" }"));
    let prepared = studio.prepared();
    for (weight, place) in weights(&prepared.assignment, 0).iter().zip(loaded(&prepared)) {
        assert!((weight - (place.x + HALF) / (2.0 * HALF)).abs() < 1e-5, "{place}: {weight}");
    }
    let blue = Studio::of_json(&colored(), &layer("all", "select = { vertex_color = \"b\" }"));
    assert_eq!(blue.prepared().assignment.shared_parts, [None], "it is 1 everywhere");
    let told = fault(&Studio::of_json(&colored(), &layer("none", "select = { vertex_color = \"g\" }")));
    assert!(told.contains("layer 'none': no vertex of its meshes is coloured in its channel"), "{told}");
    let told = fault(&Studio::tiny(&quad(), &layer("none", "select = { vertex_color = \"r\" }")));
    assert!(told.contains("none of its meshes has vertex colours; export them with it (COLOR_0)"), "{told}");
}

#[test]
fn a_mask_is_painted_over_the_uvs() {
    let keys =
        |more: &str| layer("left", &format!("select = {{ mask = {{ file = \"mask.png\"{more} }}, feather = 0.0 }}"));
    let studio = Studio::of_json(&unwrapped(), &keys(""));
    // White in the upper left quarter.
    paint(&studio, [64, 64], |x, y| if x < 32 && y < 32 { 255 } else { 0 });
    let prepared = studio.prepared();
    for (weight, place) in weights(&prepared.assignment, 0).iter().zip(loaded(&prepared)) {
        if place.x.abs() > 0.02 && place.y.abs() > 0.02 {
            assert_eq!(*weight, f32::from(u8::from(place.x < 0.0 && place.y > 0.0)), "{place}");
        }
    }
    // Grey counts as it is shown.
    paint(&studio, [8, 8], |_, _| 128);
    assert!(weights(&studio.prepared().assignment, 0).iter().all(|weight| (weight - 128.0 / 255.0).abs() < 1e-3));
    paint(&studio, [8, 8], |_, _| 0);
    assert!(fault(&studio).contains("no vertex of its meshes is white in its mask"), "{}", fault(&studio));
    std::fs::write(studio.scene().with_file_name("mask.png"), b"no picture").expect("written");
    let told = fault(&studio);
    assert!(told.contains("layer[0].select.mask.file: layer 'left': ") && told.contains("mask.png"), "{told}");
    std::fs::rename(studio.scene().with_file_name("mask.png"), studio.scene().with_file_name("maske.png"))
        .expect("moved");
    assert!(fault(&studio).contains("there is no file") && fault(&studio).contains("maske.png"), "{}", fault(&studio));
    let other_set = Studio::of_json(&unwrapped(), &keys(", texcoord = 1"));
    paint(&other_set, [8, 8], |_, _| 255);
    assert!(fault(&other_set).contains("has UVs (TEXCOORD_1)"), "{}", fault(&other_set));
    let bare = Studio::tiny(&quad(), &keys(""));
    paint(&bare, [8, 8], |_, _| 255);
    assert!(fault(&bare).contains("has UVs (TEXCOORD_0) that a mask could lie on"), "{}", fault(&bare));
}

#[test]
fn a_mask_of_another_shape_than_the_texture_is_refused() {
    let Some(fox) = asset("gltf-samples/Fox.glb") else { return };
    let studio = studio(&fox, "side", &layer("head", "select = { mask = { file = \"mask.png\" } }"));
    let mask = studio.scene().with_file_name("mask.png");
    let folder = tempfile::tempdir().expect("a folder");
    let mut shot = studio.shot.clone();
    if let Some(rule) = &mut shot.layers[0].selection.mask {
        rule.file = folder.path().join("mask.png");
    }
    assert!(!mask.exists());
    let save = |width, height| {
        let picture = image::GrayImage::from_pixel(width, height, image::Luma([128]));
        picture.save(folder.path().join("mask.png")).expect("written");
    };
    save(192, 108);
    let told = PreparedShot::new(shot.clone()).expect_err("it has another shape").to_string();
    assert!(told.contains("the mask has 192 x 108 pixels, the texture of 'fox' on the same UVs"), "{told}");
    save(96, 96);
    assert!(PreparedShot::new(shot).is_ok(), "another size of the same shape will do");
}

/// Two materials on one mesh, left and right of the middle, vertices doubled where they meet.
fn two_materials() -> Value {
    let half = |name, x0: f32, x1: f32| grid(name, [x0, -HALF, x1, HALF], 16);
    let mut scene = Tiny::of(vec![half("Quad", -HALF, 0.0), half("Other", 0.0, HALF)]).json();
    let other = scene["meshes"][1]["primitives"][0].clone();
    scene["meshes"][0]["primitives"].as_array_mut().expect("a list").push(other);
    scene["nodes"][1].as_object_mut().expect("a node").remove("mesh");
    scene["materials"][0]["name"] = json!("Skin");
    scene["materials"][1]["name"] = json!("Fur");
    scene
}

#[test]
fn materials_of_one_mesh_meet_without_a_seam() {
    let pin = |at: [f64; 2], by: f64| {
        format!(
            "[[layer.pin]]\nanchor = {{ screen = {at:?}, frame = 1 }}\nkeys = [{{ frame = 1, offset = [0.0, {by}] }}]\n"
        )
    };
    let layers = layer("skin", "select = { materials = [\"Skin\"] }")
        + &pin([0.5, 0.5], 0.15)
        + &layer("fur", "select = { materials = [\"!Skin\"] }")
        + &pin([1.1, 0.5], -0.15);
    let studio = Studio::of_json(&two_materials(), &layers);
    let prepared = studio.prepared();
    let shared: Vec<bool> = prepared.assignment.shared_parts.iter().map(Option::is_some).collect();
    assert_eq!(shared, [true, true], "each goes on into the other over the feather");
    no_vertex_comes_apart(&prepared, 1, 17);
    let frame = studio.frame(1);
    assert_eq!(holes(&frame), 0);
    let told = fault(&Studio::of_json(&two_materials(), &layer("a", "select = { materials = [\"Fir\"] }")));
    assert!(told.contains("layer[0].select.materials") && told.contains("did you mean \"Fur\"?"), "{told}");
}

#[test]
fn a_mesh_without_a_skin_has_no_joints() {
    let told = fault(&Studio::tiny(&quad(), &layer("arm", "select = { joints = [\"Arm*\"] }")));
    assert!(told.contains("layer[0].select.joints: layer 'arm': none of its meshes has a skin"), "{told}");
}

#[test]
fn what_a_layer_has_only_a_little_of_moves_only_a_little() {
    let pin = "[[layer.pin]]\nname = \"p\"\nanchor = { screen = [0.75, 0.5], frame = 1 }\nkeys = [{ frame = 1, offset = [0.0, 0.1] }]\n";
    let studio = Studio::of_json(&colored(), &(layer("right", "select = { vertex_color = \"r\" }") + pin));
    let told = studio.prepared().notes;
    assert!(
        told.iter().any(|note| note.contains("pin 'p' sits on 'Quad', where the layer moves 44 % of the mesh")),
        "{told:?}"
    );
}

#[test]
fn a_pin_on_the_screen_where_its_layer_is_not_seen_is_told() {
    let notes = |at: &str| {
        let pin = format!("[[layer.pin]]\nname = \"p\"\nanchor = {{ screen = {at} }}\n");
        let hold = "[[layer.pin]]\nname = \"q\"\nanchor = { screen = [0.75, 0.5], frame = 1 }\n";
        let notes = Studio::tiny(&quad(), &(layer("all", "") + &pin + hold)).prepared().notes;
        notes.into_iter().filter(|note| note.contains("pin 'p' is fixed on the screen")).collect::<Vec<_>>()
    };
    let told = notes("[0.02, 0.97]");
    assert!(told.len() == 1 && told[0].contains("at 0.02, 0.97, where the layer is not seen in frame 1"), "{told:?}");
    assert!(notes("[0.75, 0.5]").is_empty());
}

/// A shot of a file, seen by one of the views.
fn studio(scene: &Path, view: &str, layers: &str) -> Studio {
    let text = format!(
        "version = 1\nscene = {scene:?}\ncamera = {view:?}\nframes = {{ first = 1, last = 9, rate = 24 }}\nsize = [320, 240]\n\
         samples = 1\n{layers}"
    );
    Studio::of_shot(Shot::parse(&text, Path::new("shot.toml")).expect("a right shot"))
}

/// Pixels without anything between two covered ones, across or up.
fn holes(frame: &Frame) -> usize {
    let is_covered = |x: i32, y: i32| at(frame, "A", x, y) > 0.5;
    let is_hole = |&(x, y): &(i32, i32)| {
        let across = is_covered(x - 1, y) && is_covered(x + 1, y);
        !is_covered(x, y) && (across || is_covered(x, y - 1) && is_covered(x, y + 1))
    };
    pixels(frame).filter(is_hole).count()
}

/// Vertices that lie on one point before the warp lie on one point after it, to the bit; and there are `least` such points.
fn no_vertex_comes_apart(prepared: &PreparedShot, frame: i32, least: usize) {
    let at_rest = {
        let mut shot = prepared.shot.clone();
        shot.layers.iter_mut().for_each(|layer| layer.strength = 0.0);
        shot.layers.iter_mut().flat_map(|layer| &mut layer.pins).for_each(|pin| pin.keys.clear());
        PreparedShot::with_scene(shot, prepared.scene.clone()).expect("it fits")
    };
    let shapes = |prepared: &PreparedShot| -> Vec<(usize, BakedShape)> {
        let baked = prepared.bake(&[frame], BakeTimes::Clip, |_| true, |_| {}).expect("it is solved");
        let nodes = baked.nodes.into_iter();
        nodes.flat_map(|node| node.parts.into_iter().map(move |part| (node.node, part.shapes[0].clone()))).collect()
    };
    let mut places: HashMap<(usize, [u32; 3]), Vec<[u32; 3]>> = HashMap::new();
    let mut moved = 0.0_f32;
    for ((node, rest), (_, warped)) in shapes(&at_rest).iter().zip(&shapes(prepared)) {
        for (from, to) in rest.positions.iter().zip(&warped.positions) {
            moved = moved.max(from.distance(*to));
            let bits = |place: glam::Vec3| place.to_array().map(f32::to_bits);
            places.entry((*node, bits(*from))).or_default().push(bits(*to));
        }
    }
    assert!(moved > 0.0, "something moves");
    let doubled = places.values().filter(|ends| ends.len() > 1);
    assert!(doubled.clone().count() >= least, "{}", doubled.count());
    for (from, ends) in places.iter().filter(|(_, ends)| ends.len() > 1) {
        assert!(ends.iter().all(|end| *end == ends[0]), "{from:?} comes apart: {ends:?}");
    }
}

/// Pins at the points of the unwarped picture, each moved by so much.
fn pin(at: [f64; 2], by: [f64; 2]) -> String {
    format!("[[layer.pin]]\nanchor = {{ screen = {at:?}, frame = 1 }}\nkeys = [{{ frame = 1, offset = {by:?} }}]\n")
}

#[test]
fn head_and_tail_of_the_fox_move_apart_from_its_body() {
    let Some(fox) = asset("gltf-samples/Fox.glb") else { return };
    let layers = layer("head", "select = { joints = [\"b_Neck*\"] }")
        + &pin(FOX_HEAD, [0.0, 0.12])
        + &layer("tail", "select = { joints = [\"b_Tail01*\"] }")
        + &pin(FOX_TAIL, [0.0, -0.12])
        + &layer("body", "nodes = \"rest\"");
    let studio = studio(&fox, "side", &layers);
    let mut prepared = studio.prepared();
    no_vertex_comes_apart(&prepared, 1, 250);
    let (warped, still) = (studio.frame_of(&mut prepared, 1), unpinned(&studio).frame(1));
    assert!(holes(&warped) <= holes(&still), "{} {}", holes(&warped), holes(&still));
    // Every layer is seen, and head and tail went where their pins say while the feet stay.
    let middle = |frame: &Frame, layer: f32| {
        let own: Vec<i32> =
            pixels(frame).filter(|&(x, y)| at(frame, "id.layer", x, y) == layer).map(|(_, y)| y).collect();
        own.iter().sum::<i32>() as f64 / own.len() as f64
    };
    let by = |layer: f32| (middle(&warped, layer) - middle(&still, layer)) / 240.0;
    let lowest = |frame: &Frame| pixels(frame).filter(|&(x, y)| at(frame, "A", x, y) > 0.5).map(|(_, y)| y).max();
    assert!((-0.14..-0.06).contains(&by(1.0)) && (0.04..0.14).contains(&by(2.0)), "{} {}", by(1.0), by(2.0));
    assert_eq!(lowest(&warped), lowest(&still));
    let told = fault(&self::studio(&fox, "side", &layer("head", "select = { joints = [\"b_Nack_04\"] }")));
    assert!(told.contains("no joint matches 'b_Nack_04'; did you mean \"b_Neck_04\"?"), "{told}");
}

#[test]
fn the_knights_trunk_bends_at_his_hips_without_a_seam() {
    let Some(knight) = asset("kaykit/Knight.glb") else { return };
    let nodes = "nodes = [\"Knight_*\"]";
    let layers = layer("lower", nodes)
        + &layer("upper", &format!("{nodes}\nselect = {{ joints = [\"spine\"] }}"))
        + &pin([0.646, 0.4], [0.12, 0.08]);
    let studio = studio(&knight, "front", &layers);
    let mut prepared = studio.prepared();
    let shared = prepared.assignment.shared_parts.iter().flatten().count();
    assert!(shared >= 1, "the trunk hangs on both");
    no_vertex_comes_apart(&prepared, 1, 100);
    let (warped, still) = (studio.frame_of(&mut prepared, 1), unpinned(&studio).frame(1));
    assert!(holes(&warped) <= holes(&still), "{} {}", holes(&warped), holes(&still));
    let seen = |layer: f32| pixels(&warped).filter(|&(x, y)| at(&warped, "id.layer", x, y) == layer).count();
    assert!(seen(1.0) > 200 && seen(2.0) > 200, "{} {}", seen(1.0), seen(2.0));
}

/// A layer: its name, its keys, and its pins with their moves.
type PinnedLayer<'a> = (&'a str, &'a str, &'a [[[f64; 2]; 2]]);

/// The same shot without pins.
fn unpinned(studio: &Studio) -> Studio {
    let mut shot = studio.shot.clone();
    shot.layers.iter_mut().for_each(|layer| layer.pins.clear());
    Studio::of_shot(shot)
}

/// Checks that layers which bend where they meet leave no seam, whether their lattices are coarse, plain, or have branches of their own.
fn no_seam_opens((scene, view): (&Path, &str), layers: &[PinnedLayer], least: usize) {
    // Layers without pins do not move, whatever their lattices.
    let mut still = None;
    for (lattice, branches) in [
        ("dims = [6, 6]", None),
        ("dims = [24, 18], topology = \"plain\"", Some(0)),
        ("dims = [24, 18], topology = \"branching\"", Some(layers.len())),
    ] {
        let layer = |(name, keys, pins): &PinnedLayer| {
            let pins: String = pins.iter().map(|&[at, by]| pin(at, by)).collect();
            format!("[[layer]]\nname = \"{name}\"\n{keys}\nlattice = {{ {lattice} }}\n{pins}")
        };
        let mut studio = studio(scene, view, &layers.iter().map(layer).collect::<String>());
        // One frame is looked at.
        studio.shot.layers.iter_mut().for_each(|layer| layer.settings.temporal = 0.0);
        let mut prepared = studio.prepared();
        let sample = prepared.sample_at(1.0).expect("it is solved");
        let solutions = sample.layers.iter().filter_map(|layer| layer.solution.as_ref());
        let found = solutions.filter(|solution| solution.branches.is_some()).count();
        assert!(branches.is_none_or(|branches| branches == found), "{lattice}: {found} layers branch");
        no_vertex_comes_apart(&prepared, 1, least);
        let still = *still.get_or_insert_with(|| holes(&unpinned(&studio).frame(1)));
        let warped = holes(&studio.frame_of(&mut prepared, 1));
        // Toes and fingers have gaps of a pixel between them; a seam is as long as the border of two layers.
        assert!(warped < still + 30, "{lattice}: {warped} pixels are open, {still} at rest");
    }
}

#[test]
fn layers_of_one_mesh_that_bend_leave_no_seam_at_any_dims() {
    if let Some(fox) = asset("gltf-samples/Fox.glb") {
        let layers: &[PinnedLayer] = &[
            ("head", "select = { joints = [\"b_Neck*\"] }", &[[FOX_HEAD, [0.0, 0.12]], [[0.3, 0.6], [0.0, 0.02]]]),
            ("tail", "select = { joints = [\"b_Tail01*\"] }", &[[FOX_TAIL, [0.0, -0.12]], [[1.2, 0.3], [0.05, 0.0]]]),
            (
                "body",
                "nodes = \"rest\"",
                &[
                    [[0.4, 0.3], [0.12, 0.06]],
                    [[0.6, 0.6], [0.0, 0.0]],
                    [[0.9, 0.3], [0.0, 0.05]],
                    [[0.8, 0.5], [0.0, 0.0]],
                ],
            ),
        ];
        no_seam_opens((fox.as_path(), "side"), layers, 250);
    }
    if let Some(knight) = asset("kaykit/Knight.glb") {
        let upper = "nodes = [\"Knight_*\"]\nselect = { joints = [\"spine\"] }";
        let layers: &[PinnedLayer] = &[
            (
                "lower",
                "nodes = [\"Knight_*\"]",
                &[[[0.6, 0.1], [-0.1, 0.0]], [[0.8, 0.1], [0.0, 0.0]], [[0.6, 0.3], [0.0, 0.0]]],
            ),
            ("upper", upper, &[[[0.646, 0.4], [0.12, 0.08]], [[0.8, 0.5], [0.05, -0.1]], [[0.5, 0.5], [0.0, 0.0]]]),
        ];
        no_seam_opens((knight.as_path(), "front"), layers, 100);
    }
}

/// Points of the fox in the unwarped picture.
const FOX_HEAD: [f64; 2] = [0.19, 0.69];
const FOX_TAIL: [f64; 2] = [1.1, 0.375];
