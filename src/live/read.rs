//! Reads a shot file into parameters, with its pins and their keys, for hosts that keep keys themselves.
//!
//! In: a [`ShotShape`]. Out: a [`ShotFile`]; warnings about what the parameters cannot express.

use super::base_scene::BaseScene;
use super::layer_places::LayerPlaces;
use super::{Controls, LiveError, Pin, PinRegion, ShapeSource, ShotShape, solve};
use crate::pipeline::{PinAnchor, PreparedShot, RestPoint};
use crate::plate::Filter;
use crate::shot::{Ease, FrameRange, Goal, Layer, OffsetUnit, PinKey, PinTargets, Rotation};
use crate::space::{FrameSize, ScreenPoint, ScreenVector};
use crate::spelling::pluralised;

/// The contents of a shot file as parameters.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ShotFile {
    /// The layer's lattice, and its pins at the shape's frame. Strength and smoothness are 1, since those of the file stay in force.
    pub controls: Controls,
    /// One per pin of the controls.
    pub tracks: Vec<PinTrack>,
    /// Name of the layer.
    pub layer: String,
    /// Filter for colour; `None`: not set in the file.
    pub filter: Option<Filter>,
    /// First and last frame.
    pub frames: [i32; 2],
    /// Warnings about what the parameters do not express, or not exactly.
    pub warnings: Vec<String>,
}

impl ShotFile {
    /// Summarises for the user what was read, for a host with `most` pins.
    #[must_use]
    pub(crate) fn summary(&self, most: usize) -> String {
        let count = self.tracks.len();
        let mut parts = vec![format!("read {} of layer {}", pluralised(count.min(most), "pin", "pins"), self.layer)];
        if count > most {
            let more = pluralised(count - most, "more is", "more are");
            parts.push(format!("{more} skipped: at most {most} fit"));
        }
        if self.tracks.iter().any(|track| track.keys.len() > 1) {
            parts.push("between keys, the host's interpolation applies".to_owned());
        }
        parts.extend(self.warnings.iter().cloned());
        parts.join("; ")
    }
}

/// A pin over time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PinTrack {
    /// Name in the file.
    pub name: String,
    /// Position in the frame in which pins are placed.
    pub rest: ScreenPoint,
    /// Keys, with increasing frames.
    pub keys: Vec<TrackKey>,
    /// The region that moves with the pin.
    pub region: Option<PinRegion>,
}

/// The values of a pin at a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TrackKey {
    /// Frame of the key.
    pub frame: f64,
    /// [`Pin::target`] at the key.
    pub target: ScreenPoint,
    /// [`Pin::rotation`] at the key, in radians.
    pub rotation: Option<f64>,
    /// [`Pin::scale`] at the key.
    pub scale: Option<f64>,
    /// Easing of the segment that starts at this key.
    pub ease: Ease,
}

/// Maximum number of frames with keys of a pin, which bounds a host's infinite ranges.
const MAX_FRAMES: i32 = 100_000;

impl PinTrack {
    /// Samples a host's animated pin: a key at every frame from its first to its last key and at every key of the host,
    /// so that the shape of the curves is kept. `pin_at` evaluates the pin at a time, `offset` is the frame minus the
    /// time. A pin without keys gets a single one at `now`.
    #[must_use]
    pub(crate) fn sampled(
        name: String,
        times: &[f64],
        [now, offset]: [f64; 2],
        pin_at: impl Fn(f64) -> Option<Pin>,
    ) -> Self {
        let mut times: Vec<f64> = times.iter().copied().filter(|time| time.is_finite()).collect();
        let [first, last] = [f64::min, f64::max].map(|pick| times.iter().copied().reduce(pick));
        if let (Some(first), Some(last)) = (first, last) {
            let last = last.min(first + f64::from(MAX_FRAMES));
            times.extend((first.ceil() as i32..=last.floor() as i32).map(f64::from));
        } else {
            times.push(now);
        }
        times.sort_by(f64::total_cmp);
        times.dedup();
        let pin = pin_at(now);
        let (rest, region) = pin.map_or_else(Default::default, |pin| (pin.rest, pin.region));
        let key = |time: f64| {
            let Pin { rest: was, target, rotation, scale, .. } = pin_at(time)?;
            Some(TrackKey { frame: time + offset, target: rest + (target - was), rotation, scale, ease: Ease::Linear })
        };
        Self { name, rest, region, keys: times.into_iter().filter_map(key).collect() }
    }
}

/// Reads the layer's pins. A [`warp`](super::warp) over the same shape with these controls and
/// [`OwnPins::LeftOut`](super::OwnPins::LeftOut) equals that of the shot itself.
///
/// # Errors
/// [`LiveError`] if the file is invalid or does not fit its scene.
pub(crate) fn read_shot(shape: &ShotShape, frame: FrameSize) -> Result<ShotFile, LiveError> {
    let base = solve::base(&ShapeSource::Shot(shape.clone()), frame)?;
    let prepared = base.prepared.as_ref().expect("shots have a scene");
    let (layer, places) = (&prepared.shot.layers[base.layer], LayerPlaces::new(prepared, base.layer));
    Reader { prepared, layer, index: base.layer, shape, places }.read(&base)
}

struct Reader<'a> {
    prepared: &'a PreparedShot,
    layer: &'a Layer,
    index: usize,
    shape: &'a ShotShape,
    places: LayerPlaces<'a>,
}

impl Reader<'_> {
    fn read(&self, base: &BaseScene) -> Result<ShotFile, LiveError> {
        let [nx, ny, _] = self.layer.space.dims();
        let rests = self.prepared.rests_of(base.layer, f64::from(self.shape.pin_frame));
        let points: Vec<ScreenPoint> = rests.iter().map(|rest| rest.point).collect();
        let casts = self.prepared.cast(self.shape.pin_frame, &points);
        let now = self.targets_now();
        let (mut pins, mut tracks, mut warnings) = (Vec::new(), Vec::new(), Vec::new());
        for (number, (rest, cast)) in rests.iter().zip(&casts).enumerate() {
            warnings.extend(self.doubts(number, rest, cast.as_ref()));
            let goal = |goal, frame| self.offset(number, goal, frame);
            let target = &now.pins[number];
            let rotation = match target.rotation {
                Some(Rotation::InView(angle)) => Some(angle),
                _ => None,
            };
            let offset = goal(target.goal, self.shape.frame)?;
            pins.push(Pin {
                rest: rest.point,
                target: rest.point + offset,
                rotation,
                scale: target.log_scale.map(f64::exp),
                region: self.region(number),
                ..Pin::new(rest.point, rest.point)
            });
            let keys = values_of(&self.layer.pins[number], self.prepared.shot.frames);
            let keys = keys
                .into_iter()
                .map(|(goal_of_key, key)| Ok(TrackKey { target: rest.point + goal(goal_of_key, key.frame)?, ..key }));
            let name = self.layer.pins[number].name.clone();
            let keys = keys.collect::<Result<_, LiveError>>()?;
            tracks.push(PinTrack { name, rest: rest.point, keys, region: self.region(number) });
        }
        let controls = Controls { dims: [nx, ny], basis: self.layer.basis, pins, ..Controls::default() };
        let frames = [self.prepared.shot.frames.first, self.prepared.shot.frames.last];
        let filter = self.prepared.shot.lines.has("warp.filter").then_some(self.prepared.shot.warp.filter);
        Ok(ShotFile { controls, tracks, layer: self.layer.name.clone(), filter, frames, warnings })
    }

    /// Returns the targets of the pins' keys at the shape's frame, without strength.
    fn targets_now(&self) -> PinTargets {
        let layer = Layer { strength: 1.0, ..self.layer.clone() };
        let frame = self.prepared.key_frame(&layer, self.prepared.mid_exposure_time(self.shape.frame));
        layer.pin_path(&self.prepared.shot.frames, frame).pop().unwrap_or_default()
    }

    /// Returns the offset of a goal from the position of the pin's point at a frame.
    fn offset(&self, number: usize, goal: Goal, frame: f64) -> Result<ScreenVector, LiveError> {
        let unit = self.layer.pins[number].unit;
        match goal {
            Goal::Offset(offset) if unit == OffsetUnit::Frame => Ok(offset),
            Goal::Offset(offset) => {
                let [width, height] = self.places.box_size(frame)?;
                Ok(ScreenVector::new(offset.0.x * width, offset.0.y * height))
            }
            Goal::Target(target) => Ok(target - self.places.rest(number, frame)),
            // These goals belong to layers in scene space.
            Goal::SceneOffset(_) | Goal::SceneTarget(_) => Ok(ScreenVector::default()),
        }
    }

    /// Returns the region of a pin, in frame heights.
    fn region(&self, number: usize) -> Option<PinRegion> {
        let pin = &self.layer.pins[number];
        let region = pin.region.filter(|_| pin.unit == OffsetUnit::Frame)?;
        Some(PinRegion { radius: region.radius, rigidity: region.rigidity, stiffness: region.stiffness })
    }

    /// Returns warnings about what the parameters of a pin do not express exactly.
    fn doubts(&self, number: usize, rest: &RestPoint, cast: Option<&PinAnchor>) -> Vec<String> {
        let pin = &self.layer.pins[number];
        let frame = self.shape.pin_frame;
        let told = |what: String| format!("pin '{}' {what}", pin.name);
        let mut doubts = Vec::new();
        let own = self.prepared.anchors_of(self.index)[number];
        match (own, cast) {
            _ if rest.presence <= 0.0 => {
                doubts.push(told(format!("is behind the camera in frame {frame}: place pins in another frame")))
            }
            (
                PinAnchor::Surface { part, corners, .. },
                Some(PinAnchor::Surface { part: other, corners: found, .. }),
            ) if part == *other && corners.iter().any(|corner| found.contains(corner)) => {}
            (PinAnchor::Surface { .. }, _) => {
                doubts
                    .push(told(format!("is hidden in frame {frame}: placed there, it would stick to another surface")));
            }
            (PinAnchor::Screen(_), Some(_)) if self.prepared.shot.scene().is_some() => {
                doubts.push(told("is fixed on the screen in the file: here it sticks to the model".into()));
            }
            (PinAnchor::Screen(_), _) => {}
        }
        if pin.unit == OffsetUnit::Box || matches!(pin.keys.first().map(|key| key.goal), Some(Goal::Target(_))) {
            doubts.push(told("has goals relative to the box or the screen: they are exact only at its keys".into()));
        }
        if has_own_channels(pin) {
            doubts.push(told("keys its rotation or scale on frames of their own: it gets a key in every frame".into()));
        }
        if pin.region.is_some() && pin.unit == OffsetUnit::Box {
            doubts.push(told("has a region measured relative to the box, which only the file can express".into()));
        }
        doubts
    }
}

const fn has_own_channels(pin: &crate::shot::Pin) -> bool {
    !pin.rotate_keys.is_empty() || !pin.scale_keys.is_empty()
}

/// Returns goals and keys of a pin, whose targets follow from the goals. If channels have keys of their own, there is a key in every
/// frame of the shot between the first and the last, which keeps the motion of all.
fn values_of(pin: &crate::shot::Pin, frames: FrameRange) -> Vec<(Goal, TrackKey)> {
    let in_view = |rotation: Option<Rotation>| match rotation {
        Some(Rotation::InView(angle)) => Some(angle),
        _ => None,
    };
    let target = ScreenPoint::default();
    if !has_own_channels(pin) {
        let own = |key: &PinKey| {
            let rotation = in_view(key.rotate_degrees).map(f64::to_radians);
            (key.goal, TrackKey { frame: key.frame, target, rotation, scale: key.scale, ease: key.ease })
        };
        return pin.keys.iter().map(own).collect();
    }
    let mut times: Vec<f64> = pin.key_frames().collect();
    times.sort_by(f64::total_cmp);
    if let [first, .., last] = *times.as_slice() {
        let inner = (frames.first..=frames.last).map(f64::from).filter(|frame| (first..last).contains(frame));
        times.extend(inner.take(MAX_FRAMES as usize));
        times.sort_by(f64::total_cmp);
    }
    times.dedup();
    let sampled = |frame: f64| {
        let now = pin.keyed_target(frame);
        let (rotation, scale) = (in_view(now.rotation), now.log_scale.map(f64::exp));
        (now.goal, TrackKey { frame, target, rotation, scale, ease: Ease::Linear })
    };
    times.into_iter().map(sampled).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_host_s_curve_gets_a_key_at_every_frame_and_at_its_own() {
        let at = |time: f64| Some(Pin::new(ScreenPoint::new(0.0, time), ScreenPoint::new(time * time, time)));
        let track = PinTrack::sampled("nose".into(), &[4.0, 1.5, 2.0, f64::NAN], [2.0, 100.0], at);
        let found: Vec<[f64; 2]> = track.keys.iter().map(|key| [key.frame, key.target.0.x]).collect();
        assert_eq!(found, [[101.5, 2.25], [102.0, 4.0], [103.0, 9.0], [104.0, 16.0]]);
        // A target that moves with the rest position has no offset from it.
        assert!(track.keys.iter().all(|key| key.target.0.y == track.rest.0.y), "{track:?}");
        assert_eq!(PinTrack::sampled("still".into(), &[], [7.0, 0.0], at).keys.len(), 1);
    }

    #[test]
    fn a_pin_whose_rotation_has_own_keys_gets_a_key_in_every_frame() {
        let text = "scene = 'a.glb'\nframes = { first = 1, last = 24 }\n[[layer]]\n[[layer.pin]]\n\
                    anchor = { screen = [0.5, 0.5], frame = 1 }\n\
                    keys = [{ frame = 1, offset = [0, 0], ease = 'hold' }, { frame = 3, offset = [0.2, 0] }]\n";
        let values = |text: &str| {
            let shot = crate::shot::Shot::parse(text, "a.toml".as_ref()).expect("a shot");
            values_of(&shot.layers[0].pins[0], shot.frames)
        };
        let plain: Vec<_> = values(text).iter().map(|(_, key)| (key.frame, key.rotation, key.ease)).collect();
        assert_eq!(plain, [(1.0, None, Ease::Hold), (3.0, None, Ease::Linear)]);
        let own = format!("{text}rotate_keys = [{{ frame = 2.5, value = 0 }}, {{ frame = 5, value = 100 }}]");
        let wanted =
            [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.5, 0.0, 0.0], [3.0, 0.2, 20.0], [4.0, 0.2, 60.0], [5.0, 0.2, 100.0]];
        let found = values(&own);
        assert_eq!(found.len(), wanted.len());
        for ((goal, key), [frame, x, degrees]) in found.into_iter().zip(wanted) {
            let (Goal::Offset(offset), Some(angle)) = (goal, key.rotation) else { unreachable!("{goal:?}") };
            assert!((offset.0.x - x).abs() < 1e-12 && (angle.to_degrees() - degrees).abs() < 1e-9, "{key:?}");
            assert_eq!((key.frame, key.scale, key.ease), (frame, None, Ease::Linear));
        }
    }
}
