//! Notes on pins that do not do what their places suggest.
//!
//! In: a [`PreparedShot`] with its pins attached. Out: notes for the user.

use super::layer_assignment::LayerAssignment;
use crate::pipeline::{PinAnchor, PreparedShot};
use crate::pose::Pose;
use crate::screen::primitive;
use crate::shot::{Anchor, Pin, Source};

/// Fraction of the mesh moved by a layer at a pin, below which the pin is reported.
const FULL_FRACTION: f64 = 0.99;

/// Returns notes on pins that are attached to points that their layers do not move, or not fully.
pub(super) fn notes_on_pins(prepared: &PreparedShot, first: &Pose) -> Vec<String> {
    let mut notes = Vec::new();
    for (index, layer) in prepared.shot.layers.iter().enumerate() {
        for (pin, pinned) in layer.pins.iter().zip(prepared.anchors_of(index)) {
            if let (PinAnchor::Surface { part, .. }, Some(text)) =
                (pinned, note_on_pin(&prepared.assignment, index, pinned))
            {
                let node = &prepared.scene.nodes[first.parts[*part].node].name;
                notes.push(format!("layer '{}': pin '{}' sits on '{node}', {text}", layer.name, pin.name));
            }
        }
    }
    notes.extend(notes_on_fixed_pins(prepared, first));
    notes
}

/// Returns notes on pins that are fixed on the screen where their layers, of a scene, are not seen in the first frame.
fn notes_on_fixed_pins(prepared: &PreparedShot, first: &Pose) -> Vec<String> {
    let shot = &prepared.shot;
    if !matches!(shot.source, Source::Scene(_)) {
        return Vec::new();
    }
    let mut fixed = Vec::new();
    for (index, layer) in shot.layers.iter().enumerate() {
        let parts = &prepared.assignment.parts_of_layer[index];
        // Lines have no surface to pin.
        let has_lines = parts.iter().any(|&part| !primitive(&prepared.scene, &first.parts[part]).lines.is_empty());
        let is_fixed = |pin: &&Pin| !pin.is_muted && pin.mirror.is_none() && !has_lines;
        fixed.extend(layer.pins.iter().filter(is_fixed).filter_map(|pin| match pin.anchor {
            Anchor::Screen { at, frame: None } => Some((at, (layer, pin, parts))),
            _ => None,
        }));
    }
    if fixed.is_empty() {
        return Vec::new();
    }
    let (places, pins): (Vec<_>, Vec<_>) = fixed.into_iter().unzip();
    let frame = shot.frames.first;
    let on_layer = |anchor: &Option<PinAnchor>, parts: &[usize]| {
        anchor.as_ref().is_some_and(|anchor| matches!(anchor, PinAnchor::Surface { part, .. } if parts.contains(part)))
    };
    let casts = prepared.cast(frame, &places);
    let off = places.iter().zip(pins).zip(casts).filter(|((_, (.., parts)), cast)| !on_layer(cast, parts));
    off.map(|((at, (layer, pin, _)), _)| {
        format!(
            "layer '{}': pin '{}' is fixed on the screen at {}, {}, where the layer is not seen in frame {frame}, and bends what is near; \
             move it onto the layer, or give its anchor a `frame` to attach it to the model",
            layer.name, pin.name, at.0.x, at.0.y
        )
    })
    .collect()
}

/// Returns a note on a pin that is attached to a point that its layer does not move, or not fully.
fn note_on_pin(assignment: &LayerAssignment, layer: usize, pinned: &PinAnchor) -> Option<String> {
    let PinAnchor::Surface { part, corners, barycentric, .. } = pinned else { return None };
    if !assignment.parts_of_layer[layer].contains(part) {
        return Some("which the layer does not move; the pin still follows it".into());
    }
    let share = assignment.share(layer, *part);
    let moved: f64 = corners.iter().zip(barycentric).map(|(&corner, weight)| share.at(corner) * weight).sum();
    (moved < FULL_FRACTION).then(|| {
        let percent = (100.0 * moved).round();
        format!(
            "where the layer moves {percent} % of the mesh: the pin moves it only that far; pin it farther inside, or reduce \
             `feather`"
        )
    })
}
