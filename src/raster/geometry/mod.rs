//! Builds the [`Geometry`] of one time: vertices placed on the screen, cut at the near plane, long edges split, warped.
//!
//! In: the scene, its pose and projection now, one frame later and one earlier, and a lattice a part.
//! Out: what a raster draws. Only places on the screen are warped; depth, normals and lighting stay the scene's own.

mod curvature;
mod lines;
mod sort;
mod split;
mod vertex;

use super::{Draw, Geometry, MATTE_LAYERS, RasterVertex};
use crate::image::cryptomatte::MatteId;
use crate::lattice::ScreenLattice;
use crate::pose::{Pose, PosedLight};
use crate::scene::{AlphaMode, Primitive, Scene};
use crate::screen::{Camera, ScreenMesh, primitive};
use curvature::Curvature;
use glam::DVec2;
use lines::Cutter;
use rayon::prelude::*;
use split::Splitter;
use vertex::{DepthRange, Loose};

/// The scene on the screen at one time, with its solved lattices.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    /// The pose.
    pub pose: &'a Pose,
    /// The same pose, projected.
    pub mesh: &'a ScreenMesh,
    /// The camera it was projected with.
    pub camera: &'a Camera,
    /// One a part of the pose: the lattice that warps it, if any.
    pub lattices: &'a [Option<&'a ScreenLattice>],
}

/// What [`assemble`] needs.
#[derive(Clone, Copy, Debug)]
pub struct Assembly<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The time to draw.
    pub now: Moment<'a>,
    /// One frame later, then one frame earlier; `None` where motion is not wanted (it is then zero).
    pub neighbours: Option<[Moment<'a>; 2]>,
    /// One a part: 1 + index of the layer, 0 for none.
    pub layer_ids: &'a [u32],
    /// One a part: its ids in the Cryptomattes, in the order of [`MATTE_LAYERS`]; empty: none.
    pub mattes: &'a [[MatteId; MATTE_LAYERS.len()]],
    /// All lights.
    pub lights: &'a [PosedLight],
    /// Strength of the neutral surroundings.
    pub environment: f32,
    /// Width of lines, frame heights.
    pub line_width: f64,
}

/// One part, ready to be joined with the others.
struct BuiltPart {
    vertices: Vec<RasterVertex>,
    triangles: Vec<[u32; 3]>,
    /// Its indices are filled in when the parts are joined.
    draw: Draw,
    is_blended: bool,
}

/// Builds the geometry of one time.
#[must_use]
pub fn assemble(assembly: &Assembly) -> Geometry {
    let camera = assembly.now.camera;
    let range = DepthRange::of(assembly.now.mesh, camera);
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
    let warped = |loose: &Loose| loose.warped(lattices, range);
    let material = &scene.materials[source.material];
    let loose = vertex::gather(assembly, part);
    let (vertices, triangles) = if source.lines.is_empty() {
        faces(source, Splitter::new(loose, curvature.as_ref()), (now, part), warped)
    } else {
        let cutter = Cutter { vertices: &loose, near: now.camera.near(), curvature: curvature.as_ref() };
        ribbons(source, &cutter, (now.camera, assembly.line_width), warped)
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
    (now, part): (Moment, usize),
    warped: impl Fn(&Loose) -> RasterVertex + Send + Sync,
) -> (Vec<RasterVertex>, Vec<[u32; 3]>) {
    for corners in &source.triangles {
        splitter.add(*corners, now.camera.near());
    }
    let (loose, mut triangles) = splitter.finish();
    let vertices: Vec<RasterVertex> = loose.par_iter().with_min_len(2048).map(warped).collect();
    if now.lattices[part].is_some() {
        keep_facing(&mut triangles, &loose, &vertices);
    }
    (vertices, triangles)
}

/// Vertices and triangles of lines.
fn ribbons(
    source: &Primitive,
    cutter: &Cutter,
    (camera, width): (&Camera, f64),
    warped: impl Fn(&Loose) -> RasterVertex,
) -> (Vec<RasterVertex>, Vec<[u32; 3]>) {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for run in source.lines.iter().flat_map(|line| cutter.runs(line)) {
        let points: Vec<RasterVertex> = run.iter().map(&warped).collect();
        lines::add_ribbon(&points, (camera, width), (&mut vertices, &mut triangles));
    }
    (vertices, triangles)
}

/// Turns triangles that the warp turned over, so that they face the viewer if they did before it: a fold shows the
/// side that was seen, it does not open a hole.
fn keep_facing(triangles: &mut [[u32; 3]], loose: &[Loose], vertices: &[RasterVertex]) {
    let side = |[a, b, c]: [DVec2; 3]| (b - a).perp_dot(c - a);
    for corners in triangles {
        let before = side(corners.map(|corner| loose[corner as usize].places[0].point().0));
        let after = side(corners.map(|corner| {
            let [x, y, _, w] = vertices[corner as usize].screen.map(f64::from);
            DVec2::new(x, y) / w
        }));
        if before * after < 0.0 {
            corners.swap(1, 2);
        }
    }
}
