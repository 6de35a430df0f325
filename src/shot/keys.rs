//! Evaluates keys at a time: eases, interpolation, `step` and `strength`.
//!
//! In: a [`Layer`](super::Layer) and a frame, which may be fractional. Out: [`PinTargets`].

use super::ease::eased;
use super::{Ease, FrameRange, Goal, HandleTrack, Layer, Pin, PinKey, PinTarget, PinTargets, Rotation, Shot};
use crate::space::{ScreenPoint, ScreenVector};

impl Shot {
    /// Evaluates the keys of layer `layer` at a (fractional) frame, with step and strength applied.
    ///
    /// With a step of 2 or more, the keys are evaluated at the frame where the step began, at fractional frames, too;
    /// with a step of 1 they are not held, so that pins blur within a frame. Empty if there is no such layer.
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
        targets_at(layer, &KeyedChannels::of_layer(layer), held_frame(&self.frames, layer.step, frame))
    }

    /// Returns the drawing that layer `layer` shows at a (fractional) frame: the number of the frame whose keys are
    /// held; 0 if nothing is held, or there is no such layer.
    #[must_use]
    pub(crate) fn drawing(&self, layer: usize, frame: f64) -> i64 {
        match self.layers.get(layer) {
            Some(layer) if layer.step > 1 => held_frame(&self.frames, layer.step, frame) as i64,
            _ => 0,
        }
    }
}

/// Maximum number of path points between two key times, one per frame; fast rotations of a pin add more.
const PATH_STEPS: f64 = 8.0;

/// Maximum rotation of a pin between two path points in radians: 30 degrees.
const PATH_TURN: f64 = 0.524;

impl Shot {
    /// Returns the path of layer `layer` up to a (fractional) frame: the keys evaluated from the first key on, at every
    /// key and in between, with strength applied; the last point is [`Self::pin_targets`]. Empty if there is no such
    /// layer.
    ///
    /// A step holds only the last point: pins on twos follow the same path.
    #[must_use]
    pub(crate) fn pin_path(&self, layer: usize, frame: f64) -> Vec<PinTargets> {
        self.layers.get(layer).map(|layer| layer.pin_path(&self.frames, frame)).unwrap_or_default()
    }
}

impl Layer {
    /// Whether anything can move the layer: pins, handles or a transferred lattice.
    #[must_use]
    pub(crate) const fn is_moved(&self) -> bool {
        !self.pins.is_empty() || !self.handles.is_empty() || self.transfer.is_some()
    }

    /// Whether muted pins are all that could move the layer.
    #[must_use]
    pub(crate) fn has_muted_pins_only(&self) -> bool {
        self.is_moved()
            && self.handles.is_empty()
            && self.transfer.is_none()
            && self.pins.iter().all(|pin| pin.is_muted)
    }

    /// Returns the path of the layer up to a (fractional) frame of a shot with these frames, as [`Shot::pin_path`].
    #[must_use]
    pub(crate) fn pin_path(&self, frames: &FrameRange, frame: f64) -> Vec<PinTargets> {
        let held = held_frame(frames, self.step, frame);
        let mut times: Vec<f64> = self.pins.iter().flat_map(Pin::key_frames).collect();
        times.extend(self.handles.iter().flat_map(|handle| handle.keys.iter().map(|key| key.frame)));
        times.retain(|&time| time < held);
        times.push(held);
        times.sort_by(f64::total_cmp);
        times.dedup();
        let channels = KeyedChannels::of_layer(self);
        let mut path = Vec::new();
        for ends in times.windows(2) {
            let count = path_steps(self, &channels, [ends[0], ends[1]]);
            let time = |step: usize| ends[0] + (ends[1] - ends[0]) * step as f64 / count as f64;
            path.extend((0..count).map(|step| targets_at(self, &channels, time(step))));
        }
        path.push(targets_at(self, &channels, held));
        path
    }
}

/// Returns the number of path points between two key times. Within one frame pins move almost straight, and on straight
/// paths no pair of them rotates by half a turn: baked keys, one per frame, need no points in between.
fn path_steps(layer: &Layer, channels: &[KeyedChannels], [from, to]: [f64; 2]) -> usize {
    let angle =
        |(pin, channels): (&Pin, &KeyedChannels), time| match pin_at(pin, *channels, time, layer.strength).rotation {
            Some(Rotation::InView(angle)) => angle,
            // In world space nothing accumulates turns.
            Some(Rotation::Axes(_)) | None => 0.0,
        };
    let winding =
        layer.pins.iter().zip(channels).filter(|(_, channels)| matches!(channels.rotation, Some(Rotation::InView(_))));
    let turns = winding.map(|pin| (angle(pin, to) - angle(pin, from)).abs());
    let most = turns.fold(0.0, f64::max);
    (to - from).clamp(1.0, PATH_STEPS).max(most / PATH_TURN).ceil() as usize
}

/// The channels that a pin's keys use. Rotation and scale are constrained as soon as one key sets them; a key without
/// them means 0 and 1.
#[derive(Clone, Copy)]
struct KeyedChannels {
    /// The first rotation set; its kind is that of all keys.
    rotation: Option<Rotation>,
    is_scaled: bool,
}

impl KeyedChannels {
    /// Determines the channels of a pin. It scans all keys, which may be many.
    fn of(pin: &Pin) -> Self {
        let own_rotation = pin.rotate_keys.first().map(|key| key.value);
        Self {
            rotation: own_rotation.or_else(|| pin.keys.iter().find_map(|key| key.rotate_degrees)),
            is_scaled: !pin.scale_keys.is_empty() || pin.keys.iter().any(|key| key.scale.is_some()),
        }
    }

    /// Determines the channels of every pin; called once per path.
    fn of_layer(layer: &Layer) -> Vec<Self> {
        layer.pins.iter().map(Self::of).collect()
    }
}

impl Pin {
    /// Takes unit and keys of another pin.
    pub(super) fn copy_keys(&mut self, other: &Self) {
        self.unit = other.unit;
        self.keys.clone_from(&other.keys);
        self.rotate_keys.clone_from(&other.rotate_keys);
        self.scale_keys.clone_from(&other.scale_keys);
    }

    /// Returns the frames of all keys, channel by channel.
    pub(crate) fn key_frames(&self) -> impl Iterator<Item = f64> {
        let rotation = self.rotate_keys.iter().map(|key| key.frame);
        self.keys.iter().map(|key| key.frame).chain(rotation).chain(self.scale_keys.iter().map(|key| key.frame))
    }

    /// Whether its only key holds the pin in its place, like that of a pin without keys in the file.
    pub(super) fn rests(&self) -> bool {
        let is_at_rest = |key: &PinKey| {
            let is_zero = match key.goal {
                Goal::Offset(offset) => offset == ScreenVector::default(),
                Goal::SceneOffset(offset) => offset == [0.0; 3],
                Goal::Target(_) | Goal::SceneTarget(_) => false,
            };
            is_zero && key.rotate_degrees.is_none() && key.scale.is_none()
        };
        let has_own_channels = !self.rotate_keys.is_empty() || !self.scale_keys.is_empty();
        matches!(&self.keys[..], [only] if is_at_rest(only)) && !has_own_channels
    }

    /// Evaluates the keys at a (fractional) frame, without the step and strength of the layer.
    #[cfg(any(test, feature = "editor", feature = "ofx"))]
    #[must_use]
    pub(crate) fn keyed_target(&self, frame: f64) -> PinTarget {
        pin_at(self, KeyedChannels::of(self), frame, 1.0)
    }
}

impl HandleTrack {
    /// Whether its only key holds the handle in its place, like that of a handle without keys in the file.
    pub(super) fn rests(&self) -> bool {
        matches!(&self.keys[..], [only] if only.offset == [0.0; 3])
    }
}

#[cfg(feature = "editor")]
impl HandleTrack {
    /// Evaluates the keys at a (fractional) frame, without the step and strength of the layer.
    #[must_use]
    pub(crate) fn keyed_offset(&self, frame: f64) -> [f64; 3] {
        handle_at(self, 1.0, frame)
    }
}

/// Evaluates all keys of a layer at a frame.
fn targets_at(layer: &Layer, channels: &[KeyedChannels], frame: f64) -> PinTargets {
    let pins = layer.pins.iter().zip(channels);
    PinTargets {
        pins: pins.map(|(pin, channels)| pin_at(pin, *channels, frame, layer.strength)).collect(),
        handles: layer.handles.iter().map(|handle| handle_at(handle, layer.strength, frame)).collect(),
    }
}

/// Returns the frame whose keys are in effect at `frame`.
fn held_frame(frames: &FrameRange, step: u32, frame: f64) -> f64 {
    if step <= 1 {
        return frame;
    }
    let (first, step) = (f64::from(frames.first), f64::from(step));
    first + ((frame - first) / step).floor() * step
}

fn pin_at(pin: &Pin, channels: KeyedChannels, frame: f64, strength: f64) -> PinTarget {
    let Some(span) = Span::of(&pin.keys, frame, |key| (key.frame, key.ease)) else {
        return PinTarget { goal: Goal::Offset(ScreenVector::default()), rotation: None, log_scale: None };
    };
    let goal = match (span.from.goal, span.to.goal) {
        (Goal::Target(from), Goal::Target(to)) => Goal::Target(ScreenPoint(from.0.lerp(to.0, span.weight))),
        (Goal::Offset(from), Goal::Offset(to)) => Goal::Offset(ScreenVector(from.0.lerp(to.0, span.weight) * strength)),
        (Goal::SceneTarget(from), Goal::SceneTarget(to)) => Goal::SceneTarget(mix_all(from, to, span.weight)),
        (Goal::SceneOffset(from), Goal::SceneOffset(to)) => {
            Goal::SceneOffset(mix_all(from, to, span.weight).map(|x| x * strength))
        }
        // Validation ensures that a pin's goals are of one kind.
        (from, _) => from,
    };
    let log_scale = match Span::of(&pin.scale_keys, frame, |key| (key.frame, key.ease)) {
        Some(own) => mix(own.from.value.ln(), own.to.value.ln(), own.weight),
        None => {
            let log_scale = |key: &PinKey| key.scale.map_or(0.0, f64::ln);
            mix(log_scale(span.from), log_scale(span.to), span.weight)
        }
    };
    let rotation = channels.rotation.map(|kind| {
        let mixed = match Span::of(&pin.rotate_keys, frame, |key| (key.frame, key.ease)) {
            Some(own) => mix_all(angles(Some(own.from.value)), angles(Some(own.to.value)), own.weight),
            None => mix_all(angles(span.from.rotate_degrees), angles(span.to.rotate_degrees), span.weight),
        };
        radians(kind, mixed, strength)
    });
    PinTarget { goal, rotation, log_scale: channels.is_scaled.then_some(log_scale * strength) }
}

/// Returns the angles of a rotation, of which one in the view has only the first.
fn angles(rotation: Option<Rotation>) -> [f64; 3] {
    match rotation {
        None => [0.0; 3],
        Some(Rotation::InView(angle)) => [angle, 0.0, 0.0],
        Some(Rotation::Axes(angles)) => angles,
    }
}

/// Returns a rotation of this kind in radians, with strength applied.
fn radians(kind: Rotation, degrees: [f64; 3], strength: f64) -> Rotation {
    let mixed = degrees.map(|angle| angle.to_radians() * strength);
    match kind {
        Rotation::InView(_) => Rotation::InView(mixed[0]),
        Rotation::Axes(_) => Rotation::Axes(mixed),
    }
}

fn handle_at(handle: &HandleTrack, strength: f64, frame: f64) -> [f64; 3] {
    let Some(span) = Span::of(&handle.keys, frame, |key| (key.frame, key.ease)) else { return [0.0; 3] };
    mix_all(span.from.offset, span.to.offset, span.weight).map(|x| x * strength)
}

/// Interpolates linearly; exact at both ends.
fn mix(from: f64, to: f64, weight: f64) -> f64 {
    from * (1.0 - weight) + to * weight
}

fn mix_all(from: [f64; 3], to: [f64; 3], weight: f64) -> [f64; 3] {
    std::array::from_fn(|axis| mix(from[axis], to[axis], weight))
}

/// The keys around a time.
pub(super) struct Span<'a, K> {
    pub(super) from: &'a K,
    pub(super) to: &'a K,
    /// 0: all `from`, 1: all `to`; an ease may overshoot.
    pub(super) weight: f64,
}

impl<'a, K> Span<'a, K> {
    /// Finds the keys around a frame; before the first and after the last key the value holds. `None` without keys.
    pub(super) fn of(keys: &'a [K], frame: f64, timing: impl Fn(&K) -> (f64, Ease)) -> Option<Self> {
        let after = keys.partition_point(|key| timing(key).0 <= frame);
        let Some(from) = after.checked_sub(1).and_then(|index| keys.get(index)) else {
            return keys.first().map(|key| Self { from: key, to: key, weight: 0.0 });
        };
        let Some(to) = keys.get(after) else { return Some(Self { from, to: from, weight: 0.0 }) };
        let ((start, ease), (end, _)) = (timing(from), timing(to));
        Some(Self { from, to, weight: eased(ease, (frame - start) / (end - start)) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn shot(more: &str) -> Shot {
        let text = format!(
            "scene = 'a.glb'\nframes = {{ first = 1, last = 24 }}\n[[layer]]\n[[layer.pin]]\nname = 'p'\n\
             anchor = {{ screen = [0.5, 0.5], frame = 1 }}\n\
             keys = [{{ frame = 1, offset = [0, 0] }}, {{ frame = 11, offset = [1, 0] }}]\n{more}"
        );
        Shot::parse(&text, Path::new("a.toml")).expect("a shot")
    }

    const OWN: &str = "rotate_keys = [{ frame = 1, value = 0 }, { frame = 5, value = 360, ease = 'hold' }, { frame = 9, value = 90 }]\n\
                       scale_keys = [{ frame = 3, value = 1, ease = 'smooth' }, { frame = 7, value = 4 }]";

    #[test]
    fn every_channel_follows_its_own_keys() {
        // Frame, x, degrees, power of four of the scale: 3t² − 2t³ is 0.15625 at a quarter.
        let table = [
            [-3.0, 0.0, 0.0, 0.0],
            [3.0, 0.2, 180.0, 0.0],
            [4.0, 0.3, 270.0, 0.15625],
            [5.0, 0.4, 360.0, 0.5],
            [7.0, 0.6, 360.0, 1.0],
            [8.9, 0.79, 360.0, 1.0],
            [9.0, 0.8, 90.0, 1.0],
            [20.0, 1.0, 90.0, 1.0],
        ];
        let shot = shot(OWN);
        for [frame, x, degrees, power] in table {
            let PinTarget { goal, rotation, log_scale } = shot.pin_targets(0, frame).pins[0];
            let (Goal::Offset(offset), Some(Rotation::InView(angle))) = (goal, rotation) else {
                unreachable!("{goal:?}")
            };
            let found = [offset.0.x, angle.to_degrees(), log_scale.expect("scaled") / 4.0_f64.ln()];
            let is_near = found.iter().zip([x, degrees, power]).all(|(found, wanted)| (found - wanted).abs() < 1e-9);
            assert!(is_near, "{frame}: {found:?}");
        }
    }

    #[test]
    fn strength_and_the_path_take_all_keys_in() {
        let plain = shot(OWN);
        let half = Shot::parse(
            "scene = 'a.glb'\nframes = { first = 1, last = 24 }\nstrength = 0.5\n[[layer]]\n[[layer.pin]]\n\
             anchor = { screen = [0.5, 0.5], frame = 1 }\nrotate_keys = [{ frame = 1, value = 90 }]",
            Path::new("a.toml"),
        );
        let target = half.expect("a shot").pin_targets(0, 3.0).pins[0];
        assert_eq!((target.rotation, target.log_scale), (Some(Rotation::InView(45.0_f64.to_radians())), None));
        // Frames 1, 3, 5, 7, 9, 11: half a turn takes six points, three quarters of a turn nine, and two frames two.
        assert_eq!(plain.pin_path(0, 11.0).len(), 6 + 6 + 2 + 9 + 2 + 1);
        let last = plain.range_notes();
        assert!(last.is_empty(), "{last:?}");
        let notes = shot("scale_keys = [{ frame = 30, value = 2 }]").range_notes();
        assert!(
            notes.len() == 1 && notes[0].contains("1 key lies outside") && notes[0].contains("frame 30"),
            "{notes:?}"
        );
    }
}
