//! Vertices before and after the warp.
//!
//! In: a part's attributes and projections. Out: [`ClipVertex`]es, which may be interpolated along edges, and
//! [`RasterVertex`]es, which may not. Clip vertices are made when asked for: a mesh of millions of them is never held.

use super::assembly::Assembly;
use crate::lattice::ScreenLattice;
use crate::pose::{Pose, PosedPart};
use crate::raster::RasterVertex;
use crate::scene::Primitive;
use crate::screen::{Camera, Projected, primitive};
use crate::space::ScenePoint;
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

/// A vertex before the warp, as clipping and splitting need it: everything in it is linear over its triangle in scene
/// space.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ClipVertex {
    /// Projected now, one frame later, one frame earlier.
    pub(super) places: [Projected; 3],
    position: Vec3,
    normal: Vec3,
    tangent: Vec4,
    uv: Vec4,
    color: Vec4,
}

/// What z maps to 1 and 0: reversed, so that floats are fine where distances are large.
#[derive(Clone, Copy, Debug)]
pub(super) struct DepthRange {
    near: f64,
    /// Set for an orthographic lens; a perspective one needs no end.
    far: Option<f64>,
}

impl DepthRange {
    /// The range that holds all of a pose.
    pub(super) fn of(pose: &Pose, camera: &Camera) -> Self {
        let near = camera.near();
        let points = || pose.parts.iter().flat_map(|part| &part.positions);
        let depths = || points().map(|&point| camera.project(point).depth);
        let far = camera.is_parallel().then(|| depths().filter(|depth| depth.is_finite()).fold(near + 1e-3, f64::max));
        Self { near, far }
    }

    /// z·w of a vertex.
    fn z_times_w(self, place: Projected) -> f64 {
        match self.far {
            // near / w times w.
            None => self.near,
            // A hair above 0 at the far end: 0 is the cleared buffer.
            Some(far) => 1.0 - 0.999 * (place.depth - self.near) / (far - self.near),
        }
    }
}

/// The vertices of a part: those of its primitive, then those that were made on edges.
pub(super) struct VertexList<'a> {
    assembly: &'a Assembly<'a>,
    posed: &'a PosedPart,
    source: &'a Primitive,
    part: usize,
    /// Those of the primitive, projected now.
    projected: Vec<Projected>,
    made: Vec<ClipVertex>,
}

impl<'a> VertexList<'a> {
    pub(super) fn new(assembly: &'a Assembly, part: usize) -> Self {
        let posed = &assembly.now.pose.parts[part];
        let project = |&point: &ScenePoint| assembly.now.camera.project(point);
        let projected = posed.positions.par_iter().with_min_len(4096).map(project).collect();
        Self { assembly, posed, source: primitive(assembly.scene, posed), part, projected, made: Vec::new() }
    }

    pub(super) fn len(&self) -> usize {
        self.posed.positions.len() + self.made.len()
    }

    /// Adds a vertex; gives its index.
    pub(super) fn push(&mut self, vertex: ClipVertex) -> u32 {
        self.made.push(vertex);
        self.len() as u32 - 1
    }

    /// The vertex's projection now.
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
            // Also behind the camera: clipping and splitting mix places that are linear over the triangle.
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
    /// The vertex a share `t` of the way to `other`; symmetric for t = 0.5, so neighbours agree on it.
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

    /// The vertex as drawn: its three places moved by the lattices of their times, the rest as it was.
    pub(super) fn warped(&self, lattices: [Option<&ScreenLattice>; 3], range: DepthRange) -> RasterVertex {
        // A point that passes the near plane has no place on the screen there: it counts as still.
        let seen = |i: usize| if self.places[i].depth >= range.near && self.places[i].w > 0.0 { i } else { 0 };
        let [now, next, previous] = std::array::from_fn(|i| warp_place(self.places[seen(i)], lattices[seen(i)]));
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

/// Homogeneous screen position (x·w, y·w, w) after the warp.
fn warp_place(place: Projected, lattice: Option<&ScreenLattice>) -> [f32; 3] {
    let h = match lattice {
        // Vertices behind the camera are kept for their indices' sake and never drawn.
        Some(lattice) if place.w > 0.0 => lattice.warp(place.point()).0 * place.w,
        _ => place.h,
    };
    [h.x as f32, h.y as f32, place.w as f32]
}
