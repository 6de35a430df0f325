//! Merges duplicate vertices, so that texture seams do not split one-rings.
//!
//! In: a shape. Out: the same shape with distinct points, in order of first appearance.

use super::problem::Shape;
use foldhash::fast::FixedState;
use std::collections::HashMap;

/// Merges vertices with bitwise equal coordinates (0 and −0 are equal).
pub(crate) fn merge_duplicates<const D: usize>(shape: &Shape<D>) -> Shape<D> {
    let mut first: HashMap<[u64; D], u32, FixedState> =
        HashMap::with_capacity_and_hasher(shape.points.len(), FixedState::default());
    let mut points = Vec::new();
    let index: Vec<u32> = shape
        .points
        .iter()
        .map(|point| {
            *first.entry(point.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                points.push(*point);
                points.len() as u32 - 1
            })
        })
        .collect();
    let triangles = shape.triangles.iter().map(|triangle| triangle.map(|corner| index[corner as usize])).collect();
    let strokes = shape.strokes.iter().map(|stroke| stroke.iter().map(|&point| index[point as usize]).collect());
    Shape {
        strokes: strokes.collect(),
        triangles,
        points,
        stiffness: shape.stiffness.clone(),
        links: shape.links.clone(),
    }
}
