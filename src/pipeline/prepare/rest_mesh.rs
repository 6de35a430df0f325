//! Collects all triangles of a layer in the scene at rest, independent of clips.
//!
//! In: a scene, the parts of a layer. Out: a [`RestMesh`].

use crate::pose::{ClipChoice, Pose, pose};
use crate::scene::Scene;
use crate::screen::primitive;
use glam::{DVec2, DVec3};

/// The triangles of some parts, numbered consecutively over all parts.
#[derive(Clone, Debug, Default)]
pub(in crate::pipeline) struct RestMesh {
    /// Positions in scene space, metres.
    pub(in crate::pipeline) points: Vec<[f64; 3]>,
    /// Corners, counter-clockwise as seen from outside.
    pub(in crate::pipeline) triangles: Vec<[u32; 3]>,
    /// #triangles: whether the part itself lists the corners in reverse order.
    pub(in crate::pipeline) is_mirrored: Vec<bool>,
    /// #triangles: index of the node whose mesh has the triangle.
    pub(in crate::pipeline) nodes: Vec<usize>,
}

/// Returns the pose without any clip.
pub(in crate::pipeline) fn rest_pose(scene: &Scene) -> Pose {
    pose(scene, ClipChoice::default(), 0.0)
}

impl RestMesh {
    /// Returns the lower and upper corner of the bounding box, metres; both at the origin if there are no points.
    pub(in crate::pipeline) fn bounds(&self) -> [DVec3; 2] {
        let points = self.points.iter().map(|&point| [DVec3::from(point); 2]);
        points.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or_default()
    }

    /// Returns the sides of the bounding box along x, y and z, metres.
    pub(in crate::pipeline) fn sides(&self) -> [f64; 3] {
        let [low, high] = self.bounds();
        (high - low).to_array()
    }

    /// Returns the length of the bounding box's diagonal, metres.
    pub(in crate::pipeline) fn diagonal(&self) -> f64 {
        self.sides().iter().map(|side| side.powi(2)).sum::<f64>().sqrt()
    }

    /// Returns the points of a picture, which is flat.
    pub(in crate::pipeline) fn flat(&self) -> Vec<[f64; 2]> {
        self.points.iter().map(|&[x, y, _]| [x, y]).collect()
    }

    /// Returns the triangle of a flat picture that contains a point, else the one whose middle is nearest; `None` if there are none.
    pub(super) fn triangle_at(&self, at: DVec2) -> Option<usize> {
        let corners = |triangle: usize| {
            self.triangles[triangle].map(|corner| DVec3::from(self.points[corner as usize]).truncate())
        };
        let contains = |triangle: &usize| {
            let [a, b, c] = corners(*triangle);
            let sides = [(b - a).perp_dot(at - a), (c - b).perp_dot(at - b), (a - c).perp_dot(at - c)];
            sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
        };
        let square = |triangle: usize| (corners(triangle).into_iter().sum::<DVec2>() / 3.0).distance_squared(at);
        let all = 0..self.triangles.len();
        all.clone().find(contains).or_else(|| all.min_by(|&a, &b| square(a).total_cmp(&square(b))))
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
            mesh.nodes.resize(mesh.triangles.len(), part.node);
        }
        mesh
    }
}
