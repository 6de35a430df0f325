//! By how much two solves of one frame differ: alone, and over time.
//!
//! In: two samples of a frame. Out: per layer the greatest distance, and where.

use crate::pipeline::{PreparedShot, TimeSample};
use crate::raster::geometry::PartPoint;
use crate::screen::ScreenMesh;
use crate::space::ScreenPoint;
use glam::DVec2;

/// Maximum number of triangles of a part that are looked at.
const LOOKED_AT: usize = 2000;

/// The greatest difference of a layer between two solves.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LayerShift {
    /// Name of the layer.
    pub layer: String,
    /// Name of the node that differs most.
    pub node: String,
    /// Distance in pixels.
    pub pixels: f64,
}

impl PreparedShot {
    /// Returns the layers whose visible surface differs between two solves of a frame, the most different first.
    #[must_use]
    pub(crate) fn layer_shifts(&self, [before, after]: [&TimeSample; 2]) -> Vec<LayerShift> {
        let meshes = [before.mesh(), after.mesh()];
        let shift = |(layer, parts): (usize, &Vec<usize>)| {
            let far = |&part: &usize| {
                let own = |sample: &TimeSample, mesh: &ScreenMesh| self.warped_middles(sample, mesh, [layer, part]);
                let middles = own(before, &meshes[0]).into_iter().zip(own(after, &meshes[1]));
                let far = middles.filter_map(|(before, after)| Some((before? - after?).0.length()));
                (far.fold(0.0, f64::max), part)
            };
            let (far, part) = parts.iter().map(far).max_by(|a, b| a.0.total_cmp(&b.0))?;
            let node = self.scene.nodes[self.assignment.node_of_part[part]].name.clone();
            let pixels = far * f64::from(self.shot.size.height);
            (far > 0.0).then(|| LayerShift { layer: self.shot.layers[layer].name.clone(), node, pixels })
        };
        let mut found: Vec<LayerShift> = self.assignment.parts_of_layer.iter().enumerate().filter_map(shift).collect();
        found.sort_by(|a, b| b.pixels.total_cmp(&a.pixels));
        found
    }

    /// Returns the middles of triangles of a part as a layer warps them; `None` for those behind the camera or of other layers.
    fn warped_middles(
        &self,
        sample: &TimeSample,
        mesh: &ScreenMesh,
        [layer, part]: [usize; 2],
    ) -> Vec<Option<ScreenPoint>> {
        let warp = sample.layers[layer].part_warp(part);
        let triangles = &crate::screen::primitive(&self.scene, &sample.pose.parts[part]).triangles;
        let middle = |(triangle, corners): (usize, &[u32; 3])| {
            let ends = corners.map(|corner| mesh.parts[part].vertices[corner as usize]);
            let is_seen = ends.iter().all(|end| end.w > 0.0);
            let is_own = self.assignment.layer_of_triangle(part, triangle) == Some(layer);
            let point = ScreenPoint(ends.iter().map(|end| end.h / end.w).sum::<DVec2>() / 3.0);
            (is_seen && is_own).then(|| warp.warp(point, PartPoint { weights: &[], triangle: triangle as u32 }))
        };
        triangles.iter().enumerate().step_by(triangles.len().div_ceil(LOOKED_AT).max(1)).map(middle).collect()
    }
}
