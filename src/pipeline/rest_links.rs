//! Which triangles of a layer hang together, for lattices that branch: as the scene stands at rest, not as the screen shows it.
//!
//! In: a scene, the parts of a layer, the strokes that cut its picture. Out: [`Link`]s between its triangles, those of all parts
//! counted through.

use super::PipelineError;
use super::rest_mesh::{RestMesh, rest_pose};
use crate::scene::Scene;
use crate::shot::{Layer, Shot, Source};
use crate::solve::{Link, LinkEnd, Topology, solid_links, surface_links};
use std::sync::Arc;

/// One a layer; `None`: its lattice does not branch, or it is a whole picture, which hangs together as it lies.
///
/// # Errors
/// [`PipelineError::Mismatch`] where a stroke cuts nothing.
pub(super) fn rest_links(
    shot: &Shot,
    scene: &Scene,
    parts_of_layer: &[Vec<usize>],
) -> Result<Vec<Option<Arc<Vec<Link>>>>, PipelineError> {
    let mut rest = None;
    let mut all = Vec::with_capacity(shot.layers.len());
    for (index, (layer, parts)) in shot.layers.iter().zip(parts_of_layer).enumerate() {
        let is_solid = matches!(shot.source, Source::Scene(_));
        if layer.settings.topology == Topology::Plain || !is_solid && layer.cuts.is_empty() {
            all.push(None);
            continue;
        }
        let mesh = RestMesh::of(scene, rest.get_or_insert_with(|| rest_pose(scene)), parts);
        let links = if is_solid { links_of_solid(&mesh) } else { links_of_picture(shot, (index, layer), &mesh)? };
        all.push(Some(Arc::new(links)));
    }
    Ok(all)
}

/// Links along the surface and through the solid.
fn links_of_solid(mesh: &RestMesh) -> Vec<Link> {
    let mut links = surface_links(&mesh.points, &mesh.triangles);
    links.extend(solid_links(&mesh.points, &mesh.triangles));
    let in_own_order = |end: &mut LinkEnd| {
        if mesh.is_mirrored[end.triangle as usize] {
            end.barycentric.swap(1, 2);
        }
    };
    links.iter_mut().flat_map(|link| &mut link.ends).for_each(in_own_order);
    links
}

/// Links of a flat picture but those that strokes cut.
fn links_of_picture(shot: &Shot, (index, layer): (usize, &Layer), mesh: &RestMesh) -> Result<Vec<Link>, PipelineError> {
    // Cards lie flat: their x and y are those of the screen.
    let points: Vec<[f64; 2]> = mesh.points.iter().map(|&[x, y, _]| [x, y]).collect();
    let mut links = surface_links(&points, &mesh.triangles);
    let middle = |end: &LinkEnd| -> [f64; 2] {
        let corners = mesh.triangles[end.triangle as usize].map(|corner| points[corner as usize]);
        [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0)
    };
    for (number, stroke) in layer.cuts.iter().enumerate() {
        let before = links.len();
        links.retain(|link| {
            let way = link.ends.each_ref().map(middle);
            !stroke.windows(2).any(|segment| meet(way, [segment[0], segment[1]]))
        });
        if links.len() == before {
            let what = format!("layer '{}': stroke {number} cuts nothing", layer.name);
            let hint = "draw it across the picture, in frame heights, y up: [0, 0] is the lower left corner";
            return Err(PipelineError::mismatch(shot, &format!("layer[{index}].lattice.cuts[{number}]"), what, hint));
        }
    }
    Ok(links)
}

/// Whether two segments cross or touch.
fn meet([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0 && a != b
}
