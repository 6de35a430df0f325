//! Vertices before and after the warp.
//!
//! In: a part's attributes and projections. Out: [`ClipVertex`]es, which may be interpolated along edges, and
//! [`RasterVertex`]es, which may not. Clip vertices are created on demand, so a mesh of millions of them is never
//! stored.

use super::assembly::Assembly;
use super::part_warp::{PartPoint, PartWarp};
use crate::pose::{Pose, PosedPart};
use crate::raster::RasterVertex;
use crate::scene::Primitive;
use crate::screen::{Camera, Projected, primitive};
use crate::space::ScenePoint;
use glam::{DVec2, Vec2, Vec3, Vec4};
use rayon::prelude::*;

/// A vertex before the warp, as needed by clipping and splitting: all its fields are linear over its triangle in scene
/// space.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ClipVertex {
    /// Projections now, one frame later and one frame earlier.
    pub(super) places: [Projected; 3],
    position: Vec3,
    normal: Vec3,
    tangent: Vec4,
    uv: Vec4,
    color: Vec4,
}

/// The depths that z maps to 1 and 0: reversed, for floating-point precision at large distances.
#[derive(Clone, Copy, Debug)]
pub(super) struct DepthRange {
    near: f64,
    /// Set for an orthographic lens; a perspective one needs no far plane.
    far: Option<f64>,
}

impl DepthRange {
    /// Returns the range that contains all of a pose.
    pub(super) fn of(pose: &Pose, camera: &Camera) -> Self {
        let near = camera.near();
        let farthest = |part: &PosedPart| {
            let depths = part.positions.par_iter().with_min_len(4096).map(|&point| camera.project(point).depth);
            depths.filter(|depth| depth.is_finite()).reduce(|| near + 1e-3, f64::max)
        };
        let far = camera.is_parallel().then(|| pose.parts.iter().map(farthest).fold(near + 1e-3, f64::max));
        Self { near, far }
    }

    /// Returns z·w of a vertex.
    fn z_times_w(self, place: Projected) -> f64 {
        match self.far {
            // near / w times w.
            None => self.near,
            // Slightly above 0 at the far end: 0 is the cleared depth.
            Some(far) => 1.0 - 0.999 * (place.depth - self.near) / (far - self.near),
        }
    }
}

/// The vertices of a part: those of its primitive, then those created on edges.
pub(super) struct VertexList<'a> {
    assembly: &'a Assembly<'a>,
    posed: &'a PosedPart,
    source: &'a Primitive,
    part: usize,
    /// Projections of the primitive's vertices now.
    projected: Vec<Projected>,
    made: Vec<ClipVertex>,
    /// #created vertices: an end of the edge on which they were created.
    made_from: Vec<u32>,
    /// Weights of the created vertices, for parts with several lattices.
    made_weights: Vec<f32>,
    /// One triangle per vertex, for parts with a branching lattice: those of the primitive's vertices, then of the
    /// created ones.
    triangles: Vec<u32>,
}

impl<'a> VertexList<'a> {
    pub(super) fn new(assembly: &'a Assembly, part: usize) -> Self {
        let posed = &assembly.now.pose.parts[part];
        let project = |&point: &ScenePoint| assembly.now.camera.project(point);
        let projected = posed.positions.par_iter().with_min_len(4096).map(project).collect();
        let source = primitive(assembly.scene, posed);
        let warps = assembly.neighbours.iter().flatten().chain([&assembly.now]);
        let has_branches = warps.map(|time| &time.warps[part]).any(PartWarp::has_branches);
        let triangles = if has_branches { vertex_triangles(source) } else { Vec::new() };
        Self {
            assembly,
            posed,
            source,
            part,
            projected,
            made: Vec::new(),
            made_from: Vec::new(),
            made_weights: Vec::new(),
            triangles,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.posed.positions.len() + self.made.len()
    }

    /// Adds the vertex at a fraction of the way from one to another along an edge of a triangle; returns its index.
    pub(super) fn add_between(&mut self, (from, to): (u32, u32), share: f64, triangle: u32) -> u32 {
        if !self.triangles.is_empty() {
            self.triangles.push(triangle);
        }
        let (a, b) = ((1.0 - share) as f32, share as f32);
        let ends = self.weights(from).iter().zip(self.weights(to));
        let mixed: Vec<f32> = ends.map(|(from, to)| from * a + to * b).collect();
        self.made_weights.extend(mixed);
        self.made_from.push(from);
        self.made.push(self.get(from).lerp(&self.get(to), share));
        self.len() as u32 - 1
    }

    /// Returns the position of a vertex on the part.
    pub(super) fn on_part(&self, index: u32) -> PartPoint<'_> {
        let triangle = self.triangles.get(index as usize).copied().unwrap_or_default();
        PartPoint { weights: self.weights(index), triangle }
    }

    /// Returns the weights of a vertex, one per lattice; empty if a single lattice warps the part.
    fn weights(&self, index: u32) -> &[f32] {
        let (index, count) = (index as usize, self.posed.positions.len());
        match index.checked_sub(count) {
            None => self.assembly.now.warps[self.part].weights_of(index),
            Some(made) => {
                let lattices = self.made_weights.len().checked_div(self.made.len()).unwrap_or(0);
                self.made_weights.get(made * lattices..(made + 1) * lattices).unwrap_or(&[])
            }
        }
    }

    /// Returns whether a vertex lies on a closed surface that faces outwards.
    pub(super) fn is_solid(&self, index: u32) -> bool {
        let mut index = index as usize;
        while let Some(made) = index.checked_sub(self.posed.positions.len()) {
            index = self.made_from[made] as usize;
        }
        let solid = self.assembly.scene.meshes[self.posed.mesh].solid_vertices(self.posed.primitive);
        solid.get(index).copied().unwrap_or(false)
    }

    /// Returns the vertex's projection now.
    pub(super) fn projected(&self, index: u32) -> Projected {
        let index = index as usize;
        match self.made.get(index.wrapping_sub(self.posed.positions.len())) {
            Some(made) => made.places[0],
            None => self.projected[index],
        }
    }

    pub(super) fn get(&self, index: u32) -> ClipVertex {
        let index = index as usize;
        if let Some(made) = self.made.get(index.wrapping_sub(self.posed.positions.len())) {
            return *made;
        }
        let mut places = [self.projected[index]; 3];
        if let Some(neighbours) = &self.assembly.neighbours {
            // Points behind the camera are included: clipping and splitting interpolate positions that are linear over
            // the triangle.
            for (place, moment) in places[1..].iter_mut().zip(neighbours) {
                *place = moment.camera.project(moment.pose.parts[self.part].positions[index]);
            }
        }
        let uv = |set: usize| self.source.uvs[set].get(index).copied().unwrap_or(Vec2::ZERO);
        let (first, second) = (uv(0), uv(1));
        ClipVertex {
            places,
            position: self.posed.positions[index].0,
            normal: self.posed.normals[index].0,
            tangent: self.posed.tangents.get(index).copied().unwrap_or(Vec4::ZERO),
            uv: Vec4::new(first.x, first.y, second.x, second.y),
            color: self.source.colors.get(index).copied().unwrap_or(Vec4::ONE),
        }
    }
}

impl ClipVertex {
    /// Interpolates by a fraction `t` of the way to `other`; symmetric for t = 0.5, so neighbours agree on it.
    pub(super) fn lerp(&self, other: &Self, t: f64) -> Self {
        let (a, b) = ((1.0 - t) as f32, t as f32);
        Self {
            places: std::array::from_fn(|i| self.places[i].lerp(other.places[i], t)),
            position: self.position * a + other.position * b,
            normal: self.normal * a + other.normal * b,
            tangent: (self.tangent * a + other.tangent * b).truncate().extend(self.tangent.w),
            uv: self.uv * a + other.uv * b,
            color: self.color * a + other.color * b,
        }
    }

    /// Returns the vertex as drawn: its three positions warped, each with the warp of its time; other fields unchanged.
    pub(super) fn warped(&self, warps: [&PartWarp; 3], on: PartPoint, range: DepthRange) -> RasterVertex {
        // A point in front of the near plane at a neighbouring time has no screen position there: it is treated as
        // static.
        let seen = |i: usize| if self.places[i].depth >= range.near && self.places[i].w > 0.0 { i } else { 0 };
        let [now, next, previous] = std::array::from_fn(|i| warp_place(self.places[seen(i)], warps[seen(i)], on));
        let z = range.z_times_w(self.places[0]) as f32;
        RasterVertex {
            screen: [now[0], now[1], z, now[2]],
            position: self.position.to_array(),
            depth: self.places[0].depth as f32,
            normal: self.normal.to_array(),
            next,
            previous,
            tangent: self.tangent.to_array(),
            uv: self.uv.to_array(),
            color: self.color.to_array(),
        }
    }
}

/// Returns twice the area of a triangle; positive if its corners are counter-clockwise.
pub(super) fn doubled_area([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Returns the same for a warped triangle on the screen.
pub(super) fn warped_doubled_area(corners: &[u32; 3], vertices: &[RasterVertex]) -> f64 {
    doubled_area(corners.map(|corner| vertices[corner as usize].on_screen()))
}

/// Returns a triangle of every vertex, the first one, #vertices; 0 for vertices without triangles.
#[must_use]
pub(crate) fn vertex_triangles(source: &Primitive) -> Vec<u32> {
    let mut triangles = vec![0; source.positions.len()];
    for (number, corners) in source.triangles.iter().enumerate().rev() {
        corners.iter().for_each(|&corner| triangles[corner as usize] = number as u32);
    }
    triangles
}

/// Returns the homogeneous screen position (x·w, y·w, w) after the warp.
fn warp_place(place: Projected, warp: &PartWarp, on: PartPoint) -> [f32; 3] {
    // Vertices behind the camera are kept to preserve indices, and never drawn.
    let is_moved = place.w > 0.0 && !warp.is_rest();
    let h = if is_moved { warp.warp(place.point(), on).0 * place.w } else { place.h };
    [h.x as f32, h.y as f32, place.w as f32]
}
