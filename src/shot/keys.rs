//! Keys at a time: eases, interpolation, `step` and `strength`.
//!
//! In: a [`Layer`](super::Layer) and a frame, which may lie between frames. Out: [`PinTargets`].

use super::ease::eased;
use super::{Ease, FrameRange, Goal, HandleTrack, Layer, Pin, PinKey, PinTarget, PinTargets, Shot};
use crate::space::{ScreenPoint, ScreenVector};

impl Shot {
    /// What the keys of layer `layer` say at a (fractional) frame, its step and strength applied.
    ///
    /// With a step of 2 and more the keys are read at the frame where the step began, between frames too; a step of 1
    /// holds nothing, so that pins blur within a frame. Empty where there is no such layer.
    ///
    /// ```
    /// use pinwarp::shot::{Goal, Shot};
    /// use pinwarp::space::ScreenVector;
    /// let text = "scene = 'pot.glb'
    /// frames = { first = 1, last = 24 }
    /// [[layer]]
    /// [[layer.pin]]
    /// anchor = { screen = [0.5, 0.5] }
    /// keys = [ { frame = 1, offset = [0, 0] }, { frame = 5, offset = [0.5, 0] } ]";
    /// let shot = Shot::parse(text, "pot.toml".as_ref())?;
    /// assert_eq!(shot.pin_targets(0, 2.0).pins[0].goal, Goal::Offset(ScreenVector::new(0.125, 0.0)));
    /// # Ok::<(), pinwarp::shot::ShotError>(())
    /// ```
    #[must_use]
    pub fn pin_targets(&self, layer: usize, frame: f64) -> PinTargets {
        let Some(layer) = self.layers.get(layer) else { return PinTargets::default() };
        let frame = held_frame(&self.frames, layer.step, frame);
        PinTargets {
            pins: layer.pins.iter().map(|pin| pin_at(pin, frame, layer.strength)).collect(),
            handles: layer.handles.iter().map(|handle| handle_at(handle, layer, frame)).collect(),
        }
    }
}

/// The frame whose keys count at `frame`.
fn held_frame(frames: &FrameRange, step: u32, frame: f64) -> f64 {
    if step <= 1 {
        return frame;
    }
    let (first, step) = (f64::from(frames.first), f64::from(step));
    first + ((frame - first) / step).floor() * step
}

fn pin_at(pin: &Pin, frame: f64, strength: f64) -> PinTarget {
    let Some(place) = Place::of(&pin.keys, frame, |key| (key.frame, key.ease)) else {
        return PinTarget { goal: Goal::Offset(ScreenVector::default()), rotation: None, log_scale: None };
    };
    let goal = match (place.from.goal, place.to.goal) {
        (Goal::Target(from), Goal::Target(to)) => Goal::Target(ScreenPoint(from.0.lerp(to.0, place.weight))),
        (from, to) => Goal::Offset(ScreenVector(from.offset().0.lerp(to.offset().0, place.weight) * strength)),
    };
    // Rotation and scale are held as soon as one key of the pin says so; a key that is silent means 0 and 1.
    let scalar = |value: fn(&PinKey) -> Option<f64>| {
        let is_held = pin.keys.iter().any(|key| value(key).is_some());
        let mixed = mix(value(place.from).unwrap_or(0.0), value(place.to).unwrap_or(0.0), place.weight);
        is_held.then_some(mixed * strength)
    };
    PinTarget {
        goal,
        rotation: scalar(|key| key.rotate_degrees.map(f64::to_radians)),
        log_scale: scalar(|key| key.scale.map(f64::ln)),
    }
}

impl Goal {
    /// The offset; zero for a target (no pin mixes both).
    fn offset(self) -> ScreenVector {
        match self {
            Self::Offset(offset) => offset,
            Self::Target(_) => ScreenVector::default(),
        }
    }
}

fn handle_at(handle: &HandleTrack, layer: &Layer, frame: f64) -> [f64; 2] {
    let Some(place) = Place::of(&handle.keys, frame, |key| (key.frame, key.ease)) else { return [0.0; 2] };
    let (from, to) = (place.from.offset, place.to.offset);
    [0, 1].map(|axis| mix(from[axis], to[axis], place.weight) * layer.strength)
}

/// Exact at both ends.
fn mix(from: f64, to: f64, weight: f64) -> f64 {
    from * (1.0 - weight) + to * weight
}

/// Where a time lies among keys.
struct Place<'a, K> {
    from: &'a K,
    to: &'a K,
    /// 0: all `from`, 1: all `to`; an ease may overshoot.
    weight: f64,
}

impl<'a, K> Place<'a, K> {
    /// Before the first and after the last key the value holds. `None` without keys.
    fn of(keys: &'a [K], frame: f64, timing: impl Fn(&K) -> (f64, Ease)) -> Option<Self> {
        let after = keys.partition_point(|key| timing(key).0 <= frame);
        let Some(from) = after.checked_sub(1).and_then(|index| keys.get(index)) else {
            return keys.first().map(|key| Self { from: key, to: key, weight: 0.0 });
        };
        let Some(to) = keys.get(after) else { return Some(Self { from, to: from, weight: 0.0 }) };
        let ((start, ease), (end, _)) = (timing(from), timing(to));
        Some(Self { from, to, weight: eased(ease, (frame - start) / (end - start)) })
    }
}
