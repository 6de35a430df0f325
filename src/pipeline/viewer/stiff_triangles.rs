//! Finds the triangles of a solved frame that are stiffer or softer than the rest, for viewers.
//!
//! In: a solved [`TimeSample`]. Out: their corners on the screen, warped, with their stiffness.

use crate::pipeline::{PreparedShot, TimeSample};
use crate::raster::geometry::PartPoint;
use crate::screen::primitive;
use crate::space::ScreenPoint;

/// Number of triangles above which only evenly spaced ones are returned.
const MAX_TRIANGLES: usize = 40_000;

/// Difference of a stiffness from 1 that counts, on a natural logarithmic scale.
const LEAST: f64 = 0.02;

/// A triangle with a stiffness of its own, as seen on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StiffTriangle {
    /// Its corners, warped.
    pub corners: [ScreenPoint; 3],
    /// Its stiffness; that of the rest is 1.
    pub stiffness: f64,
}

impl PreparedShot {
    /// Returns the triangles that face the camera and whose stiffness differs from 1.
    #[must_use]
    pub(crate) fn stiff_triangles(&self, sample: &TimeSample) -> Vec<StiffTriangle> {
        let painted = self.layer_inputs.stiffness.painted.iter();
        let stiff = |value: f64| value.ln().abs() > LEAST;
        let count: usize = painted.clone().flat_map(|parts| parts.values().flatten()).filter(|&&v| stiff(v)).count();
        let every = count.div_ceil(MAX_TRIANGLES).max(1);
        if count == 0 {
            return Vec::new();
        }
        let (mesh, near) = (sample.mesh(), sample.camera.near());
        let warps = sample.warps(&self.assignment, |_| true);
        let mut found = Vec::new();
        for (&part, stiffness) in painted.flatten() {
            let (vertices, warp) = (&mesh.parts[part].vertices, &warps[part]);
            let triangles =
                primitive(&self.scene, &sample.pose.parts[part]).triangles.iter().zip(stiffness).enumerate();
            for (triangle, (corners, &stiffness)) in triangles.filter(|(_, (_, value))| stiff(**value)).step_by(every) {
                let ends = corners.map(|corner| vertices[corner as usize]);
                if ends.iter().any(|end| end.depth < near || end.w <= 0.0 || !end.h.is_finite()) {
                    continue;
                }
                let at = |place: usize| {
                    let weights = warp.weights_of(corners[place] as usize);
                    warp.warp(ends[place].point(), PartPoint { weights, triangle: triangle as u32 })
                };
                found.push(StiffTriangle { corners: [at(0), at(1), at(2)], stiffness });
            }
        }
        // The far side of a closed surface is hidden by its near side.
        if found.iter().any(is_facing) {
            found.retain(is_facing);
        }
        found
    }
}

/// Whether the corners are counter-clockwise on the screen.
fn is_facing(triangle: &StiffTriangle) -> bool {
    let [a, b, c] = triangle.corners;
    (b - a).0.perp_dot((c - a).0) > 0.0
}
