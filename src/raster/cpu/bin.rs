//! Bins a pass's triangles into tiles of the window.
//!
//! In: [`Geometry`], its transform to the window. Out: chunks of set-up triangles, each with its sorted (tile,
//! triangle) pairs. Chunks have a fixed number of triangles, so the order in a tile never depends on the number of
//! threads.

use super::material::Materials;
use super::triangle::{Source, Triangle, WindowVertex, set_up};
use crate::raster::window::WindowFromScreen;
use crate::raster::{Geometry, RasterVertex};
use glam::IVec2;
use rayon::prelude::*;
use std::ops::Range;

/// Side of a tile in pixels.
pub(super) const TILE: i32 = 64;

/// Triangles per chunk.
const CHUNK: usize = 2048;

/// The tiling of a window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Tiling {
    /// Window size in pixels.
    pub(super) size: IVec2,
}

impl Tiling {
    pub(super) fn columns(self) -> usize {
        (self.size.x.max(0) as usize).div_ceil(TILE as usize)
    }

    pub(super) fn count(self) -> usize {
        self.columns() * (self.size.y.max(0) as usize).div_ceil(TILE as usize)
    }

    /// Returns the first pixel of a tile.
    pub(super) fn origin(self, tile: usize) -> IVec2 {
        IVec2::new((tile % self.columns()) as i32, (tile / self.columns()) as i32) * TILE
    }
}

fn window_vertex(vertex: &RasterVertex, window_from_screen: &WindowFromScreen) -> WindowVertex {
    let [_, _, z, w] = vertex.screen.map(f64::from);
    WindowVertex { at: window_from_screen.point(vertex), z: (z / w) as f32, inverse_w: (1.0 / w) as f32 }
}

/// Set-up triangles and their tiles; buffers are reused between passes.
#[derive(Debug, Default)]
pub(super) struct Bins {
    vertices: Vec<WindowVertex>,
    chunks: Vec<Chunk>,
}

#[derive(Debug, Default)]
struct Chunk {
    triangles: Vec<Triangle>,
    /// Sorted pairs of tile and index into `triangles`.
    pairs: Vec<(u32, u32)>,
}

impl Bins {
    /// Fills the bins with a pass's triangles.
    pub(super) fn fill(&mut self, geometry: &Geometry, materials: &Materials, to: (WindowFromScreen, Tiling)) {
        let (window_from_screen, tiling) = to;
        geometry
            .vertices
            .par_iter()
            .with_min_len(1024)
            .map(|vertex| window_vertex(vertex, &window_from_screen))
            .collect_into_vec(&mut self.vertices);
        let starts = first_triangles(geometry);
        let total = starts.last().copied().unwrap_or(0);
        self.chunks.resize_with(total.div_ceil(CHUNK), Chunk::default);
        let vertices = &self.vertices;
        self.chunks.par_iter_mut().enumerate().for_each(|(index, chunk)| {
            chunk.triangles.clear();
            let range = index * CHUNK..((index + 1) * CHUNK).min(total);
            for_each_source(geometry, materials, (&starts, range), |source| {
                let Some(corners) = corners(vertices, source.corners) else { return };
                set_up(&source, corners, tiling.size, &mut |triangle| chunk.triangles.push(triangle));
            });
            chunk.sort_into(tiling);
        });
    }

    /// Returns the triangles that may touch a tile, in drawing order.
    pub(super) fn of_tile(&self, tile: usize) -> impl Iterator<Item = &Triangle> {
        let tile = tile as u32;
        self.chunks.iter().flat_map(move |chunk| {
            let first = chunk.pairs.partition_point(|pair| pair.0 < tile);
            let mine = chunk.pairs[first..].iter().take_while(move |pair| pair.0 == tile);
            mine.map(|pair| &chunk.triangles[pair.1 as usize])
        })
    }
}

impl Chunk {
    fn sort_into(&mut self, tiling: Tiling) {
        self.pairs.clear();
        for (index, triangle) in self.triangles.iter().enumerate() {
            let (first, last) = (triangle.min / TILE, triangle.max / TILE);
            for row in first.y..=last.y {
                let base = row as usize * tiling.columns();
                self.pairs.extend((first.x..=last.x).map(|column| ((base + column as usize) as u32, index as u32)));
            }
        }
        self.pairs.sort_unstable();
    }
}

/// Returns the number of triangles before each draw, and the total at the end.
fn first_triangles(geometry: &Geometry) -> Vec<usize> {
    let mut total = 0;
    let mut starts = vec![0];
    for draw in &geometry.draws {
        total += indices_of(geometry, &draw.indices).len() / 3;
        starts.push(total);
    }
    starts
}

/// Returns a draw's vertex indices; empty if the range lies outside the geometry.
fn indices_of<'a>(geometry: &'a Geometry, range: &Range<u32>) -> &'a [u32] {
    geometry.indices.get(range.start as usize..range.end as usize).unwrap_or(&[])
}

/// Calls `visit` for the triangles of a range of the pass.
fn for_each_source(
    geometry: &Geometry,
    materials: &Materials,
    (starts, range): (&[usize], Range<usize>),
    mut visit: impl FnMut(Source),
) {
    let mut index = range.start;
    let mut draw = starts.partition_point(|&start| start <= index).saturating_sub(1);
    while index < range.end && draw < geometry.draws.len() {
        let item = &geometry.draws[draw];
        let is_culled = !materials.get(item.material).factors.double_sided;
        let until = range.end.min(starts[draw + 1]);
        let corners = &indices_of(geometry, &item.indices)[(index - starts[draw]) * 3..(until - starts[draw]) * 3];
        for corner in corners.chunks_exact(3) {
            let corners = [corner[0], corner[1], corner[2]];
            visit(Source { corners, draw: draw as u32, is_mirrored: item.is_mirrored, is_culled });
        }
        index = until;
        draw += 1;
    }
}

fn corners(vertices: &[WindowVertex], corners: [u32; 3]) -> Option<[WindowVertex; 3]> {
    let get = |corner: u32| vertices.get(corner as usize).copied();
    Some([get(corners[0])?, get(corners[1])?, get(corners[2])?])
}
