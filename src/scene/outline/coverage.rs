//! The coverage of a picture, coarse enough to be outlined fast.
//!
//! In: alpha of pixels. Out: a grid with an empty border, dilated by about a pixel, except into the gaps between parts.

use super::slits::slits;
use crate::space::PixelRect;

/// Pictures with longer sides are outlined by blocks of pixels.
const MAX_CELLS: u32 = 2048;

/// The value of cells in a gap: the outline then passes about half-way between such a cell and a covered one, and parts of which only the
/// corners touch across a gap are apart.
const SLIT: f32 = -1.0;

/// Thresholds of coverage below which nothing is outlined, from the one for sharp and soft edges to those for glows.
const EDGES: [f32; 4] = [0.1, 0.05, 0.02, 0.005];

/// Largest share of a picture's coverage that may lie below the threshold.
const FAINT: f64 = 0.05;

/// Coverage on a grid of cells: pixels, or square blocks of them. Cell (i, j) has its centre at (i, j).
pub(super) struct AlphaGrid {
    /// Cells across and down, including a border of one empty cell.
    pub(super) size: [usize; 2],
    /// #cells, rows from the top; [`SLIT`] in gaps between parts.
    pub(super) values: Vec<f32>,
    /// Threshold of the inside.
    pub(super) edge: f32,
    window: PixelRect,
    /// Pixels per cell, across and down.
    block: u32,
}

impl AlphaGrid {
    /// Computes the coverage of the pixels of a window.
    pub(super) fn of(window: PixelRect, alpha: &[f32]) -> Self {
        debug_assert_eq!(alpha.len(), window.area(), "one value a pixel");
        let block = window.width.max(window.height).div_ceil(MAX_CELLS).max(1);
        let [width, height] = [window.width, window.height].map(|side| side.div_ceil(block) as usize + 2);
        let mut values = vec![0.0_f32; width * height];
        for (y, row) in alpha.chunks_exact(window.width.max(1) as usize).enumerate() {
            let line = (y / block as usize + 1) * width + 1;
            for (x, &alpha) in row.iter().enumerate() {
                let cell = &mut values[line + x / block as usize];
                *cell = cell.max(alpha);
            }
        }
        // The maximum over a block dilates by half a block; single pixels are dilated explicitly.
        let mut values = if block == 1 { spread(&values, width) } else { values };
        let most = values.iter().copied().fold(0.0, f32::max);
        let edge = edge(alpha).min(0.5 * most);
        // Gaps as narrow as this vanish from the dilated grid.
        for pixel in slits(alpha, window.width as usize, edge, 2 * block as usize) {
            let [x, y] =
                [pixel % window.width as usize, pixel / window.width as usize].map(|at| at / block as usize + 1);
            values[y * width + x] = SLIT;
        }
        Self { size: [width, height], values, edge, window, block }
    }

    /// Whether a point of the outline, on the line between two cells, lies beside a gap.
    pub(super) fn is_beside_slit(&self, [x, y]: [f64; 2]) -> bool {
        let cell = |x: f64, y: f64| self.values[y as usize * self.size[0] + x as usize];
        cell(x.floor(), y.floor()) == SLIT || cell(x.ceil(), y.ceil()) == SLIT
    }

    /// Converts a position in cells to pixels of image space.
    pub(super) fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let block = f64::from(self.block);
        let along = |cell: f64, start: i32, length: u32| {
            // The last block may be truncated by the far side.
            f64::from(start) + ((cell - 0.5) * block).clamp(0.0, f64::from(length))
        };
        [along(x, self.window.x, self.window.width), along(y, self.window.y, self.window.height)]
    }
}

/// Returns the threshold of the inside: the highest with little of the picture below it. What lies outside moves with the nearest part of
/// the shape, so a wide glow would be torn.
fn edge(alpha: &[f32]) -> f32 {
    let total: f64 = alpha.iter().map(|&alpha| f64::from(alpha.max(0.0))).sum();
    let below = |edge: f32| {
        alpha.iter().filter(|alpha| (0.0..edge).contains(*alpha)).map(|&alpha| f64::from(alpha)).sum::<f64>()
    };
    let [.., lowest] = EDGES;
    EDGES.into_iter().find(|&edge| below(edge) <= FAINT * total).unwrap_or(lowest)
}

/// Returns the maximum of each cell and its eight neighbours; the border stays empty.
fn spread(values: &[f32], width: usize) -> Vec<f32> {
    let height = values.len() / width;
    let mut across = values.to_vec();
    for (wide, row) in across.chunks_exact_mut(width).zip(values.chunks_exact(width)) {
        for x in 1..width - 1 {
            wide[x] = row[x - 1].max(row[x]).max(row[x + 1]);
        }
        (wide[0], wide[width - 1]) = (0.0, 0.0);
    }
    let mut spread = vec![0.0; values.len()];
    for y in 1..height - 1 {
        for x in 1..width - 1 {
            let at = y * width + x;
            spread[at] = across[at - width].max(across[at]).max(across[at + width]);
        }
    }
    spread
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_glow_is_outlined_and_a_soft_edge_is_not() {
        let window = PixelRect { x: 0, y: 0, width: 200, height: 200 };
        let picture = |softness: f32, glow: f32| -> Vec<f32> {
            let at = |index: usize| {
                let distance = ((index % 200) as f32 - 99.5).hypot((index / 200) as f32 - 99.5);
                let disc = ((40.0 - distance) / softness + 0.5).clamp(0.0, 1.0);
                disc.max(glow * (1.0 - distance / 100.0).max(0.0))
            };
            (0..window.area()).map(at).collect()
        };
        for (softness, glow, wanted) in [(1.0, 0.0, 0.1), (12.0, 0.0, 0.1), (1.0, 0.16, 0.02)] {
            assert_eq!(AlphaGrid::of(window, &picture(softness, glow)).edge, wanted, "{softness} {glow}");
        }
    }
}
