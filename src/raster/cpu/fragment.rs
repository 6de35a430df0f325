//! A fragment, one pixel of one triangle: perspective-correct attributes, its colour and its data.
//!
//! In: a set-up triangle, its vertices, a pixel. Out: associated RGBA, depth, normal, motion.

use super::material::{Materials, Prepared};
use super::shading::{self, Light, Surface};
use super::texture::Footprint;
use super::triangle::Triangle;
use crate::raster::{Draw, Geometry, RasterVertex};
use glam::{IVec2, Vec2, Vec3, Vec4, Vec4Swizzles};

/// State shared by all triangles of a pass.
pub(super) struct Shade<'a> {
    pub(super) geometry: &'a Geometry,
    pub(super) materials: &'a Materials,
    pub(super) lights: &'a [Light],
    /// Pixels per unit of screen space, x and y.
    pub(super) pixels_per_unit: Vec2,
}

/// A triangle with everything needed to shade its pixels.
#[derive(Clone, Copy)]
pub(super) struct Face<'a> {
    pub(super) triangle: &'a Triangle,
    pub(super) draw: &'a Draw,
    pub(super) material: &'a Prepared,
    corners: [&'a RasterVertex; 3],
}

/// Perspective-correct barycentrics of the three corners.
#[derive(Clone, Copy, Debug)]
struct Barycentrics([f32; 3]);

impl Barycentrics {
    fn vec3(&self, of: [[f32; 3]; 3]) -> Vec3 {
        let [p, q, r] = of.map(Vec3::from);
        p * self.0[0] + q * self.0[1] + r * self.0[2]
    }

    fn vec4(&self, of: [[f32; 4]; 3]) -> Vec4 {
        let [p, q, r] = of.map(Vec4::from);
        p * self.0[0] + q * self.0[1] + r * self.0[2]
    }
}

impl<'a> Face<'a> {
    pub(super) fn of(shade: &Shade<'a>, triangle: &'a Triangle) -> Self {
        let draw = &shade.geometry.draws[triangle.draw as usize];
        let corners = triangle.corners.map(|corner| &shade.geometry.vertices[corner as usize]);
        Self { triangle, draw, material: shade.materials.get(draw.material), corners }
    }

    fn each<T>(&self, field: impl Fn(&RasterVertex) -> T) -> [T; 3] {
        self.corners.map(field)
    }

    /// Returns the barycentrics at a pixel centre.
    fn barycentrics(&self, pixel: IVec2) -> Barycentrics {
        let offset = pixel - self.triangle.min;
        let [second, third] = self.triangle.barycentrics.map(|plane| plane.at(offset));
        let w = self.triangle.inverse_w;
        let raw = [(1.0 - second - third) * w[0], second * w[1], third * w[2]];
        let scale = 1.0 / (raw[0] + raw[1] + raw[2]);
        Barycentrics(raw.map(|weight| weight * scale))
    }

    /// Returns their differences to the next pixel to the right and below.
    ///
    /// With screen barycentrics l and W = Σ lᵢ/wᵢ: bᵢ = lᵢ/(wᵢ W), so ∂bᵢ = (∂lᵢ/wᵢ − bᵢ ∂W)/W.
    fn barycentric_slopes(&self, pixel: IVec2, barycentrics: &Barycentrics) -> [Barycentrics; 2] {
        let offset = pixel - self.triangle.min;
        let planes = &self.triangle.barycentrics;
        let [second, third] = planes.map(|plane| plane.at(offset));
        let w = self.triangle.inverse_w;
        let whole = (1.0 - second - third) * w[0] + second * w[1] + third * w[2];
        [[planes[0].dx, planes[1].dx], [planes[0].dy, planes[1].dy]].map(|[second, third]| {
            let raw = [-(second + third) * w[0], second * w[1], third * w[2]];
            let slope = raw[0] + raw[1] + raw[2];
            Barycentrics([0, 1, 2].map(|i| (raw[i] - barycentrics.0[i] * slope) / whole))
        })
    }

    /// Returns the texture footprints of both UV sets.
    fn footprints(&self, pixel: IVec2, barycentrics: &Barycentrics) -> [Footprint; 2] {
        if !self.material.has_textures() {
            return [Footprint::default(); 2];
        }
        let uv = self.each(|vertex| vertex.uv);
        let [at, dx, dy] = [barycentrics.vec4(uv), Vec4::ZERO, Vec4::ZERO];
        let [slope_x, slope_y] = self.barycentric_slopes(pixel, barycentrics);
        let (dx, dy) = (dx + slope_x.vec4(uv), dy + slope_y.vec4(uv));
        [Footprint { at: at.xy(), dx: dx.xy(), dy: dy.xy() }, Footprint { at: at.zw(), dx: dx.zw(), dy: dy.zw() }]
    }

    /// Returns the material's alpha before any cutoff.
    pub(super) fn alpha(&self, shade: &Shade, pixel: IVec2) -> f32 {
        let barycentrics = self.barycentrics(pixel);
        let uv = self.footprints(pixel, &barycentrics);
        let color = barycentrics.vec4(self.each(|vertex| vertex.color));
        shade.materials.base_color(self.material, &uv, color).w
    }

    /// Returns associated linear RGBA, and the shading normal if it was computed.
    pub(super) fn color(&self, shade: &Shade, pixel: IVec2) -> (Vec4, Option<Vec3>) {
        let barycentrics = self.barycentrics(pixel);
        let uv = self.footprints(pixel, &barycentrics);
        let vertex_color = barycentrics.vec4(self.each(|vertex| vertex.color));
        let base = shade.materials.base_color(self.material, &uv, vertex_color);
        let alpha = if self.material.is_blended() { base.w.clamp(0.0, 1.0) } else { 1.0 };
        if self.material.factors.unlit {
            return ((base.xyz() * alpha).extend(alpha), None);
        }
        let (metallic, roughness) = shade.materials.metallic_roughness(self.material, &uv);
        let position = barycentrics.vec3(self.each(|vertex| vertex.position));
        let normal = self.normal_at(shade, &barycentrics, &uv);
        let towards = shade.geometry.parallel_view.unwrap_or(shade.geometry.eye.0 - position);
        let surface = Surface {
            position,
            normal,
            to_viewer: shading::unit_or(towards, normal),
            base_color: base.xyz(),
            metallic: metallic.clamp(0.0, 1.0),
            roughness: roughness.clamp(0.0, 1.0),
            occlusion: shade.materials.occlusion(self.material, &uv),
            emissive: shade.materials.emissive(self.material, &uv),
        };
        let ambient = shading::ambient_surface(&surface, shade.geometry.environment);
        let lit = shade.lights.iter().fold(ambient, |sum, light| sum + shading::light_surface(&surface, light));
        ((lit * alpha).extend(alpha), Some(normal))
    }

    /// Returns the shading normal, facing the viewer.
    pub(super) fn normal(&self, shade: &Shade, pixel: IVec2) -> Vec3 {
        let barycentrics = self.barycentrics(pixel);
        let needs_map = self.material.has_normal_map();
        let uv = if needs_map { self.footprints(pixel, &barycentrics) } else { [Footprint::default(); 2] };
        self.normal_at(shade, &barycentrics, &uv)
    }

    fn normal_at(&self, shade: &Shade, barycentrics: &Barycentrics, uv: &[Footprint; 2]) -> Vec3 {
        let normal = barycentrics.vec3(self.each(|vertex| vertex.normal));
        if !self.material.has_normal_map() {
            // Equal to `shading_normal` with a zero tangent, at a fraction of its cost.
            let unit = shading::unit_or(normal, Vec3::Z);
            return if self.triangle.is_front { unit } else { -unit };
        }
        let tangent = barycentrics.vec4(self.each(|vertex| vertex.tangent));
        let mapped = shade.materials.mapped_normal(self.material, uv);
        shading::shading_normal(normal, tangent, mapped, self.triangle.is_front)
    }

    /// Returns the distance along the view axis in metres.
    pub(super) fn depth(&self, pixel: IVec2) -> f32 {
        Vec3::from(self.barycentrics(pixel).0).dot(self.each(|vertex| vertex.depth).into())
    }

    /// Returns forward and backward motion in pixels; exactly 0 at rest.
    pub(super) fn motion(&self, shade: &Shade, pixel: IVec2) -> [f32; 4] {
        let barycentrics = self.barycentrics(pixel);
        let at = |points: [[f32; 3]; 3]| screen_point(barycentrics.vec3(points));
        let here = at(self.each(|vertex| [vertex.screen[0], vertex.screen[1], vertex.screen[3]]));
        let towards = |points: [[f32; 3]; 3]| match (here, at(points)) {
            (Some(here), Some(there)) => (there - here) * shade.pixels_per_unit,
            _ => Vec2::ZERO,
        };
        let [forward, backward] =
            [towards(self.each(|vertex| vertex.next)), towards(self.each(|vertex| vertex.previous))];
        [forward.x, forward.y, backward.x, backward.y]
    }
}

/// Returns the screen point of a homogeneous position; `None` behind the camera.
fn screen_point(homogeneous: Vec3) -> Option<Vec2> {
    (homogeneous.z > 1e-6).then(|| homogeneous.truncate() / homogeneous.z)
}
