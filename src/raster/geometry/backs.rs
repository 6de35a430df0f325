//! Draws the back faces of closed surfaces where a warp uncovers them.
//!
//! In: the triangles of a part before and after the warp. Out: the same triangles with those added that face away from the viewer, turned
//! around. Without a warp the front faces of a closed surface cover all of its back faces, so culling these saves time and shows the same. Where
//! layers or branches move apart, or the warp folds, the front opens, and what lies behind the opening is the inside of the back.

use super::vertex::{VertexList, warped_doubled_area};
use crate::raster::RasterVertex;

/// Factor of z by which back faces lie farther away than they are: where they meet the front faces, at outlines, the front is visible.
const BEHIND: f32 = 1.0 - 1e-4;

/// The triangles of a part: submesh after submesh, with the end of each.
pub(super) type Faces = (Vec<RasterVertex>, Vec<[u32; 3]>, Vec<usize>);

/// Adds the back faces of closed surfaces. `is_mirrored`: whether front faces are clockwise. A part that reaches in front of the near plane,
/// which opens it, gets none.
pub(super) fn add_backs(
    (mut vertices, triangles, ends): Faces,
    list: &VertexList,
    is_mirrored: bool,
    near: f64,
) -> Faces {
    if (0..list.len() as u32).any(|vertex| list.projected(vertex).depth < near) {
        return (vertices, triangles, ends);
    }
    // After the warp triangles still face the way that they did before.
    let is_back = |corners: &[u32; 3]| {
        let area = warped_doubled_area(corners, &vertices);
        list.is_solid(corners[0]) && area != 0.0 && (area < 0.0) != is_mirrored
    };
    let is_back: Vec<bool> = triangles.iter().map(is_back).collect();
    let backs = is_back.iter().filter(|is_back| **is_back).count();
    // #vertices: the one turned around; its own number: there is none.
    let mut turned: Vec<u32> = (0..vertices.len() as u32).collect();
    let mut count = vertices.len() as u32;
    for (corners, _) in triangles.iter().zip(&is_back).filter(|(_, is_back)| **is_back) {
        for &corner in corners {
            if turned[corner as usize] == corner {
                turned[corner as usize] = count;
                count += 1;
            }
        }
    }
    vertices.resize(count as usize, RasterVertex::default());
    for (vertex, &turned) in turned.iter().enumerate().filter(|(vertex, turned)| **turned != *vertex as u32) {
        vertices[turned as usize] = turned_around(&vertices[vertex]);
    }
    let (mut all, mut all_ends) = (Vec::with_capacity(triangles.len() + backs), Vec::with_capacity(ends.len()));
    let mut from = 0;
    for end in ends {
        all.extend(&triangles[from..end]);
        for number in (from..end).filter(|number| is_back[*number]) {
            let [a, b, c] = triangles[number].map(|corner| turned[corner as usize]);
            all.push([a, c, b]);
        }
        all_ends.push(all.len());
        from = end;
    }
    (vertices, all, all_ends)
}

/// A vertex whose surface faces the other way.
fn turned_around(vertex: &RasterVertex) -> RasterVertex {
    let mut turned = *vertex;
    turned.screen[2] *= BEHIND;
    turned.normal = turned.normal.map(|x| -x);
    turned.tangent = turned.tangent.map(|x| -x);
    turned
}
