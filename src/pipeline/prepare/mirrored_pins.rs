//! Attaches pins that follow others to the mirrored points of the model.
//!
//! In: a shot with such pins, whose others are attached, and the scene at rest. Out: their anchors, and [`MirroredPin`]s.

use super::anchors::mismatch;
use super::reflection::MirroredPin;
use super::rest_mesh::{RestMesh, rest_pose};
#[cfg(any(test, feature = "editor"))]
use super::symmetry::LayerMirror;
use super::symmetry::Symmetry;
use crate::pipeline::{PinAnchor, PipelineError, PreparedShot};
use crate::pose::{Pose, PosedPart};
use crate::scene::Scene;
use crate::screen::primitive;
use crate::shot::{AxisPlane, Mirror, Source};
use crate::solve::nearest_barycentric;
use crate::space::ScreenPoint;
use crate::spelling::other_side;
use glam::{DMat3, DVec3};

/// Fraction of the surface that a plane has to map onto the surface to be used.
const LEAST_MET: f64 = 0.5;

/// Distance of a mirrored point from the surface, in diagonals of the model, above which the user is told.
const FAR: f64 = 0.03;

/// Attaches the mirrored pins of all layers, whose followed pins are attached already.
pub(in crate::pipeline) fn attach(prepared: &mut PreparedShot) -> Result<(), PipelineError> {
    let mirrors = prepared.shot.layers.iter().enumerate().flat_map(|(layer, own)| {
        own.pins.iter().enumerate().filter_map(move |(pin, own)| Some(([layer, pin], own.mirror?)))
    });
    let mirrors: Vec<([usize; 2], Mirror)> = mirrors.collect();
    prepared.layer_inputs.mirrored = prepared.shot.layers.iter().map(|layer| vec![None; layer.pins.len()]).collect();
    if mirrors.is_empty() {
        return Ok(());
    }
    let rest = rest_pose(&prepared.scene);
    for (place, mirror) in mirrors {
        let layers = [place[0], mirror.layer];
        // The model at rest and the layers stay the same while pins are edited, and so do the planes.
        let plane = match prepared.layer_inputs.planes.get(&layers) {
            Some(&plane) => plane,
            None => plane_of(prepared, &rest, place, layers)?,
        };
        prepared.layer_inputs.planes.insert(layers, plane);
        let task = Task {
            prepared,
            rest: &rest,
            place,
            plane,
            source: prepared.layer_inputs.anchors[mirror.layer][mirror.pin],
        };
        let anchor = if mirror.is_anchor_mirrored { Some(task.anchor()?) } else { None };
        let mirrored = task.mirrored();
        if let Some((anchor, note)) = anchor {
            prepared.layer_inputs.anchors[place[0]][place[1]] = anchor;
            prepared.notes.extend(note);
        }
        prepared.layer_inputs.mirrored[place[0]][place[1]] = Some(mirrored);
    }
    Ok(())
}

/// Returns the plane between the two layers of a mirrored pin: that of the shot, or the best that the model at rest has.
fn plane_of(
    prepared: &mut PreparedShot,
    rest: &Pose,
    place: [usize; 2],
    layers: [usize; 2],
) -> Result<Symmetry, PipelineError> {
    let found = best_plane(prepared, rest, layers);
    let layer = &prepared.shot.layers[layers[0]];
    if let Some(found) = found.filter(|_| layer.symmetry.or(prepared.shot.layers[layers[1]].symmetry).is_some()) {
        return Ok(found);
    }
    let percent = |found: Symmetry| (100.0 * found.met).round();
    let Some(plane) = found.filter(|found| found.met >= LEAST_MET) else {
        let share = found.map_or(0.0, percent);
        let what =
            format!("no plane of symmetry is found: the best one maps {share} % of the surface at rest onto itself");
        let hint = "give the layer one, symmetry = { axis = \"x\", at = 0.0 }, and the mirrored pin an `anchor`";
        return Err(mismatch(&prepared.shot, (place, "mirror"), (what, hint.into())));
    };
    let note = format!(
        "layer '{}': mirrored pins are reflected at the plane {}, which maps {} % of the surface at rest onto itself",
        layer.name,
        equation(&plane),
        percent(plane)
    );
    prepared.notes.push(note);
    Ok(plane)
}

/// Returns the plane between two layers: that of the shot, or the best that the model at rest has.
fn best_plane(prepared: &PreparedShot, rest: &Pose, layers: [usize; 2]) -> Option<Symmetry> {
    let said = layers.iter().find_map(|&layer| prepared.shot.layers[layer].symmetry);
    if let Some(AxisPlane { axis, at }) = said {
        return Some(Symmetry { normal: DVec3::AXES[axis], offset: at, met: 1.0 });
    }
    let mut parts = layers.map(|layer| prepared.assignment.parts_of_layer[layer].clone()).concat();
    parts.sort_unstable();
    parts.dedup();
    Symmetry::of(&RestMesh::of(&prepared.scene, rest, &parts))
}

/// Returns where a layer at rest mirrors; `None` if it has no plane of symmetry.
#[cfg(any(test, feature = "editor"))]
pub(in crate::pipeline) fn mirror_of_layer(prepared: &PreparedShot, rest: &Pose, layer: usize) -> Option<LayerMirror> {
    let known = prepared.layer_inputs.planes.get(&[layer; 2]).copied();
    let plane = known.or_else(|| best_plane(prepared, rest, [layer; 2])).filter(|plane| plane.met >= LEAST_MET)?;
    let own = &prepared.assignment.parts_of_layer[layer];
    Some(LayerMirror { plane, diagonal: RestMesh::of(&prepared.scene, rest, own).diagonal() })
}

/// Returns the point of a layer at rest that is the mirror image of a point, and the node that it is on; `None` if nothing is there.
#[cfg(any(test, feature = "editor"))]
pub(in crate::pipeline) fn mirrored_point(
    prepared: &PreparedShot,
    rest: &Pose,
    (layer, mirror): (usize, LayerMirror),
    at: DVec3,
) -> Option<(DVec3, usize)> {
    let (own, image) = (&prepared.assignment.parts_of_layer[layer], mirror.plane.reflected(at));
    let nearest = own.iter().filter_map(|&part| {
        let (gap, triangle, barycentric) = nearest_of(&prepared.scene, &rest.parts[part], image)?;
        Some((gap, part, triangle, barycentric))
    });
    let (gap, part, triangle, barycentric) = nearest.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let posed = &rest.parts[part];
    let corners = primitive(&prepared.scene, posed).triangles[triangle];
    let place = |corner: u32| posed.positions[corner as usize].0.as_dvec3();
    let found: DVec3 = corners.iter().zip(barycentric).map(|(&corner, weight)| place(corner) * weight).sum();
    (gap <= FAR * mirror.diagonal).then_some((found, posed.node))
}

/// Returns the nearest point of a part at rest: distance, triangle and barycentric coordinates.
fn nearest_of(scene: &Scene, posed: &PosedPart, point: DVec3) -> Option<(f64, usize, [f64; 3])> {
    let place = |corner: u32| posed.positions[corner as usize].0.as_dvec3();
    let nearest = primitive(scene, posed).triangles.iter().enumerate().map(|(triangle, corners)| {
        let places = corners.map(place);
        let barycentric = nearest_barycentric(&point.to_array(), &places.map(|place| place.to_array()));
        let found: DVec3 = places.iter().zip(barycentric).map(|(place, share)| *place * share).sum();
        (found.distance(point), triangle, barycentric)
    });
    nearest.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Returns the equation of a plane in words: `x = 0.012`, or `0.6 x + 0 y + 0.8 z = 1.2`.
fn equation(plane: &Symmetry) -> String {
    let rounded = |value: f64| (value * 1e3).round() / 1e3 + 0.0;
    let axes = plane.normal.to_array();
    match axes.iter().position(|x| x.abs() > 0.9998) {
        Some(axis) => format!("{} = {}", ["x", "y", "z"][axis], rounded(plane.offset * axes[axis].signum())),
        None => {
            let [x, y, z] = axes.map(rounded);
            format!("{x} x + {y} y + {z} z = {}", rounded(plane.offset))
        }
    }
}

/// A mirrored pin to be attached.
struct Task<'a> {
    prepared: &'a PreparedShot,
    rest: &'a Pose,
    /// Layer and pin.
    place: [usize; 2],
    plane: Symmetry,
    /// The anchor of the followed pin.
    source: PinAnchor,
}

impl Task<'_> {
    fn mirrored(&self) -> MirroredPin {
        let carrier = self.prepared.assignment.carriers[self.place[0]];
        let normal = carrier.map_or(self.plane.normal, |node| {
            let scene_from_carrier = DMat3::from_mat4(self.rest.scene_from_node[node].as_dmat4());
            scene_from_carrier.transpose() * self.plane.normal
        });
        MirroredPin { source: self.source, carrier, normal }
    }

    /// Returns the mirrored point of the followed pin's, and a note if the surface is not there.
    fn anchor(&self) -> Result<(PinAnchor, Option<String>), PipelineError> {
        let part = match self.source {
            PinAnchor::Screen(point) => return self.screen_anchor(point).map(|anchor| (anchor, None)),
            PinAnchor::Surface { part, .. } => part,
        };
        let at = self.source.in_scene(self.rest).expect("a point of a surface has a place in the scene");
        let image = self.plane.reflected(at);
        let own = &self.prepared.assignment.parts_of_layer[self.place[0]];
        let diagonal = RestMesh::of(&self.prepared.scene, self.rest, own).diagonal();
        // The part on the other side by name, or the same part, before what only lies near.
        let twin = self.twin_parts(part);
        let near: Vec<usize> = own.iter().copied().filter(|part| twin.contains(part)).collect();
        let nearest = |parts: &[usize]| {
            parts.iter().filter_map(|&part| self.nearest(part, image)).min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let found = nearest(&near).filter(|(gap, _)| *gap <= FAR * diagonal).or_else(|| nearest(own));
        let Some((gap, anchor)) = found else {
            let hint = "give the mirrored pin an `anchor`";
            return Err(self.fault("its layer has no surface to which the mirrored point could be attached", hint));
        };
        let note = (gap > FAR * diagonal).then(|| {
            let layer = &self.prepared.shot.layers[self.place[0]];
            format!(
                "layer '{}': the mirrored point of pin '{}' is {} % of the layer's diagonal away from its surface at rest; give the \
                 pin an `anchor` if it is attached to the wrong place",
                layer.name,
                layer.pins[self.place[1]].name,
                (100.0 * gap / diagonal).round()
            )
        });
        Ok((anchor, note))
    }

    /// Returns the parts of the node on the other side by name, else those of the same node.
    fn twin_parts(&self, part: usize) -> Vec<usize> {
        let scene = &self.prepared.scene;
        let node = self.rest.parts[part].node;
        let twin = other_side(&scene.nodes[node].name).and_then(|name| scene.node_named(&name)).unwrap_or(node);
        (0..self.rest.parts.len()).filter(|&part| self.rest.parts[part].node == twin).collect()
    }

    /// Returns the nearest point of a part at rest, with its distance.
    fn nearest(&self, part: usize, point: DVec3) -> Option<(f64, PinAnchor)> {
        let posed = &self.rest.parts[part];
        let (gap, triangle, barycentric) = nearest_of(&self.prepared.scene, posed, point)?;
        let corners = primitive(&self.prepared.scene, posed).triangles[triangle];
        Some((gap, PinAnchor::Surface { part, triangle, corners, barycentric }))
    }

    /// Returns the mirrored point of a point of the screen, which pictures and plates have.
    fn screen_anchor(&self, point: ScreenPoint) -> Result<PinAnchor, PipelineError> {
        if matches!(self.prepared.shot.source, Source::Scene(_)) {
            let hint = "add `frame` to the anchor of the pin that it follows, or give the mirrored pin an `anchor`";
            return Err(self.fault("the pin that it follows is fixed on the screen, which has no other side", hint));
        }
        let image = self.plane.reflected(DVec3::new(point.0.x, point.0.y, 0.0));
        Ok(PinAnchor::Screen(ScreenPoint::new(image.x, image.y)))
    }

    fn fault(&self, what: &str, hint: &str) -> PipelineError {
        mismatch(&self.prepared.shot, (self.place, "mirror"), (what.into(), hint.into()))
    }
}
