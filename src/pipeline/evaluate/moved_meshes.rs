//! Moves the meshes of the scene by the lattices of world layers.
//!
//! In: a pose and the solved layers. Out: the deformed pose. Tangents are transformed by the lattice's gradient,
//! normals by its cofactor matrix (the inverse transpose up to a factor, which normalisation removes).

use super::part_triangle_ranges::triangles_of;
use crate::lattice::SceneLattice;
use crate::pipeline::prepare::selection::SharedPart;
use crate::pipeline::{LayerAssignment, LayerState, WorldSolution};
use crate::pose::{Pose, PosedPart};
use crate::raster::geometry::vertex_triangles;
use crate::scene::{Primitive, Scene};
use crate::screen::primitive;
use crate::space::{ScenePoint, SceneVector};
use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

/// Minimum number of vertices per parallel task.
const CHUNK: usize = 2048;

/// Moves the meshes of all solved world layers.
pub(in crate::pipeline) fn move_meshes(
    (scene, assignment): (&Scene, &LayerAssignment),
    pose: &mut Pose,
    layers: &[LayerState],
) {
    let lattices: Vec<Vec<SceneLattice>> = layers.iter().map(lattices_of).collect();
    for (index, part) in pose.parts.iter_mut().enumerate() {
        let source = primitive(scene, part);
        let of_layer = |layer: usize| {
            let branch_of_vertex = branch_of_vertex(&layers[layer], (index, source), &part.positions);
            (!lattices[layer].is_empty()).then(|| PartLattice { lattices: &lattices[layer], branch_of_vertex })
        };
        match &assignment.shared_parts[index] {
            None => {
                let Some(lattice) = assignment.layer_of_part[index].and_then(of_layer) else { continue };
                move_part(part, |vertex, point| lattice.warp_with_gradient(vertex, point));
            }
            Some(shared) => {
                let lattices: Vec<_> = shared.layers.iter().map(|&layer| of_layer(layer)).collect();
                if lattices.iter().any(Option::is_some) {
                    let slopes = weight_slopes(shared, &source.triangles, &part.positions);
                    let blend = Blend { shared, lattices, slopes };
                    move_part(part, |vertex, point| blend.warp(vertex, point));
                }
            }
        }
    }
}

/// Returns the lattices of a solved world layer: one per branch, or a single one; none for other layers, and for a layer at rest, whose
/// meshes stay as they are to the bit.
fn lattices_of(state: &LayerState) -> Vec<SceneLattice> {
    let Some(WorldSolution { lattice, branches, .. }) = &state.world else { return Vec::new() };
    let lattices = match branches {
        None => vec![lattice.clone()],
        Some(branches) => {
            let placed = |branch| SceneLattice { lattice: branches.lattice(branch), ..lattice.clone() };
            (0..branches.branch_count()).map(placed).collect()
        }
    };
    let is_moved = |placed: &SceneLattice| placed.lattice.handles != placed.lattice.grid.at_rest().handles;
    if lattices.iter().any(is_moved) { lattices } else { Vec::new() }
}

/// Returns the branch that each vertex of a part belongs to; empty if the layer does not branch.
fn branch_of_vertex(state: &LayerState, (part, source): (usize, &Primitive), positions: &[ScenePoint]) -> Vec<usize> {
    let Some(WorldSolution { lattice, branches: Some(branches), .. }) = &state.world else { return Vec::new() };
    let branch = |(triangle, point): (&u32, &ScenePoint)| {
        let point = lattice.frame.box_from_scene(point.0.as_dvec3()).to_array();
        let own = triangles_of(&state.starts, part, *triangle as usize);
        // The layer does not move vertices without a triangle in its shape.
        own.map_or(0, |own| branches.branch_within(own, point))
    };
    vertex_triangles(source).iter().zip(positions).map(branch).collect()
}

/// How a layer moves the vertices of one part.
struct PartLattice<'a> {
    /// One per branch.
    lattices: &'a [SceneLattice],
    /// The branch of each vertex; empty if there is only one.
    branch_of_vertex: Vec<usize>,
}

impl PartLattice<'_> {
    /// Returns the image of a vertex at a point, and the gradient there.
    fn warp_with_gradient(&self, vertex: usize, point: DVec3) -> (DVec3, DMat3) {
        let branch = self.branch_of_vertex.get(vertex).copied().unwrap_or(0);
        self.lattices[branch].warp_with_gradient(point)
    }
}

fn move_part(part: &mut PosedPart, warp: impl Fn(usize, DVec3) -> (DVec3, DMat3) + Sync) {
    let moved: Vec<(Vec3, DMat3)> = part
        .positions
        .par_iter()
        .with_min_len(CHUNK)
        .enumerate()
        .map(|(vertex, point)| {
            let (place, gradient) = warp(vertex, point.0.as_dvec3());
            (place.as_vec3(), gradient)
        })
        .collect();
    for (vertex, (place, gradient)) in moved.into_iter().enumerate() {
        part.positions[vertex] = ScenePoint(place);
        if let Some(normal) = part.normals.get_mut(vertex) {
            let [x, y, z] = [gradient.x_axis, gradient.y_axis, gradient.z_axis];
            let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
            *normal = SceneVector(turned(cofactors, normal.0));
        }
        if let Some(tangent) = part.tangents.get_mut(vertex) {
            *tangent = turned(gradient, tangent.truncate()).extend(tangent.w);
        }
    }
}

/// Transforms and normalises a direction; returns it unchanged if the result is zero.
fn turned(by: DMat3, direction: Vec3) -> Vec3 {
    (by * direction.as_dvec3()).try_normalize().map_or(direction, |turned| turned.as_vec3())
}

/// The lattices that together move the vertices of one part.
struct Blend<'a> {
    shared: &'a SharedPart,
    /// One per layer of the part.
    lattices: Vec<Option<PartLattice<'a>>>,
    /// Gradients of the weights: #vertices x #layers.
    slopes: Vec<DVec3>,
}

impl Blend<'_> {
    /// Returns the image of a vertex and the gradient there: x + Σ wᵢ dᵢ(x), and I + Σ wᵢ ∇dᵢ + dᵢ ∇wᵢᵀ.
    fn warp(&self, vertex: usize, point: DVec3) -> (DVec3, DMat3) {
        let (mut place, mut gradient) = (point, DMat3::IDENTITY);
        let count = self.lattices.len();
        let weights = self.shared.at(vertex as u32).iter().zip(&self.slopes[vertex * count..]);
        for (lattice, (&weight, &slope)) in self.lattices.iter().zip(weights) {
            let Some(lattice) = lattice.as_ref().filter(|_| weight > 0.0 || slope != DVec3::ZERO) else { continue };
            let (moved, own) = lattice.warp_with_gradient(vertex, point);
            if weight == 1.0 && slope == DVec3::ZERO {
                return (moved, own);
            }
            let (by, weight) = (moved - point, f64::from(weight));
            place += by * weight;
            gradient += (own - DMat3::IDENTITY) * weight + DMat3::from_cols(by * slope.x, by * slope.y, by * slope.z);
        }
        (place, gradient)
    }
}

/// Returns the gradients of a part's weights along its surface, per metre: #vertices x #layers, area-weighted means
/// over the triangles at each vertex.
fn weight_slopes(shared: &SharedPart, triangles: &[[u32; 3]], positions: &[ScenePoint]) -> Vec<DVec3> {
    let count = shared.layers.len();
    let mut slopes = vec![DVec3::ZERO; positions.len() * count];
    let mut areas = vec![0.0; positions.len()];
    for corners in triangles {
        let [a, b, c] = corners.map(|corner| positions[corner as usize].0.as_dvec3());
        let normal = (b - a).cross(c - a);
        let area = normal.length();
        if area <= 0.0 {
            continue;
        }
        // The gradient of the linear function that is 1 at a corner and 0 at the others, times twice the area.
        let opposite = [c - b, a - c, b - a].map(|edge| normal.cross(edge) / area);
        for layer in 0..count {
            let weights = corners.map(|corner| f64::from(shared.at(corner)[layer]));
            let slope: DVec3 = opposite.iter().zip(weights).map(|(&gradient, weight)| gradient * weight).sum();
            corners.iter().for_each(|&corner| slopes[corner as usize * count + layer] += slope);
        }
        corners.iter().for_each(|&corner| areas[corner as usize] += area);
    }
    for (slopes, area) in slopes.chunks_mut(count).zip(&areas).filter(|(_, area)| **area > 0.0) {
        slopes.iter_mut().for_each(|slope| *slope /= *area);
    }
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_of_a_linear_weight_are_its_gradient() {
        let places = [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 3.0, 1.0], [2.0, 3.0, 1.0_f32]];
        let positions = places.map(|place| ScenePoint(Vec3::from_array(place)));
        let weight = |[x, y, _]: [f32; 3]| 0.1 + 0.2 * x + 0.05 * y;
        let triangles = [[0, 1, 2], [2, 1, 3]];
        let shared = SharedPart::new(&[(0, places.map(weight).to_vec())], &triangles);
        for slope in weight_slopes(&shared, &triangles, &positions) {
            assert!((slope - DVec3::new(0.2, 0.05, 0.0)).length() < 1e-6, "{slope}");
        }
    }
}
