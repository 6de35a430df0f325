//! Finds the point of the model at rest under a brush, and its mirror image.
//!
//! In: a prepared shot, a frame, a point of the screen. Out: the point as strokes of stiffness store it, and the scale there.

use crate::pipeline::prepare::mirrored_pins::{mirror_of_layer, mirrored_point};
use crate::pipeline::prepare::rest_mesh::rest_pose;
use crate::pipeline::{PickedPoint, PreparedShot, TimeSample};
use crate::screen::primitive;
use crate::space::ScreenPoint;
use glam::DVec3;
use std::sync::PoisonError;

/// A point of the model under a brush.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BrushPoint {
    /// The layer that moves the point.
    pub layer: usize,
    /// Its place.
    pub place: PaintedPlace,
    /// Length of a frame height at the depth of the point, in the unit of the place.
    pub per_height: f64,
}

/// A place that a stroke paints.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PaintedPlace {
    /// Name of the node.
    pub node: String,
    /// Position in the scene at rest, metres; in pictures frame heights.
    pub at: [f64; 3],
}

impl PreparedShot {
    /// Returns the point of the model under a brush in the warped picture; `None` where no layer's surface is seen.
    #[must_use]
    pub(crate) fn brush_point(&self, sample: &TimeSample, at: ScreenPoint) -> Option<BrushPoint> {
        let PickedPoint { node, layer, hit, .. } = self.pick_warped(sample, at)?;
        let rest = self.cache.rest.get_or_init(|| rest_pose(&self.scene));
        let part = &rest.parts[hit.part];
        let corners = primitive(&self.scene, part).triangles[hit.triangle];
        let place = |corner: u32| part.positions[corner as usize].0.as_dvec3();
        let rest: DVec3 = corners.iter().zip(hit.barycentric).map(|(&corner, weight)| place(corner) * weight).sum();
        let place = PaintedPlace { node, at: rest.to_array() };
        Some(BrushPoint { layer: layer?, place, per_height: sample.camera.frame_height_at(hit.depth) })
    }

    /// Returns the place on the other side of a layer at rest; `None` if the layer has no other side there.
    #[must_use]
    pub(crate) fn mirrored_place(&self, layer: usize, place: &PaintedPlace) -> Option<PaintedPlace> {
        let rest = self.cache.rest.get_or_init(|| rest_pose(&self.scene));
        // Both take a pass over the whole layer, and a stroke asks for many points.
        let known = || self.cache.mirrors.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known().get(&layer).copied();
        let mirror = found.unwrap_or_else(|| {
            let mirror = mirror_of_layer(self, rest, layer);
            known().insert(layer, mirror);
            mirror
        });
        let (at, node) = mirrored_point(self, rest, (layer, mirror?), DVec3::from(place.at))?;
        Some(PaintedPlace { node: self.scene.nodes[node].name.clone(), at: at.to_array() })
    }
}
