//! Validates positions and rotations: the number of components, their unit, one kind per pin.
//!
//! In: raw keys, and whether the layer's lattice is in screen or world space. Out: [`Goal`]s, [`Rotation`]s, indices
//! and offsets of handles.

use super::{Check, LayerDefaults};
use crate::shot::raw::{RawHandle, RawPin, RawPinKey, RawRotation, RawSpace};
use crate::shot::{Goal, OffsetUnit, Rotation};
use crate::space::{ScreenPoint, ScreenVector};
use crate::spelling::pluralised;

/// The suggestion for three numbers in a screen layer.
const TO_WORLD: &str = "or move the lattice into the scene: lattice = { space = \"world\", dims = [5, 5, 5] }";

/// The common properties of a pin's keys.
pub(super) struct PinKind<'a> {
    pub(super) unit: OffsetUnit,
    pub(super) shot: &'a LayerDefaults,
    has_targets: bool,
    /// Number of components of a position.
    axes: usize,
    /// Number of angles, if any key has a rotation.
    angles: Option<usize>,
}

impl<'a> PinKind<'a> {
    /// Determines the properties from the first key that sets each.
    pub(super) fn of(raw: &RawPin, shot: &'a LayerDefaults) -> Self {
        let written = raw.keys.iter().find_map(|key| key.target.as_ref().or(key.offset.as_ref()));
        let in_keys = raw.keys.iter().find_map(|key| key.rotate);
        let silent = if shot.space == RawSpace::World { 3 } else { 2 };
        Self {
            unit: raw.unit,
            shot,
            has_targets: raw.keys.first().is_some_and(|key| key.target.is_some()),
            axes: written.map_or(silent, Vec::len),
            angles: in_keys.or(raw.rotate_keys.first().map(|key| key.value)).map(angles),
        }
    }
}

const fn angles(rotation: RawRotation) -> usize {
    match rotation {
        RawRotation::InView(_) => 1,
        RawRotation::Axes(_) => 3,
    }
}

impl Check<'_> {
    /// Returns the goal of a key.
    pub(super) fn goal(&mut self, raw: &RawPinKey, key: &str, kind: &PinKind) -> Goal {
        let kinds = "give all keys of a pin an `offset`, or all a `target`";
        match raw.target {
            Some(_) if raw.offset.is_some() => {
                self.fault(&format!("{key}.target"), "this key has an offset and a target", kinds);
            }
            Some(_) if !kind.has_targets => self.fault(&format!("{key}.target"), "the first key has no target", kinds),
            None if kind.has_targets => self.fault(key, "the first key has a target, this one has none", kinds),
            _ => {}
        }
        let (name, is_target) = if raw.target.is_some() { ("target", true) } else { ("offset", false) };
        let numbers = raw.target.as_ref().or(raw.offset.as_ref());
        if let Some(numbers) = numbers {
            self.place(numbers, &format!("{key}.{name}"), kind);
        }
        let at = |axis: usize| numbers.and_then(|numbers| numbers.get(axis)).copied().unwrap_or(0.0);
        match (kind.axes, is_target) {
            (3, true) => Goal::SceneTarget([at(0), at(1), at(2)]),
            (3, false) => Goal::SceneOffset([at(0), at(1), at(2)]),
            (_, true) => Goal::Target(ScreenPoint::new(at(0), at(1))),
            (_, false) => Goal::Offset(ScreenVector::new(at(0), at(1))),
        }
    }

    /// Checks number and magnitude of the components of an offset or target.
    fn place(&mut self, numbers: &[f64], key: &str, kind: &PinKind) {
        let is_offset = key.ends_with("offset");
        match (kind.shot.space, numbers.len()) {
            (RawSpace::Screen, 3) => {
                let hint = format!("give [x, y] in frame heights, {TO_WORLD}");
                self.fault(key, "has three numbers, but the layer's lattice lies on the screen", hint);
            }
            (_, count) if count != kind.axes => {
                let given = pluralised(count, "number", "numbers");
                let what = format!("has {given}, other keys of the pin have {}", kind.axes);
                let hint = "give all keys two numbers (dragged on the screen) or all three (along the scene's axes)";
                self.fault(key, what, hint);
            }
            (RawSpace::World, 2) if is_offset && kind.unit == OffsetUnit::Box => {
                let hint = "give [x, y, z], or unit = \"frame\" to drag it on the screen";
                self.fault(key, "the box of a world layer has three sizes, found two numbers", hint);
            }
            _ if kind.unit == OffsetUnit::Box && is_offset => self.box_unit(numbers, key),
            (_, 2) => self.screen_unit(numbers, key, kind.shot),
            _ => {}
        }
    }

    /// Returns a rotation in degrees.
    pub(super) fn rotation(&mut self, raw: RawRotation, key: &str, kind: &PinKind) -> Rotation {
        if kind.shot.space == RawSpace::Screen && angles(raw) == 3 {
            let hint = format!("give one angle, {TO_WORLD}");
            self.fault(key, "has three angles, but the layer's lattice lies on the screen", hint);
        } else if kind.angles.is_some_and(|count| count != angles(raw)) {
            let hint = "give all keys one angle (as seen) or all three (about x, y and z)";
            self.fault(key, "other keys of the pin have another number of angles", hint);
        }
        match raw {
            RawRotation::InView(angle) => Rotation::InView(angle),
            RawRotation::Axes(angles) => Rotation::Axes(angles),
        }
    }

    /// Returns the index of a handle; the third component is 0 in screen space.
    pub(super) fn handle_index(
        &mut self,
        raw: &RawHandle,
        dims: [usize; 3],
        key: &str,
        shot: &LayerDefaults,
    ) -> [usize; 3] {
        let key = format!("{key}.index");
        let axes = shot.space.axes();
        let at = |axis: usize| raw.index.get(axis).copied().unwrap_or(0);
        let index = [at(0), at(1), at(2)];
        let sides = &dims[..axes];
        if raw.index.len() != axes {
            let given = pluralised(raw.index.len(), "number", "numbers");
            let what = format!("has {given}, the lattice of this layer has {axes} axes");
            self.fault(&key, what, format!("give {axes} whole numbers"));
        } else if index.iter().zip(dims).any(|(place, count)| *place >= count) {
            let size: Vec<String> = sides.iter().map(ToString::to_string).collect();
            let what = format!("there is no handle {:?} in a lattice of {}", raw.index, size.join(" x "));
            let names = ["columns", "rows", "layers"];
            let range = |(name, count): (&&str, &usize)| format!("{name} from 0 to {}", count.saturating_sub(1));
            let ranges: Vec<String> = names.iter().zip(sides).map(range).collect();
            self.fault(&key, what, format!("there are {}", ranges.join(", ")));
        }
        index
    }

    /// Returns the offset of a handle; the third component is 0 in screen space.
    pub(super) fn handle_offset(&mut self, raw: &[f64], key: &str, shot: &LayerDefaults) -> [f64; 3] {
        let key = format!("{key}.offset");
        let axes = shot.space.axes();
        if raw.len() == axes {
            self.box_unit(raw, &key);
        } else {
            let given = pluralised(raw.len(), "number", "numbers");
            let what = format!("has {given}, the box of this layer's lattice has {axes} sizes");
            self.fault(&key, what, format!("give {axes} numbers"));
        }
        let at = |axis: usize| raw.get(axis).copied().unwrap_or(0.0);
        [at(0), at(1), at(2)]
    }
}

impl RawSpace {
    /// Returns the number of axes of a lattice.
    pub(super) const fn axes(self) -> usize {
        match self {
            Self::Screen => 2,
            Self::World => 3,
        }
    }
}
