//! Collects all triangles of a layer in the scene at rest, independent of clips.
//!
//! In: a scene, the parts of a layer. Out: a [`RestMesh`].

use crate::pose::{ClipChoice, Pose, pose};
use crate::scene::Scene;
use crate::screen::primitive;

/// The triangles of some parts, numbered consecutively over all parts.
#[derive(Clone, Debug, Default)]
pub(in crate::pipeline) struct RestMesh {
    /// Positions in scene space, metres.
    pub(in crate::pipeline) points: Vec<[f64; 3]>,
    /// Corners, counter-clockwise as seen from outside.
    pub(in crate::pipeline) triangles: Vec<[u32; 3]>,
    /// #triangles: whether the part itself lists the corners in reverse order.
    pub(in crate::pipeline) is_mirrored: Vec<bool>,
}

/// Returns the pose without any clip.
pub(in crate::pipeline) fn rest_pose(scene: &Scene) -> Pose {
    pose(scene, ClipChoice::default(), 0.0)
}

impl RestMesh {
    /// Returns the sides of the bounding box along x, y and z, metres.
    pub(in crate::pipeline) fn sides(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| {
            let values = || self.points.iter().map(|point| point[axis]);
            (values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)).max(0.0)
        })
    }

    /// Returns the length of the bounding box's diagonal, metres.
    pub(in crate::pipeline) fn diagonal(&self) -> f64 {
        self.sides().iter().map(|side| side.powi(2)).sum::<f64>().sqrt()
    }

    /// Returns the points of a picture, which is flat.
    pub(in crate::pipeline) fn flat(&self) -> Vec<[f64; 2]> {
        self.points.iter().map(|&[x, y, _]| [x, y]).collect()
    }

    /// Collects the triangles of `parts`.
    pub(in crate::pipeline) fn of(scene: &Scene, rest: &Pose, parts: &[usize]) -> Self {
        let mut mesh = Self::default();
        for part in parts.iter().map(|&part| &rest.parts[part]) {
            let base = mesh.points.len() as u32;
            mesh.points.extend(part.positions.iter().map(|point| point.0.as_dvec3().to_array()));
            // Mirroring swaps front and back.
            let ordered = |&[a, b, c]: &[u32; 3]| if part.is_mirrored { [a, c, b] } else { [a, b, c] };
            let corners = primitive(scene, part).triangles.iter().map(ordered);
            mesh.triangles.extend(corners.map(|corners| corners.map(|corner| corner + base)));
            mesh.is_mirrored.resize(mesh.triangles.len(), part.is_mirrored);
        }
        mesh
    }
}
