//! The published schema, the reference page and the template say what the program does.

use super::parse;
use pinwarp::shot::template::{self, ClipFact, Subject, TemplateFacts};
use pinwarp::shot::{CameraRule, OffsetUnit, Rotation, Shot, schema};
use pinwarp::solve::Topology;
use pinwarp::space::FrameSize;
use serde_json::Value;
use std::path::PathBuf;

fn doc(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("docs").join(name)
}

#[test]
fn the_published_schema_is_up_to_date() {
    let path = doc("shot.schema.json");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, schema()).unwrap();
    }
    let published = std::fs::read_to_string(&path).unwrap();
    assert!(published == schema(), "docs/shot.schema.json is stale: run the tests with UPDATE=1");
}

/// All keys of all tables of a schema.
fn keys(schema: &Value, found: &mut Vec<String>) {
    if let Some(properties) = schema.get("properties").and_then(Value::as_object) {
        found.extend(properties.keys().cloned());
    }
    match schema {
        Value::Object(rules) => rules.values().for_each(|rule| keys(rule, found)),
        Value::Array(rules) => rules.iter().for_each(|rule| keys(rule, found)),
        _ => {}
    }
}

#[test]
fn every_key_is_in_the_reference() {
    let reference = std::fs::read_to_string(doc("SHOT.md")).unwrap();
    let mut found = Vec::new();
    keys(&serde_json::from_str(&schema()).unwrap(), &mut found);
    assert!(found.len() > 40, "{found:?}");
    for key in found {
        let is_row = reference.contains(&format!("| `{key}` |")) || reference.contains(&format!("`{key}`: "));
        assert!(is_row, "docs/SHOT.md says nothing about `{key}`");
    }
}

#[test]
fn the_example_of_the_reference_is_a_shot() {
    let reference = std::fs::read_to_string(doc("SHOT.md")).unwrap();
    let example = reference.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    assert_eq!(parse(example).unwrap().layers[0].pins.len(), 1);
}

fn facts() -> TemplateFacts {
    TemplateFacts {
        subject: Subject::Scene,
        can_branch: false,
        cameras: vec!["Cam \"A\"".to_owned(), "B".to_owned()],
        has_camera: true,
        clips: vec![ClipFact { name: "Walk\nfast".to_owned(), secs: 1.5 }],
        spare_nodes: vec!["Sword".to_owned(), "Axe".to_owned()],
        mesh_nodes: (0..30).map(|i| format!("Mesh.{i}")).collect(),
        frames: [1, 48],
        rate: 29.97,
        size: FrameSize { width: 1440, height: 1080, pixel_aspect: 1.333 },
    }
}

/// Takes the single # at the start of lines away.
fn uncommented(text: &str) -> String {
    let line = |line: &str| {
        let is_example = line.trim_start().starts_with("# ");
        if is_example { line.replacen("# ", "", 1) } else { line.to_owned() }
    };
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn the_template_is_a_working_shot_without_pins() {
    let shot = parse(&template::write("my scene.glb", &facts())).unwrap();
    assert_eq!(shot.scene(), Some(std::path::Path::new("shots/my scene.glb")));
    assert_eq!(shot.camera, CameraRule::Named("Cam \"A\"".to_owned()));
    assert_eq!((shot.frames.first, shot.frames.last, shot.frames.rate), (1, 48, 29.97));
    assert_eq!(shot.size, facts().size);
    assert!(shot.layers[0].pins.is_empty() && shot.layers[0].handles.is_empty());
}

#[test]
fn the_examples_of_the_template_work_when_uncommented() {
    let text = uncommented(&template::write("a.glb", &facts()));
    let shot = parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let layer = &shot.layers[0];
    assert_eq!((layer.pins.len(), layer.handles.len(), layer.nodes.len()), (1, 1, 1));
    assert_eq!((layer.pins[0].unit, layer.pins[0].keys.len()), (OffsetUnit::Frame, 2));
    assert_eq!(
        (layer.pins[0].keys[1].rotate_degrees, layer.pins[0].keys[1].scale),
        (Some(Rotation::InView(10.0)), Some(1.1))
    );
}

#[test]
fn the_template_suits_a_bare_scene_of_one_frame() {
    let bare = TemplateFacts {
        subject: Subject::Scene,
        can_branch: true,
        cameras: Vec::new(),
        has_camera: false,
        clips: Vec::new(),
        spare_nodes: Vec::new(),
        mesh_nodes: Vec::new(),
        frames: [1, 1],
        rate: 24.0,
        size: FrameSize::new(64, 64),
    };
    let text = template::write("a.glb", &bare);
    assert!(text.contains("no camera: one that shows the whole scene is used"), "{text}");
    let shot = parse(&text).unwrap();
    assert_eq!(shot.frames.count(), 1);
    assert_eq!(shot.layers[0].settings.topology, Topology::Branching);
    assert!(shot.layers[0].has_auto_dims);
    parse(&uncommented(&text)).unwrap();
}

#[test]
fn the_shots_that_come_with_the_program_are_valid() {
    let scenes = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let shots: Vec<PathBuf> = std::fs::read_dir(scenes)
        .unwrap()
        .map(|entry| entry.unwrap().path().join("shot.toml"))
        .filter(|path| path.exists())
        .collect();
    assert!(!shots.is_empty());
    for path in shots {
        let shot = Shot::read(&path).unwrap_or_else(|error| panic!("{error}"));
        let Some(scene) = shot.scene() else { continue };
        assert!(scene.exists(), "{}: {} is not there", path.display(), scene.display());
    }
}

/// Work that grows with the square of the number of keys takes ten minutes here.
#[test]
fn a_hundred_thousand_keys_are_read_and_their_lines_known() {
    let keys: Vec<String> =
        (1..=100_000).map(|frame| format!("    {{ frame = {frame}, offset = [0.0, 0.1] }},\n")).collect();
    let head = "scene = 'pot.glb'\nframes = { first = 1, last = 100000 }\n[[layer]]\n[[layer.pin]]\n";
    let text = format!("{head}anchor = {{ screen = [0.5, 0.5] }}\nkeys = [\n{}]\n", keys.concat());
    let shot = Shot::parse(&text, std::path::Path::new("shot.toml")).expect("a good shot");
    assert_eq!(shot.layers[0].pins[0].keys.len(), 100_000);
    assert_eq!(shot.lines.of("layer[0].pin[0].keys[99999].frame"), 7 + 99_999);
    let wrong = text.replace("{ frame = 99999, offset", "{ frame = 99999, ofset");
    let error = Shot::parse(&wrong, std::path::Path::new("shot.toml")).expect_err("a misspelt key").to_string();
    assert!(error.starts_with("shot.toml:100005: layer[0].pin[0].keys[99998].ofset"), "{error}");
}
