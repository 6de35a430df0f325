//! Builds the [`Geometry`] of one time: vertices projected, clipped at the near plane, long edges split, warped.
//!
//! In: the scene, its pose and camera now, one frame later and one earlier, and a lattice for each part.
//! Out: what a raster draws. Only positions on the screen are warped; depth, normals and lighting stay unwarped.

mod assembly;
mod curvature;
mod lines;
mod sort;
mod split;
mod vertex;

pub use assembly::{Assembly, PosedScene};

use super::{Draw, Geometry, RasterVertex};
use crate::scene::{AlphaMode, Primitive};
use crate::screen::{Camera, primitive};
use assembly::BuiltPart;
use curvature::Curvature;
use glam::DVec2;
use lines::LineClipper;
use rayon::prelude::*;
use split::Splitter;
use vertex::{ClipVertex, DepthRange, VertexList};

/// Builds the geometry of one time.
#[must_use]
pub fn assemble(assembly: &Assembly) -> Geometry {
    let camera = assembly.now.camera;
    let range = DepthRange::of(assembly.now.pose, camera);
    let parts: Vec<BuiltPart> =
        (0..assembly.now.pose.parts.len()).into_par_iter().map(|part| build(assembly, part, range)).collect();
    let mut geometry = Geometry {
        eye: camera.eye(),
        parallel_view: camera.is_parallel().then(|| camera.towards_viewer()),
        lights: assembly.lights.to_vec(),
        environment: assembly.environment,
        ..Geometry::default()
    };
    sort::join(parts, &mut geometry);
    geometry
}

/// Places, cuts, splits and warps one part.
fn build(assembly: &Assembly, part: usize, range: DepthRange) -> BuiltPart {
    let Assembly { scene, now, neighbours, .. } = *assembly;
    let posed = &now.pose.parts[part];
    let source = primitive(scene, posed);
    let lattice = now.lattices[part];
    let curvature = lattice.map(Curvature::of);
    let lattices =
        [lattice, neighbours.and_then(|n| n[0].lattices[part]), neighbours.and_then(|n| n[1].lattices[part])];
    let warped = |vertex: &ClipVertex| vertex.warped(lattices, range);
    let material = &scene.materials[source.material];
    let list = VertexList::new(assembly, part);
    let (vertices, triangles) = if source.lines.is_empty() {
        faces(source, Splitter::new(list, source.triangles.len(), curvature.as_ref()), (now, part), warped)
    } else {
        let clipper = LineClipper { vertices: &list, near: now.camera.near(), curvature: curvature.as_ref() };
        ribbons(source, &clipper, (now.camera, assembly.line_width), warped)
    };
    BuiltPart {
        vertices,
        triangles,
        draw: Draw {
            indices: 0..0,
            material: source.material as u32,
            layer_id: assembly.layer_ids[part],
            object_id: posed.node as u32 + 1,
            mattes: assembly.mattes.get(part).copied().unwrap_or_default(),
            is_mirrored: posed.is_mirrored,
        },
        is_blended: material.alpha == AlphaMode::Blend,
    }
}

/// Vertices and triangles of a surface.
fn faces(
    source: &Primitive,
    mut splitter: Splitter,
    (now, part): (PosedScene, usize),
    warped: impl Fn(&ClipVertex) -> RasterVertex + Send + Sync,
) -> (Vec<RasterVertex>, Vec<[u32; 3]>) {
    for corners in &source.triangles {
        splitter.add(*corners, now.camera.near());
    }
    let (list, mut triangles) = splitter.finish();
    let one = |index: u32| warped(&list.get(index));
    let vertices: Vec<RasterVertex> = (0..list.len() as u32).into_par_iter().with_min_len(2048).map(one).collect();
    if now.lattices[part].is_some() {
        keep_facing(&mut triangles, &list, &vertices);
    }
    (vertices, triangles)
}

/// Vertices and triangles of lines.
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

/// Turns triangles that the warp turned over, so that they face the viewer if they did before it: a fold shows the
/// side that was seen, it does not open a hole.
fn keep_facing(triangles: &mut [[u32; 3]], list: &VertexList, vertices: &[RasterVertex]) {
    let side = |[a, b, c]: [DVec2; 3]| (b - a).perp_dot(c - a);
    for corners in triangles {
        let before = side(corners.map(|corner| list.projected(corner).point().0));
        let after = side(corners.map(|corner| {
            let [x, y, _, w] = vertices[corner as usize].screen.map(f64::from);
            DVec2::new(x, y) / w
        }));
        if before * after < 0.0 {
            corners.swap(1, 2);
        }
    }
}
