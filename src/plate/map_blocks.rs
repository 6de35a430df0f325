//! Fills a map block by block from few exact points, with smooth interpolation between them.
//!
//! In: a [`PixelField`] and exact points every 32 pixels. Out: offsets, accurate to 1e-3 pixels. A block that misses the tolerance at a
//! check point, or contains a crease or a fold, is quartered, down to pixels that are solved individually.

use super::WarpMap;
use super::map_patch::{LARGEST, Patch};
use super::pixel_field::{Node, PixelField, center};
use crate::space::PixelRect;
use glam::DVec2;
use rayon::prelude::*;

/// Size below which blocks are not quartered.
const SMALLEST: usize = 4;
/// Tolerance at the check points of a block, in pixels.
const GOOD: f64 = 2e-4;
/// Check points of a block, as fractions of its size: inside, and on the sides, whose ends may lie on different sheets of a fold.
const CHECKS: [(f64, f64); 9] =
    [(0.5, 0.5), (0.25, 0.5), (0.5, 0.25), (0.75, 0.5), (0.5, 0.75), (0.0, 0.5), (0.5, 0.0), (1.0, 0.5), (0.5, 1.0)];

/// Exact points of a window, spaced [`LARGEST`] pixels from its first pixel to one point beyond its end.
pub(super) struct MapNodes {
    columns: usize,
    /// #columns · #rows, rows from the top; `None` where the search failed.
    nodes: Vec<Option<Node>>,
}

impl MapNodes {
    /// Returns the number of points that a window needs, as columns and rows.
    pub(super) fn count(window: PixelRect) -> [usize; 2] {
        [window.width, window.height].map(|pixels| (pixels as usize).div_ceil(LARGEST) + 1)
    }

    /// Solves all points, each from its start offset.
    pub(super) fn solve(pixel_field: PixelField, window: PixelRect, starts: &[DVec2]) -> Self {
        let [columns, rows] = Self::count(window);
        debug_assert_eq!(starts.len(), columns * rows);
        let node = |index: usize| {
            let step = |k: usize| (k * LARGEST) as i32;
            let pixel = center(window.x + step(index % columns), window.y + step(index / columns));
            pixel_field.solve(pixel, starts[index]).or_else(|| pixel_field.solve(pixel, DVec2::ZERO))
        };
        let nodes = (0..columns * rows).into_par_iter().with_min_len(64).map(node).collect();
        Self { columns, nodes }
    }
}

/// A square block of pixels in a strip.
#[derive(Clone, Copy)]
struct Block {
    /// First column, relative to the window.
    x: usize,
    /// First row, relative to the strip.
    y: usize,
    size: usize,
    corners: [Option<Node>; 4],
}

/// A strip of the window, [`LARGEST`] rows high.
struct Strip<'a> {
    pixel_field: PixelField<'a>,
    window: PixelRect,
    /// First row, relative to the window.
    top: usize,
    /// Offsets, in rows of the window's width.
    offsets: &'a mut [[f32; 2]],
    /// One flag per pixel, or empty.
    excluded: &'a [u8],
    /// Whether all pixels so far were found.
    is_complete: bool,
}

/// Fills an identity map. `excluded` pixels (one flag per pixel, or empty) are skipped. Returns whether all other
/// pixels were found; those that were not are NaN.
pub(super) fn fill(pixel_field: PixelField, nodes: &MapNodes, excluded: &[u8], map: &mut WarpMap) -> bool {
    let (window, width) = (map.window, map.window.width as usize);
    let strips = map.offsets.par_chunks_mut(LARGEST * width).enumerate().map(|(row, offsets)| {
        let start = row * LARGEST * width;
        let excluded = if excluded.is_empty() { excluded } else { &excluded[start..start + offsets.len()] };
        let mut strip = Strip { pixel_field, window, top: row * LARGEST, offsets, excluded, is_complete: true };
        for column in 0..nodes.columns - 1 {
            let first = row * nodes.columns + column;
            let corners = [first, first + 1, first + nodes.columns, first + nodes.columns + 1];
            let corners = corners.map(|index| nodes.nodes[index]);
            strip.fill(Block { x: column * LARGEST, y: 0, size: LARGEST, corners });
        }
        strip.is_complete
    });
    // No early exit: every strip has to be filled.
    strips.reduce(|| true, |a, b| a && b)
}

impl Strip<'_> {
    fn width(&self) -> usize {
        self.window.width as usize
    }

    fn rows(&self) -> usize {
        self.offsets.len() / self.width()
    }

    /// Returns the centre of a pixel of the strip.
    fn pixel(&self, x: usize, y: usize) -> DVec2 {
        center(self.window.x + x as i32, self.window.y + (self.top + y) as i32)
    }

    fn fill(&mut self, block: Block) {
        if block.x >= self.width() || block.y >= self.rows() {
            return;
        }
        let patch = self.patch(&block);
        match patch {
            Some(patch) if self.is_good(&block, &patch) => self.draw(&block, &patch),
            patch if block.size > SMALLEST => self.quarter(&block, patch),
            patch => self.solve_each(&block, patch),
        }
    }

    /// Returns the block's interpolating patch if all corners are known.
    fn patch(&self, block: &Block) -> Option<Patch> {
        let [Some(a), Some(b), Some(c), Some(d)] = block.corners else { return None };
        Some(Patch::new(&[a, b, c, d], block.size as f64))
    }

    fn is_good(&self, block: &Block, patch: &Patch) -> bool {
        let size = block.size;
        let places = [(0, 0), (size, 0), (0, size), (size, size)].map(|(x, y)| self.pixel(block.x + x, block.y + y));
        let Some(nodes) = all(block.corners) else { return false };
        let corners = std::array::from_fn(|k| (places[k], nodes[k]));
        !self.holds_excluded(block)
            && self.pixel_field.is_smooth(&corners)
            && CHECKS.into_iter().all(|(u, v)| {
                let pixel = places[0] + DVec2::new(u, v) * size as f64;
                self.pixel_field.residual(pixel, patch.at(u, v)) <= GOOD
            })
    }

    /// Whether the block contains an excluded pixel. Its far corners count, which may be the first pixels of the next blocks.
    fn holds_excluded(&self, block: &Block) -> bool {
        if self.excluded.is_empty() {
            return false;
        }
        let columns = block.x..(block.x + block.size + 1).min(self.width());
        let rows = block.y..(block.y + block.size + 1).min(self.rows());
        let width = self.width();
        rows.into_iter().any(|y| self.excluded[y * width..][columns.clone()].iter().any(|&flag| flag != 0))
    }

    fn draw(&mut self, block: &Block, patch: &Patch) {
        if block.corners.iter().flatten().all(|node| node.is_still()) {
            return;
        }
        let width = self.width();
        let columns = block.x..(block.x + block.size).min(width);
        for y in 0..block.size.min(self.rows() - block.y) {
            patch.fill(block.size, y, &mut self.offsets[(block.y + y) * width..][columns.clone()]);
        }
    }

    fn quarter(&mut self, block: &Block, patch: Option<Patch>) {
        let half = block.size / 2;
        let node = |x: usize, y: usize| {
            let place = [x, y].map(|step| step as f64 / 2.0);
            let start = self.start(block, patch.as_ref(), place);
            self.pixel_field.solve(self.pixel(block.x + x * half, block.y + y * half), start)
        };
        let [a, b, c, d] = block.corners;
        let middle = node(1, 1);
        let (top, left, right, bottom) = (node(1, 0), node(0, 1), node(2, 1), node(1, 2));
        let quarters =
            [[a, top, left, middle], [top, b, middle, right], [left, middle, c, bottom], [middle, right, bottom, d]];
        for (k, corners) in quarters.into_iter().enumerate() {
            self.fill(Block { x: block.x + k % 2 * half, y: block.y + k / 2 * half, size: half, corners });
        }
    }

    /// Returns a start offset for a search: from the patch, or else from any known corner.
    fn start(&self, block: &Block, patch: Option<&Patch>, place: [f64; 2]) -> DVec2 {
        let corner = || block.corners.iter().flatten().next().map_or(DVec2::ZERO, |node| node.offset);
        patch.map_or_else(corner, |patch| patch.at(place[0], place[1]))
    }

    fn solve_each(&mut self, block: &Block, patch: Option<Patch>) {
        let width = self.width();
        for y in block.y..(block.y + block.size).min(self.rows()) {
            for x in block.x..(block.x + block.size).min(width) {
                let index = y * width + x;
                if self.excluded.get(index).is_some_and(|&flag| flag != 0) {
                    continue;
                }
                let place = [x - block.x, y - block.y].map(|step| step as f64 / block.size as f64);
                let start = self.start(block, patch.as_ref(), place);
                let pixel = self.pixel(x, y);
                let found = self.pixel_field.solve(pixel, start).or_else(|| self.pixel_field.solve(pixel, DVec2::ZERO));
                self.is_complete &= found.is_some();
                self.offsets[index] = found.map_or(DVec2::NAN, |node| node.offset).as_vec2().to_array();
            }
        }
    }
}

fn all(corners: [Option<Node>; 4]) -> Option<[Node; 4]> {
    let [a, b, c, d] = corners;
    Some([a?, b?, c?, d?])
}
