//! Draws one tile: visibility first, then each visible pixel is shaded once, then blended triangles in order.
//!
//! In: the tile's triangles of a pass. Out: the tile's planes, which accumulate all passes of a frame.

use super::bin::TILE;
use super::coverage::{NOTHING, TILE_PIXELS, Visibility};
use super::fragment::{Face, Shade};
use super::layout::Layout;
use super::matte::{TileMattes, TransparentFragment};
use super::triangle::Triangle;
use crate::image::ChannelGroup;
use crate::raster::PassRole;
use glam::{IVec2, Vec3, Vec4};

/// The accumulated samples of a tile.
#[derive(Debug, Default)]
pub(super) struct Tile {
    /// [`Layout::planes`] planes of [`TILE_PIXELS`] samples; reused between frames.
    planes: Vec<f32>,
    /// Whether a pass has drawn into the planes of beauty.
    has_beauty: bool,
    /// Whether a pass has drawn into the planes of data.
    has_data: bool,
    /// Ids and their coverage.
    pub(super) mattes: TileMattes,
}

/// Buffers of a thread that draws tiles.
#[derive(Default)]
pub(super) struct Scratch<'a> {
    /// The tile's triangles.
    list: Vec<&'a Triangle>,
    /// Opaque and masked surfaces.
    visibility: Visibility,
    /// Surfaces that are visible to data channels: those, and nearly opaque blended ones.
    data: Visibility,
    color: Vec<Vec4>,
    /// Shading normals of opaque surfaces, if shading computed them.
    normals: Vec<Option<Vec3>>,
    /// Blended surfaces, if mattes are requested.
    fragments: Vec<TransparentFragment>,
}

/// The parameters of a tile in a pass.
#[derive(Clone, Copy)]
pub(super) struct TilePass<'a> {
    pub(super) shade: &'a Shade<'a>,
    pub(super) layout: &'a Layout,
    pub(super) role: PassRole,
    /// 1 / number of beauty passes.
    pub(super) weight: f32,
    /// First pixel of the tile in the window.
    pub(super) origin: IVec2,
    /// Size of the part of the tile inside the window.
    pub(super) size: IVec2,
}

/// A pixel of a tile.
#[derive(Clone, Copy)]
struct TilePixel {
    /// Index in the tile.
    place: usize,
    /// Pixel of the window.
    pixel: IVec2,
}

/// Minimum alpha at which blended surfaces are visible to data channels.
const DATA_ALPHA: f32 = 0.5;

impl TilePass<'_> {
    fn wants_beauty(&self) -> bool {
        self.role != PassRole::Data && self.layout.first(ChannelGroup::Beauty).is_some()
    }

    fn wants_data(&self) -> bool {
        self.role != PassRole::Beauty && self.layout.has_data()
    }

    fn wants_mattes(&self) -> bool {
        self.role != PassRole::Data && self.layout.has_mattes
    }

    /// Returns the pixels of the tile's part inside the window.
    fn pixels(&self) -> impl Iterator<Item = TilePixel> + use<> {
        let (origin, size) = (self.origin, self.size);
        let pixel =
            move |x: i32, y: i32| TilePixel { place: (y * TILE + x) as usize, pixel: origin + IVec2::new(x, y) };
        (0..size.y).flat_map(move |y| (0..size.x).map(move |x| pixel(x, y)))
    }
}

impl Tile {
    /// Clears the previous frame.
    pub(super) fn reset(&mut self) {
        (self.has_beauty, self.has_data) = (false, false);
        self.mattes.reset();
    }

    /// Returns the samples of a plane, row by row; `None` if no pass has drawn into its group.
    pub(super) fn plane(&self, group: ChannelGroup, plane: usize) -> Option<&[f32]> {
        let is_drawn = if group.is_data() { self.has_data } else { self.has_beauty };
        is_drawn.then(|| &self.planes[plane * TILE_PIXELS..(plane + 1) * TILE_PIXELS])
    }

    /// Draws a pass's triangles.
    pub(super) fn draw<'a>(
        &mut self,
        pass: &TilePass<'a>,
        triangles: impl Iterator<Item = &'a Triangle>,
        scratch: &mut Scratch<'a>,
    ) {
        scratch.list.clear();
        scratch.list.extend(triangles);
        if scratch.list.is_empty() {
            return;
        }
        self.prepare(pass);
        scratch.cover(pass);
        scratch.normals.clear();
        if pass.wants_beauty() {
            scratch.shade(pass);
        }
        scratch.blend(pass);
        if pass.wants_beauty() {
            self.add_beauty(pass, &scratch.color);
        }
        if pass.wants_mattes() {
            self.add_mattes(pass, scratch);
        }
        if pass.wants_data() {
            self.write_surfaces(pass, scratch);
        }
    }

    /// Initialises the planes that this pass is the first to draw into with the value of empty pixels.
    fn prepare(&mut self, pass: &TilePass) {
        self.planes.resize(pass.layout.planes * TILE_PIXELS, 0.0);
        let is_first_beauty = pass.wants_beauty() && !self.has_beauty;
        let is_first_data = pass.wants_data() && !self.has_data;
        for (group, spec, plane) in pass.layout.channels() {
            let is_first = if group.is_data() { is_first_data } else { is_first_beauty };
            if is_first {
                self.planes[plane * TILE_PIXELS..(plane + 1) * TILE_PIXELS].fill(spec.empty);
            }
        }
        self.has_beauty |= is_first_beauty;
        self.has_data |= is_first_data;
    }

    fn add_beauty(&mut self, pass: &TilePass, color: &[Vec4]) {
        let Some(first) = pass.layout.first(ChannelGroup::Beauty) else { return };
        let planes = &mut self.planes[first * TILE_PIXELS..(first + 4) * TILE_PIXELS];
        for (channel, plane) in planes.chunks_exact_mut(TILE_PIXELS).enumerate() {
            for (sum, color) in plane.iter_mut().zip(color) {
                *sum += color[channel] * pass.weight;
            }
        }
    }

    fn add_mattes(&mut self, pass: &TilePass, scratch: &Scratch) {
        let draws = &pass.shade.geometry.draws;
        let seen = pass.pixels().map(|TilePixel { place, .. }| (place, scratch.visibility.seen[place]));
        let opaque = seen.filter(|(_, number)| *number != NOTHING);
        let with_ids = opaque.map(|(place, number)| (place, draws[scratch.list[number as usize].draw as usize].mattes));
        self.mattes.add_pass(pass.weight, &scratch.fragments, with_ids);
    }

    /// Writes the data of the visible surface of each pixel.
    fn write_surfaces(&mut self, pass: &TilePass, scratch: &Scratch) {
        let mut faces = FaceCache::new(pass.shade);
        for TilePixel { place, pixel } in pass.pixels() {
            let number = scratch.data.seen[place];
            if number == NOTHING {
                continue;
            }
            let face = faces.get(number, &scratch.list);
            let is_opaque = number == scratch.visibility.seen[place];
            let normal = scratch.normals.get(place).copied().flatten().filter(|_| is_opaque);
            self.write_data(pass, face, TilePixel { place, pixel }, normal);
        }
    }

    /// Writes the data of one pixel; `normal`: that of the shaded surface, if shading computed one.
    fn write_data(&mut self, pass: &TilePass, face: &Face, at: TilePixel, normal: Option<Vec3>) {
        let (layout, TilePixel { place, pixel }) = (pass.layout, at);
        let mut put = |group: ChannelGroup, values: &dyn Fn() -> [f32; 4]| {
            let Some(first) = layout.first(group) else { return };
            for (at, value) in values().into_iter().take(group.channels().len()).enumerate() {
                self.planes[(first + at) * TILE_PIXELS + place] = value;
            }
        };
        put(ChannelGroup::Depth, &|| [face.depth(pixel), 0.0, 0.0, 0.0]);
        put(ChannelGroup::Motion, &|| face.motion(pass.shade, pixel));
        put(ChannelGroup::Normal, &|| normal.unwrap_or_else(|| face.normal(pass.shade, pixel)).extend(0.0).to_array());
        put(ChannelGroup::Id, &|| [face.draw.layer_id as f32, face.draw.object_id as f32, 0.0, 0.0]);
    }
}

/// Caches the last face, which neighbouring pixels mostly share.
struct FaceCache<'a> {
    shade: &'a Shade<'a>,
    last: Option<(u32, Face<'a>)>,
}

impl<'a> FaceCache<'a> {
    fn new(shade: &'a Shade<'a>) -> Self {
        Self { shade, last: None }
    }

    fn get(&mut self, number: u32, list: &[&'a Triangle]) -> &Face<'a> {
        if self.last.as_ref().is_none_or(|last| last.0 != number) {
            self.last = None;
        }
        let shade = self.shade;
        &self.last.get_or_insert_with(|| (number, Face::of(shade, list[number as usize]))).1
    }
}

impl<'a> Scratch<'a> {
    /// Finds the nearest opaque or masked triangle of each pixel.
    fn cover(&mut self, pass: &TilePass<'a>) {
        self.visibility.clear();
        let mut kept = Vec::new();
        for (number, triangle) in self.list.iter().enumerate() {
            let face = Face::of(pass.shade, triangle);
            if face.material.is_blended() {
                continue;
            }
            let Some(cutoff) = face.material.cutoff() else {
                self.visibility.fill(triangle, pass.origin, number as u32);
                continue;
            };
            kept.clear();
            self.visibility.visit(triangle, pass.origin, |place, pixel, z| {
                if face.alpha(pass.shade, pixel) >= cutoff {
                    kept.push((place, z));
                }
            });
            for &(place, z) in &kept {
                (self.visibility.z[place], self.visibility.seen[place]) = (z, number as u32);
            }
        }
    }

    /// Shades every pixel that shows an opaque surface.
    fn shade(&mut self, pass: &TilePass<'a>) {
        self.color.clear();
        self.color.resize(TILE_PIXELS, Vec4::ZERO);
        self.normals.resize(TILE_PIXELS, None);
        let mut faces = FaceCache::new(pass.shade);
        for TilePixel { place, pixel } in pass.pixels() {
            let number = self.visibility.seen[place];
            if number != NOTHING {
                (self.color[place], self.normals[place]) = faces.get(number, &self.list).color(pass.shade, pixel);
            }
        }
    }

    /// Blends transparent triangles over, and determines the surfaces visible to data channels and to mattes.
    fn blend(&mut self, pass: &TilePass<'a>) {
        if pass.wants_data() {
            self.data.z.copy_from_slice(&self.visibility.z);
            self.data.seen.copy_from_slice(&self.visibility.seen);
        }
        self.fragments.clear();
        for (number, triangle) in self.list.iter().enumerate() {
            let face = Face::of(pass.shade, triangle);
            if !face.material.is_blended() {
                continue;
            }
            let (color, data, fragments) = (&mut self.color, &mut self.data, &mut self.fragments);
            self.visibility.visit(triangle, pass.origin, |place, pixel, z| {
                if pixel.cmpge(pass.origin + pass.size).any() {
                    return;
                }
                let alpha = match pass.wants_beauty() {
                    true => {
                        let (over, _) = face.color(pass.shade, pixel);
                        color[place] = over + color[place] * (1.0 - over.w);
                        over.w
                    }
                    false => face.alpha(pass.shade, pixel),
                };
                if pass.wants_mattes() {
                    fragments.push(TransparentFragment { place, ids: face.draw.mattes, alpha: alpha.clamp(0.0, 1.0) });
                }
                if pass.wants_data() && alpha >= DATA_ALPHA && z > data.z[place] {
                    (data.z[place], data.seen[place]) = (z, number as u32);
                }
            });
        }
    }
}
