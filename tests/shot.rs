//! The shot file as a user meets it: a good one is read in full, every rule has a file that breaks it.

use pinwarp::raster::ChannelGroup;
use pinwarp::shot::{Anchor, BoxRule, ClipName, Ease, Goal, OffsetUnit, Shot, ShotError};
use pinwarp::solve::{Energy, Regularizer};
use pinwarp::space::{ScreenBox, ScreenPoint, ScreenVector};
use std::path::Path;

/// The shot of the design notes, with most keys there are.
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
  keys  = [ { frame = 1, offset = [0.0, 0.0] }, { frame = 24, offset = [0.0, 0.1], ease = { bezier = [0.2, 0, 0.8, 1] } } ]

[output]
path     = "out/teapot.%04d.exr"
channels = ["beauty", "id"]
"#;

fn parse(text: &str) -> Result<Shot, ShotError> {
    Shot::parse(text, Path::new("shots/pot.toml"))
}

#[test]
fn a_good_shot_is_read_in_full() {
    let shot = parse(GOOD).unwrap();
    assert_eq!(shot.scene, Path::new("shots/teapot.glb"));
    assert_eq!((shot.camera.as_deref(), &shot.clip), (Some("ShotCam"), &Some(ClipName::Name("Walk".to_owned()))));
    assert_eq!((shot.frames.first, shot.frames.last, shot.frames.clip_start, shot.is_looped), (1, 48, -3, true));
    assert_eq!((shot.shutter.angle, shot.shutter.phase, shot.samples), (180.0, -90.0, 16));
    assert_eq!(shot.output.path, Path::new("shots/out/teapot.%04d.exr"));
    assert_eq!(shot.output.channels, [ChannelGroup::Beauty, ChannelGroup::Id]);
    let layer = &shot.layers[0];
    assert_eq!((layer.name.as_str(), layer.dims, layer.step, layer.strength), ("body", [10, 8], 2, 2.0));
    let bounds = ScreenBox::new(ScreenPoint::new(0.1, 0.2), ScreenPoint::new(1.5, 0.9));
    assert_eq!(layer.bounds, BoxRule::Fixed(bounds));
    assert_eq!((layer.settings.energy, layer.settings.regularizer), (Energy::Edge, Regularizer::Rest));
    let [spout, second] = layer.pins.as_slice() else { panic!("two pins") };
    let Anchor::Surface { node, triangle: 312, barycentric, rest: None, .. } = &spout.anchor else { panic!("anchor") };
    assert_eq!(node, "Teapot");
    assert!((barycentric.iter().sum::<f64>() - 1.0).abs() < 1e-15, "0.2 + 0.5 + 0.3005 is made to sum to 1");
    assert_eq!((spout.keys[1].rotate_degrees, spout.keys[1].ease), (Some(20.0), Ease::Smooth));
    assert_eq!((second.name.as_str(), second.unit, second.keys.len()), ("pin2", OffsetUnit::Box, 1));
    assert_eq!(second.keys[0].goal, Goal::Offset(ScreenVector::new(0.0, 0.0)), "without keys a pin holds its place");
    assert_eq!(second.anchor, Anchor::Screen { at: ScreenPoint::new(0.91, 0.52), frame: Some(1) });
    assert_eq!(layer.handles[0].keys[1].ease, Ease::Bezier([0.2, 0.0, 0.8, 1.0]));
}
