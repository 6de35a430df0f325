//! Draws the branches of a lattice over the preview, each in its own colour and only where it contains part of the shape.
//!
//! In: a solved [`BranchedLattice`]. Out: lines and folded cells on a [`Canvas`].

use super::overlay_legend::FOLDED;
use crate::image::{Canvas, Rgba8};
use crate::lattice::ScreenLattice;
use crate::solve::BranchedLattice;
use crate::space::{FrameSize, ImagePoint, ScreenPoint};

/// Line segments per span.
const PIECES: usize = 4;

/// Colours of the branches, starting with the largest, repeated cyclically.
const TINTS: [[u8; 3]; 6] =
    [[64, 200, 255], [255, 150, 50], [120, 230, 90], [235, 110, 240], [240, 225, 70], [110, 140, 255]];

/// The overlay of one branch in one frame.
#[derive(Clone, Debug)]
pub(in crate::pipeline) struct BranchPicture {
    lattice: ScreenLattice,
    /// The cells that contain part of the shape, by column and row, and whether the shape folds in each.
    cells: Vec<([usize; 2], bool)>,
}

impl BranchPicture {
    /// Creates the overlays of all branches.
    pub(in crate::pipeline) fn all_of(branches: &BranchedLattice<2>) -> Vec<Self> {
        let margin = branches.grid().basis.margin();
        let of_branch = |branch: usize| {
            let lattice = branches.lattice(branch);
            let own = branches.cells(branch);
            let folded = branches.folds_of(branch).cells;
            let is_folded = |cell: &[usize; 2]| folded.contains(&cell.map(|place| place + margin));
            let cells = own.into_iter().map(|cell| (cell, is_folded(&cell))).collect();
            Self { lattice, cells }
        };
        (0..branches.branch_count()).map(of_branch).collect()
    }

    /// Whether any cell folds.
    pub(in crate::pipeline) fn has_folds(&self) -> bool {
        self.cells.iter().any(|(_, is_folded)| *is_folded)
    }

    /// Draws the branch in the colour of the given number.
    pub(in crate::pipeline) fn draw(&self, canvas: &mut Canvas, number: usize, (frame, unit_px): (FrameSize, f64)) {
        let [r, g, b] = TINTS[number % TINTS.len()];
        let grid = &self.lattice.grid;
        let warped = |x: f64, y: f64| {
            let at = ScreenPoint(grid.point_from_spans([x, y]).into());
            frame.image_from_screen(self.lattice.warp(at))
        };
        for &([i, j], is_folded) in &self.cells {
            let (i, j) = (i as f64, j as f64);
            let sides = [|t: f64| [t, 0.0], |t: f64| [1.0, t], |t: f64| [1.0 - t, 1.0], |t: f64| [0.0, 1.0 - t]];
            let along = |k: usize| k as f64 / PIECES as f64;
            let rim = sides.iter().flat_map(|side| (0..PIECES).map(move |k| side(along(k))));
            let rim: Vec<ImagePoint> = rim.map(|[x, y]| warped(i + x, j + y)).collect();
            if is_folded {
                canvas.fill_polygon(&rim, FOLDED);
            }
            for (k, &from) in rim.iter().enumerate() {
                canvas.line(from, rim[(k + 1) % rim.len()], unit_px, Rgba8([r, g, b, 130]));
            }
        }
    }
}
