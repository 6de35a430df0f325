//! The pointer: places, drags, turns, scales and selects, depending on what lies under it.
//!
//! In: pointer positions and modifier keys. Out: gestures; a drag changes the document once, when it ends.

use super::gesture::{Click, Gesture, Painting};
use super::painting::BRUSH_RADII;
use super::shown::Wipe;
use super::{Purpose, Session};
use crate::edit::EditError;
use crate::edit::axis_ring::going_on;
use crate::edit::track::{Keying, Move, PinScale, key_time, moved};
use crate::edit::track_keys::{Track, TrackKeys};
use crate::edit::worker::SolvedFrame;
use crate::pipeline::LayerMarks;
use crate::shot::{PinRegion, Shot};
use crate::space::ScreenPoint;
use crate::spelling::other_side;
use glam::DVec2;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Minimum and maximum radius of a region, in frame heights.
const RADII: [f64; 2] = [0.005, 4.0];

/// Minimum and maximum stiffness that a drag can set.
const STIFFNESSES: [f64; 2] = [0.01, 100.0];

/// Decades of stiffness per frame height of pointer movement.
const STIFFNESS_PER_HEIGHT: f64 = 6.0;

/// Distance in hit distances of a ring up to which a press on it is a click.
const CLICK: f64 = 0.4;

/// Radius in frame heights of a region created by a stiffness drag.
const USUAL_RADIUS: f64 = 0.1;

/// The property of a pin that is dragged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum PinPart {
    /// Its target.
    #[default]
    Target,
    /// The radius of its region.
    Radius,
    /// The stiffness of its region.
    Stiffness,
}

/// Modifier keys when the pointer is pressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Held {
    /// Whether the selection is extended.
    pub adds: bool,
    /// Whether the pin moves the part as a whole.
    pub whole: bool,
    /// The property of a pin that is dragged.
    pub part: PinPart,
}

/// The ring around a selected pin, as drawn by the viewport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ring {
    /// Its radius in frame heights.
    pub radius: f64,
    /// Its hit distance in frame heights.
    pub reach: f64,
}

impl Session {
    /// Handles a pointer press. `reach`: hit distance of points in frame heights.
    pub(crate) fn press(&mut self, at: ScreenPoint, (reach, ring): (f64, Ring), held: Held) {
        if self.leave_rendered() {
            return;
        }
        if self.playhead.is_playing() {
            // The frame that is stopped at is drawn as rendered.
            self.go(self.playhead.frame());
        }
        self.set_gesture_aside();
        let base = Arc::new(self.document.shot().clone());
        let near = self.pin_near(at, reach);
        // A ring is as wide as the feet of a figure are apart: a pin that lies on it is caught first.
        if held.part == PinPart::Target
            && near.is_none()
            && let Some(turn) = self.turn_at(at, ring, &base)
        {
            let (slack, turn) = (CLICK * ring.reach, Box::new(turn));
            let others: Vec<[usize; 2]> = self.counterparts(&base).collect();
            self.selection.pins.clone().into_iter().chain(others).for_each(|at| self.want_turns(at));
            self.gesture = Gesture::OnRing { from: at, slack, placed: (!held.adds).then_some(held.whole), turn };
            return;
        }
        if let Some((pin, rest)) = near {
            if !self.selection.pins.contains(&pin) {
                if !held.adds {
                    self.selection.clear();
                }
                self.selection.layer = pin[0];
                self.selection.pins.insert(pin);
            } else if held.adds {
                self.selection.pins.remove(&pin);
                return;
            }
            if held.part == PinPart::Radius && self.radius_per_height(pin).is_none() {
                return self.say("The size of this region cannot be seen here: type its radius.");
            }
            self.gesture = match held.part {
                PinPart::Target => self.drag_from(at, base),
                PinPart::Radius => Gesture::Region { pin, rest, base },
                PinPart::Stiffness => Gesture::Stiffness { pin, from: at, base },
            };
            return;
        }
        match held.part {
            PinPart::Stiffness => return self.begin_stroke(at, held.adds),
            PinPart::Radius => {
                self.gesture = Gesture::BrushSize { center: at };
                return;
            }
            PinPart::Target => {}
        }
        if let Some(share) = self.shown.wipe.share()
            && (at.0.x - f64::from(share) * base.size.aspect()).abs() <= reach
        {
            self.gesture = Gesture::Wipe;
            return;
        }
        if let Some(handle) = self.handle_near(at, reach) {
            if base.layers[handle.0].has_auto_dims {
                return self.say("The dims of this lattice are automatic: set them in the layer's settings first.");
            }
            if !self.selection.handles.contains(&handle) && !held.adds {
                self.selection.clear();
            }
            self.selection.layer = handle.0;
            self.selection.handles.insert(handle);
            self.gesture = self.drag_from(at, base);
            return;
        }
        if held.adds {
            self.gesture = Gesture::Box { from: at, to: at };
            return;
        }
        let click = self.ask_for_point(at, held.whole);
        self.gesture = Gesture::Placing { click, at, is_up: false };
    }

    /// Handles pointer movement; `grows`: a rotation gesture also scales.
    pub(crate) fn motion_with(&mut self, to: ScreenPoint, grows: bool) {
        if let Gesture::OnRing { from, slack, turn, .. } = &self.gesture
            && (to - *from).0.length() > *slack
        {
            self.gesture = Gesture::clone(turn);
        }
        match &mut self.gesture {
            Gesture::Idle | Gesture::OnRing { .. } => {}
            Gesture::Placing { at, .. } => *at = to,
            Gesture::Paint(_) => self.stroke_to(to),
            Gesture::BrushSize { center } => {
                let radius = (to - *center).0.length().clamp(BRUSH_RADII[0], BRUSH_RADII[1]);
                self.brush.radius = (radius * 1e4).round() / 1e4;
            }
            Gesture::Wipe => {
                let share = (to.0.x / self.shot().size.aspect()).clamp(0.0, 1.0);
                self.shown.wipe = Wipe::At(share as f32);
            }
            Gesture::Box { to: corner, .. } => *corner = to,
            Gesture::Drag { from, base, has_moved, carried } => {
                *has_moved = *has_moved || to != *from;
                let (by, base) = ((to - *from).0, Arc::clone(base));
                carried.by = by;
                if *has_moved {
                    self.carry_pins();
                    let dragged = self.dragged_shot(&base, Move::By(by));
                    self.show_dragged(dragged);
                }
            }
            Gesture::Turn { center, from, turned, base } => {
                let ([start, now], base) = ([*from, to].map(|point| (point - *center).0), Arc::clone(base));
                *turned = going_on(start.angle_to(now), *turned);
                let change = Move::Turn(turned.to_degrees());
                let turned = self.dragged_shot(&base, change);
                let factor = now.length() / start.length().max(1e-9);
                let grown = match turned {
                    Ok(shot) if grows && factor > 0.0 => self.dragged_shot(&shot, Move::Grow(factor)),
                    turned => turned,
                };
                self.show_dragged(grown);
            }
            Gesture::TurnAbout { center, radius, axis, ring, from, turned, base } => {
                let (ends, base) = ([*from, to].map(|point| (point - *center).0 / *radius), Arc::clone(base));
                *turned = ring.angle(ends, *turned);
                let change = Move::TurnAbout(*axis, turned.to_degrees());
                let turned = self.dragged_shot(&base, change);
                self.show_dragged(turned);
            }
            Gesture::Region { pin: [layer, pin], rest, base } => {
                let radius = (to - *rest).0.length().clamp(RADII[0], RADII[1]);
                let (layer, pin, shot) = (*layer, *pin, Shot::clone(base));
                let radius = radius * self.radius_per_height([layer, pin]).unwrap_or(1.0);
                let old = shot.layers[layer].pins[pin].region;
                let old = old.unwrap_or(PinRegion { radius, rigidity: 1.0, stiffness: 1.0 });
                let new = PinRegion { radius: (radius * 1e4).round() / 1e4, ..old };
                self.show_region(shot, [layer, pin], new);
            }
            Gesture::Stiffness { pin: [layer, pin], from, base } => {
                let (layer, pin, shot) = (*layer, *pin, Shot::clone(base));
                let tens = (to - *from).0.y * STIFFNESS_PER_HEIGHT;
                let radius = USUAL_RADIUS * self.radius_per_height([layer, pin]).unwrap_or(1.0);
                let old = shot.layers[layer].pins[pin].region;
                let old = old.unwrap_or(PinRegion { radius, rigidity: 0.0, stiffness: 1.0 });
                let stiffness = (old.stiffness * 10.0_f64.powf(tens)).clamp(STIFFNESSES[0], STIFFNESSES[1]);
                let stiffness = (stiffness * 1e2).round() / 1e2;
                self.say(format!("Stiffness {stiffness:.2}: up is stiffer, down softer; 1 is as the rest"));
                self.show_region(shot, [layer, pin], PinRegion { stiffness, ..old });
            }
        }
    }

    /// Handles pointer movement.
    pub(crate) fn motion(&mut self, to: ScreenPoint) {
        self.motion_with(to, false);
    }

    /// Handles a pointer release.
    pub(crate) fn release(&mut self) {
        match std::mem::replace(&mut self.gesture, Gesture::Idle) {
            Gesture::Idle => {}
            Gesture::Placing { click, at, .. } => self.gesture = Gesture::Placing { click, at, is_up: true },
            // A ring catches drags alone: a click places a pin on the surface under it.
            Gesture::OnRing { from, placed, .. } => {
                if let Some(is_whole) = placed {
                    let click = Click { keeps_selection: true, ..self.ask_for_point(from, is_whole) };
                    self.gesture = Gesture::Placing { click, at: from, is_up: true };
                }
            }
            Gesture::Box { from, to } => self.choose_box([from, to]),
            Gesture::Drag { has_moved: false, .. } | Gesture::BrushSize { .. } | Gesture::Wipe => {}
            Gesture::Paint(painting) => {
                self.gesture = Gesture::Paint(Painting { is_up: true, ..painting });
                self.end_stroke();
            }
            Gesture::Drag { base, .. } => {
                self.commit("Move", &base);
                self.explain_lone_pin();
            }
            Gesture::Turn { base, .. } | Gesture::TurnAbout { base, .. } => self.commit("Turn", &base),
            // A click without motion changes nothing.
            Gesture::Region { .. } | Gesture::Stiffness { .. } if self.dragged.is_none() => {}
            Gesture::Region { pin, .. } | Gesture::Stiffness { pin, .. } => {
                let region = self.shot().layers.get(pin[0]).and_then(|layer| layer.pins.get(pin[1])?.region);
                self.document.end_series();
                self.set_region(pin, region);
                self.document.end_series();
            }
        }
        self.place_overtaken();
    }

    /// Explains why all of a layer moves when its only pin is dragged.
    fn explain_lone_pin(&mut self) {
        let layers = &self.document.shot().layers;
        let is_alone = |at: [usize; 2]| layers.get(at[0]).is_some_and(|layer| layer.pins.len() == 1);
        if self.selection.single_pin().is_some_and(is_alone) {
            // A pin that is placed now would hold the moved place.
            let what = self.subject();
            self.say(format!(
                "One pin moves the whole layer. To bend it: Ctrl+Z, click where the {what} should stay, then drag."
            ));
        }
    }

    /// Cancels the gesture, or clears the selection if there is none.
    pub(crate) fn cancel(&mut self) {
        if self.gesture.is_idle() && self.leave_rendered() {
            return;
        }
        self.put_carried_back();
        match std::mem::replace(&mut self.gesture, Gesture::Idle) {
            Gesture::Idle => self.selection.clear(),
            _ if self.dragged.is_some() => self.let_go(),
            _ => {}
        }
        self.place_overtaken();
    }

    /// Returns whether a gesture is in progress.
    #[must_use]
    pub(crate) const fn is_dragging(&self) -> bool {
        !matches!(
            self.gesture,
            Gesture::Idle | Gesture::Placing { is_up: true, .. } | Gesture::Paint(Painting { is_up: true, .. })
        )
    }

    /// Returns two opposite corners of the selection box.
    #[must_use]
    pub(crate) const fn choosing_box(&self) -> Option<[ScreenPoint; 2]> {
        if let Gesture::Box { from, to } = self.gesture { Some([from, to]) } else { None }
    }

    /// Moves the selection by an offset in frame heights.
    pub(crate) fn nudge(&mut self, by: DVec2) {
        let base = self.document.shot().clone();
        match self.dragged_shot(&base, Move::By(by)) {
            Err(error) => self.say(error.to_string()),
            Ok(shot) => {
                self.dragged = Some(Arc::new(shot));
                let series = format!("nudge {:?} {:?}", self.selection.pins, self.selection.handles);
                self.commit_series("Nudge", &base, Some(&series));
            }
        }
    }

    /// Returns the shot with the selected pins and handles changed.
    fn dragged_shot(&self, base: &Shot, change: Move) -> Result<Shot, EditError> {
        let (mut shot, frame) = (base.clone(), self.playhead.frame());
        if let Some(what) = self.selection.pins.iter().find_map(|&at| self.follows(at)) {
            return Err(EditError::Unusable { what, hint: "or delete this one and pin it by itself".into() });
        }
        let chosen = self.selection.pins.iter().map(|&at| (at, change));
        for (at, change) in chosen.chain(self.counterparts(base).map(|at| (at, change.mirrored()))) {
            let time = key_time(&base.frames, &base.layers[at[0]], frame);
            let ready = self.ready_to_turn(base, at, change);
            let keys = moved(&ready, at, Keying { time, auto: self.auto_key }, change, self.scale_of(at))?;
            let pin = &mut shot.layers[at[0]].pins[at[1]];
            pin.clone_from(&ready.layers[at[0]].pins[at[1]]);
            keys.put_into(pin);
        }
        shot.copy_mirrored_keys();
        if let Move::By(by) = change {
            self.drag_handles(&mut shot, base, by);
        }
        Ok(shot)
    }

    /// Returns the counterparts of the selected pins on the other side, if mirroring is on.
    fn counterparts(&self, shot: &Shot) -> impl Iterator<Item = [usize; 2]> {
        let chosen = self.selection.pins.iter().filter_map(|&at| self.counterpart(shot, at));
        let found: Vec<[usize; 2]> = chosen.collect();
        found.into_iter().filter(|at| !self.selection.pins.contains(at))
    }

    /// Returns the counterpart of a pin on the other side, by its name, if mirroring is on.
    fn counterpart(&self, shot: &Shot, at: [usize; 2]) -> Option<[usize; 2]> {
        let own = shot.layers.get(at[0])?.pins.get(at[1]).filter(|_| self.mirrors)?;
        let name = other_side(&own.name)?;
        // Looks in its own layer first, then in the others.
        let named =
            |layer: usize| shot.layers[layer].pins.iter().position(|pin| pin.name == name && pin.mirror.is_none());
        let layers = std::iter::once(at[0]).chain(0..shot.layers.len());
        { layers }.find_map(|layer| Some([layer, named(layer)?]))
    }

    /// Returns a pin, and its counterpart if mirroring is on and both have regions in the same unit.
    pub(super) fn with_counterpart(&self, at: [usize; 2]) -> Vec<[usize; 2]> {
        let other = self.counterpart(self.document.shot(), at);
        let other = other.filter(|other| self.radius_unit(*other) == self.radius_unit(at));
        std::iter::once(at).chain(other).collect()
    }

    /// Shows a drag of the region of a pin, and of its counterpart.
    fn show_region(&mut self, mut shot: Shot, at: [usize; 2], region: PinRegion) {
        for [layer, pin] in self.with_counterpart(at) {
            shot.layers[layer].pins[pin].region = Some(region);
        }
        self.show_dragged(Ok(shot));
    }

    fn show_dragged(&mut self, shot: Result<Shot, EditError>) {
        match shot {
            Err(error) => {
                self.gesture = Gesture::Idle;
                self.say(error.to_string());
            }
            Ok(shot) => {
                if self.dragged.is_none() {
                    self.revision += 1;
                }
                self.dragged = Some(Arc::new(shot));
                let mut layers = self.selection.layers();
                let others: Vec<usize> = self.counterparts(self.document.shot()).map(|[layer, _]| layer).collect();
                layers.extend(others);
                layers.extend(self.followers().into_iter().map(|[layer, _]| layer));
                layers.sort_unstable();
                layers.dedup();
                self.refresh(Purpose::Drag(layers));
            }
        }
    }

    fn commit(&mut self, what: &str, base: &Shot) {
        self.document.end_series();
        self.commit_series(what, base, None);
    }

    /// Commits a drag to the document.
    fn commit_series(&mut self, what: &str, base: &Shot, series: Option<&str>) {
        let Some(shot) = self.dragged.clone() else { return };
        let pins = self.selection.pins.iter().copied().chain(self.counterparts(base));
        let pins = pins.flat_map(|at| Track::of_pin(&shot, at));
        let handles = self.selection.handles.iter().copied().map(Track::Handle);
        let changed = |track: Track| {
            let keys = track.keys(&shot)?;
            (track.keys(base).as_ref() != Some(&keys)).then_some((track, keys))
        };
        let keys: Vec<(Track, TrackKeys)> = pins.chain(handles).filter_map(changed).collect();
        let pins: BTreeSet<[usize; 2]> = keys.iter().filter_map(|(track, _)| track.pin()).collect();
        let things = match (pins.len(), self.selection.handles.len()) {
            (1, 0) => "pin",
            (_, 0) => "pins",
            (0, _) => "handles",
            _ => "pins and handles",
        };
        let label = format!("{what} {things}");
        self.write_keys(&label, &keys, series);
    }

    /// Returns the nearest visible pin and its rest position.
    #[must_use]
    pub(crate) fn pin_near(&self, at: ScreenPoint, reach: f64) -> Option<([usize; 2], ScreenPoint)> {
        if !self.shown.shows_pins() {
            return None;
        }
        let marks = self.marks();
        let pins = marks.iter().flat_map(|marks| marks.pins.iter().map(move |pin| (marks.layer, pin)));
        let near = pins.map(|(layer, pin)| ((pin.target - at).0.length(), [layer, pin.pin], pin.rest));
        let nearest = near.filter(|(far, ..)| *far <= reach).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map(|(_, pin, rest)| (pin, rest))
    }

    /// Selects the visible pins and handles in a box.
    fn choose_box(&mut self, [a, b]: [ScreenPoint; 2]) {
        let holds = |point: ScreenPoint| ((point - a).0 * (point - b).0).max_element() <= 0.0;
        let marks = if self.shown.shows_pins() { self.marks() } else { &[] };
        let pins =
            marks.iter().flat_map(|marks| marks.pins.iter().map(move |pin| ([marks.layer, pin.pin], pin.target)));
        let pins: Vec<[usize; 2]> = pins.filter(|(_, target)| holds(*target)).map(|(pin, _)| pin).collect();
        let handles = self.handles_where(holds);
        self.selection.pins.extend(pins);
        self.selection.handles.extend(handles);
    }

    /// Returns the marks of the current frame; until they are known, those of the frame that is seen.
    #[must_use]
    pub(crate) fn marks(&self) -> &[LayerMarks] {
        let seen = self.current.as_ref().map(|picture| picture.frame);
        let fits = |solve: &&Arc<SolvedFrame>| solve.frame == self.playhead.frame() || Some(solve.frame) == seen;
        self.current_solve.as_ref().filter(fits).map_or(&[], |solve| &solve.marks)
    }

    pub(super) fn marks_of(&self, layer: usize) -> Option<&LayerMarks> {
        self.marks().iter().find(|marks| marks.layer == layer)
    }

    /// Returns what a movement on the screen means in the unit of a pin.
    pub(super) fn scale_of(&self, [layer, pin]: [usize; 2]) -> PinScale {
        let Some(marks) = self.marks_of(layer) else { return PinScale::default() };
        let steps = marks.pins.iter().find(|mark| mark.pin == pin).and_then(|mark| mark.steps);
        PinScale { rest_box: marks.rest_box, steps }
    }
}
