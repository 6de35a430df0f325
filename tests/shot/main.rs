//! The shot file as a user meets it: read in full, every rule broken once, edited, and documented.

#[path = "../support/random.rs"]
mod random;

mod cameras;
mod document;
mod edits;
mod faults;
mod hostile;
mod images;
mod motion;
mod plates;
mod world;

use pinwarp::raster::ChannelGroup;
use pinwarp::shot::{
    Anchor, BoxRule, CameraRule, ClipName, Ease, Goal, LayerSpace, OffsetUnit, Rotation, Shot, ShotError,
};
use pinwarp::solve::{Energy, Regularizer};
use pinwarp::space::{FrameSize, ScreenBox, ScreenPoint, ScreenVector};
use std::path::Path;

/// A shot with most keys there are. Tests count its lines.
const GOOD: &str = r#"version = 1
scene  = "teapot.glb"
camera = "ShotCam"
frames = { first = 1, last = 48, rate = 24, clip = "Walk", clip_start = -3, loop = true }
shutter = { angle = 180 }
size   = [1920, 1080]
environment = 0.5
strength = 0.5

[[layer]]
name    = "body"   # the whole pot
nodes   = ["Teapot*"]
lattice = { dims = [10, 8], basis = "bspline", box = { fixed = [0.1, 0.2, 1.5, 0.9] } }
solve   = { energy = "edge", regularizer = "rest", weights = "cot" }
step    = 2
strength = 4

  [[layer.pin]]
  name   = "spout"
  anchor = { node = "Teapot", primitive = 0, triangle = 312, barycentric = [0.2, 0.5, 0.3005] }
  keys   = [ { frame = 1, offset = [0.0, 0.0] },
             { frame = 12, offset = [0.06, 0.03], rotate = 20, ease = "smooth" } ]

  [[layer.pin]]
  anchor = { screen = [0.91, 0.52], frame = 1 }
  unit = "box"

  [[layer.handle]]
  index = [9, 4]
  keys  = [ { frame = 1, offset = [0, 0] }, { frame = 24, offset = [0, 0.1], ease = { bezier = [0.2, 0, 0.8, 1] } } ]

[output]
path     = "out/teapot.%04d.exr"
channels = ["beauty", "id"]
"#;

fn parse(text: &str) -> Result<Shot, ShotError> {
    Shot::parse(text, Path::new("shots/pot.toml"))
}

/// A change that must find its place.
fn replaced(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from:?} is not in the text");
    text.replacen(from, to, 1)
}

#[test]
fn a_good_shot_is_read_in_full() {
    let shot = parse(GOOD).unwrap();
    assert_eq!(shot.scene(), Some(std::path::Path::new("shots/teapot.glb")));
    assert_eq!(
        (&shot.camera, &shot.clip),
        (&CameraRule::Named("ShotCam".to_owned()), &Some(ClipName::Name("Walk".to_owned())))
    );
    assert_eq!((shot.frames.first, shot.frames.last, shot.frames.clip_start, shot.is_looped), (1, 48, -3, true));
    assert_eq!((shot.frames.count(), shot.frames.seconds(21.0)), (48, 1.0));
    assert_eq!((shot.shutter.angle, shot.shutter.phase, shot.samples), (180.0, -90.0, 16));
    assert_eq!(shot.output.path, Path::new("shots/out/teapot.%04d.exr"));
    assert_eq!(shot.output.channels, [ChannelGroup::Beauty, ChannelGroup::Id]);
    let layer = &shot.layers[0];
    assert_eq!((layer.name.as_str(), layer.step, layer.strength), ("body", 2, 2.0));
    let bounds = ScreenBox::new(ScreenPoint::new(0.1, 0.2), ScreenPoint::new(1.5, 0.9));
    assert_eq!(layer.space, LayerSpace::Screen { dims: [10, 8], bounds: BoxRule::Fixed(bounds) });
    assert_eq!((layer.settings.energy, layer.settings.regularizer), (Energy::Edge, Regularizer::Rest));
    assert_eq!(layer.handles[0].keys[1].ease, Ease::Bezier([0.2, 0.0, 0.8, 1.0]));
}

#[test]
fn pins_are_read_in_full() {
    let shot = parse(GOOD).unwrap();
    let [spout, second] = shot.layers[0].pins.as_slice() else { panic!("two pins") };
    let Anchor::Surface { node, triangle: 312, barycentric, rest: None, .. } = &spout.anchor else { panic!("anchor") };
    assert_eq!(node, "Teapot");
    assert!((barycentric.iter().sum::<f64>() - 1.0).abs() < 1e-15, "0.2 + 0.5 + 0.3005 is made to sum to 1");
    assert_eq!((spout.keys[1].rotate_degrees, spout.keys[1].ease), (Some(Rotation::InView(20.0)), Ease::Smooth));
    assert_eq!((second.name.as_str(), second.unit, second.keys.len()), ("pin2", OffsetUnit::Box, 1));
    assert_eq!(second.keys[0].goal, Goal::Offset(ScreenVector::new(0.0, 0.0)), "without keys a pin holds its place");
    assert_eq!(second.anchor, Anchor::Screen { at: ScreenPoint::new(0.91, 0.52), frame: Some(1) });
}

#[test]
fn omitted_keys_take_the_documented_defaults() {
    let shot = parse("scene = 'a.glb'\nframes = { first = 5, last = 9 }\n[[layer]]\n[[layer]]").unwrap();
    assert_eq!((shot.frames.rate, shot.frames.clip_start, shot.is_looped), (24.0, 5, false));
    assert_eq!((shot.shutter.angle, shot.samples, shot.size), (0.0, 16, FrameSize::new(1920, 1080)));
    assert_eq!((shot.environment, shot.exposure_stops), (None, 0.0));
    assert_eq!(shot.output.path, Path::new("shots/out/pot.####.exr"));
    assert_eq!(shot.output.channels.len(), 5);
    let names: Vec<&str> = shot.layers.iter().map(|layer| layer.name.as_str()).collect();
    assert_eq!(names, ["layer1", "layer2"]);
    let layer = &shot.layers[0];
    assert_eq!(layer.space, LayerSpace::Screen { dims: [10, 10], bounds: BoxRule::Follow });
    assert_eq!((layer.step, layer.strength), (1, 1.0));
    assert_eq!((layer.settings.energy, layer.settings.regularizer), (Energy::Area, Regularizer::Bend));
}

#[test]
fn other_spellings_of_a_choice_are_read() {
    let shot = parse(&replaced(GOOD, "clip = \"Walk\"", "clip = 2")).unwrap();
    assert_eq!(shot.clip, Some(ClipName::Index(2)));
    let shot = parse(&replaced(GOOD, "{ fixed = [0.1, 0.2, 1.5, 0.9] }", "\"frame\"")).unwrap();
    assert_eq!(shot.layers[0].space, LayerSpace::Screen { dims: [10, 8], bounds: BoxRule::Frame });
    let paper = replaced(GOOD, "energy = \"edge\", regularizer = \"rest\", weights = \"cot\"", "preset = \"paper\"");
    let settings = &parse(&paper).unwrap().layers[0].settings;
    assert_eq!((settings.energy, settings.regularizer), (Energy::Edge, Regularizer::Rest));
    let one_frame = replaced(&replaced(GOOD, "last = 48", "last = 1"), "teapot.%04d.exr", "teapot.exr");
    assert_eq!(parse(&one_frame).unwrap().frames.count(), 1);
}

#[test]
fn a_missing_file_is_named() {
    let error = Shot::read(Path::new("no/such/shot.toml")).unwrap_err();
    assert!(error.to_string().starts_with("cannot read no/such/shot.toml: "), "{error}");
}

#[test]
fn the_hash_counts_what_changes_frames_and_nothing_else() {
    let hash = |text: &str| parse(text).unwrap().hash();
    let good = hash(GOOD);
    assert_eq!(good.len(), 32);
    assert_eq!(good, hash(&replaced(GOOD, "# the whole pot", "\n# another comment\n")));
    assert_eq!(good, hash(&replaced(GOOD, "size   = [1920, 1080]", "size=[ 1_920,0x438]")));
    assert_eq!(good, hash(&replaced(GOOD, "out/teapot", "elsewhere/pot")), "where frames go does not change them");
    let moved = Shot::parse(GOOD, Path::new("/home/somebody/other.toml")).unwrap();
    assert_eq!(good, moved.hash(), "nor does where the shot lies");
    for (from, to) in [("0.06, 0.03", "0.06, 0.0300001"), ("teapot.glb", "pot.glb"), ("\"id\"", "\"depth\"")] {
        assert_ne!(good, hash(&replaced(GOOD, from, to)), "{from}");
    }
}
