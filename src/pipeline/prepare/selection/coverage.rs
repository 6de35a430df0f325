//! Computes how much of every part a layer selects, before other layers take precedence.
//!
//! In: the resolved rules of a layer's selection. Out: a [`PartCoverage`] per part.

use super::feather::soften;
use super::mesh_graph::MeshGraph;
use super::rules::Rules;
use crate::pose::PosedPart;
use crate::scene::{Primitive, Scene};
use crate::screen::primitive;

/// Tolerance to rounding in the weights of skins and the pixels of masks, within which a share counts as 0 or 1.
const ROUNDING: f32 = 1e-4;

/// How much of a part a layer selects.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum PartCoverage {
    /// None of it.
    Nothing,
    /// All of it.
    All,
    /// #vertices, each 0 to 1.
    Vertices(Vec<f32>),
}

impl PartCoverage {
    /// Whether nothing that is drawn is selected.
    pub(super) const fn is_nothing(&self) -> bool {
        matches!(self, Self::Nothing)
    }

    fn at(&self, vertex: usize) -> f32 {
        match self {
            Self::Nothing => 0.0,
            Self::All => 1.0,
            Self::Vertices(shares) => shares[vertex],
        }
    }

    /// Converts shares to the simplest form: rounds shares near 0 and 1, and reduces equal shares of all drawn vertices
    /// to `Nothing` or `All`.
    fn simplified(mut shares: Vec<f32>, primitive: &Primitive) -> Self {
        for share in &mut shares {
            *share = if *share < ROUNDING { 0.0 } else { *share };
            *share = if *share > 1.0 - ROUNDING { 1.0 } else { *share };
        }
        let all_are =
            |wanted: f32| primitive.triangles.iter().flatten().all(|&corner| shares[corner as usize] == wanted);
        match (all_are(0.0), all_are(1.0)) {
            (true, _) => Self::Nothing,
            (_, true) => Self::All,
            _ => Self::Vertices(shares),
        }
    }
}

/// Returns the selected share of every part, with borders softened within the meshes of each node. `width`: relative to
/// the diagonal of a node's meshes.
pub(super) fn named(scene: &Scene, parts: &[PosedPart], rules: &Rules, width: f64) -> Vec<PartCoverage> {
    let mut named: Vec<PartCoverage> = parts.iter().map(|part| of_part(scene, part, rules)).collect();
    if rules.is_whole() {
        return named;
    }
    let mut first = 0;
    while first < parts.len() {
        let count = parts[first..].iter().take_while(|part| part.node == parts[first].node).count();
        let primitives: Vec<&Primitive> =
            parts[first..first + count].iter().map(|part| primitive(scene, part)).collect();
        soften_node(&mut named[first..first + count], &primitives, width);
        first += count;
    }
    named
}

fn of_part(scene: &Scene, part: &PosedPart, rules: &Rules) -> PartCoverage {
    let source = primitive(scene, part);
    if !rules.nodes.contains(&part.node) {
        return PartCoverage::Nothing;
    }
    if rules.is_whole() {
        return PartCoverage::All;
    }
    let shares: Vec<f32> = (0..source.positions.len()).map(|vertex| rules.share(scene, part, vertex)).collect();
    if source.lines.is_empty() {
        return PartCoverage::simplified(shares, source);
    }
    // A line has no width over which to blend: it belongs entirely to the side of its majority.
    let corners = || source.lines.iter().flatten();
    let sum: f32 = corners().map(|&corner| shares[corner as usize]).sum();
    if 2.0 * sum >= corners().count() as f32 { PartCoverage::All } else { PartCoverage::Nothing }
}

/// Softens the selection on the triangles of one node.
fn soften_node(named: &mut [PartCoverage], primitives: &[&Primitive], width: f64) {
    let surfaces: Vec<usize> = (0..named.len()).filter(|&part| primitives[part].lines.is_empty()).collect();
    let is_even = surfaces
        .iter()
        .all(|&part| !matches!(named[part], PartCoverage::Vertices(_)) && named[part] == named[surfaces[0]]);
    if is_even {
        return;
    }
    let meshes: Vec<&Primitive> = surfaces.iter().map(|&part| primitives[part]).collect();
    let graph = MeshGraph::of(&meshes);
    let (mut sums, mut counts) = (vec![0.0_f32; graph.count], vec![0_u32; graph.count]);
    for (&part, joint_of) in surfaces.iter().zip(&graph.joint_of) {
        for (vertex, &joint) in joint_of.iter().enumerate().filter(|(_, joint)| **joint != MeshGraph::UNUSED) {
            sums[joint as usize] += named[part].at(vertex);
            counts[joint as usize] += 1;
        }
    }
    let means: Vec<f32> = sums.iter().zip(&counts).map(|(sum, count)| sum / (*count).max(1) as f32).collect();
    let softened = soften(&graph, &means, (width * f64::from(graph.diagonal)) as f32);
    for (&part, joint_of) in surfaces.iter().zip(&graph.joint_of) {
        let share = |&joint: &u32| softened.get(joint as usize).copied().unwrap_or(0.0);
        named[part] = PartCoverage::simplified(joint_of.iter().map(share).collect(), primitives[part]);
    }
}
