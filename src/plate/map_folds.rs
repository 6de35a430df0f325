//! Finds the folds of a warped picture: the preimages that land on each folded pixel, and which of them is in front.
//!
//! In: a [`PixelField`] and its [`WarpedMesh`]. Out: the folded pixels, and the preimages of each, front first.
//!
//! The map is not flipped far away, so except for one, preimages come in pairs with negative and positive determinant:
//! a pixel is covered more than once exactly where the image of a flipped region lies.

use super::Field;
use super::map_mesh::{Triangle, WarpedMesh, halves};
use super::pixel_field::{Direction, PixelField, center, corner};
use crate::space::{FrameSize, PixelRect};
use glam::{DMat2, DVec2};
use rayon::prelude::*;

/// Spacing of the fine mesh in pixels, in the source and in the picture; its hits are refined by searches.
const FINE: f64 = 2.0;
/// Maximum number of fine mesh lines per cell.
const MAX_LINES: f64 = 64.0;
/// Maximum shift of a preimage by refinement, in pixels; beyond it, the search has moved to another preimage.
const SLIP: f64 = 2.0;
/// Preimages closer than this are the same, in pixels.
const SAME: f64 = 0.5;

/// Pixel flags.
pub(super) const NEAR: u8 = 1;
pub(super) const FOLDED: u8 = 2;

/// All folds of a window.
pub(super) struct MapFolds {
    /// #pixels of the window, or empty if nothing folds: 0, [`NEAR`] a fold, or [`FOLDED`].
    pub(super) flags: Vec<u8>,
    /// Preimages of the flagged pixels that are not flipped: ordered by pixel, then front first.
    pub(super) preimages: Vec<Preimage>,
}

/// A preimage of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Preimage {
    /// Index of the pixel in the window.
    pub(super) pixel: u32,
    /// Offset to the source, in pixels.
    pub(super) offset: DVec2,
}

/// A finely subdivided cell of the mesh.
struct SubdividedCell {
    lines: [usize; 2],
    /// #lines: positions relative to the centre of the window's first pixel.
    places: Vec<DVec2>,
    /// #lines: offsets to the source.
    offsets: Vec<DVec2>,
}

impl Field {
    /// Whether a window of the warped picture contains folds.
    pub(super) fn folds_in(&self, frame: FrameSize, window: PixelRect) -> bool {
        let pixel_field = PixelField { field: self, frame, direction: Direction::Backward };
        !self.is_one_to_one()
            && window.area() > 0
            && !flags(pixel_field, &WarpedMesh::behind(pixel_field, window), window).is_empty()
    }
}

impl MapFolds {
    /// The absence of folds.
    pub(super) const NONE: Self = Self { flags: Vec::new(), preimages: Vec::new() };

    /// Finds all folds.
    pub(super) fn find(pixel_field: PixelField, mesh: &WarpedMesh, window: PixelRect) -> Self {
        let mut flags = flags(pixel_field, mesh, window);
        let Some(touched) = bounds(&flags, window) else { return Self::NONE };
        let preimages = preimages(pixel_field, mesh, window, (&flags, touched));
        // Pixels without a preimage lie on a crease and are left to the search.
        let mut is_met = vec![false; flags.len()];
        preimages.iter().for_each(|preimage| is_met[preimage.pixel as usize] = true);
        flags.iter_mut().zip(is_met).filter(|(_, is_met)| !is_met).for_each(|(flag, _)| *flag = 0);
        Self { flags, preimages }
    }

    /// Finds, in the fine mesh, preimages of the pixels whose offset is NaN because the search failed.
    pub(super) fn of_missing(
        pixel_field: PixelField,
        mesh: &WarpedMesh,
        window: PixelRect,
        offsets: &[[f32; 2]],
    ) -> Self {
        let flags: Vec<u8> = offsets.par_iter().map(|offset| if offset[0].is_nan() { NEAR } else { 0 }).collect();
        let Some(touched) = bounds(&flags, window) else { return Self::NONE };
        let preimages = preimages(pixel_field, mesh, window, (&flags, touched));
        Self { flags, preimages }
    }

    /// Returns the front preimage of every flagged pixel.
    pub(super) fn first_preimages(&self) -> impl Iterator<Item = &Preimage> {
        self.preimages.chunk_by(|a, b| a.pixel == b.pixel).map(|group| &group[0])
    }

    /// Returns the indices of the folded pixels in the window.
    pub(super) fn pixels(&self) -> Vec<u32> {
        let folded = self.flags.iter().enumerate().filter(|(_, flag)| **flag == FOLDED);
        folded.map(|(index, _)| index as u32).collect()
    }
}

/// Flags the pixels on which flipped regions land, and a border of one pixel.
fn flags(pixel_field: PixelField, mesh: &WarpedMesh, window: PixelRect) -> Vec<u8> {
    let counts = [window.width as usize, window.height as usize];
    let found: Vec<Vec<u32>> = mesh
        .folded()
        .into_par_iter()
        .map(|cell| {
            let mut found = Vec::new();
            for triangle in SubdividedCell::cut(pixel_field, mesh, cell, window).triangles().filter(|t| t.area() < 0.0)
            {
                triangle.visit_either_way(counts, |[x, y], _| found.push((y * counts[0] + x) as u32));
            }
            found
        })
        .collect();
    if found.iter().all(Vec::is_empty) {
        return Vec::new();
    }
    let mut flags = vec![0; window.area()];
    for index in found.into_iter().flatten() {
        let (x, y) = (index as usize % counts[0], index as usize / counts[0]);
        for y in y.saturating_sub(1)..(y + 2).min(counts[1]) {
            for flag in &mut flags[y * counts[0]..][x.saturating_sub(1)..(x + 2).min(counts[0])] {
                *flag = NEAR.max(*flag);
            }
        }
        flags[index as usize] = FOLDED;
    }
    flags
}

/// Returns the bounding box of all flagged pixels, in pixels.
fn bounds(flags: &[u8], window: PixelRect) -> Option<[DVec2; 2]> {
    let width = window.width.max(1) as usize;
    let flagged = flags.iter().enumerate().filter(|(_, flag)| **flag != 0);
    let places = flagged.map(|(index, _)| DVec2::new((index % width) as f64, (index / width) as f64));
    let around = places.fold(None, |around: Option<[DVec2; 2]>, place| {
        Some(around.map_or([place; 2], |[lo, hi]| [lo.min(place), hi.max(place)]))
    });
    around.map(|[lo, hi]| [corner(window) + lo, corner(window) + hi + 1.0])
}

/// Returns all preimages of the flagged pixels, refined.
fn preimages(
    pixel_field: PixelField,
    mesh: &WarpedMesh,
    window: PixelRect,
    (flags, touched): (&[u8], [DVec2; 2]),
) -> Vec<Preimage> {
    let counts = [window.width as usize, window.height as usize];
    let found = mesh.cells_near(touched).into_par_iter().flat_map_iter(|cell| {
        let mut found = Vec::new();
        for triangle in SubdividedCell::cut(pixel_field, mesh, cell, window).triangles() {
            triangle.visit(counts, |[x, y], offset| {
                let pixel = y * counts[0] + x;
                if flags[pixel] != 0 {
                    found.push(Preimage { pixel: pixel as u32, offset });
                }
            });
        }
        found
    });
    let mut preimages: Vec<Preimage> = found.collect();
    preimages.par_iter_mut().for_each(|preimage| preimage.refine(pixel_field, window));
    // The preimage that moved further is in front: what is pulled lies over what stays.
    preimages.par_sort_by(|a, b| {
        let order = |preimage: &Preimage| -preimage.offset.length_squared();
        a.pixel.cmp(&b.pixel).then(order(a).total_cmp(&order(b)))
    });
    // Neighbouring triangles share their sides.
    preimages.dedup_by(|b, a| a.pixel == b.pixel && (a.offset - b.offset).length() < SAME);
    preimages
}

impl Preimage {
    /// Refines the offset from the fine mesh to the exact one, unless the search moves to another preimage.
    fn refine(&mut self, pixel_field: PixelField, window: PixelRect) {
        let (x, y) = (self.pixel % window.width, self.pixel / window.width);
        let pixel = center(window.x + x as i32, window.y + y as i32);
        if let Some(exact) = pixel_field.solve(pixel, self.offset)
            && (exact.offset - self.offset).length() < SLIP
            && (DMat2::IDENTITY + exact.slope).determinant() > 0.0
        {
            self.offset = exact.offset;
        }
    }
}

impl SubdividedCell {
    fn cut(pixel_field: PixelField, mesh: &WarpedMesh, cell: usize, window: PixelRect) -> Self {
        let [lo, hi] = mesh.image_box(cell);
        let size = mesh.step.max(hi - lo) / FINE;
        let lines = [size.x, size.y].map(|pixels| pixels.ceil().clamp(2.0, MAX_LINES) as usize + 1);
        // The image may be rotated: both axes are cut as finely as the longer one needs.
        let lines = [lines[0].max(lines[1]); 2];
        let step = mesh.step / DVec2::new((lines[0] - 1) as f64, (lines[1] - 1) as f64);
        let (start, first) = (mesh.point(cell), center(window.x, window.y));
        let (mut places, mut offsets) = (Vec::new(), Vec::new());
        for index in 0..lines[0] * lines[1] {
            let point = start + step * DVec2::new((index % lines[0]) as f64, (index / lines[0]) as f64);
            let moved = pixel_field.displace(point).0;
            places.push(point + moved - first);
            offsets.push(-moved);
        }
        Self { lines, places, offsets }
    }

    fn triangles(&self) -> impl Iterator<Item = Triangle> {
        let [columns, rows] = self.lines;
        let cells = (0..rows - 1).flat_map(move |row| (0..columns - 1).map(move |column| row * columns + column));
        cells.flat_map(move |cell| {
            halves([cell, cell + 1, cell + columns, cell + columns + 1]).map(|half| Triangle {
                places: half.map(|index| self.places[index]),
                offsets: half.map(|index| self.offsets[index]),
            })
        })
    }
}
