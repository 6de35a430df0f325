//! Moves a layer's lattice from the screen into the scene, or back.
//!
//! In: a shot and its text, a layer, the marks of the frame. Out: the text, and what could not be kept.

use crate::edit::track_keys::axes_of;
use crate::pipeline::{LayerMarks, PinMark};
use crate::shot::edit::{
    PinName, Setting, has_pin_setting, put_handle, put_keys, put_layer_setting, put_pin_setting, put_region,
    put_rotate_keys, remove_pin,
};
use crate::shot::{
    Anchor, BoxRule, Connectivity, Goal, Layer, LayerSpace, OffsetUnit, Pin, PinKey, PinRegion, Rotation, Shot,
    ShotError, Unmatted, WorldBoxRule,
};
use crate::solve::Topology;
use crate::space::ScreenVector;
use crate::spelling::pluralised;
use glam::{DVec2, DVec3};

/// Where a lattice lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Space {
    /// On the screen, with two axes.
    Screen,
    /// In the scene, with three axes.
    Scene,
}

impl Space {
    /// Returns where the lattice of a layer lies.
    #[must_use]
    pub(crate) const fn of(space: LayerSpace) -> Self {
        match space {
            LayerSpace::Screen { .. } => Self::Screen,
            LayerSpace::World { .. } => Self::Scene,
        }
    }

    /// Returns the name that the user sees.
    #[must_use]
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Screen => "screen",
            Self::Scene => "scene",
        }
    }

    /// Returns the dims of a lattice that has just been moved.
    const fn dims(self) -> &'static [i64] {
        match self {
            Self::Screen => &[10, 10],
            Self::Scene => &[5, 5, 5],
        }
    }
}

/// A layer that is moved to the other space.
struct Moved<'a> {
    shot: &'a Shot,
    index: usize,
    layer: &'a Layer,
    to: Space,
    marks: Option<&'a LayerMarks>,
    text: String,
    /// What is not kept.
    dropped: Vec<String>,
}

/// Returns the text with a layer in another space, and what is not kept.
///
/// Pins keep what means the same in both spaces: offsets and targets in frame heights, and rotations about the view. What is measured
/// in sizes of the box or in metres is converted as it is seen in the frame of the marks. Handles do not carry over, as their offsets
/// are along the axes of another box.
///
/// # Errors
/// [`ShotError`] if the text cannot be edited.
pub(in crate::edit) fn moved(
    (shot, text): (&Shot, &str),
    index: usize,
    to: Space,
    marks: Option<&LayerMarks>,
) -> Result<(String, Vec<String>), ShotError> {
    let (layer, text) = (&shot.layers[index], text.to_owned());
    let mut moved = Moved { shot, index, layer, to, marks, text, dropped: Vec::new() };
    moved.handles()?;
    moved.lattice()?;
    moved.pins()?;
    Ok((moved.text, moved.dropped))
}

/// Returns whether the conversion depends on the marks of the frame.
pub(in crate::edit) fn needs_marks(layer: &Layer, to: Space) -> bool {
    let has_scene_keys = |pin: &Pin| pin.keys.iter().any(|key| matches!(key.goal, Goal::SceneOffset(_)));
    let needs =
        |pin: &Pin| pin.region.is_some() || pin.unit == OffsetUnit::Box || to == Space::Screen && has_scene_keys(pin);
    layer.pins.iter().any(needs)
}

impl Moved<'_> {
    fn set(&mut self, key: &[&str], setting: &Setting) -> Result<(), ShotError> {
        self.text = put_layer_setting(&self.text, &self.layer.name, key, setting)?;
        Ok(())
    }

    fn handles(&mut self) -> Result<(), ShotError> {
        for track in &self.layer.handles {
            self.text = put_handle(&self.text, &self.layer.name, axes_of(self.layer.space, &track.index), &[])?;
        }
        if !self.layer.handles.is_empty() {
            self.dropped.push(pluralised(self.layer.handles.len(), "moved handle", "moved handles"));
        }
        Ok(())
    }

    fn lattice(&mut self) -> Result<(), ShotError> {
        let space = if self.to == Space::Scene { Setting::Text("world".into()) } else { Setting::Default };
        self.set(&["lattice", "space"], &space)?;
        let usual = Space::of(self.layer.space).dims();
        if self.layer.has_auto_dims {
            self.dropped.push("the automatic dims".to_owned());
        } else if !self.layer.space.dims().iter().zip(usual).all(|(count, usual)| *count as i64 == *usual) {
            self.dropped.push("the dims".to_owned());
        }
        self.set(&["lattice", "dims"], &Setting::Wholes(self.to.dims().to_vec()))?;
        let what = match self.layer.space {
            LayerSpace::Screen { bounds: BoxRule::Follow, .. }
            | LayerSpace::World { bounds: WorldBoxRule::Follow, .. } => None,
            LayerSpace::Screen { bounds: BoxRule::Frame, .. } => Some("the box of the whole frame"),
            LayerSpace::Screen { bounds: BoxRule::Fixed(_), .. }
            | LayerSpace::World { bounds: WorldBoxRule::Fixed(_), .. } => Some("the fixed box"),
        };
        if let Some(what) = what {
            self.set(&["lattice", "box"], &Setting::Default)?;
            self.dropped.push(what.to_owned());
        }
        if self.to == Space::Scene {
            self.turned_box()?;
            self.connectivity()?;
            self.matte()?;
        }
        Ok(())
    }

    /// In the scene a box takes all three axes of its node, and has no angle.
    fn turned_box(&mut self) -> Result<(), ShotError> {
        let orientation = &self.layer.orientation;
        if orientation.node.is_none() {
            self.set(&["lattice", "frame"], &Setting::Default)?;
        } else {
            self.set(&["lattice", "frame", "axis"], &Setting::Default)?;
            self.set(&["lattice", "frame", "angle"], &Setting::Default)?;
        }
        if orientation.angle != 0.0 {
            self.dropped.push("the angle of the box".into());
        }
        Ok(())
    }

    /// Cuts and joins need a branching lattice, which a lattice in the scene is only if the shot says so.
    fn connectivity(&mut self) -> Result<(), ShotError> {
        let layer = self.layer;
        if layer.settings.topology == Topology::Branching && layer.connectivity != Connectivity::default() {
            self.set(&["lattice", "topology"], &Setting::Text("branching".into()))?;
        }
        Ok(())
    }

    fn matte(&mut self) -> Result<(), ShotError> {
        let has_matte = self.layer.matte.is_some() || self.layer.unmatted != Unmatted::OwnNodes;
        if has_matte {
            self.set(&["matte"], &Setting::Default)?;
            self.dropped.push("the matte".into());
        }
        Ok(())
    }

    fn pins(&mut self) -> Result<(), ShotError> {
        let gone = self.gone();
        let mut names = Vec::new();
        for [layer, pin] in &gone {
            let owner = &self.shot.layers[*layer];
            let name = &owner.pins[*pin].name;
            self.text = remove_pin(&self.text, PinName { layer: &owner.name, pin: name })?;
            names.push(format!("'{name}'"));
        }
        if !names.is_empty() {
            self.dropped.push(format!("{} {}", if names.len() == 1 { "pin" } else { "pins" }, names.join(", ")));
        }
        for (index, pin) in self.layer.pins.iter().enumerate() {
            if !gone.contains(&[self.index, index]) {
                self.pin(index, pin)?;
            }
        }
        Ok(())
    }

    /// Returns the pins that the other space cannot have: points of the screen, and pins that follow across spaces, with their followers.
    fn gone(&self) -> Vec<[usize; 2]> {
        let all = || {
            let layers = self.shot.layers.iter().enumerate();
            layers.flat_map(|(layer, own)| own.pins.iter().enumerate().map(move |(pin, own)| ([layer, pin], own)))
        };
        let is_on_screen = |pin: &Pin| matches!(pin.anchor, Anchor::Screen { frame: None, .. });
        let is_lost = |([layer, _], pin): &([usize; 2], &Pin)| match pin.mirror {
            Some(mirror) if (mirror.layer == self.index) != (*layer == self.index) => true,
            _ => *layer == self.index && self.to == Space::Scene && is_on_screen(pin),
        };
        let lost: Vec<[usize; 2]> = all().filter(is_lost).map(|(at, _)| at).collect();
        let follows_lost = |pin: &Pin| pin.mirror.is_some_and(|mirror| lost.contains(&[mirror.layer, mirror.pin]));
        let followers = all().filter(|(at, pin)| follows_lost(pin) && !lost.contains(at)).map(|(at, _)| at);
        lost.iter().copied().chain(followers).collect()
    }

    fn pin(&mut self, index: usize, pin: &Pin) -> Result<(), ShotError> {
        let layer = &self.layer.name;
        let at = PinName { layer, pin: &pin.name };
        let mark = self.marks.and_then(|marks| marks.pins.iter().find(|mark| mark.pin == index));
        let followed = pin.mirror.map(|mirror| &self.shot.layers[mirror.layer].pins[mirror.pin]);
        // A pin that follows another one has neither keys nor a unit of its own, but may have a region.
        if followed.is_none() {
            let (keys, are_kept) = self.keys(pin, mark);
            if keys != pin.keys {
                self.text = put_keys(&self.text, at, &keys)?;
            }
            if !are_kept {
                self.dropped.push(format!("the keys of pin '{}'", pin.name));
            }
            if pin.unit == OffsetUnit::Box {
                self.text = put_pin_setting(&self.text, at, "unit", &Setting::Default)?;
            }
            let has_axes = pin.rotate_keys.iter().any(|key| matches!(key.value, Rotation::Axes(_)));
            if has_axes && self.to == Space::Screen {
                self.text = put_rotate_keys(&self.text, at, &[])?;
            }
            if self.to == Space::Screen && (has_axes || has_three_angles(&pin.keys)) {
                self.dropped.push(format!("the rotation of pin '{}'", pin.name));
            }
        }
        // A pin that follows another one has the region of that one, which is converted with it, unless it has its own.
        let is_own = followed.is_none() || has_pin_setting(&self.text, at, "region");
        let Some(region) = pin.region.filter(|_| is_own) else { return Ok(()) };
        let factor = self.radius(pin, mark).filter(|factor| factor.is_finite());
        let region = factor.map(|factor| PinRegion { radius: readable(region.radius * factor), ..region });
        self.text = put_region(&self.text, at, region)?;
        if region.is_none() {
            self.dropped.push(format!("the region of pin '{}'", pin.name));
        }
        Ok(())
    }

    /// Returns the factor from the radius of a pin's region to that in the other space; `None` if it is not known.
    fn radius(&self, pin: &Pin, mark: Option<&PinMark>) -> Option<f64> {
        let metres = |mark: &PinMark| mark.metres_per_height;
        // A pin that is not seen lies about as deep as the others.
        let others = || self.marks.and_then(|marks| marks.pins.iter().find_map(metres));
        let metres = mark.and_then(metres).or_else(others);
        match (self.to, pin.unit) {
            (Space::Scene, OffsetUnit::Frame) => metres,
            (Space::Scene, OffsetUnit::Box) => Some(self.marks?.rest_box?.upright.size().length() * metres?),
            (Space::Screen, OffsetUnit::Frame) => metres.map(f64::recip),
            (Space::Screen, OffsetUnit::Box) => None,
        }
    }

    /// Returns the keys of a pin in the other space; one that holds the point where they cannot be converted.
    fn keys(&self, pin: &Pin, mark: Option<&PinMark>) -> (Vec<PinKey>, bool) {
        let in_view = |key: &PinKey| {
            let angles = key.rotate_degrees.filter(|angles| self.to == Space::Scene || !is_three(*angles));
            PinKey { rotate_degrees: angles, ..*key }
        };
        let keys = pin.keys.iter().map(|key| Some(PinKey { goal: self.goal((pin, mark), key.goal)?, ..in_view(key) }));
        if let Some(keys) = keys.collect() {
            return (keys, true);
        }
        let resting = |key| PinKey { goal: Goal::Offset(ScreenVector::default()), ..in_view(key) };
        (pin.keys.first().map(resting).into_iter().collect(), false)
    }

    /// Returns a goal in the other space; `None` if it has none there.
    fn goal(&self, (pin, mark): (&Pin, Option<&PinMark>), goal: Goal) -> Option<Goal> {
        match (self.to, goal) {
            (Space::Scene, Goal::Offset(ScreenVector(offset))) if pin.unit == OffsetUnit::Box => {
                let rest_box = self.marks?.rest_box?;
                let upright = offset * rest_box.upright.size();
                Some(Goal::Offset(rounded(DVec2::from_angle(rest_box.angle).rotate(upright))))
            }
            (Space::Screen, Goal::SceneOffset(offset)) if offset == [0.0; 3] => {
                Some(Goal::Offset(ScreenVector::default()))
            }
            (Space::Screen, Goal::SceneOffset(offset)) => {
                let steps = mark?.steps.filter(|_| pin.unit == OffsetUnit::Frame)?;
                Some(Goal::Offset(seen(offset.into(), steps)))
            }
            (Space::Screen, Goal::SceneTarget(_)) => None,
            (_, kept) => Some(kept),
        }
    }
}

/// Rounds a radius to four digits, within what a shot accepts. Models may be millimetres or kilometres long.
fn readable(radius: f64) -> f64 {
    let radius = radius.clamp(1e-5, 1e5);
    let digits = 10.0_f64.powi(3 - radius.log10().floor() as i32);
    (radius * digits).round() / digits
}

const fn is_three(rotation: Rotation) -> bool {
    matches!(rotation, Rotation::Axes(_))
}

fn has_three_angles(keys: &[PinKey]) -> bool {
    keys.iter().any(|key| key.rotate_degrees.is_some_and(is_three))
}

/// Returns how an offset in metres is seen, frame heights. `steps`: what a frame height to the right and one up are in metres.
fn seen(offset: DVec3, steps: [DVec3; 2]) -> ScreenVector {
    rounded(steps.map(|step| offset.dot(step) / step.length_squared().max(f64::MIN_POSITIVE)).into())
}

fn rounded(offset: DVec2) -> ScreenVector {
    ScreenVector((offset * 1e6).round() / 1e6)
}

#[cfg(test)]
mod tests {
    use super::readable;

    #[test]
    fn radii_of_small_models_keep_their_digits() {
        let radii = [(0.000_123_456, 0.000_123_5), (12.345_67, 12.35), (1e-9, 1e-5), (0.1018, 0.1018)];
        for (radius, short) in radii {
            assert!((readable(radius) - short).abs() < 1e-9, "{radius}: {}", readable(radius));
        }
    }
}
