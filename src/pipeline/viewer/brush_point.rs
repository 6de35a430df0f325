//! Finds the point of the model at rest under a brush.
//!
//! In: a prepared shot, a frame, a point of the screen. Out: the point as strokes of stiffness store it, and the scale there.

use crate::pipeline::prepare::rest_mesh::rest_pose;
use crate::pipeline::{PickedPoint, PreparedShot, TimeSample};
use crate::screen::primitive;
use crate::space::{ScreenPoint, ScreenVector};
use glam::DVec3;

/// A point of the model under a brush.
#[derive(Clone, Debug, PartialEq)]
pub struct BrushPoint {
    /// The layer that moves the point.
    pub layer: usize,
    /// Name of the node.
    pub node: String,
    /// Position in the scene at rest, metres; in pictures frame heights.
    pub at: [f64; 3],
    /// Length of a frame height at the depth of the point, in the same unit.
    pub per_height: f64,
}

impl PreparedShot {
    /// Returns the point of the model under a brush in the warped picture; `None` where no layer's surface is seen.
    #[must_use]
    pub fn brush_point(&self, sample: &TimeSample, at: ScreenPoint) -> Option<BrushPoint> {
        let PickedPoint { node, layer, hit, .. } = self.pick_warped(sample, at)?;
        let rest = self.cache.rest.get_or_init(|| rest_pose(&self.scene));
        let part = &rest.parts[hit.part];
        let corners = primitive(&self.scene, part).triangles[hit.triangle];
        let place = |corner: u32| part.positions[corner as usize].0.as_dvec3();
        let rest: DVec3 = corners.iter().zip(hit.barycentric).map(|(&corner, weight)| place(corner) * weight).sum();
        let w = if sample.camera.is_parallel() { 1.0 } else { hit.depth };
        let height = sample.camera.scene_from_screen_vector(ScreenVector::new(0.0, 1.0), w).length();
        Some(BrushPoint { layer: layer?, node, at: rest.to_array(), per_height: height })
    }
}
