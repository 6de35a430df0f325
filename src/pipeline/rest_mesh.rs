//! All triangles of a layer as the scene stands at rest, whatever its clips do.
//!
//! In: a scene, the parts of a layer. Out: a [`RestMesh`].

use crate::pose::{ClipChoice, Pose, pose};
use crate::scene::Scene;
use crate::screen::primitive;

/// The triangles of some parts, those of all parts counted through.
#[derive(Clone, Debug, Default)]
pub(super) struct RestMesh {
    /// Scene space, metres.
    pub(super) points: Vec<[f64; 3]>,
    /// Corners, counter-clockwise seen from outside.
    pub(super) triangles: Vec<[u32; 3]>,
    /// #triangles: the part's own order of corners is the other one.
    pub(super) is_mirrored: Vec<bool>,
}

/// The pose without any clip.
pub(super) fn rest_pose(scene: &Scene) -> Pose {
    pose(scene, ClipChoice::default(), 0.0)
}

impl RestMesh {
    /// Sides of its bounds along x, y and z, metres.
    pub(super) fn sides(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| {
            let values = || self.points.iter().map(|point| point[axis]);
            (values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)).max(0.0)
        })
    }

    /// Length of the diagonal of its bounds, metres.
    pub(super) fn diagonal(&self) -> f64 {
        self.sides().iter().map(|side| side.powi(2)).sum::<f64>().sqrt()
    }

    /// The points of a picture, which lies flat.
    pub(super) fn flat(&self) -> Vec<[f64; 2]> {
        self.points.iter().map(|&[x, y, _]| [x, y]).collect()
    }

    /// The triangles of `parts`.
    pub(super) fn of(scene: &Scene, rest: &Pose, parts: &[usize]) -> Self {
        let mut mesh = Self::default();
        for part in parts.iter().map(|&part| &rest.parts[part]) {
            let base = mesh.points.len() as u32;
            mesh.points.extend(part.positions.iter().map(|point| point.0.as_dvec3().to_array()));
            // The front of a mirrored part is what was its back.
            let ordered = |&[a, b, c]: &[u32; 3]| if part.is_mirrored { [a, c, b] } else { [a, b, c] };
            let corners = primitive(scene, part).triangles.iter().map(ordered);
            mesh.triangles.extend(corners.map(|corners| corners.map(|corner| corner + base)));
            mesh.is_mirrored.resize(mesh.triangles.len(), part.is_mirrored);
        }
        mesh
    }
}
