//! Stiffness painted in a shot, and regions of pins, in the solved lattice.

use super::support::Studio;
use super::tiny::{Part, Tiny, grid};
use pinwarp::pipeline::{OpenShot, PipelineError, PreparedShot, Rework};
use pinwarp::shot::{BrushStroke, ColorChannel, PinRegion, Shot, StiffPart, StiffnessRule};
use pinwarp::space::ScreenPoint;
use std::path::Path;

/// Two sheets side by side, pulled apart at their outer corners.
fn sheets() -> Studio {
    let parts = vec![grid("Left", [-0.4, -0.2, 0.0, 0.2], 6), grid("Right", [0.0, -0.2, 0.4, 0.2], 6)];
    let pin = |name: &str, x: f64, y: f64, by: f64| {
        format!(
            "[[layer.pin]]\nname = \"{name}\"\nanchor = {{ screen = [{x}, {y}], frame = 1 }}\n\
             keys = [{{ frame = 1, offset = [{by}, 0.0] }}]\n"
        )
    };
    let pins =
        [pin("a", 0.42, 0.32, -0.1), pin("b", 0.42, 0.68, -0.1), pin("c", 1.18, 0.32, 0.1), pin("d", 1.18, 0.68, 0.1)];
    Studio::tiny(&Tiny::of(parts), &format!("[[layer]]\nname = \"all\"\n{}", pins.concat()))
}

/// How far a horizontal piece of the frame around a point is stretched.
fn stretch(prepared: &PreparedShot, [x, y]: [f64; 2]) -> f64 {
    let sample = prepared.sample_at(1.0).expect("a solvable frame");
    let lattice = &sample.layers[0].solution.as_ref().expect("a warped layer").lattice;
    let [a, b] = [-0.05, 0.05].map(|by| lattice.warp(ScreenPoint::new(x + by, y)).0.x);
    (b - a) / 0.1 - 1.0
}

fn rule(part: StiffPart, value: f64) -> StiffnessRule {
    StiffnessRule { part, value }
}

#[test]
fn a_stiff_node_stretches_less() {
    let mut studio = sheets();
    let share = |studio: &Studio| stretch(&studio.prepared(), [0.6, 0.5]) / stretch(&studio.prepared(), [1.0, 0.5]);
    assert!((share(&studio) - 1.0).abs() < 0.02, "{}", share(&studio));
    studio.shot.layers[0].stiffness = vec![rule(StiffPart::Nodes(vec!["Le*".into()]), 8.0)];
    assert!(share(&studio) < 0.4, "{}", share(&studio));
    studio.shot.layers[0].stiffness.push(rule(StiffPart::Nodes(vec!["Left".into()]), 0.125));
    assert!((share(&studio) - 1.0).abs() < 0.02, "values multiply: {}", share(&studio));
}

#[test]
fn a_brush_stroke_stiffens_what_it_covers_and_a_later_one_erases() {
    let mut studio = sheets();
    let share = |studio: &Studio| stretch(&studio.prepared(), [0.6, 0.5]) / stretch(&studio.prepared(), [1.0, 0.5]);
    let stroke = |value: f64| BrushStroke {
        nodes: vec!["Le*".into()],
        points: vec![[-0.2, -0.2, 0.0], [-0.2, 0.2, 0.0]],
        radius: 0.5,
        value,
    };
    studio.shot.layers[0].strokes = vec![stroke(8.0)];
    let painted = share(&studio);
    assert!(painted < 0.4, "{painted}");
    studio.shot.layers[0].strokes.push(stroke(8.0));
    assert!((share(&studio) - painted).abs() < 1e-9, "paint over paint is the same paint");
    studio.shot.layers[0].strokes.push(stroke(1.0));
    assert!((share(&studio) - 1.0).abs() < 0.02, "{}", share(&studio));
    studio.shot.layers[0].strokes = vec![BrushStroke { points: vec![[9.0; 3]], ..stroke(8.0) }];
    let note = |notes: &[String]| notes.iter().any(|note| note.contains("1 brush stroke of its stiffness"));
    assert!(note(&studio.prepared().notes), "{:?}", studio.prepared().notes);
    studio.shot.layers[0].strokes = vec![BrushStroke { nodes: vec!["Lift".into()], ..stroke(8.0) }];
    let error = PreparedShot::new(studio.shot.clone()).err().map(|error| error.to_string());
    assert!(error.as_ref().is_some_and(|text| text.contains("no node matches 'Lift'")), "{error:?}");
}

#[test]
fn a_stroke_does_not_reach_what_lies_behind_or_beside_it() {
    // Two sheets, one behind the other, and a third beside them that they do not touch.
    let mut behind = grid("Behind", [-0.4, -0.3, 0.4, 0.3], 8);
    behind.positions.iter_mut().for_each(|place| place[2] -= 0.1);
    let parts = vec![grid("Front", [-0.4, -0.3, 0.4, 0.3], 8), behind, grid("Beside", [0.45, -0.3, 0.7, 0.3], 4)];
    let mut studio = Studio::tiny(&Tiny::of(parts), "[[layer]]\nname = \"all\"\n");
    studio.shot.layers[0].strokes =
        vec![BrushStroke { nodes: Vec::new(), points: vec![[0.3, 0.0, 0.0]], radius: 0.3, value: 8.0 }];
    let prepared = studio.prepared();
    let sample = prepared.sample_at(1.0).expect("a solvable frame");
    let triangles = prepared.stiff_triangles(&sample);
    let count = triangles.len();
    assert!(count > 0);
    studio.shot.layers[0].strokes[0].nodes = vec!["Front".into()];
    let prepared = studio.prepared();
    let sample = prepared.sample_at(1.0).expect("a solvable frame");
    assert_eq!(prepared.stiff_triangles(&sample).len(), count, "only the front was painted");
}

#[test]
fn notes_about_strokes_vanish_with_them() {
    let mut studio = sheets();
    let stroke = BrushStroke { nodes: Vec::new(), points: vec![[9.0; 3]], radius: 0.5, value: 8.0 };
    let mut open = OpenShot::new(studio.shot.clone()).expect("it loads");
    let notes = |open: &OpenShot| open.prepared().notes.iter().filter(|note| note.contains("brush stroke")).count();
    let before = open.prepared().notes.clone();
    studio.shot.layers[0].strokes = vec![stroke.clone(), stroke];
    assert_eq!(open.edit(studio.shot.clone()).expect("it fits"), Rework::Stiffness);
    assert_eq!(notes(&open), 1);
    studio.shot.layers[0].strokes.pop();
    open.edit(studio.shot.clone()).expect("it fits");
    assert_eq!(notes(&open), 1, "{:?}", open.prepared().notes);
    studio.shot.layers[0].strokes.clear();
    open.edit(studio.shot.clone()).expect("it fits");
    assert_eq!(open.prepared().notes, before);
}

#[test]
fn a_region_keeps_its_shape_and_goes_with_its_pin() {
    let mut studio = sheets();
    let at = [0.47, 0.38];
    let plain = stretch(&studio.prepared(), at);
    studio.shot.layers[0].pins[0].region = Some(PinRegion { radius: 0.45, rigidity: 1.0, stiffness: 1.0 });
    let held = stretch(&studio.prepared(), at);
    assert!(plain > 0.01 && held.abs() < 0.5 * plain, "{held} {plain}");
}

fn refusal(part: StiffPart) -> String {
    let mut studio = Studio::teapot(64, 36);
    studio.shot.layers[0].stiffness = vec![rule(part, 2.0)];
    match PreparedShot::new(studio.shot.clone()) {
        Err(error @ PipelineError::Mismatch { .. }) => error.to_string(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_the_scene_does_not_have_is_named() {
    let text = refusal(StiffPart::Nodes(vec!["Taepot".into()]));
    assert!(text.contains("no node matches 'Taepot'") && text.contains("Teapot"), "{text}");
    let text = refusal(StiffPart::Nodes(vec!["Table".into()]));
    assert!(text.contains("it has no meshes of Table"), "{text}");
    let text = refusal(StiffPart::Material("Glase".into()));
    assert!(text.contains("none of its meshes has the material 'Glase'") && text.contains("\"Glaze\""), "{text}");
    let text = refusal(StiffPart::VertexColor(ColorChannel::R));
    assert!(text.contains("none of its meshes has vertex colours"), "{text}");
}

#[test]
fn lines_cannot_be_stiff() {
    let line = Part { triangles: vec![[0, 1, 2]], ..grid("Line", [-0.2, -0.2, 0.2, 0.2], 1) };
    let mut scene = Tiny::of(vec![line, grid("Quad", [0.2, -0.2, 0.6, 0.2], 1)]).json();
    scene["meshes"][0]["primitives"][0]["mode"] = serde_json::json!(3);
    let mut studio = Studio::of_json(&scene, "[[layer]]\nname = \"all\"\n");
    let mut refused = |name: &str| {
        studio.shot.layers[0].stiffness = vec![rule(StiffPart::Nodes(vec![name.into()]), 2.0)];
        PreparedShot::new(studio.shot.clone()).err().map(|error| error.to_string())
    };
    let text = refused("Line").expect("nothing of it can be stiff");
    assert!(text.contains("layer[0].stiffness[0].nodes") && text.contains("lines only"), "{text}");
    assert_eq!(refused("*"), None, "some of it has triangles");
}

#[test]
fn materials_and_vertex_colours_count() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/gingerman/shot.toml");
    let solved = |rules: Vec<StiffnessRule>| {
        let mut shot = Shot::read(&path).expect("a right shot");
        shot.layers[0].stiffness = rules;
        let middle = f64::from(shot.frames.first.midpoint(shot.frames.last));
        let sample = PreparedShot::new(shot).expect("it fits its scene").sample_at(middle).expect("a solvable frame");
        sample.layers[0].solution.as_ref().expect("a warped layer").lattice.clone()
    };
    let plain = solved(Vec::new());
    assert_eq!(solved(vec![rule(StiffPart::Material("Dough".into()), 1.0)]), plain);
    assert_ne!(solved(vec![rule(StiffPart::Material("Dough".into()), 9.0)]), plain);
    assert_ne!(solved(vec![rule(StiffPart::VertexColor(ColorChannel::R), 9.0)]), plain);
}
