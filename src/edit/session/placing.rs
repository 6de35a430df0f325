//! Placing, naming and deleting pins.
//!
//! In: points of the model, names. Out: document changes.

use super::gesture::{Click, Gesture};
use super::wording::pin_noun;
use super::{Purpose, Session};
use crate::edit::track::key_time;
use crate::edit::track_keys::with_key;
use crate::edit::worker::{FoundPoint, HeldPlace, Question};
use crate::shot::edit::{
    PinName, Setting, add_pin, mirror_pin, put_keys, put_pin_setting, put_region, remove_pin, rename_pin,
};
use crate::shot::{Ease, Goal, PinKey, PinRegion, Shot, ShotError};
use crate::space::{ScreenPoint, ScreenVector};
use crate::spelling::other_side;
use glam::DVec2;
use std::collections::BTreeSet;

/// Distance in frame heights below which a pinned point counts as at rest: a tenth of a pixel at 1080 lines.
const AT_REST: f64 = 1e-4;

/// Radius of the region, in frame heights, of a pin that moves a part as a whole.
const WHOLE_RADIUS: f64 = 0.18;

/// Returns the keys of a new pin that holds the surface where it is shown `here`, and in other keyed frames; none where it is at rest and
/// no other frame is keyed.
fn holding_keys(here: HeldPlace, others: &[HeldPlace], strength: f64) -> Vec<PinKey> {
    let is_moved = |place: &HeldPlace| place.offset.0.length() > AT_REST;
    let strength = if strength.abs() < 1e-6 { 1.0 } else { strength };
    let key = |place: &HeldPlace| PinKey {
        frame: place.time,
        goal: Goal::Offset(ScreenVector(if is_moved(place) { place.offset.0 / strength } else { DVec2::ZERO })),
        rotate_degrees: None,
        scale: None,
        ease: place.ease,
    };
    let keys: Vec<PinKey> = others.iter().map(key).collect();
    // At rest in all frames, it needs no key in this one.
    match is_moved(&here) || others.iter().any(is_moved) {
        true => with_key(&keys, key(&here)),
        false => keys,
    }
}

impl Session {
    /// Asks the worker what surface lies under the pointer.
    pub(super) fn ask_for_point(&mut self, at: ScreenPoint, is_whole: bool) -> Click {
        self.next_question += 1;
        let click =
            Click { id: self.next_question, frame: self.playhead.frame(), from: at, is_whole, keeps_selection: false };
        self.worker.ask(Question::Point { id: click.id, frame: click.frame, at });
        click
    }

    /// Handles the answer: places a pin if a layer's surface is visible there, else starts a selection box.
    pub(super) fn picked(&mut self, id: u64, found: Option<FoundPoint>) {
        if self.picked_before(id, found.as_ref()) {
            return;
        }
        let Gesture::Placing { click, at, is_up } = self.gesture else { return };
        if id != click.id {
            return;
        }
        let unmoved = found.as_ref().filter(|found| found.point.layer.is_none()).map(|found| found.point.node.clone());
        let Some((layer, found)) = found.and_then(|found| Some((found.point.layer?, found))) else {
            if !click.keeps_selection {
                self.selection.clear();
            }
            if let Some(node) = unmoved {
                let hint = "add it to a layer (Nodes), or make one from it (+), in the panel on the left";
                self.say(format!("No layer moves '{node}': {hint}, then click again."));
            }
            if is_up {
                self.gesture = Gesture::Idle;
            } else {
                self.gesture = Gesture::Box { from: click.from, to: at };
            }
            return;
        };
        self.gesture = Gesture::Idle;
        if self.place(layer, &found, click) && !is_up {
            self.drag_placed(click.from);
            self.motion(at);
        }
    }

    /// Places a pin at a visible point of the model. In frames in which its layer has keys it holds the place that it has there.
    pub(super) fn place(&mut self, layer: usize, found: &FoundPoint, click: Click) -> bool {
        let point = &found.point;
        let shot = self.document.shot();
        let Some(owner) = shot.layers.get(layer) else { return false };
        let (layer_name, name) = (owner.name.clone(), free_name(shot, layer, pin_noun(shot, &point.node)));
        let at = PinName { layer: &layer_name, pin: &name };
        let mut text = add_pin(self.document.text(), Some(&layer_name), &name, &point.anchor);
        let here = HeldPlace {
            time: key_time(&shot.frames, owner, click.frame),
            ease: Ease::Smooth,
            offset: click.from - point.rest,
        };
        let keys = holding_keys(here, &found.held, owner.strength);
        if !keys.is_empty() {
            text = text.and_then(|text| put_keys(&text, at, &keys));
        }
        if click.is_whole {
            let region = PinRegion { radius: WHOLE_RADIUS, rigidity: 1.0, stiffness: 1.0 };
            text = text.and_then(|text| put_region(&text, at, Some(region)));
        }
        if !self.change("Add pin", text, None) {
            return false;
        }
        let pins = &self.document.shot().layers[layer].pins;
        let Some(pin) = pins.iter().position(|pin| pin.name == name) else { return false };
        self.selection.only_pin([layer, pin]);
        self.say(format!("Pin '{name}' in layer '{layer_name}': drag it; arrow keys nudge it"));
        true
    }

    /// Adds a pin on the other side of the model for each selected one, which follows it with mirrored keys.
    pub(crate) fn mirror_pins(&mut self) {
        let chosen: Vec<[usize; 2]> = self.selection.pins.iter().copied().collect();
        let mut text = Ok(self.document.text().to_owned());
        let mut added = Vec::new();
        for [layer, pin] in chosen {
            let layers = &self.document.shot().layers;
            let owner = &layers[layer];
            let mut others = layers.iter().flat_map(|layer| &layer.pins).filter_map(|other| other.mirror);
            let is_followed = others.any(|mirror| [mirror.layer, mirror.pin] == [layer, pin]);
            if is_followed || owner.pins[pin].mirror.is_some() {
                continue;
            }
            let of = &owner.pins[pin].name;
            let wanted = other_side(of).unwrap_or_else(|| format!("{of} mirrored"));
            let name = free_name(self.document.shot(), layer, &wanted);
            let at = PinName { layer: &owner.name, pin: of };
            text = text.and_then(|text| mirror_pin(&text, at, &name));
            added.push(name);
        }
        if added.is_empty() {
            return self.say("No pin without a mirrored one is selected: click one first.");
        }
        let label = if added.len() == 1 { "Mirror pin" } else { "Mirror pins" };
        if self.change(label, text, None) {
            self.say(format!("'{}' follows the selected pin, mirrored", added.join("', '")));
        }
    }

    /// Deletes the selected pins, with the pins that follow them, and puts the selected handles back to rest.
    pub(crate) fn delete_pins(&mut self) {
        let chosen: Vec<[usize; 2]> = self.selection.pins.iter().copied().chain(self.followers()).collect();
        let names: BTreeSet<_> = chosen.into_iter().filter_map(|at| self.names_of(at)).collect();
        let handles = self.selection.handles.len();
        if names.is_empty() && handles == 0 {
            return self.say("No pin is selected: click one first.");
        }
        let mut text = self.without_handles(self.document.text());
        for (layer, pin) in &names {
            text = text.and_then(|text| remove_pin(&text, PinName { layer, pin }));
        }
        self.selection.clear();
        let label = match (names.len(), handles) {
            (0, 1) => "Reset handle",
            (0, _) => "Reset handles",
            (1, 0) => "Delete pin",
            _ => "Delete pins",
        };
        self.change(label, text, None);
    }

    /// Renames a pin.
    pub(crate) fn rename_pin(&mut self, at: [usize; 2], name: &str) {
        if let Some((layer, pin)) = self.names_of(at) {
            let text = rename_pin(self.document.text(), PinName { layer: &layer, pin: &pin }, name);
            self.change("Rename pin", text, None);
        }
    }

    /// Sets the region that moves with a pin, and with its counterpart; `None`: only its point moves.
    pub(crate) fn set_region(&mut self, at: [usize; 2], region: Option<PinRegion>) {
        self.set_with_counterpart(at, "region", |text, at| put_region(text, at, region));
    }

    /// Changes a setting of a pin and, if edits are mirrored, of its counterpart, at once.
    pub(super) fn set_with_counterpart(
        &mut self,
        at: [usize; 2],
        what: &str,
        put: impl Fn(&str, PinName) -> Result<String, ShotError>,
    ) {
        let Some((layer, pin)) = self.names_of(at) else { return };
        let series = format!("{what} {layer}/{pin}");
        let mut text = Ok(self.document.text().to_owned());
        for (layer, pin) in self.with_counterpart(at).into_iter().filter_map(|at| self.names_of(at)) {
            text = text.and_then(|text| put(&text, PinName { layer: &layer, pin: &pin }));
        }
        self.change(&format!("Change {what}"), text, Some(&series));
    }

    /// Mutes or unmutes the selected pins.
    pub(crate) fn mute_chosen(&mut self) {
        let pins: Vec<[usize; 2]> = self.selection.pins.iter().copied().collect();
        self.toggle_pin_mute(&pins);
    }

    /// Mutes or unmutes pins; all take the new state of the first.
    pub(crate) fn toggle_pin_mute(&mut self, pins: &[[usize; 2]]) {
        let pin = |at: &[usize; 2]| self.document.shot().layers.get(at[0]).and_then(|layer| layer.pins.get(at[1]));
        let Some(first) = pins.first().and_then(pin) else { return self.say("No pin is selected: click one first.") };
        let (setting, label) = match first.is_muted {
            true => (Setting::Default, "Unmute"),
            false => (Setting::Flag(true), "Mute"),
        };
        let mut text = Ok(self.document.text().to_owned());
        for (layer, pin) in pins.iter().filter_map(|&at| self.names_of(at)) {
            let at = PinName { layer: &layer, pin: &pin };
            text = text.and_then(|text| put_pin_setting(&text, at, "mute", &setting));
        }
        let label = format!("{label} {}", if pins.len() == 1 { "pin" } else { "pins" });
        self.change(&label, text, None);
    }

    /// Returns the names of layer and pin.
    pub(super) fn names_of(&self, [layer, pin]: [usize; 2]) -> Option<(String, String)> {
        let layer = self.document.shot().layers.get(layer)?;
        Some((layer.name.clone(), layer.pins.get(pin)?.name.clone()))
    }

    /// Returns the pins that follow selected ones.
    pub(super) fn followers(&self) -> Vec<[usize; 2]> {
        let shot = self.document.shot();
        let is_follower = |[layer, pin]: &[usize; 2]| {
            let mirror = shot.layers[*layer].pins[*pin].mirror;
            mirror.is_some_and(|mirror| self.selection.pins.contains(&[mirror.layer, mirror.pin]))
        };
        let all =
            shot.layers.iter().enumerate().flat_map(|(layer, own)| (0..own.pins.len()).map(move |pin| [layer, pin]));
        all.filter(is_follower).collect()
    }

    /// Selects all pins of the layer.
    pub(crate) fn choose_all(&mut self) {
        let layer = self.selection.layer;
        let count = self.document.shot().layers.get(layer).map_or(0, |layer| layer.pins.len());
        self.selection.pins = (0..count).map(|pin| [layer, pin]).collect();
    }

    /// Returns a message if a pin cannot have keys of its own, because it follows another one.
    pub(super) fn follows(&self, at: [usize; 2]) -> Option<String> {
        let shot = self.document.shot();
        let mirror = shot.layers.get(at[0])?.pins.get(at[1])?.mirror?;
        let (own, other) = (self.names_of(at)?, self.names_of([mirror.layer, mirror.pin])?);
        Some(format!("'{}' follows '{}', mirrored: move that pin", own.1, other.1))
    }

    /// Discards the drag in progress and shows the frame of the document.
    pub(super) fn let_go(&mut self) {
        self.dragged = None;
        self.frames_changed();
        self.refresh(Purpose::Look);
    }
}

/// Returns a name for a pin, after what it holds, that is unique in the layer.
fn free_name(shot: &Shot, layer: usize, node: &str) -> String {
    let pins = &shot.layers[layer].pins;
    let is_free = |name: &String| pins.iter().all(|pin| pin.name != *name);
    let numbered = (2..).map(|number| format!("{node} {number}"));
    std::iter::once(node.to_owned()).chain(numbered).find(is_free).unwrap_or_else(|| node.to_owned())
}
