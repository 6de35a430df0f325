//! Assembles the [`Geometry`] of one time: vertices are projected, clipped at the near plane, long edges split, and
//! warped.
//!
//! In: the scene, its pose and camera now, one frame later and one earlier, and the warp of each part. Out: the input
//! of a rasteriser. Only screen positions are warped; depth, normals and lighting remain unwarped.

mod assembly;
mod backs;
mod curvature;
mod edge_bends;
mod lines;
mod part_warp;
mod sort;
mod split;
mod vertex;

pub(crate) use assembly::KeptParts;
pub(crate) use assembly::{Assembly, PosedScene, Submesh};
pub(crate) use part_warp::PartPoint;
pub(crate) use part_warp::{BranchWarp, PartWarp, WarpBlend};

use super::{Draw, Geometry, RasterVertex};
use crate::scene::{AlphaMode, Primitive};
use crate::screen::{Camera, primitive};
use assembly::BuiltPart;
use backs::{Faces, add_backs};
use edge_bends::{EdgeBends, LatticeCurvatures};
use lines::LineClipper;
use rayon::prelude::*;
use split::Splitter;
use std::sync::atomic::{AtomicBool, Ordering};
pub(crate) use vertex::vertex_triangles;
use vertex::{ClipVertex, DepthRange, VertexList, doubled_area, warped_doubled_area};

/// Polled for cancellation; returns true once the result is no longer wanted.
pub(crate) type IsCancelled<'a> = dyn Fn() -> bool + Sync + 'a;

/// Twice the area over the squared longest edge of a projected triangle below which it is seen edge-on.
const EDGE_ON: f64 = 0.05;

/// Number of vertices between two polls.
const POLLED: u32 = 65_536;

/// Assembles the geometry of one time.
#[cfg(test)]
#[must_use]
pub(crate) fn assemble(assembly: &Assembly) -> Geometry {
    assemble_keeping(assembly, &KeptParts::default(), &|| false).unwrap_or_default()
}

/// Same as [`assemble`], with parts that have been built before. `None` if it was cancelled.
#[must_use]
pub(crate) fn assemble_keeping(assembly: &Assembly, kept: &KeptParts, is_cancelled: &IsCancelled) -> Option<Geometry> {
    let camera = assembly.now.camera;
    let range = DepthRange::of(assembly.now.pose, camera);
    let warps = assembly.split_for.unwrap_or(assembly.now.warps);
    let is_built = |part: &usize| !matches!(kept.parts.get(*part), Some(Some(part)) if part.get().is_some());
    let curvatures = LatticeCurvatures::of((0..warps.len()).filter(is_built).map(|part| &warps[part]));
    let build = |part: usize, is_cancelled: &IsCancelled| {
        build(assembly, part, (range, &curvatures.edge_bends(&warps[part])), is_cancelled)
    };
    let built = |part: usize| match kept.parts.get(part) {
        Some(Some(kept)) => kept.get_or_init(|| build(part, &|| false)).clone(),
        _ => build(part, is_cancelled),
    };
    let parts: Vec<BuiltPart> = (0..assembly.now.pose.parts.len()).into_par_iter().map(built).collect();
    if is_cancelled() {
        return None;
    }
    let mut geometry = Geometry {
        eye: camera.eye(),
        parallel_view: camera.is_parallel().then(|| camera.towards_viewer()),
        lights: assembly.lights.to_vec(),
        environment: assembly.environment,
        ..Geometry::default()
    };
    sort::join(parts, &mut geometry);
    Some(geometry)
}

/// Projects, clips, splits and warps one part; what is left out once it is cancelled is not seen.
fn build(
    assembly: &Assembly,
    part: usize,
    (range, bends): (DepthRange, &EdgeBends),
    is_cancelled: &IsCancelled,
) -> BuiltPart {
    let Assembly { scene, now, neighbours, .. } = *assembly;
    let posed = &now.pose.parts[part];
    let source = primitive(scene, posed);
    let (warp, rest) = (&now.warps[part], PartWarp::Rest);
    let beside = |side: usize| neighbours.map_or(&rest, |neighbours| &neighbours[side].warps[part]);
    let warps = [warp, beside(0), beside(1)];
    let warped = |vertex: &ClipVertex, on: PartPoint| vertex.warped(warps, on, range);
    let material = &scene.materials[source.material];
    let list = VertexList::new(assembly, part);
    let submeshes = &assembly.submeshes[part];
    let (vertices, triangles, ends) = if source.lines.is_empty() {
        let splitter = Splitter::new(list, source.triangles.len(), bends);
        let (faces, opening) = faces(assembly, part, splitter, warped, is_cancelled);
        match opening {
            Some(list) if !material.double_sided && material.alpha != AlphaMode::Blend => {
                add_backs(faces, &list, posed.is_mirrored, now.camera.near())
            }
            _ => faces,
        }
    } else {
        let clipper = LineClipper { vertices: &list, near: now.camera.near(), bends };
        let warped = |vertex: &ClipVertex| warped(vertex, PartPoint { weights: &[], triangle: 0 });
        let (vertices, triangles) = ribbons(source, &clipper, (now.camera, assembly.line_width), warped);
        let end = triangles.len();
        (vertices, triangles, vec![end; submeshes.len()])
    };
    let draw = |submesh: &Submesh| Draw {
        indices: 0..0,
        material: source.material as u32,
        layer_id: submesh.layer_id,
        object_id: posed.node as u32 + 1,
        mattes: submesh.mattes,
        is_mirrored: posed.is_mirrored,
    };
    let draws = submeshes.iter().map(draw).zip(ends).collect();
    BuiltPart { vertices, triangles, draws, is_blended: material.alpha == AlphaMode::Blend }
}

/// Returns vertices and triangles of a surface, submesh after submesh, and the end of each submesh's triangles. Once it is cancelled,
/// something is missing. With them comes the list of vertices if the warp may open the front of the part: a single lattice without folds
/// does not.
fn faces<'a>(
    assembly: &Assembly,
    part: usize,
    mut splitter: Splitter<'a>,
    warped: impl Fn(&ClipVertex, PartPoint) -> RasterVertex + Send + Sync,
    is_cancelled: &IsCancelled,
) -> (Faces, Option<VertexList<'a>>) {
    let Assembly { scene, now, .. } = *assembly;
    let (source, submeshes) = (primitive(scene, &now.pose.parts[part]), &assembly.submeshes[part]);
    let near = now.camera.near();
    let mut ends = Vec::with_capacity(submeshes.len());
    for submesh in submeshes {
        if is_cancelled() {
            break;
        }
        splitter.add_all(source, submesh.triangles.as_deref(), near);
        ends.push(splitter.count());
    }
    let (list, mut triangles) = splitter.finish();
    let is_over = AtomicBool::new(is_cancelled());
    let one = |index: u32| {
        if index.is_multiple_of(POLLED) && is_cancelled() {
            is_over.store(true, Ordering::Relaxed);
        }
        if is_over.load(Ordering::Relaxed) {
            return RasterVertex::default();
        }
        warped(&list.get(index), list.on_part(index))
    };
    let vertices: Vec<RasterVertex> = (0..list.len() as u32).into_par_iter().with_min_len(2048).map(one).collect();
    let warp = &now.warps[part];
    let is_opened = !warp.is_rest()
        && !is_over.into_inner()
        && (keep_facing(&mut triangles, &list, &vertices) || !matches!(warp, PartWarp::Lattice(_)));
    ((vertices, triangles, ends), is_opened.then_some(list))
}

/// Returns vertices and triangles of lines.
fn ribbons(
    source: &Primitive,
    clipper: &LineClipper,
    (camera, width): (&Camera, f64),
    warped: impl Fn(&ClipVertex) -> RasterVertex,
) -> (Vec<RasterVertex>, Vec<[u32; 3]>) {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for run in source.lines.iter().flat_map(|line| clipper.runs(line)) {
        let points: Vec<RasterVertex> = run.iter().map(&warped).collect();
        lines::add_ribbon(&points, (camera, width), (&mut vertices, &mut triangles));
    }
    (vertices, triangles)
}

/// Restores the orientation of triangles that the warp inverted, so that they face the viewer if they did before: a
/// fold shows its visible side instead of opening a hole. Returns whether any of them faced the viewer clearly: those seen edge-on, along
/// every outline, turn under the slightest warp and open nothing.
fn keep_facing(triangles: &mut [[u32; 3]], list: &VertexList, vertices: &[RasterVertex]) -> bool {
    let turned = triangles.par_iter_mut().with_min_len(2048).filter_map(|corners| {
        let [a, b, c] = corners.map(|corner| list.projected(corner).point().0);
        let (before, after) = (doubled_area([a, b, c]), warped_doubled_area(corners, vertices));
        let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        (before * after < 0.0).then(|| {
            corners.swap(1, 2);
            before.abs() > EDGE_ON * longest
        })
    });
    turned.reduce(|| false, |a, b| a | b)
}
