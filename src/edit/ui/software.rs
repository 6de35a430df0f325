//! Software rasteriser for the window's shapes: for screenshots by scripts and for tests.
//!
//! In: the output of one pass of the toolkit. Out: a [`Preview`]. Textures are sampled bilinearly; colours are blended
//! as on the GPU.

use crate::image::Preview;
use eframe::egui::epaint::{ImageData, ImageDelta, Mesh, Primitive, Vertex};
use eframe::egui::{self, Color32, FullOutput, Rect, TextureId, TexturesDelta};
use std::collections::HashMap;

/// A texture in memory.
#[derive(Clone, Debug, Default)]
struct Texture {
    size: [usize; 2],
    pixels: Vec<Color32>,
}

/// Stores textures and draws passes.
#[derive(Clone, Debug, Default)]
pub(crate) struct SoftwarePainter {
    textures: HashMap<TextureId, Texture>,
}

impl SoftwarePainter {
    /// Applies texture updates and removals.
    pub(crate) fn take_textures(&mut self, delta: &mut TexturesDelta) {
        let taken = std::mem::take(delta);
        for (id, deltas) in &taken.set {
            deltas.iter().for_each(|delta| self.set(*id, delta));
        }
        taken.free.iter().for_each(|id| _ = self.textures.remove(id));
        let mut taken = taken;
        taken.clear();
    }

    fn set(&mut self, id: TextureId, delta: &ImageDelta) {
        let ImageData::Color(image) = &delta.image;
        let Some([left, top]) = delta.pos else {
            self.textures.insert(id, Texture { size: image.size, pixels: image.pixels.clone() });
            return;
        };
        let Some(texture) = self.textures.get_mut(&id) else { return };
        for (row, pixels) in image.pixels.chunks(image.size[0].max(1)).enumerate() {
            let start = (top + row) * texture.size[0] + left;
            if let Some(place) = texture.pixels.get_mut(start..start + pixels.len()) {
                place.copy_from_slice(pixels);
            }
        }
    }

    /// Draws a pass.
    #[must_use]
    pub(crate) fn draw(&self, ctx: &egui::Context, output: &FullOutput, size: [u32; 2]) -> Preview {
        let scale = output.pixels_per_point;
        let mut picture = Preview::transparent(size[0], size[1]);
        picture.rgba.chunks_exact_mut(4).for_each(|pixel| pixel[3] = u8::MAX);
        for clipped in ctx.tessellate(output.shapes.clone(), scale) {
            if let Primitive::Mesh(mesh) = &clipped.primitive
                && let Some(texture) = self.textures.get(&mesh.texture_id)
            {
                draw_mesh(&mut picture, (mesh, texture), clipped.clip_rect, scale);
            }
        }
        picture
    }
}

fn draw_mesh(picture: &mut Preview, (mesh, texture): (&Mesh, &Texture), clip: Rect, scale: f32) {
    let edge = |value: f32, most: u32| (value * scale).round().clamp(0.0, most as f32) as i32;
    let clip = [
        edge(clip.min.x, picture.width),
        edge(clip.min.y, picture.height),
        edge(clip.max.x, picture.width),
        edge(clip.max.y, picture.height),
    ];
    for corners in mesh.indices.chunks_exact(3) {
        let corners = [0, 1, 2].map(|k| mesh.vertices[corners[k] as usize]);
        Triangle::of(corners, scale).into_iter().for_each(|triangle| triangle.draw(picture, texture, clip));
    }
}

/// A triangle in pixels, counter-clockwise.
struct Triangle {
    corners: [Vertex; 3],
    at: [[f32; 2]; 3],
    area: f32,
}

impl Triangle {
    fn of(mut corners: [Vertex; 3], scale: f32) -> Option<Self> {
        let place = |vertex: &Vertex| [vertex.pos.x * scale, vertex.pos.y * scale];
        let mut at = corners.each_ref().map(place);
        let mut area = cross(at[0], at[1], at[2]);
        if area < 0.0 {
            corners.swap(1, 2);
            at.swap(1, 2);
            area = -area;
        }
        (area > 1e-9).then_some(Self { corners, at, area })
    }

    fn draw(&self, picture: &mut Preview, texture: &Texture, clip: [i32; 4]) {
        let bound =
            |axis: usize, pick: fn(f32, f32) -> f32| pick(pick(self.at[0][axis], self.at[1][axis]), self.at[2][axis]);
        let from = |axis: usize| ((bound(axis, f32::min) - 0.5).ceil() as i32).max(clip[axis]);
        let to = |axis: usize| ((bound(axis, f32::max) - 0.5).floor() as i32 + 1).min(clip[axis + 2]);
        for y in from(1)..to(1) {
            for x in from(0)..to(0) {
                let point = [x as f32 + 0.5, y as f32 + 0.5];
                if let Some(weights) = self.weights(point) {
                    let color = self.color(texture, weights);
                    let start = 4 * (y as usize * picture.width as usize + x as usize);
                    blend(&mut picture.rgba[start..start + 4], color);
                }
            }
        }
    }

    /// Returns the barycentric weights of a point; `None` if it lies outside. Points on a shared edge belong to one
    /// triangle.
    fn weights(&self, point: [f32; 2]) -> Option<[f32; 3]> {
        let mut weights = [0.0; 3];
        for (k, weight) in weights.iter_mut().enumerate() {
            let [a, b] = [self.at[(k + 1) % 3], self.at[(k + 2) % 3]];
            *weight = side(a, b, point);
            let is_top_left = (a[1] == b[1] && b[0] > a[0]) || b[1] < a[1];
            if *weight < 0.0 || *weight == 0.0 && !is_top_left {
                return None;
            }
        }
        Some(weights.map(|weight| weight / self.area))
    }

    fn color(&self, texture: &Texture, weights: [f32; 3]) -> [f32; 4] {
        let mix = |of: &dyn Fn(&Vertex) -> f32| (0..3).map(|k| weights[k] * of(&self.corners[k])).sum::<f32>();
        let texel = texture.sample(mix(&|vertex| vertex.uv.x), mix(&|vertex| vertex.uv.y));
        std::array::from_fn(|k| texel[k] * mix(&|vertex| f32::from(vertex.color.to_array()[k])) / 255.0)
    }
}

/// Returns twice the area of a triangle, with the same magnitude for both directions of the edge from `a` to `b`: rounding must not
/// leave a pixel between the two triangles of an edge.
fn side(a: [f32; 2], b: [f32; 2], point: [f32; 2]) -> f32 {
    if a < b { cross(a, b, point) } else { -cross(b, a, point) }
}

fn cross(a: [f32; 2], b: [f32; 2], c: [f32; 2]) -> f32 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

impl Texture {
    /// Samples bilinearly, clamped at the edges.
    fn sample(&self, u: f32, v: f32) -> [f32; 4] {
        let [width, height] = self.size;
        if self.pixels.is_empty() {
            return [255.0; 4];
        }
        let axis = |at: f32, count: usize| {
            let at = (at * count as f32 - 0.5).clamp(0.0, count as f32 - 1.0);
            let low = at.floor();
            (low as usize, (low as usize + 1).min(count - 1), at - low)
        };
        let ((x0, x1, s), (y0, y1, t)) = (axis(u, width), axis(v, height));
        let texel = |x: usize, y: usize| self.pixels[y * width + x].to_array();
        let [a, b, c, d] = [texel(x0, y0), texel(x1, y0), texel(x0, y1), texel(x1, y1)];
        std::array::from_fn(|k| {
            let row = |left: u8, right: u8| f32::from(left) + s * (f32::from(right) - f32::from(left));
            let (above, below) = (row(a[k], b[k]), row(c[k], d[k]));
            above + t * (below - above)
        })
    }
}

/// Blends a premultiplied colour over a pixel.
fn blend(pixel: &mut [u8], color: [f32; 4]) {
    let left = 1.0 - color[3] / 255.0;
    for (code, color) in pixel.iter_mut().zip(color) {
        *code = (color + f32::from(*code) * left).round().clamp(0.0, 255.0) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{Color32, pos2, vec2};

    /// Small discs are rectangles with a texture, whose pixels lie on the edge between both triangles.
    #[test]
    fn every_pixel_of_a_rectangle_belongs_to_one_of_its_triangles() {
        let texture = Texture::default();
        for step in 0..400 {
            // The diagonal passes through the middle of a pixel, up to rounding.
            let center = pos2(10.5 + (step % 3) as f32, 12.5 + (step % 5) as f32);
            let mut mesh = Mesh::default();
            mesh.add_colored_rect(
                Rect::from_center_size(center, vec2(9.0, 9.0) * (1.0 + 0.0013 * step as f32)),
                Color32::WHITE,
            );
            mesh.vertices.iter_mut().for_each(|vertex| vertex.color = Color32::from_rgba_premultiplied(90, 90, 90, 90));
            let mut picture = Preview::transparent(32, 32);
            draw_mesh(&mut picture, (&mesh, &texture), Rect::EVERYTHING, 1.0);
            let rect = mesh.calc_bounds();
            for (place, pixel) in picture.rgba.chunks_exact(4).enumerate() {
                let at = pos2((place % 32) as f32 + 0.5, (place / 32) as f32 + 0.5);
                let inside = rect.contains(at);
                assert_eq!(pixel[3], if inside { 90 } else { 0 }, "{at:?} in {rect:?}");
            }
        }
    }
}
