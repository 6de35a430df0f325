//! Visibility in one tile: the nearest triangle at each pixel.
//!
//! In: triangles in drawing order. Out: per pixel the greatest reversed z and the number of its triangle. The inner
//! loops work on eight pixels at a time in plain arrays, which the compiler vectorises.

use super::bin::TILE;
use super::triangle::Triangle;
use glam::IVec2;

/// Pixels per tile.
pub(super) const TILE_PIXELS: usize = (TILE * TILE) as usize;

/// Number of no triangle.
pub(super) const NOTHING: u32 = u32::MAX;

const LANES: usize = 8;

/// Depth and visible triangle of a tile's pixels, rows from the top.
#[derive(Debug)]
pub(super) struct Visibility {
    pub(super) z: Vec<f32>,
    pub(super) seen: Vec<u32>,
}

impl Default for Visibility {
    fn default() -> Self {
        Self { z: vec![0.0; TILE_PIXELS], seen: vec![NOTHING; TILE_PIXELS] }
    }
}

/// Edge functions of a triangle, relative to the tile's first pixel.
struct TileEdges {
    a: [i32; 3],
    b: [i32; 3],
    /// Values at the tile's first pixel.
    start: [i32; 3],
}

impl TileEdges {
    /// Sets up the edge functions; `None` if the triangle misses the tile.
    ///
    /// An edge function that is nowhere negative in the tile is replaced by 0, so that the others change sign inside
    /// the tile and fit 32 bits: |a| + |b| ≤ 2·49152·256 over 63 pixels < 2³¹.
    fn of(triangle: &Triangle, origin: IVec2) -> Option<Self> {
        let mut edges = Self { a: [0; 3], b: [0; 3], start: [0; 3] };
        let reach = i64::from(TILE - 1);
        for (i, edge) in triangle.edges.iter().enumerate() {
            let (a, b) = (i64::from(edge.a), i64::from(edge.b));
            let start = edge.c + a * i64::from(origin.x) + b * i64::from(origin.y);
            let greatest = start + a.max(0) * reach + b.max(0) * reach;
            let least = start + a.min(0) * reach + b.min(0) * reach;
            if greatest < 0 {
                return None;
            }
            if least < 0 {
                (edges.a[i], edges.b[i], edges.start[i]) = (edge.a, edge.b, start as i32);
            }
        }
        Some(edges)
    }

    /// Returns the values at the tile's pixel (x, y).
    fn at(&self, x: i32, y: i32) -> [i32; 3] {
        [0, 1, 2].map(|i| self.start[i] + self.a[i] * x + self.b[i] * y)
    }
}

/// Values of a triangle shared by eight neighbouring pixels.
struct Lanes {
    /// Differences of the edge functions from the first pixel to each.
    ramps: [[i32; LANES]; 3],
    z_dx: f32,
    number: u32,
}

/// Depth and visible triangle of neighbouring pixels.
struct TilePixels<'a> {
    z: &'a mut [f32],
    seen: &'a mut [u32],
}

impl Lanes {
    /// Draws eight pixels: `values` are the edge functions at the first, `z_start` the z of its row and `column` its
    /// place in the row, both relative to the triangle's first pixel.
    #[inline]
    fn fill(&self, pixels: TilePixels, values: [i32; 3], z_start: f32, column: i32) {
        let (z, seen) = (&mut pixels.z[..LANES], &mut pixels.seen[..LANES]);
        for lane in 0..LANES {
            let [p, q, r] = [0, 1, 2].map(|k| values[k] + self.ramps[k][lane]);
            let depth = z_start + self.z_dx * (column + lane as i32) as f32;
            let wins = ((p | q | r) >= 0) & (depth > z[lane]);
            z[lane] = if wins { depth } else { z[lane] };
            seen[lane] = if wins { self.number } else { seen[lane] };
        }
    }
}

impl Visibility {
    pub(super) fn clear(&mut self) {
        self.z.fill(0.0);
        self.seen.fill(NOTHING);
    }

    /// Draws an opaque triangle where it is covered and nearer.
    pub(super) fn fill(&mut self, triangle: &Triangle, origin: IVec2, number: u32) {
        let Some(edges) = TileEdges::of(triangle, origin) else { return };
        let (low, high) = bounds(triangle, origin);
        let first = low.x & !(LANES as i32 - 1);
        let lanes = Lanes {
            ramps: [0, 1, 2].map(|k| std::array::from_fn(|lane| edges.a[k] * lane as i32)),
            z_dx: triangle.z.dx,
            number,
        };
        for y in low.y..=high.y {
            let offset = origin + IVec2::new(first, y) - triangle.min;
            let z_start = triangle.z.base + triangle.z.dy * offset.y as f32;
            let mut values = edges.at(first, y);
            let row = (y * TILE) as usize;
            for group in first as usize / LANES..=high.x as usize / LANES {
                let places = row + group * LANES..row + (group + 1) * LANES;
                let column = offset.x + (group * LANES) as i32 - first;
                let pixels = TilePixels { z: &mut self.z[places.clone()], seen: &mut self.seen[places] };
                lanes.fill(pixels, values, z_start, column);
                values = [0, 1, 2].map(|k| values[k] + edges.a[k] * LANES as i32);
            }
        }
    }

    /// Calls `visit` with place, window pixel and z for each pixel that the triangle covers and in which it is nearer
    /// than the visible surface.
    pub(super) fn visit(&self, triangle: &Triangle, origin: IVec2, mut visit: impl FnMut(usize, IVec2, f32)) {
        let Some(edges) = TileEdges::of(triangle, origin) else { return };
        let (low, high) = bounds(triangle, origin);
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                let [p, q, r] = edges.at(x, y);
                let pixel = origin + IVec2::new(x, y);
                let (place, z) = ((y * TILE + x) as usize, triangle.z.at(pixel - triangle.min));
                if (p | q | r) >= 0 && z > self.z[place] {
                    visit(place, pixel, z);
                }
            }
        }
    }
}

/// Returns the triangle's first and last pixel in the tile, relative to the tile's first pixel.
fn bounds(triangle: &Triangle, origin: IVec2) -> (IVec2, IVec2) {
    ((triangle.min - origin).max(IVec2::ZERO), (triangle.max - origin).min(IVec2::splat(TILE - 1)))
}
