//! Softens the border of a selection, so that a mesh stretches between two layers instead of tearing.
//!
//! In: shares of the vertices of a mesh, 0 to 1. Out: shares that pass from 0 to 1 over at least a given distance along
//! the surface; unchanged where they already vary slowly.

use super::mesh_graph::MeshGraph;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Shares that differ by less count as equal.
const ROUNDING: f32 = 1e-5;

/// Softens the shares of a graph's vertices over a width in metres.
///
/// The result is the mean of the least majorant and the greatest minorant of limited slope (Pasch-Hausdorff envelopes), which leaves
/// soft transitions alone and keeps the middle of a hard border in place. The ramp across it is eased in and out.
pub(super) fn soften(graph: &MeshGraph, shares: &[f32], width: f32) -> Vec<f32> {
    if width.is_nan() || width <= 0.0 || shares.iter().all(|share| *share == shares[0]) {
        return shares.to_vec();
    }
    let slope = 2.0 / width;
    let above = majorant(graph, shares, slope);
    let inverted: Vec<f32> = shares.iter().map(|share| 1.0 - share).collect();
    let below = majorant(graph, &inverted, slope);
    let eased = |((&share, above), below): ((&f32, f32), f32)| {
        let ramp = 0.5 * (above + (1.0 - below));
        if (ramp - share).abs() <= ROUNDING {
            return share;
        }
        // Only borders between 0 and 1 are eased; intermediate painted values are kept as they are.
        let hardness = (2.0 * share - 1.0).powi(2);
        ramp + (ramp * ramp * (3.0 - 2.0 * ramp) - ramp) * hardness
    };
    shares.iter().zip(above).zip(below).map(eased).collect()
}

/// Returns the smallest values that are nowhere below the shares and nowhere steeper than `slope` per metre, by
/// Dijkstra's algorithm starting at the largest shares.
fn majorant(graph: &MeshGraph, shares: &[f32], slope: f32) -> Vec<f32> {
    let mut values = shares.to_vec();
    // The order of positive floats is that of their bits.
    let entry = |value: f32, vertex: u32| (value.to_bits(), Reverse(vertex));
    let is_source = |vertex: u32| {
        let own = shares[vertex as usize];
        graph.around(vertex).iter().any(|&(other, length)| own - length * slope > shares[other as usize])
    };
    let sources = (0..graph.count as u32).filter(|&vertex| is_source(vertex));
    let mut open: BinaryHeap<_> = sources.map(|vertex| entry(shares[vertex as usize], vertex)).collect();
    while let Some((bits, Reverse(vertex))) = open.pop() {
        let value = f32::from_bits(bits);
        if value < values[vertex as usize] {
            continue;
        }
        for &(other, length) in graph.around(vertex) {
            let carried = value - length * slope;
            if carried > values[other as usize] {
                values[other as usize] = carried;
                open.push(entry(carried, other));
            }
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Primitive;
    use glam::Vec3;

    /// A strip of squares of side 1 along x.
    fn strip(count: u32) -> (MeshGraph, Vec<f32>) {
        let positions: Vec<Vec3> = (0..=count).flat_map(|k| [0.0, 1.0].map(|y| Vec3::new(k as f32, y, 0.0))).collect();
        let triangles = (0..count).flat_map(|k| [[2 * k, 2 * k + 2, 2 * k + 1], [2 * k + 1, 2 * k + 2, 2 * k + 3]]);
        let primitive = Primitive { triangles: triangles.collect(), positions, ..Primitive::default() };
        let graph = MeshGraph::of(&[&primitive]);
        let mut x = vec![0.0; graph.count];
        for (vertex, &joint) in graph.joint_of[0].iter().enumerate() {
            x[joint as usize] = primitive.positions[vertex].x;
        }
        (graph, x)
    }

    #[test]
    fn a_hard_border_becomes_a_ramp_of_the_width_and_keeps_its_middle() {
        let (graph, x) = strip(40);
        let hard: Vec<f32> = x.iter().map(|x| f32::from(u8::from(*x > 20.0))).collect();
        let soft = soften(&graph, &hard, 10.0);
        for (x, share) in x.iter().zip(&soft) {
            let t = ((x - 15.5) / 10.0).clamp(0.0, 1.0);
            let wanted = t * t * (3.0 - 2.0 * t);
            assert!((share - wanted).abs() < 0.08, "{x}: {share} for {wanted}");
        }
    }

    #[test]
    fn what_is_soft_already_keeps_its_bits() {
        let (graph, x) = strip(40);
        let soft: Vec<f32> = x.iter().map(|x| (0.01 + x / 41.3).clamp(0.0, 1.0)).collect();
        assert_eq!(soften(&graph, &soft, 10.0), soft);
        let hard: Vec<f32> = x.iter().map(|x| f32::from(u8::from(*x > 20.0))).collect();
        assert_eq!(soften(&graph, &hard, 0.0), hard);
    }
}
