//! Applies controls to a layer of a shot.
//!
//! In: a layer, [`Controls`]. Out: the layer with the pins of the controls, at rest or at their targets; an error if they do not fit it.

use super::{Controls, LiveError, Moved, OwnPins, Pin};
use crate::pipeline::branching_key;
use crate::plate::Matte;
use crate::shot::{Anchor, Ease, Goal, Layer, LayerSpace, OffsetUnit, PinKey, Rotation};
use crate::solve::{Guard, Topology};
use std::path::Path;

/// Whether the pins of the controls stay at rest or move to their targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Goals {
    /// Pins keep their rest positions, because a prepared solver must not depend on targets.
    AtRest,
    /// Pins move to their targets.
    Reached,
}

/// Returns a layer with all parameters of the controls applied. Their pins follow the layer's own, with keys earlier than any other.
pub(super) fn driven_layer(layer: &Layer, controls: &Controls, (own, frame): (OwnPins, f64), goals: Goals) -> Layer {
    let mut layer = layer.clone();
    // A shot's `dims = "auto"` takes precedence over the parameter.
    if let LayerSpace::Screen { bounds, .. } = layer.space
        && !layer.has_auto_dims
    {
        layer.space = LayerSpace::Screen { dims: controls.dims, bounds };
    }
    layer.basis = controls.basis;
    if layer.has_auto_topology && !layer.basis.can_branch() {
        layer.settings.topology = Topology::Plain;
    }
    layer.settings = layer.settings.with_smoothness(controls.smoothness);
    layer.strength *= controls.strength;
    if controls.guard == Guard::Limit {
        layer.settings.guard = Guard::Limit;
    }
    if controls.moved == Moved::Masked {
        layer.matte = layer.matte.or(Some(Matte::Alpha));
    }
    if own == OwnPins::LeftOut {
        layer.pins.clear();
    }
    let start = first_key(&layer).min(frame - f64::from(layer.step)) - 1.0;
    let pins = controls.pins.iter().enumerate().map(|(index, pin)| driven_pin(index, pin, start, goals));
    layer.pins.extend(pins);
    layer
}

/// Checks that a layer of a shot can be driven by the controls: their lattice has the handles that are keyed in the file, and their
/// basis can branch where the file asks for what plain lattices cannot do.
///
/// # Errors
/// [`LiveError::Layer`].
pub(super) fn check_controls(layer: &Layer, path: &Path, controls: &Controls) -> Result<(), LiveError> {
    let Controls { dims, basis, .. } = *controls;
    let fault = |what: String, hint: String| Err(LiveError::Layer { path: path.to_owned(), what, hint });
    let is_outside = |index: &[usize; 3]| (0..2).any(|axis| index[axis] >= dims[axis]);
    if let Some(handle) = layer.handles.iter().find(|handle| is_outside(&handle.index)) {
        let [nx, ny, _] = layer.space.dims();
        let what = format!("layer '{}' moves handle {:?}, a lattice of {dims:?} has none", layer.name, handle.index);
        return fault(what, format!("set the lattice to {nx} x {ny} as in the file"));
    }
    let is_branching = layer.settings.topology == Topology::Branching;
    let topology = (!layer.has_auto_topology).then(|| "lattice.topology".to_owned());
    match branching_key(layer).or(topology).filter(|_| is_branching && !basis.can_branch()) {
        Some(key) => {
            let what = format!(
                "`{key}` of layer '{}' acts on branching lattices only, and this basis cannot branch",
                layer.name
            );
            fault(what, "choose the basis B-spline or Bilinear, or remove the key".into())
        }
        None => Ok(()),
    }
}

/// Returns the time of the layer's first key.
fn first_key(layer: &Layer) -> f64 {
    let pins = layer.pins.iter().flat_map(crate::shot::Pin::key_frames);
    let handles = layer.handles.iter().filter_map(|handle| Some(handle.keys.first()?.frame));
    pins.chain(handles).fold(f64::INFINITY, f64::min)
}

/// Converts a pin of the controls: it moves from rest to target over one frame, so that rotations of more than half a turn are wound.
fn driven_pin(index: usize, pin: &Pin, start: f64, goals: Goals) -> crate::shot::Pin {
    let key = |frame: f64, goals: Goals| {
        let is_reached = goals == Goals::Reached;
        let offset = if is_reached { pin.target - pin.rest } else { Default::default() };
        PinKey {
            frame,
            goal: Goal::Offset(offset),
            rotate_degrees: pin
                .rotation
                .map(|angle| Rotation::InView(if is_reached { angle.to_degrees() } else { 0.0 })),
            scale: pin.scale.map(|scale| if is_reached { scale } else { 1.0 }),
            ease: Ease::Linear,
        }
    };
    crate::shot::Pin {
        name: format!("live{}", index + 1),
        anchor: Anchor::Screen { at: pin.rest, frame: None },
        mirror: None,
        unit: OffsetUnit::Frame,
        order: Vec::new(),
        region: pin.region.map(|region| crate::shot::PinRegion {
            radius: region.radius,
            rigidity: region.rigidity,
            stiffness: region.stiffness,
        }),
        weight: 1.0,
        is_muted: false,
        keys: vec![key(start, Goals::AtRest), key(start + 1.0, goals)],
        rotate_keys: Vec::new(),
        scale_keys: Vec::new(),
    }
}
