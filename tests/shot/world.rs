//! Layers of the world in the shot file: what is read, and what is refused with which remedy.

use super::parse;
use pinwarp::shot::{Goal, LayerSpace, Rotation, WorldBoxRule};

/// Tests count its lines.
const WORLD: &str = r#"scene = "bunny.glb"
frames = { first = 3, last = 24 }
[[layer]]
lattice = { space = "world", dims = [5, 6, 7], basis = "bernstein", box = { fixed = [-1, 0, -1, 1, 2, 1] } }
  [[layer.pin]]
  anchor = { screen = [0.9, 0.5], frame = 3 }
  keys   = [ { frame = 3, offset = [0.0, 0.0, 0.0], rotate = [0, 90, 0] }, { frame = 7, offset = [0.4, 0.8, -0.4] } ]
  [[layer.pin]]
  anchor = { screen = [0.2, 0.5], frame = 3 }
  keys   = [ { frame = 3, offset = [0.1, 0.1] }, { frame = 5 } ]
  [[layer.pin]]
  anchor = { screen = [0.3, 0.5], frame = 3 }
  unit   = "box"
  [[layer.handle]]
  index = [4, 5, 6]
  keys  = [ { frame = 3, offset = [0.0, 0.1, 0.2] } ]
"#;

#[test]
fn a_world_layer_is_read_in_full() {
    let shot = parse(WORLD).unwrap();
    let bounds = WorldBoxRule::Fixed([[-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]]);
    assert_eq!(shot.layers[0].space, LayerSpace::World { dims: [5, 6, 7], bounds });
    assert_eq!(shot.layers[0].handles[0].index, [4, 5, 6]);
    let targets = shot.pin_targets(0, 5.0);
    assert_eq!(targets.handles, [[0.0, 0.1, 0.2]]);
    assert_eq!(targets.pins[0].goal, Goal::SceneOffset([0.2, 0.4, -0.2]));
    let Some(Rotation::Axes([0.0, y, 0.0])) = targets.pins[0].rotation else { panic!("{targets:?}") };
    assert!((y - std::f64::consts::FRAC_PI_4).abs() < 1e-12, "half of 90 degrees");
    assert!(
        matches!(targets.pins[1].goal, Goal::Offset(offset) if offset.0.length() == 0.0),
        "a silent key stays dragged"
    );
    assert_eq!(targets.pins[2].goal, Goal::SceneOffset([0.0; 3]), "without keys a pin holds its place");
}

#[test]
fn omitted_keys_take_the_defaults_of_world_layers() {
    let shot = parse("scene = 'a.glb'\nframes = { first = 1, last = 2 }\n[[layer]]\nlattice.space = 'world'").unwrap();
    assert_eq!(shot.layers[0].space, LayerSpace::World { dims: [5; 3], bounds: WorldBoxRule::Follow });
}

#[test]
fn every_rule_names_key_and_remedy() {
    let cases = [
        ("[5, 6, 7]", "[5, 6]", "4: layer[0].lattice.dims: ", "give [x, y, z], for example [5, 5, 5]"),
        ("[5, 6, 7]", "[5]", "4: layer[0].lattice.dims: ", "a list of 2 or 3 whole numbers, found a list of 1"),
        ("[5, 6, 7]", "[40, 40, 40]", "4: layer[0].lattice.dims: ", "the product of all sides within 4096"),
        ("\"world\"", "\"screen\"", "4: layer[0].lattice.dims: ", "add space = \"world\", or give [across, up]"),
        ("\"world\"", "\"wold\"", "4: layer[0].lattice.space: ", "did you mean \"world\"?"),
        ("{ fixed = [-1, 0, -1, 1, 2, 1] }", "\"frame\"", "4: layer[0].lattice.box: ", "give box = \"follow\""),
        ("[-1, 0, -1, 1, 2, 1]", "[-1, 0, 1, 2]", "4: layer[0].lattice.box.fixed: ", "has 6 numbers, found 4"),
        ("[-1, 0, -1, 1, 2, 1]", "[-1, 0, -1, 1, 0, 1]", "4: layer[0].lattice.box.fixed: ", "the lower corner first"),
        ("[0.4, 0.8, -0.4]", "[0.4, 0.8]", "7: layer[0].pin[0].keys[1].offset: ", "give all keys two numbers"),
        ("offset = [0.4, 0.8, -0.4]", "target = [1, 1, 1]", "7: layer[0].pin[0].keys[1].target: ", "all a `target`"),
        ("offset = [0.4, 0.8, -0.4]", "rotate = 90", "7: layer[0].pin[0].keys[1].rotate: ", "give all keys one angle"),
        ("offset = [0.1, 0.1]", "offset = [0.1]", "10: layer[0].pin[1].keys[0].offset: ", "a list of 2 or 3 numbers"),
        ("offset = [0.1, 0.1]", "offset = [54, 0]", "10: layer[0].pin[1].keys[0].offset: ", "54 px of 1080 is 0.05"),
        (
            "unit   = \"box\"",
            "unit = \"box\"\nkeys = [ { frame = 3, offset = [1, 1] } ]",
            "14: layer[0].pin[2].keys[0].offset: ",
            "give [x, y, z], or unit = \"frame\"",
        ),
        ("[0.2, 0.5], frame = 3", "[0.2, 0.5]", "9: layer[0].pin[1].anchor: ", "add frame = 3"),
        ("[4, 5, 6]", "[4, 5]", "15: layer[0].handle[0].index: ", "give 3 whole numbers"),
        ("[4, 5, 6]", "[4, 5, 7]", "15: layer[0].handle[0].index: ", "layers from 0 to 6"),
        ("[0.0, 0.1, 0.2]", "[0.0, 0.1]", "16: layer[0].handle[0].keys[0].offset: ", "give 3 numbers"),
        (
            "[0.0, 0.1, 0.2]",
            "[0.0, 0.1, 99]",
            "16: layer[0].handle[0].keys[0].offset: ",
            "99 box sizes look like pixels",
        ),
    ];
    for (from, to, place, remedy) in cases {
        assert!(WORLD.contains(from), "{from:?}");
        let error = parse(&WORLD.replacen(from, to, 1)).expect_err(to);
        let text = error.to_string();
        let told = error.each().iter().map(ToString::to_string);
        let found = told.filter(|text| text.starts_with(&format!("shots/pot.toml:{place}")) && text.contains(remedy));
        assert_eq!(found.count(), 1, "{from} -> {to}: {place:?} {remedy:?} is not in:\n{text}");
    }
}

#[test]
fn a_screen_layer_refuses_what_needs_the_world() {
    let shot = |pin: &str| {
        format!(
            "scene = 'a.glb'\nframes = {{ first = 1, last = 2 }}\n[[layer]]\n[[layer.pin]]\nanchor.screen = [0, 0]\nkeys = [{{ frame = 1, {pin} }}]"
        )
    };
    for (pin, key) in
        [("offset = [0, 0, 1]", "offset"), ("target = [0, 0, 1]", "target"), ("rotate = [0, 0, 1]", "rotate")]
    {
        let text = parse(&shot(pin)).unwrap_err().to_string();
        assert!(text.starts_with(&format!("shots/pot.toml:6: layer[0].pin[0].keys[0].{key}: has three ")), "{text}");
        assert!(text.contains("lattice = { space = \"world\", dims = [5, 5, 5] }"), "{text}");
    }
}
