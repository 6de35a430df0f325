//! Paints stiffness with the brush strokes of a layer, later strokes over earlier ones.
//!
//! In: strokes in the scene at rest, the parts of the layer. Out: the stiffness of the triangles that they cover, multiplied
//! with what the rules of the layer say. A stroke spreads along the surface, so what lies behind or beside it is not painted.

use super::surface_distance::SurfaceDistance;
use crate::pipeline::PipelineError;
use crate::pose::Pose;
use crate::scene::Scene;
use crate::screen::primitive;
use crate::shot::{BrushStroke, Shot};
use crate::smoothstep::smoothstep;
use crate::spelling::{self, pluralised};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};

/// Fraction of the radius up to which a stroke applies fully.
const FULL: f64 = 0.5;

/// Distance in radii between the points of a stroke's line from which it spreads.
const SPACING: f64 = 0.15;

/// Maximum number of such points between two points of the file.
const MAX_SOURCES: f64 = 1000.0;

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

/// What a stroke covers: part, triangle, and how much of it, above 0 and up to 1.
type PaintedTriangles = Arc<[(usize, usize, f64)]>;

/// What the strokes of a shot cover, so that a new stroke does not compute that of the others again.
#[derive(Debug, Default)]
pub(in crate::pipeline) struct StrokeCache(Mutex<Vec<(usize, BrushStroke, PaintedTriangles)>>);

impl StrokeCache {
    /// Returns what a stroke of a layer covers. Strokes at the same places cover the same, whatever they paint.
    fn coverage(
        &self,
        layer: usize,
        stroke: &BrushStroke,
        compute: impl FnOnce() -> PaintedTriangles,
    ) -> PaintedTriangles {
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_same = |(owner, other, _): &&(usize, BrushStroke, PaintedTriangles)| {
            *owner == layer
                && other.radius == stroke.radius
                && other.points == stroke.points
                && other.nodes == stroke.nodes
        };
        if let Some((_, _, coverage)) = known().iter().find(is_same) {
            return Arc::clone(coverage);
        }
        let coverage = compute();
        known().push((layer, stroke.clone(), Arc::clone(&coverage)));
        coverage
    }

    /// Forgets strokes that a shot no longer has.
    pub(in crate::pipeline) fn retain(&self, shot: &Shot) {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.retain(|(layer, stroke, _)| shot.layers.get(*layer).is_some_and(|layer| layer.strokes.contains(stroke)));
    }
}

/// The parts of a layer at rest.
#[derive(Clone, Copy)]
pub(in crate::pipeline) struct RestParts<'a> {
    pub(in crate::pipeline) scene: &'a Scene,
    pub(in crate::pipeline) rest: &'a Pose,
    /// Indices into the parts of the pose.
    pub(in crate::pipeline) parts: &'a [usize],
}

/// The strokes of a layer.
pub(in crate::pipeline) struct Strokes<'a> {
    layer: usize,
    strokes: Vec<Stroke<'a>>,
}

/// A stroke with the nodes that it paints.
struct Stroke<'a> {
    stroke: &'a BrushStroke,
    /// `None`: all nodes.
    nodes: Option<BTreeSet<usize>>,
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
            let nodes = stroke.nodes.iter().flat_map(|pattern| scene.matching(pattern));
            let nodes: BTreeSet<usize> = nodes.flat_map(|node| scene.subtree(node)).collect();
            Ok(Stroke { stroke, nodes: (!stroke.nodes.is_empty()).then_some(nodes) })
        });
        Ok(Self { layer, strokes: strokes.collect::<Result<_, _>>()? })
    }

    /// Multiplies the stiffness of the triangles that the strokes cover. Returns a note if strokes cover none.
    pub(in crate::pipeline) fn paint(
        &self,
        on: RestParts,
        cache: &StrokeCache,
        painted: &mut BTreeMap<usize, Vec<f64>>,
    ) -> Option<String> {
        let mut log_stiffness: BTreeMap<(usize, usize), f64> = BTreeMap::new();
        let mut unmet = 0;
        for stroke in &self.strokes {
            let compute = || stroke.coverage(on);
            let coverage = cache.coverage(self.layer, stroke.stroke, compute);
            unmet += usize::from(coverage.is_empty());
            for &(part, triangle, share) in coverage.iter() {
                let value = log_stiffness.entry((part, triangle)).or_default();
                *value += (stroke.stroke.value.ln() - *value) * share;
            }
        }
        for ((part, triangle), value) in log_stiffness.into_iter().filter(|(_, value)| *value != 0.0) {
            let stiffness = painted.entry(part).or_default();
            stiffness.resize(primitive(on.scene, &on.rest.parts[part]).triangles.len(), 1.0);
            stiffness[triangle] *= value.exp();
        }
        (unmet > 0).then(|| {
            let strokes = pluralised(unmet, "brush stroke", "brush strokes");
            format!("none of its triangles at rest lies under {strokes} of its stiffness: without effect")
        })
    }
}

impl Stroke<'_> {
    fn paints(&self, node: usize) -> bool {
        self.nodes.as_ref().is_none_or(|nodes| nodes.contains(&node))
    }

    /// Returns what the stroke covers of some parts.
    fn coverage(&self, RestParts { scene, rest, parts }: RestParts) -> PaintedTriangles {
        let line: Vec<DVec3> = self.stroke.points.iter().map(|&point| DVec3::from(point)).collect();
        let low = line.iter().copied().fold(DVec3::INFINITY, DVec3::min) - self.stroke.radius;
        let high = line.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max) + self.stroke.radius;
        let (mut near, mut places) = (Vec::new(), Vec::new());
        for &part in parts {
            let posed = &rest.parts[part];
            let all = if self.paints(posed.node) { &primitive(scene, posed).triangles[..] } else { &[] };
            for (triangle, corners) in all.iter().enumerate() {
                let [a, b, c] = corners.map(|corner| posed.positions[corner as usize].0.as_dvec3());
                let is_apart = a.max(b).max(c).cmplt(low).any() || a.min(b).min(c).cmpgt(high).any();
                if !is_apart {
                    near.push((part, triangle));
                    places.push([a, b, c]);
                }
            }
        }
        let distance = SurfaceDistance::new(&places, &sources(&line, self.stroke.radius), self.stroke.radius);
        let share = |index: usize| {
            let at = |weights: [f64; 3]| falloff(distance.of(index, weights) / self.stroke.radius);
            SAMPLES.into_iter().map(at).sum::<f64>() / SAMPLES.len() as f64
        };
        let covered = near.into_iter().enumerate().map(|(index, (part, triangle))| (part, triangle, share(index)));
        covered.filter(|(_, _, share)| *share > 0.0).collect()
    }
}

/// Returns how much a stroke applies at a distance in radii: fully near its line, and less towards its radius.
fn falloff(distance: f64) -> f64 {
    1.0 - smoothstep((distance - FULL) / (1.0 - FULL))
}

/// Returns points along a line through points.
fn sources(line: &[DVec3], radius: f64) -> Vec<DVec3> {
    let mut found: Vec<DVec3> = line.first().copied().into_iter().collect();
    for ends in line.windows(2) {
        let count = (ends[0].distance(ends[1]) / (SPACING * radius)).ceil().clamp(1.0, MAX_SOURCES) as usize;
        found.extend((1..=count).map(|step| ends[0].lerp(ends[1], step as f64 / count as f64)));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stroke_is_full_inside_and_ends_at_its_radius() {
        for (distance, share) in [(0.0, 1.0), (0.5, 1.0), (0.75, 0.5), (1.0, 0.0), (f64::INFINITY, 0.0)] {
            assert!((falloff(distance) - share).abs() < 1e-9, "{distance}");
        }
    }

    #[test]
    fn a_line_has_points_close_to_each_other_and_never_too_many() {
        let line = [DVec3::ZERO, DVec3::X, DVec3::X];
        let found = sources(&line, 1.0);
        assert_eq!((found[0], found.len(), found[found.len() - 1]), (DVec3::ZERO, 9, DVec3::X));
        assert!(found.windows(2).all(|pair| pair[0].distance(pair[1]) <= SPACING + 1e-9));
        assert_eq!(sources(&[DVec3::ZERO, DVec3::X * 1e9], 1e-5).len(), 1001);
        assert_eq!(sources(&line[..1], 1.0), [DVec3::ZERO]);
    }
}
