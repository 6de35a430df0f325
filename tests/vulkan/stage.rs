//! A small scene that uses every kind of material, and geometry for it.

use glam::{Vec2, Vec3, Vec4};
use pinwarp::image::cryptomatte::MatteId;
use pinwarp::pose::PosedLight;
use pinwarp::raster::{Draw, Geometry, RasterVertex};
use pinwarp::scene::{AlphaMode, Filter, Image, LightKind, Material, Scene, Texture, TextureRef, Wrap};
use pinwarp::space::{ScenePoint, SceneVector};

/// A camera at (0, 0, `EYE`) that looks along -z; a scene height of 2 at z = 0 fills the frame.
pub(crate) const EYE: f32 = 3.0;
const NEAR: f32 = 0.5;

/// Homogeneous screen position of a scene position, and its depth.
pub(crate) fn project(position: Vec3, aspect: f32) -> ([f32; 4], f32) {
    let depth = EYE - position.z;
    let half = 0.5 * EYE;
    ([0.5 * aspect * depth + half * position.x, 0.5 * depth + half * position.y, NEAR, depth], depth)
}

/// Collects triangles; each vertex moves right a tenth in the next frame and came from a fifth below.
pub(crate) struct Builder {
    pub(crate) geometry: Geometry,
    aspect: f32,
}

impl Builder {
    pub(crate) fn new(aspect: f32) -> Self {
        let light = |kind, color, position, direction: Vec3| PosedLight {
            kind,
            color,
            position: ScenePoint(position),
            direction: SceneVector(direction.normalize()),
            range: f32::INFINITY,
        };
        let lights = vec![
            light(LightKind::Directional, Vec3::splat(2.0), Vec3::ZERO, Vec3::new(-0.4, -0.6, -1.0)),
            light(LightKind::Point, Vec3::new(3.0, 2.0, 1.0), Vec3::new(1.5, 1.0, 1.5), Vec3::NEG_Y),
            light(
                LightKind::Spot { inner: 0.2, outer: 0.5 },
                Vec3::new(4.0, 8.0, 16.0),
                Vec3::new(-1.0, 1.0, 2.0),
                Vec3::new(0.3, -0.6, -1.0),
            ),
        ];
        let eye = ScenePoint(Vec3::new(0.0, 0.0, EYE));
        let geometry = Geometry { eye, lights, environment: 0.5, ..Geometry::default() };
        Self { geometry, aspect }
    }

    pub(crate) fn vertex(&mut self, position: Vec3, normal: Vec3, uv: Vec2, color: Vec4) -> u32 {
        let (screen, depth) = project(position, self.aspect);
        let moved = |by: Vec3| {
            let ([x, y, _, w], _) = project(position + by, self.aspect);
            [x, y, w]
        };
        self.geometry.vertices.push(RasterVertex {
            screen,
            position: position.to_array(),
            depth,
            normal: normal.to_array(),
            next: moved(Vec3::new(0.1, 0.0, 0.0)),
            previous: moved(Vec3::new(0.0, -0.2, 0.0)),
            tangent: [1.0, 0.0, 0.0, 1.0],
            uv: [uv.x, uv.y, 1.0 - uv.x, uv.y],
            color: color.to_array(),
        });
        self.geometry.vertices.len() as u32 - 1
    }

    /// Adds triangles as a draw of the next object.
    pub(crate) fn draw(&mut self, corners: &[u32], material: u32, is_mirrored: bool) {
        let start = self.geometry.indices.len() as u32;
        self.geometry.indices.extend(corners);
        let end = self.geometry.indices.len() as u32;
        let object_id = self.geometry.draws.len() as u32 + 1;
        self.geometry.draws.push(Draw {
            indices: start..end,
            material,
            layer_id: object_id % 3,
            object_id,
            mattes: [object_id, material + 100, object_id % 3 + 200].map(|id| MatteId::of_name(&id.to_string())),
            is_mirrored,
        });
    }

    /// A rectangle from its lower left corner along two edges, counter-clockwise seen from edges' cross product.
    pub(crate) fn quad(&mut self, corner: Vec3, (across, up): (Vec3, Vec3), material: u32, color: Vec4) {
        let corners = self.quad_corners(corner, (across, up), color);
        self.draw(&corners, material, false);
    }

    pub(crate) fn quad_corners(&mut self, corner: Vec3, (across, up): (Vec3, Vec3), color: Vec4) -> [u32; 6] {
        let normal = across.cross(up).normalize();
        let mut at = |u: f32, v: f32| self.vertex(corner + across * u + up * v, normal, Vec2::new(u, 1.0 - v), color);
        let [a, b, c, d] = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        [a, b, c, a, c, d]
    }

    /// A ball of 2·n² · 2 triangles.
    pub(crate) fn ball(&mut self, center: Vec3, radius: f32, (n, material): (u32, u32)) {
        let first = self.geometry.vertices.len() as u32;
        for row in 0..=n {
            for column in 0..=2 * n {
                let (u, v) = (column as f32 / (2 * n) as f32, row as f32 / n as f32);
                let (around, down) = (u * std::f32::consts::TAU, v * std::f32::consts::PI);
                let normal = Vec3::new(down.sin() * around.sin(), down.cos(), down.sin() * around.cos());
                self.vertex(center + normal * radius, normal, Vec2::new(u * 4.0, v * 2.0), Vec4::ONE);
            }
        }
        let columns = 2 * n + 1;
        let cell = |row: u32, column: u32| {
            let a = first + row * columns + column;
            [a, a + columns, a + columns + 1, a, a + columns + 1, a + 1]
        };
        let corners: Vec<u32> = (0..n).flat_map(|row| (0..2 * n).flat_map(move |column| cell(row, column))).collect();
        self.draw(&corners, material, false);
    }
}

/// Materials of [`scene`].
pub(crate) const PLAIN: u32 = 0;
pub(crate) const CUTOUT: u32 = 1;
pub(crate) const GLASS: u32 = 2;
pub(crate) const MAPPED: u32 = 3;
pub(crate) const FAINT: u32 = 4;
pub(crate) const FLAT: u32 = 5;

/// Every alpha mode, texture and wrap mode.
pub(crate) fn scene() -> Scene {
    let material = |name: &str| Material { name: name.into(), metallic: 0.0, roughness: 0.5, ..Material::default() };
    let reference = |texture, uv_set| {
        Some(TextureRef { texture, uv_set, texture_from_uv: [Vec3::new(1.0, 0.0, 0.1), Vec3::new(0.0, 1.0, 0.0)] })
    };
    let unlit = |name: &str, base_color| Material { base_color, unlit: true, ..material(name) };
    let blend =
        |name: &str, base_color| Material { alpha: AlphaMode::Blend, double_sided: true, ..unlit(name, base_color) };
    Scene {
        materials: vec![
            Material { metallic: 0.3, base_color: Vec4::new(0.8, 0.6, 0.4, 1.0), ..material("plain") },
            Material {
                alpha: AlphaMode::Mask { cutoff: 0.5 },
                base_color_texture: reference(0, 0),
                double_sided: true,
                ..material("cutout")
            },
            blend("glass", Vec4::new(0.1, 0.4, 0.9, 0.6)),
            Material {
                base_color_texture: reference(1, 0),
                metallic_roughness_texture: reference(2, 1),
                normal_texture: reference(3, 0),
                normal_scale: 0.7,
                occlusion_texture: reference(2, 0),
                occlusion_strength: 0.8,
                emissive: Vec3::new(0.1, 0.2, 0.0),
                emissive_texture: reference(1, 1),
                metallic: 1.0,
                ..material("mapped")
            },
            blend("faint", Vec4::new(0.9, 0.1, 0.1, 0.3)),
            unlit("flat", Vec4::new(0.25, 0.5, 0.75, 1.0)),
        ],
        textures: vec![
            texture(0, Wrap::Repeat, Some(Filter::Linear)),
            texture(1, Wrap::Mirror, Some(Filter::Linear)),
            texture(2, Wrap::Clamp, Some(Filter::Nearest)),
            texture(3, Wrap::Repeat, None),
        ],
        images: vec![
            image((16, 16), true, |x, y| [255, 200, 40, if (x / 2 + y / 2) % 2 == 0 { 255 } else { 0 }]),
            image((24, 10), true, |x, y| [(x * 10) as u8, (y * 25) as u8, 128, 255]),
            image((7, 5), false, |x, y| [200 - (x * 20) as u8, 60 + (y * 30) as u8, (x * 30) as u8, 255]),
            image((8, 8), false, |x, y| [128 + (x % 4 * 20) as u8, 128 - (y % 4 * 20) as u8, 230, 255]),
        ],
        ..Scene::default()
    }
}

fn texture(image: usize, wrap: Wrap, mipmap: Option<Filter>) -> Texture {
    Texture { image, wrap: [wrap; 2], magnify: Filter::Linear, minify: Filter::Linear, mipmap }
}

fn image((width, height): (u32, u32), is_srgb: bool, texel: impl Fn(u32, u32) -> [u8; 4]) -> Image {
    let rgba = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(|(x, y)| texel(x, y)).collect();
    Image { width, height, rgba, is_srgb }
}

/// Everything that [`scene`] has, in one picture: a floor, two balls, a cut-out, panes before and behind each other.
pub(crate) fn everything(aspect: f32) -> Geometry {
    let mut builder = Builder::new(aspect);
    let white = Vec4::ONE;
    builder.quad(Vec3::new(-3.0, -0.9, 1.0), (Vec3::X * 6.0, Vec3::new(0.0, 0.2, -5.0)), MAPPED, white);
    builder.ball(Vec3::new(-0.7, 0.1, 0.0), 0.6, (24, PLAIN));
    builder.ball(Vec3::new(0.8, 0.0, -0.4), 0.6, (24, MAPPED));
    builder.quad(Vec3::new(-0.4, -0.5, 0.6), (Vec3::X, Vec3::Y), CUTOUT, white);
    let mirrored = builder.quad_corners(Vec3::new(-1.6, 0.4, 0.2), (Vec3::Y * 0.4, Vec3::X * 0.4), white);
    builder.draw(&mirrored, FLAT, true);
    // Seen from behind: not there.
    builder.quad(Vec3::new(1.2, 0.4, 0.2), (Vec3::Y * 0.4, Vec3::X * 0.4), FLAT, white);
    let tint = Vec4::new(1.0, 0.8, 0.6, 0.9);
    builder.quad(Vec3::new(-1.3, -0.7, -0.5), (Vec3::X * 2.4, Vec3::Y * 0.9), GLASS, tint);
    builder.quad(Vec3::new(-0.2, -0.8, 0.9), (Vec3::X * 0.8, Vec3::Y * 1.4), FAINT, white);
    builder.quad(Vec3::new(-1.0, -0.3, 1.0), (Vec3::X * 0.7, Vec3::Y * 0.7), GLASS, white);
    builder.geometry
}
