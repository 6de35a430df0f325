//! Vertices before and after the warp.
//!
//! In: a part's attributes and projections. Out: [`Loose`] vertices, which may be halved along edges, and
//! [`RasterVertex`]es, which may not.

use super::Assembly;
use crate::lattice::ScreenLattice;
use crate::raster::RasterVertex;
use crate::screen::{Camera, Projected, ScreenMesh, primitive};
use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

/// A vertex before the warp: everything in it is linear over its triangle in scene space.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Loose {
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
    /// The range that holds all of a mesh.
    pub(super) fn of(mesh: &ScreenMesh, camera: &Camera) -> Self {
        let near = camera.near();
        let depths = || mesh.parts.iter().flat_map(|part| &part.vertices).map(|vertex| vertex.depth);
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

/// All vertices of a part, as loose vertices.
pub(super) fn gather(assembly: &Assembly, part: usize) -> Vec<Loose> {
    let posed = &assembly.now.pose.parts[part];
    let source = primitive(assembly.scene, posed);
    let uv_at = |set: usize, vertex: usize| source.uvs[set].get(vertex).copied().unwrap_or(Vec2::ZERO);
    let one = |vertex: usize| {
        let now = assembly.now.mesh.parts[part].vertices[vertex];
        let mut places = [now; 3];
        if let Some(neighbours) = &assembly.neighbours {
            // Also behind the camera: cutting and splitting mix places that are linear over the triangle.
            for (place, moment) in places[1..].iter_mut().zip(neighbours) {
                *place = moment.mesh.parts[part].vertices[vertex];
            }
        }
        let (first, second) = (uv_at(0, vertex), uv_at(1, vertex));
        Loose {
            places,
            position: posed.positions[vertex].0,
            normal: posed.normals[vertex].0,
            tangent: posed.tangents.get(vertex).copied().unwrap_or(Vec4::ZERO),
            uv: Vec4::new(first.x, first.y, second.x, second.y),
            color: source.colors.get(vertex).copied().unwrap_or(Vec4::ONE),
        }
    };
    (0..posed.positions.len()).into_par_iter().with_min_len(4096).map(one).collect()
}

impl Loose {
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
