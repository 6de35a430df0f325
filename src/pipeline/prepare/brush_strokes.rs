//! Paints stiffness with the brush strokes of a layer, later strokes over earlier ones.
//!
//! In: strokes in the scene at rest, the parts of the layer. Out: the stiffness of the triangles that they cover, multiplied
//! with what the rules of the layer say.

use crate::pipeline::PipelineError;
use crate::pose::Pose;
use crate::scene::Scene;
use crate::screen::primitive;
use crate::shot::{BrushStroke, Shot};
use crate::spelling::{self, pluralised};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// Fraction of the radius up to which a stroke applies fully.
const FULL: f64 = 0.5;

/// Barycentric coordinates of the points at which a triangle is compared with a stroke: corners, middles of edges, centroid.
const SAMPLES: [[f64; 3]; 7] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
    [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
];

/// The strokes of a layer.
pub(in crate::pipeline) struct Strokes<'a>(Vec<Stroke<'a>>);

/// A stroke with the nodes that it paints.
struct Stroke<'a> {
    stroke: &'a BrushStroke,
    /// `None`: all nodes.
    nodes: Option<BTreeSet<usize>>,
    /// Bounding box of what it covers.
    low: DVec3,
    high: DVec3,
}

impl<'a> Strokes<'a> {
    /// Resolves the nodes of the strokes.
    pub(in crate::pipeline) fn of(shot: &'a Shot, layer: usize, scene: &Scene) -> Result<Self, PipelineError> {
        let strokes = shot.layers[layer].strokes.iter().map(|stroke| {
            let unknown = stroke.nodes.iter().find(|pattern| scene.matching(pattern).is_empty());
            if let Some(pattern) = unknown {
                let names = scene.nodes.iter().map(|node| node.name.as_str());
                let what = format!("layer '{}': no node matches '{pattern}'", shot.layers[layer].name);
                let hint = spelling::hint(pattern, names);
                return Err(PipelineError::mismatch(shot, &format!("layer[{layer}].stiffness"), what, hint));
            }
            Ok(Stroke::new(stroke, scene))
        });
        Ok(Self(strokes.collect::<Result<_, _>>()?))
    }

    /// Multiplies the stiffness of the triangles of `parts` that the strokes cover. Returns a note if strokes cover none.
    pub(in crate::pipeline) fn paint(
        &self,
        (scene, rest): (&Scene, &Pose),
        parts: &[usize],
        painted: &mut BTreeMap<usize, Vec<f64>>,
    ) -> Option<String> {
        let mut is_met = vec![false; self.0.len()];
        for &part in parts {
            let posed = &rest.parts[part];
            let triangles = &primitive(scene, posed).triangles;
            let strokes: Vec<usize> = (0..self.0.len()).filter(|&index| self.0[index].paints(posed.node)).collect();
            for (triangle, corners) in triangles.iter().enumerate() {
                let corners = corners.map(|corner| posed.positions[corner as usize].0.as_dvec3());
                let mut log_stiffness = 0.0;
                for &index in &strokes {
                    let stroke = &self.0[index];
                    let share = stroke.share(&corners);
                    is_met[index] |= share > 0.0;
                    log_stiffness += (stroke.stroke.value.ln() - log_stiffness) * share;
                }
                if log_stiffness != 0.0 {
                    let stiffness = painted.entry(part).or_default();
                    stiffness.resize(triangles.len(), 1.0);
                    stiffness[triangle] *= log_stiffness.exp();
                }
            }
        }
        let unmet = is_met.iter().filter(|is_met| !**is_met).count();
        (unmet > 0).then(|| {
            let strokes = pluralised(unmet, "brush stroke", "brush strokes");
            format!("none of its triangles at rest lies under {strokes} of its stiffness: without effect")
        })
    }
}

impl<'a> Stroke<'a> {
    fn new(stroke: &'a BrushStroke, scene: &Scene) -> Self {
        let nodes = stroke.nodes.iter().flat_map(|pattern| scene.matching(pattern));
        let nodes: BTreeSet<usize> = nodes.flat_map(|node| scene.subtree(node)).collect();
        let points = || stroke.points.iter().map(|&point| DVec3::from(point));
        let low = points().fold(DVec3::INFINITY, DVec3::min) - stroke.radius;
        let high = points().fold(DVec3::NEG_INFINITY, DVec3::max) + stroke.radius;
        Self { stroke, nodes: (!stroke.nodes.is_empty()).then_some(nodes), low, high }
    }

    fn paints(&self, node: usize) -> bool {
        self.nodes.as_ref().is_none_or(|nodes| nodes.contains(&node))
    }

    /// Returns how much of a triangle the stroke covers, 0 to 1.
    fn share(&self, corners: &[DVec3; 3]) -> f64 {
        let [a, b, c] = *corners;
        let is_apart = a.max(b).max(c).cmplt(self.low).any() || a.min(b).min(c).cmpgt(self.high).any();
        if is_apart {
            return 0.0;
        }
        let at = |weights: [f64; 3]| self.share_at(a * weights[0] + b * weights[1] + c * weights[2]);
        SAMPLES.into_iter().map(at).sum::<f64>() / SAMPLES.len() as f64
    }

    /// Returns how much the stroke applies at a point: fully near its line, and less towards its radius.
    fn share_at(&self, point: DVec3) -> f64 {
        let distance = distance(&self.stroke.points, point) / self.stroke.radius;
        let beyond = ((distance - FULL) / (1.0 - FULL)).clamp(0.0, 1.0);
        1.0 - beyond * beyond * (3.0 - 2.0 * beyond)
    }
}

/// Returns the distance of a point from a line through points.
fn distance(line: &[[f64; 3]], point: DVec3) -> f64 {
    let first = line.first().map_or(f64::INFINITY, |&first| DVec3::from(first).distance(point));
    let of_segment = |ends: &[[f64; 3]]| {
        let [from, to] = [DVec3::from(ends[0]), DVec3::from(ends[1])];
        let along = to - from;
        let t = (point - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        (from + along * t.clamp(0.0, 1.0)).distance(point)
    };
    line.windows(2).map(of_segment).fold(first, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stroke(points: &[[f64; 3]], value: f64) -> BrushStroke {
        BrushStroke { nodes: Vec::new(), points: points.to_vec(), radius: 1.0, value }
    }

    #[test]
    fn a_stroke_is_full_inside_and_ends_at_its_radius() {
        let stroke = stroke(&[[0.0; 3], [4.0, 0.0, 0.0]], 8.0);
        let drawn = Stroke { stroke: &stroke, nodes: None, low: DVec3::splat(-1.0), high: DVec3::new(5.0, 1.0, 1.0) };
        for (point, share) in
            [([2.0, 0.4, 0.0], 1.0), ([2.0, 0.75, 0.0], 0.5), ([2.0, 1.0, 0.0], 0.0), ([-0.4, 0.0, 0.0], 1.0)]
        {
            assert!((drawn.share_at(point.into()) - share).abs() < 1e-9, "{point:?}");
        }
        let far = [[9.0, 0.0, 0.0], [9.0, 1.0, 0.0], [10.0, 0.0, 0.0]].map(DVec3::from);
        assert_eq!(drawn.share(&far), 0.0);
    }

    #[test]
    fn a_single_point_is_a_dab() {
        assert_eq!(distance(&[[1.0, 0.0, 0.0]], DVec3::new(1.0, 2.0, 0.0)), 2.0);
        assert_eq!(distance(&[[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], DVec3::new(1.0, 2.0, 0.0)), 2.0);
    }
}
