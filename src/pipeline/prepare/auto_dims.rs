//! Chooses the number of handles of a screen layer with `dims = "auto"`.
//!
//! In: a shot, its scene at rest and in the first frame. Out: dims with several spans across the thinnest parts and
//! between neighbouring pins, and more where a handle would act on points that lie far apart along a picture.

use super::far_apart::FarApart;
use super::rest_mesh::{RestMesh, rest_pose};
use super::slenderness::Slenderness;
use crate::lattice::MAX_HANDLES;
use crate::pipeline::{PinAnchor, PreparedShot};
use crate::shot::{LayerSpace, Source};
use crate::solve::Guard;
use std::sync::PoisonError;

/// Number of spans across a thin part: as little distortion as a mesh has (docs/METHOD.md has the measurements).
const SPANS_ACROSS: f64 = 5.0;

/// Number of spans across a thin part that nothing keeps from folding: few enough to bend in an arc where a finer lattice folds.
const SPANS_ACROSS_UNGUARDED: f64 = 2.5;

/// Number of spans between two neighbouring pins, so that they do not share all of their handles.
const SPANS_BETWEEN_PINS: f64 = 2.0;

/// Minimum and maximum number of handles along an axis.
const HANDLES: [usize; 2] = [10, MAX_HANDLES];

/// Maximum number of handles along the longer side of a scene's layer, whose shape changes from frame to frame, so that every frame is
/// split and factored anew.
pub(in crate::pipeline) const SCENE_HANDLES: usize = 24;

/// Factor by which dims grow where a handle acts on points that lie far apart along a picture.
const FINER: f64 = 1.2;

/// Number of handles above which the cost of a sequence is noted.
const MANY_HANDLES: usize = 3000;

/// Size of a followed box relative to the model, including the padding on both sides.
const PADDING: f64 = 1.2;

/// Chooses the dims of all layers with `dims = "auto"`, and adds a note for each.
pub(in crate::pipeline) fn choose(prepared: &mut PreparedShot) {
    let asking = |index: &usize| prepared.shot.layers[*index].has_auto_dims;
    let layers: Vec<usize> = (0..prepared.shot.layers.len()).filter(asking).collect();
    for index in layers {
        let Choice { dims: chosen, why, wanted } = choice(prepared, index);
        set_dims(prepared, index, chosen);
        let (chosen, why) = match refined(prepared, index, chosen) {
            Some(finer) => (finer, "so that it holds apart what lies far apart along the drawing"),
            None => (chosen, why),
        };
        let layer = &prepared.shot.layers[index];
        let [across, up] = chosen;
        let halved = chosen.map(|count| count.div_ceil(2).max(HANDLES[0]));
        let cost = match (wanted, halved) {
            (Some([x, y]), _) => {
                format!(", the most that \"auto\" gives a scene; dims = [{x}, {y}] would fit them and take longer")
            }
            (None, [x, y]) if across * up > MANY_HANDLES => {
                format!("; so many take minutes for a sequence, and dims = [{x}, {y}] a fraction of that")
            }
            _ => String::new(),
        };
        prepared.notes.push(format!("layer '{}': a lattice of {across} x {up} handles, {why}{cost}", layer.name));
    }
}

fn set_dims(prepared: &mut PreparedShot, index: usize, chosen: [usize; 2]) {
    if let LayerSpace::Screen { dims, .. } = &mut prepared.shot.layers[index].space {
        *dims = chosen;
    }
}

/// Refines the lattice of a picture until no handle acts on points that lie far apart along it, and notes those that remain with the
/// finest lattice. Returns the dims if they grew.
fn refined(prepared: &mut PreparedShot, index: usize, chosen: [usize; 2]) -> Option<[usize; 2]> {
    let (mut dims, mut left) = (chosen, FarApart::of(prepared, index)?);
    while !left.is_empty() && dims.iter().any(|count| *count < HANDLES[1]) {
        dims = dims.map(|count| ((count as f64 * FINER).ceil() as usize).min(HANDLES[1]));
        set_dims(prepared, index, dims);
        left = FarApart::of(prepared, index)?;
    }
    let note = left.note(&prepared.shot.layers[index].name);
    prepared.notes.extend(note);
    (dims != chosen).then_some(dims)
}

/// Dims of a layer.
struct Choice {
    dims: [usize; 2],
    /// The reason for them, in words.
    why: &'static str,
    /// The dims that the layer would have without [`SCENE_HANDLES`], if they differ.
    wanted: Option<[usize; 2]>,
}

fn choice(prepared: &PreparedShot, index: usize) -> Choice {
    let layer = &prepared.shot.layers[index];
    let coarsest = |why| Choice { dims: [HANDLES[0]; 2], why, wanted: None };
    let Slenderness::Seen(thickness) = slenderness(prepared, index) else {
        return coarsest("for nothing is seen of it");
    };
    let across = match layer.settings.guard {
        Guard::Limit => SPANS_ACROSS,
        Guard::Report => SPANS_ACROSS_UNGUARDED,
    };
    let thin = thickness.map(|thickness| thickness / across);
    let frame = f64::from(prepared.shot.reference_frame());
    let sides = box_sides(prepared, index, frame);
    let nearest = nearest_pins(prepared, index, frame);
    let pins = nearest.map(|distance| distance / sides[0].max(sides[1]) / SPANS_BETWEEN_PINS);
    // Lengths of a span, relative to the longer side of the model.
    let (span, why) = match [thin, pins] {
        [Some(thin), Some(pins)] if pins < thin => (pins, "for its pins that are near each other"),
        [Some(thin), _] => (thin, "for its thinnest parts"),
        [None, Some(pins)] => (pins, "for its pins that are near each other"),
        [None, None] => return coarsest("for it has no thin parts"),
    };
    let ends = layer.basis.min_handles() - 1;
    let dims_for = |span: f64| {
        let spans = |side: f64| (PADDING * side / sides[0].max(sides[1]) / span).ceil() as usize;
        sides.map(|side| spans(side).saturating_add(ends).clamp(HANDLES[0], HANDLES[1]))
    };
    let wanted = dims_for(span);
    let widest = match prepared.shot.source {
        Source::Scene(_) => PADDING / (SCENE_HANDLES - ends) as f64,
        Source::Images(_) | Source::Frame => 0.0,
    };
    let dims = dims_for(span.max(widest));
    Choice { dims, why, wanted: (dims != wanted).then_some(wanted) }
}

/// Returns how thin a layer is; measured once, because it does not depend on pins.
fn slenderness(prepared: &PreparedShot, index: usize) -> Slenderness {
    let known = || prepared.cache.slenderness.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(found) = known().get(&index) {
        return *found;
    }
    let mesh = RestMesh::of(&prepared.scene, &rest_pose(&prepared.scene), &prepared.assignment.parts_of_layer[index]);
    let found = Slenderness::of(&mesh);
    known().insert(index, found);
    found
}

/// Returns width and height of a layer on the screen, in frame heights.
fn box_sides(prepared: &PreparedShot, index: usize, frame: f64) -> [f64; 2] {
    let (pose, camera) = prepared.view(frame);
    let mesh = crate::screen::project(&pose, &camera);
    match crate::pipeline::evaluate::lattice_box::screen_bounds(prepared, index, &pose, &mesh, &camera) {
        Some([low, high]) => [0, 1].map(|axis| (high[axis] - low[axis]).max(1e-6)),
        None => [1.0, 1.0],
    }
}

/// Returns the smallest distance between two pins on the surface, in frame heights; coincident pins are ignored.
fn nearest_pins(prepared: &PreparedShot, index: usize, frame: f64) -> Option<f64> {
    let on_surface = prepared.anchors_of(index).iter().map(|anchor| matches!(anchor, PinAnchor::Surface { .. }));
    let rests = prepared.rests_of(index, frame);
    let places: Vec<_> =
        rests.iter().zip(on_surface).filter(|(_, is_on)| *is_on).map(|(rest, _)| rest.point.0).collect();
    let pairs = (0..places.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
    pairs.map(|(a, b)| places[a].distance(places[b])).filter(|&distance| distance > 1e-3).reduce(f64::min)
}
