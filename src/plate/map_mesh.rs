//! A regular mesh over the unwarped picture, and its image under the field.
//!
//! In: a [`PixelField`], the window of the warped picture. Out: approximate offsets to start searches from, and the
//! cells in which the field may flip. Neighbouring cells share their corners, so there are no cracks.

use super::pixel_field::{PixelField, corner, extent};
use crate::space::PixelRect;
use glam::DVec2;
use rayon::prelude::*;

/// Mesh spacing in pixels, unless the lattice is finer.
const STEP: f64 = 32.0;
/// Maximum number of mesh lines per axis.
const MAX_LINES: usize = 1024;
/// A cell is searched for folds if the determinant at a corner is below this plus half its range over the cell.
const THIN: f64 = 0.05;
/// Fraction by which triangles are enlarged, since neighbours with different subdivision share curved sides only approximately.
const OVERLAP: f64 = 0.01;

/// Points of the unwarped picture and their images.
pub(super) struct WarpedMesh {
    /// First point, in pixels.
    pub(super) origin: DVec2,
    pub(super) step: DVec2,
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// #columns · #rows: images, in pixels.
    images: Vec<DVec2>,
    /// #columns · #rows: determinants of the gradient of the field.
    determinants: Vec<f64>,
}

/// A triangle with the offsets to the source at its corners.
pub(super) struct Triangle {
    pub(super) places: [DVec2; 3],
    pub(super) offsets: [DVec2; 3],
}

impl WarpedMesh {
    /// Creates a mesh over everything that may land in `window`.
    pub(super) fn behind(pixel_field: PixelField, window: PixelRect) -> Self {
        Self::over(
            pixel_field,
            corner(window) - pixel_field.max_displacement() - 1.0,
            corner(window) + extent(window) + pixel_field.max_displacement() + 1.0,
        )
    }

    /// Creates a mesh over a box of the unwarped picture.
    pub(super) fn over(pixel_field: PixelField, lo: DVec2, hi: DVec2) -> Self {
        let step = pixel_field.finest_step().clamp(1.0, STEP);
        let [columns, rows] = [0, 1].map(|axis| {
            let lines = ((hi - lo)[axis] / step).ceil();
            if lines < MAX_LINES as f64 { lines.max(1.0) as usize + 1 } else { MAX_LINES }
        });
        let step = (hi - lo) / DVec2::new((columns - 1) as f64, (rows - 1) as f64);
        let carried = (0..columns * rows).into_par_iter().with_min_len(256).map(|index| {
            let point = lo + step * DVec2::new((index % columns) as f64, (index / columns) as f64);
            let (moved, gradient) = pixel_field.displace(point);
            (point + moved, gradient.determinant())
        });
        let (images, determinants) = carried.unzip();
        Self { origin: lo, step, columns, rows, images, determinants }
    }

    /// Returns the indices of the first corners of all cells, x fastest.
    fn cells(&self) -> impl Iterator<Item = usize> {
        let columns = self.columns;
        (0..self.rows - 1).flat_map(move |row| (0..columns - 1).map(move |column| row * columns + column))
    }

    /// Returns the indices of a cell's corners: upper left, upper right, lower left, lower right.
    fn corners(&self, cell: usize) -> [usize; 4] {
        [cell, cell + 1, cell + self.columns, cell + self.columns + 1]
    }

    /// Returns the point of the unwarped picture at an index.
    pub(super) fn point(&self, index: usize) -> DVec2 {
        self.origin + self.step * DVec2::new((index % self.columns) as f64, (index / self.columns) as f64)
    }

    /// Returns the bounding box of a cell's image.
    pub(super) fn image_box(&self, cell: usize) -> [DVec2; 2] {
        let images = self.corners(cell).map(|index| self.images[index]);
        [images.into_iter().fold(images[0], DVec2::min), images.into_iter().fold(images[0], DVec2::max)]
    }

    /// Returns the cells in which the determinant may be zero or negative.
    pub(super) fn folded(&self) -> Vec<usize> {
        let may_fold = |&cell: &usize| {
            let values = self.corners(cell).map(|index| self.determinants[index]);
            let least = values.into_iter().fold(f64::INFINITY, f64::min);
            let most = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
            // NaN does not count as a fold.
            least < THIN + 0.5 * (most - least)
        };
        self.cells().filter(may_fold).collect()
    }

    /// Returns the cells whose image may touch a box.
    pub(super) fn cells_near(&self, [lo, hi]: [DVec2; 2]) -> Vec<usize> {
        let touches = |&cell: &usize| {
            let [least, most] = self.image_box(cell);
            let bulge = (most - least) * 0.25 + 1.0;
            (least - bulge).cmple(hi).all() && (most + bulge).cmpge(lo).all()
        };
        self.cells().filter(touches).collect()
    }

    /// Returns approximate offsets to the source at the points of a grid, given its first point, its step, and its
    /// columns and rows; 0 where no cell lands.
    pub(super) fn starts(&self, first: DVec2, step: f64, [columns, rows]: [usize; 2]) -> Vec<DVec2> {
        let mut starts = vec![DVec2::ZERO; columns * rows];
        for cell in self.cells() {
            for half in halves(self.corners(cell)) {
                let images = half.map(|index| self.images[index]);
                let offsets = half.map(|index| self.point(index) - self.images[index]);
                let triangle = Triangle { places: images.map(|image| (image - first) / step), offsets };
                triangle.visit([columns, rows], |[x, y], offset| starts[y * columns + x] = offset);
            }
        }
        starts
    }
}

/// Splits a cell into two triangles that wind from x to y.
pub(super) fn halves([a, b, c, d]: [usize; 4]) -> [[usize; 3]; 2] {
    [[a, b, d], [a, d, c]]
}

impl Triangle {
    /// Returns twice the signed area; negative if flipped.
    pub(super) fn area(&self) -> f64 {
        let [a, b, c] = self.places;
        (b - a).perp_dot(c - a)
    }

    /// Calls `visit` for every integer position in 0..columns, 0..rows on the triangle including its border, with the
    /// offset there. Skips flipped and degenerate triangles.
    pub(super) fn visit(&self, counts: [usize; 2], visit: impl FnMut([usize; 2], DVec2)) {
        if self.area() > 0.0 {
            self.visit_either_way(counts, visit);
        }
    }

    /// As [`Self::visit`], including flipped triangles.
    pub(super) fn visit_either_way(&self, counts: [usize; 2], mut visit: impl FnMut([usize; 2], DVec2)) {
        let [a, b, c] = self.places;
        let (lo, hi) = (a.min(b).min(c).ceil(), a.max(b).max(c).floor());
        let scale = 1.0 / self.area();
        if !(scale.is_finite() && hi.min_element() >= 0.0) {
            return;
        }
        let span = |axis: usize| lo[axis].max(0.0) as usize..=(hi[axis] as usize).min(counts[axis] - 1);
        for y in span(1) {
            for x in span(0) {
                let p = DVec2::new(x as f64, y as f64);
                let weights = [(c - b).perp_dot(p - b), (a - c).perp_dot(p - c), (b - a).perp_dot(p - a)];
                let [u, v, w] = weights.map(|weight| weight * scale);
                if u.min(v).min(w) >= -OVERLAP {
                    visit([x, y], self.offsets[0] * u + self.offsets[1] * v + self.offsets[2] * w);
                }
            }
        }
    }
}
