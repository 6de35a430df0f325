//! Copies and reorders the vertices of a primitive.
//!
//! In: the old index of every new vertex. Out: all per-vertex arrays in that order.

use super::Primitive;

/// Gives every triangle its own vertices; the order of triangles is kept.
pub(super) fn unshare_vertices(primitive: &mut Primitive) {
    let order: Vec<u32> = primitive.triangles.iter().flatten().copied().collect();
    gather_vertices(primitive, &order);
    // The caller's corners are u32, so three per triangle exceed that limit only with more memory than there is.
    let count = order.len() as u32;
    primitive.triangles = (0..count / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
}

/// Replaces the vertices by copies of vertices `order[0]`, `order[1]`, ...; the indices in triangles and lines are not
/// changed.
pub(super) fn gather_vertices(primitive: &mut Primitive, order: &[u32]) {
    gather(&mut primitive.positions, order);
    gather(&mut primitive.normals, order);
    gather(&mut primitive.tangents, order);
    gather(&mut primitive.colors, order);
    gather(&mut primitive.influences, order);
    primitive.uvs.iter_mut().for_each(|uvs| gather(uvs, order));
    for target in &mut primitive.targets {
        gather(&mut target.positions, order);
        gather(&mut target.normals, order);
        gather(&mut target.tangents, order);
    }
}

fn gather<T: Copy>(array: &mut Vec<T>, order: &[u32]) {
    if !array.is_empty() {
        *array = order.iter().map(|&vertex| array[vertex as usize]).collect();
    }
}
