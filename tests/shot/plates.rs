//! Shots that warp finished frames: what they may say, and what they may not.

use super::{GOOD, parse, replaced};
use pinwarp::plate::{Filter, Holes, Matte, MotionEncoding, MotionUnit, NormalMode, Semantic};
use pinwarp::shot::{BoxRule, LayerSpace, Shot, Source, Unmatted};
use std::path::{Path, PathBuf};

/// A shot without a scene. Tests count its lines.
const PLATE: &str = r#"plate  = "in/beauty.####.exr"
frames = { first = 1, last = 3 }
size   = [200, 100]

[warp]
filter   = "cubic"
normals  = "rotate"
motion   = { unit = "frame", y = "down" }
channels = [{ name = "zz.*", meaning = "depth" }]
holes    = { plate = "in/clean.%04d.exr" }

[[layer]]
matte = { cryptomatte = ["Body*"], of = "CryptoObject" }

  [[layer.pin]]
  anchor = { screen = [0.5, 0.5] }
  keys   = [{ frame = 1, offset = [0.1, 0.0] }]
"#;

#[test]
fn a_shot_over_a_plate_is_read_in_full() {
    let shot = parse(PLATE).unwrap();
    assert_eq!((shot.source, shot.plate), (Source::Frame, Some(PathBuf::from("shots/in/beauty.####.exr"))));
    assert_eq!((shot.warp.filter, shot.warp.normals), (Filter::Cubic, NormalMode::Rotate));
    assert_eq!(shot.warp.motion, Some(MotionEncoding { pixels_per_unit: [1.0, -1.0] }));
    assert_eq!(shot.warp.motion_scale, MotionUnit::Frame);
    assert_eq!(shot.warp.semantics, [("zz.*".to_owned(), Semantic::Depth)]);
    assert_eq!(shot.warp.holes, Holes::Plate("shots/in/clean.%04d.exr".into()));
    let layer = &shot.layers[0];
    assert_eq!(layer.space, LayerSpace::Screen { dims: [10, 10], bounds: BoxRule::Frame });
    let names = vec!["Body*".to_owned()];
    assert_eq!(layer.matte, Some(Matte::Cryptomatte { layer: Some("CryptoObject".into()), names }));
}

#[test]
fn mattes_are_written_in_four_ways() {
    let matte = |text: &str| {
        let shot = parse(&replaced(PLATE, "{ cryptomatte = [\"Body*\"], of = \"CryptoObject\" }", text)).unwrap();
        shot.layers[0].matte.clone()
    };
    assert_eq!(matte("\"alpha\""), Some(Matte::Alpha));
    assert_eq!(matte("\"none\""), None);
    assert_eq!(matte("{ channel = \"mask.R\" }"), Some(Matte::Channel("mask.R".into())));
    let id = Matte::Id { channel: "id.object".into(), values: vec![3, 4_294_967_295] };
    assert_eq!(matte("{ id = \"id.object\", values = [3, 4294967295] }"), Some(id));
    let names = Matte::Cryptomatte { layer: None, names: vec!["a".into()] };
    assert_eq!(matte("{ cryptomatte = [\"a\"] }"), Some(names));
}

#[test]
fn a_layer_without_a_matte_says_whether_it_moves_the_whole_picture() {
    let unmatted = |text: &str| {
        parse(&replaced(PLATE, "{ cryptomatte = [\"Body*\"], of = \"CryptoObject\" }", text)).unwrap().layers[0]
            .unmatted
    };
    assert_eq!(unmatted("\"none\""), Unmatted::Picture);
    assert_eq!(unmatted("\"alpha\""), Unmatted::OwnNodes);
}

#[test]
fn motion_is_written_in_units_and_directions() {
    let motion = |text: &str| {
        let shot = parse(&replaced(PLATE, "{ unit = \"frame\", y = \"down\" }", text)).unwrap();
        (shot.warp.motion.unwrap().pixels_per_unit, shot.warp.motion_scale)
    };
    assert_eq!(motion("{}"), ([1.0, 1.0], MotionUnit::Pixels));
    assert_eq!(motion("{ unit = \"pixels\", x = \"left\" }"), ([-1.0, 1.0], MotionUnit::Pixels));
    assert_eq!(motion("{ unit = 32.0, y = \"down\" }"), ([32.0, -32.0], MotionUnit::Pixels));
    assert_eq!(motion("{ unit = 4 }"), ([4.0, 4.0], MotionUnit::Pixels));
}

#[test]
fn a_scene_and_its_plate_stand_side_by_side() {
    let both = parse(&replaced(GOOD, "version = 1", "plate = \"a.####.exr\"\nwarp.holes = \"geometry\"")).unwrap();
    assert_eq!(
        (both.scene(), both.plate.as_deref()),
        (Some(Path::new("shots/teapot.glb")), Some(Path::new("shots/a.####.exr")))
    );
    assert_eq!(both.warp.holes, Holes::Geometry);
    let hash = |text: &str| Shot::parse(text, Path::new("shots/pot.toml")).unwrap().hash();
    assert_ne!(hash(PLATE), hash(&replaced(PLATE, "\"Body*\"", "\"Head*\"")));
    assert_ne!(hash(PLATE), hash(&replaced(PLATE, "\"cubic\"", "\"ewa\"")));
}

#[test]
fn a_plate_may_have_the_sign_of_a_counter_in_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let shot = folder.path().join("shot.toml");
    let text = "plate = \"b##_%s.png\"\nframes = { first = 1, last = 2 }\n[[layer]]\n";
    assert!(Shot::parse(text, &shot).unwrap_err().to_string().contains("shot.toml:1: plate: "));
    image::RgbaImage::new(30, 20).save(folder.path().join("b##_%s.png")).unwrap();
    assert_eq!(Shot::parse(text, &shot).unwrap().size, pinwarp::space::FrameSize::new(30, 20));
}

/// A change of the shot above, the line and key of its fault, and what is said about it.
type Case = ([&'static str; 2], usize, &'static str, &'static str);

#[test]
fn faults_name_line_key_and_remedy() {
    const MATTE: &str = "{ cryptomatte = [\"Body*\"], of = \"CryptoObject\" }";
    let cases: &[Case] = &[
        (["beauty.####.exr", "beauty.##.##.exr"], 1, "plate", "two frame counters"),
        (["clean.%04d", "clean.%s"], 10, "warp.holes.plate", "write #### or %04d"),
        (["{ plate = \"in/clean.%04d.exr\" }", "\"geometry\""], 10, "warp.holes", "has no scene that could fill holes"),
        (["{ plate = \"in/clean.%04d.exr\" }", "\"leaf\""], 10, "warp.holes", "did you mean \"leave\"?"),
        (["\"cubic\"", "\"cubics\""], 6, "warp.filter", "did you mean \"cubic\"?"),
        (["unit = \"frame\"", "unit = \"frames\""], 8, "warp.motion.unit", "did you mean \"frame\"?"),
        (["unit = \"frame\"", "unit = 0"], 8, "warp.motion.unit", "out of range"),
        (["y = \"down\"", "y = \"left\""], 8, "warp.motion.y", "allowed: \"up\", \"down\""),
        (["\"depth\"", "\"deep\""], 9, "warp.channels[0].meaning", "is not known"),
        ([MATTE, "\"alfa\""], 13, "layer[0].matte", "did you mean \"alpha\"?"),
        ([MATTE, "{}"], 13, "layer[0].matte", "does not say what it selects"),
        ([MATTE, "{ channel = \"a\", id = \"b\", values = [1] }"], 13, "layer[0].matte", "or two of them"),
        ([MATTE, "{ id = \"id.object\" }"], 13, "layer[0].matte.values", "values = [3]"),
        ([MATTE, "{ channel = \"a\", of = \"b\" }"], 13, "layer[0].matte.of", "belongs to `cryptomatte`"),
        ([MATTE, "{ channel = \"a\", values = [1] }"], 13, "layer[0].matte.values", "belongs to `id`"),
        ([MATTE, "\"alpha\"\nnodes = [\"a\"]"], 14, "layer[0].nodes", "`matte` selects a part of a plate"),
        ([MATTE, "\"alpha\"\nlattice.space = \"world\""], 14, "layer[0].lattice.space", "warped on the screen"),
        (
            ["{ screen = [0.5, 0.5] }", "{ node = \"a\", triangle = 1, barycentric = [1, 0, 0] }"],
            16,
            "layer[0].pin[0].anchor.node",
            "give a point of the screen",
        ),
    ];
    for ([from, to], line, key, says) in cases {
        let error = parse(&replaced(PLATE, from, to)).expect_err(to).to_string();
        let place = format!("shots/pot.toml:{line}: {key}: ");
        assert!(error.lines().any(|fault| fault.starts_with(&place) && fault.contains(says)), "{to}: {error}");
    }
}

#[test]
fn world_layers_have_no_matte() {
    let shot = replaced(
        GOOD,
        "nodes   = [\"Teapot*\"]\nlattice = { dims = [10, 8], basis = \"bspline\", box = { fixed = [0.1, 0.2, 1.5, 0.9] } }",
        "matte = \"alpha\"\nlattice = { space = \"world\" }",
    );
    let error = parse(&shot).unwrap_err().to_string();
    assert!(error.contains("layer[0].matte: a plate is warped on the screen"), "{error}");
}
