//! Finds the point of the model under a point of the screen, in the form that pins store.
//!
//! In: a prepared shot, a frame, a point. Out: an [`Anchor`]. In a warped picture, the point that the warp moved there is found.

use crate::pipeline::PreparedShot;
#[cfg(any(test, feature = "editor"))]
use crate::pipeline::TimeSample;
#[cfg(any(test, feature = "editor"))]
use crate::plate::Field;
use crate::pose::Pose;
use crate::screen::{self, Hit, ScreenMesh, primitive};
use crate::shot::{Anchor, Source};
use crate::space::ScreenPoint;
use glam::DVec3;

/// A point of the model.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PickedPoint {
    /// Anchor for a pin at this point.
    pub anchor: Anchor,
    /// Name of the node.
    pub node: String,
    /// The layer that moves the point; `None` if there is none.
    pub layer: Option<usize>,
    /// Position on the screen before any warp.
    pub rest: ScreenPoint,
    pub(in crate::pipeline) hit: Hit,
}

impl PreparedShot {
    /// Returns the front-most point of the unwarped model.
    #[cfg(any(test, feature = "cli"))]
    #[must_use]
    pub(crate) fn pick(&self, frame: i32, at: ScreenPoint) -> Option<PickedPoint> {
        let (pose, camera) = self.view(f64::from(frame));
        let mesh = screen::project(&pose, &camera);
        self.pick_in(&pose, &mesh, (camera.near(), at))
    }

    /// Returns the front-most point of the model as warped in a solved sample.
    #[cfg(any(test, feature = "editor"))]
    #[must_use]
    pub(crate) fn pick_warped(&self, sample: &TimeSample, at: ScreenPoint) -> Option<PickedPoint> {
        let (mesh, near) = (sample.mesh(), sample.camera.near());
        let mut found = Vec::new();
        for (layer, state) in sample.layers.iter().enumerate() {
            let Some(solution) = &state.solution else { continue };
            let field = Field::of_layer(solution.lattice.clone());
            let under = field.inverse(at, at).and_then(|rest| self.pick_in(&sample.pose, &mesh, (near, rest)));
            found.extend(under.filter(|point| point.layer == Some(layer)));
        }
        let is_moved = |layer: usize| sample.layers[layer].solution.is_some();
        let still = self.pick_in(&sample.pose, &mesh, (near, at));
        found.extend(still.filter(|point| point.layer.is_none_or(|layer| !is_moved(layer))));
        found.into_iter().min_by(|a, b| a.hit.depth.total_cmp(&b.hit.depth))
    }

    fn pick_in(&self, pose: &Pose, mesh: &ScreenMesh, (near, at): (f64, ScreenPoint)) -> Option<PickedPoint> {
        let hit = screen::pick(&self.scene, pose, mesh, near, at)?;
        let part = &pose.parts[hit.part];
        let node = self.scene.nodes[part.node].name.clone();
        let anchor = match self.shot.source {
            // Plates have no nodes that an anchor could name.
            Source::Frame => Anchor::Screen { at, frame: None },
            Source::Scene(_) | Source::Images(_) => Anchor::Surface {
                node: node.clone(),
                primitive: part.primitive,
                triangle: hit.triangle,
                barycentric: hit.barycentric,
                rest: Some(self.place_in_node(pose, &hit)),
            },
        };
        let layer = self.assignment.layer_of_triangle(hit.part, hit.triangle);
        Some(PickedPoint { anchor, node, layer, rest: at, hit })
    }

    /// Returns the picked point in its node's rest space.
    fn place_in_node(&self, pose: &Pose, hit: &Hit) -> [f64; 3] {
        let source = primitive(&self.scene, &pose.parts[hit.part]);
        let corners = source.triangles[hit.triangle].map(|corner| source.positions[corner as usize].as_dvec3());
        let point: DVec3 = (0..3).map(|i| corners[i] * hit.barycentric[i]).sum();
        point.to_array()
    }
}
