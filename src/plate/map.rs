//! Where every pixel of a warped picture comes from, or where every pixel of a picture goes.
//!
//! In: a [`Field`], a window of pixels. Out: offsets, in pixels; NaN where nothing comes from.

use super::Field;
use super::map_blocks::{self, Nodes};
use super::map_folds::{FOLDED, Folds, Sheet};
use super::map_mesh::Net;
use super::map_patch::LARGEST;
use super::map_view::{Direction, View, center, corner, extent};
use super::nearest::{HALF, nearest_source};
use crate::space::{FrameSize, PixelRect};
use glam::DVec2;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Where every pixel of a window comes from (or goes to).
#[derive(Clone, Debug, PartialEq)]
pub struct WarpMap {
    /// The display window that the screen is measured against.
    pub frame: FrameSize,
    /// The pixels that the map tells of, relative to the upper left corner of the DISPLAY window; may lie partly or
    /// wholly outside the frame.
    pub window: PixelRect,
    /// #pixels of the window, rows from the top: what has to be added to a pixel's centre, in pixels, x right, y DOWN;
    /// NaN where nothing is seen. Exactly 0 where nothing moves.
    pub offsets: Vec<[f32; 2]>,
    /// Pixels of the window (places in `offsets`, in order) at which the field is not one-to-one: several points of the
    /// source land there (backward), or the pixel lands where others do (forward).
    pub folded_pixels: Vec<u32>,
}

/// Steps between neighbours that differ by more than this, in pixels a pixel, belong to different sheets.
const TEAR: f32 = 0.5;

impl WarpMap {
    /// The map that moves nothing.
    #[must_use]
    pub fn identity(frame: FrameSize, window: PixelRect) -> Self {
        Self { frame, window, offsets: vec![[0.0; 2]; window.area()], folded_pixels: Vec::new() }
    }

    /// For every pixel of the warped picture: where it came from. Where the picture lies over itself, the sheet in
    /// front: one that is not turned over, of several the one that moved furthest (what is pulled lies over what
    /// stays). Every pixel comes from somewhere, unless the field holds NaN.
    #[must_use]
    pub fn backward(field: &Field, frame: FrameSize, window: PixelRect) -> Self {
        let (mut map, folds) = Self::without_folds(field, frame, window);
        folds.first_sheets().for_each(|sheet| map.set(sheet));
        map
    }

    /// As [`Self::backward`], but what is transparent hides nothing: where the picture lies over itself, the first sheet
    /// that is covered by half, or else the one that is covered most. `coverage`: how much of a pixel of the unwarped picture,
    /// from the upper left corner of the display window, can be seen, 0 to 1. Folds in which nothing can be seen do not count.
    #[must_use]
    pub fn backward_showing(
        field: &Field,
        (frame, window): (FrameSize, PixelRect),
        coverage: impl Fn([i32; 2]) -> f32,
    ) -> Self {
        let (mut map, folds) = Self::without_folds(field, frame, window);
        let of = |sheet: &Sheet| {
            let pixel = window.pixel_at(sheet.pixel as usize);
            nearest_source(pixel, sheet.offset.as_vec2().to_array()).map_or(0.0, &coverage)
        };
        let mut unseen = BTreeSet::new();
        for group in folds.sheets.chunk_by(|a, b| a.pixel == b.pixel) {
            let (mut best, mut most) = (&group[0], of(&group[0]));
            for sheet in &group[1..] {
                let covered = of(sheet);
                if most < HALF && covered > most {
                    (best, most) = (sheet, covered);
                }
            }
            map.set(best);
            if most <= 0.0 {
                unseen.insert(best.pixel);
            }
        }
        map.folded_pixels.retain(|pixel| !unseen.contains(pixel));
        map
    }

    /// All sheets of the warped picture that are not turned over, front first: [`Self::backward`], and behind it maps
    /// that are NaN but where the picture lies over itself. A layer with a matte needs them: what is transparent in
    /// front does not hide what lies behind.
    #[must_use]
    pub fn backward_sheets(field: &Field, frame: FrameSize, window: PixelRect) -> Vec<Self> {
        let (map, folds) = Self::without_folds(field, frame, window);
        let mut maps = vec![map];
        for group in folds.sheets.chunk_by(|a, b| a.pixel == b.pixel) {
            for (depth, sheet) in group.iter().enumerate() {
                if depth == maps.len() {
                    let nothing = vec![[f32::NAN; 2]; window.area()];
                    maps.push(Self { offsets: nothing, ..Self::identity(frame, PixelRect::default()) });
                }
                maps[depth].set(sheet);
            }
        }
        let (front, behind) = maps.split_first_mut().expect("the sheet in front is always there");
        for map in behind {
            map.window = window;
            let is_seen = |&&index: &&u32| !map.offsets[index as usize][0].is_nan();
            map.folded_pixels = front.folded_pixels.iter().filter(is_seen).copied().collect();
        }
        maps
    }

    /// The map but where sheets overlap.
    fn without_folds(field: &Field, frame: FrameSize, window: PixelRect) -> (Self, Folds) {
        let view = View { field, frame, direction: Direction::Backward };
        let mut map = Self::identity(frame, window);
        if field.is_identity() || window.area() == 0 {
            return (map, Folds::NONE);
        }
        if field.is_one_to_one() {
            let nodes = Nodes::solve(view, window, &vec![DVec2::ZERO; Nodes::count(window).iter().product()]);
            map_blocks::fill(view, &nodes, &[], &mut map);
            return (map, Folds::NONE);
        }
        let net = Net::behind(view, window);
        let starts = net.starts(center(window.x, window.y), LARGEST as f64, Nodes::count(window));
        let nodes = Nodes::solve(view, window, &starts);
        let folds = Folds::find(view, &net, window);
        let is_whole = map_blocks::fill(view, &nodes, &folds.flags, &mut map);
        if !is_whole {
            let missing = Folds::of_missing(view, &net, window, &map.offsets);
            missing.first_sheets().for_each(|sheet| map.set(sheet));
        }
        map.folded_pixels = folds.pixels();
        (map, folds)
    }

    /// For every pixel of a picture: where its centre goes. Folded are pixels that are turned over and pixels that land
    /// where another part of the picture does.
    #[must_use]
    pub fn forward(field: &Field, frame: FrameSize, window: PixelRect) -> Self {
        let mut map = Self::forward_alone(field, frame, window);
        if !(field.is_one_to_one() || window.area() == 0) {
            map.folded_pixels = map.overlapping(View { field, frame, direction: Direction::Forward });
        }
        map
    }

    /// The same, but nothing tells of folds.
    pub(super) fn forward_alone(field: &Field, frame: FrameSize, window: PixelRect) -> Self {
        let view = View { field, frame, direction: Direction::Forward };
        let mut map = Self::identity(frame, window);
        if !(field.is_identity() || window.area() == 0) {
            let nodes = Nodes::solve(view, window, &vec![DVec2::ZERO; Nodes::count(window).iter().product()]);
            map_blocks::fill(view, &nodes, &[], &mut map);
        }
        map
    }

    /// Pixels that land where a fold does.
    fn overlapping(&self, view: View) -> Vec<u32> {
        let lands_in = view.field.warped_window(self.frame, self.window);
        let net = Net::behind(view, lands_in);
        let folds = Folds::find(view, &net, lands_in);
        let is_folded = |offset: &[f32; 2], index: usize| {
            let (x, y) = (index % self.window.width as usize, index / self.window.width as usize);
            let place = corner(self.window) + DVec2::new(x as f64, y as f64) - corner(lands_in);
            let at = (place + DVec2::new(offset[0].into(), offset[1].into())).round();
            let is_within = at.cmpge(DVec2::ZERO).all() && at.cmplt(extent(lands_in)).all();
            is_within && folds.flags[at.y as usize * lands_in.width as usize + at.x as usize] == FOLDED
        };
        if folds.flags.is_empty() {
            return Vec::new();
        }
        let folded = self.offsets.par_iter().enumerate().filter(|&(index, offset)| is_folded(offset, index));
        folded.map(|(index, _)| index as u32).collect()
    }

    fn set(&mut self, sheet: &Sheet) {
        self.offsets[sheet.pixel as usize] = sheet.offset.as_vec2().to_array();
    }

    /// Where pixel (x, y) of the display window comes from (or goes to), in pixels: the centre of pixel (i, j) is
    /// (i + .5, j + .5). `None` outside the window and where nothing is seen.
    #[must_use]
    pub fn source(&self, x: i32, y: i32) -> Option<[f64; 2]> {
        let column = usize::try_from(i64::from(x) - i64::from(self.window.x)).ok()?;
        let row = usize::try_from(i64::from(y) - i64::from(self.window.y)).ok()?;
        if column >= self.window.width as usize || row >= self.window.height as usize {
            return None;
        }
        let [dx, dy] = self.offsets[row * self.window.width as usize + column].map(f64::from);
        let source = center(x, y) + DVec2::new(dx, dy);
        source.is_finite().then_some(source.to_array())
    }

    /// How the source moves per pixel at a place in `offsets`: `[row][column]`, column 0 a step to the right, column 1 a
    /// step DOWN, in pixels. Steps across the edge of a sheet do not count; a pixel alone gets the identity.
    #[must_use]
    pub fn jacobian(&self, index: usize) -> [[f32; 2]; 2] {
        let width = self.window.width as usize;
        let (column, row) = (index % width, index / width);
        let right = (column + 1 < width).then(|| index + 1);
        let below = (row + 1 < self.window.height as usize).then(|| index + width);
        let x = self.step(index, index.checked_sub(1).filter(|_| column > 0), right);
        let y = self.step(index, index.checked_sub(width), below);
        [[1.0 + x[0], y[0]], [x[1], 1.0 + y[1]]]
    }

    /// Change of the offsets a pixel, between two neighbours.
    fn step(&self, at: usize, before: Option<usize>, after: Option<usize>) -> [f32; 2] {
        let here = self.offsets[at];
        let change = |other: Option<usize>, sign: f32| {
            let there = self.offsets[other?];
            let change = [0, 1].map(|d| (there[d] - here[d]) * sign);
            (change[0] + change[1]).is_finite().then_some(change)
        };
        let square = |v: [f32; 2]| v[0] * v[0] + v[1] * v[1];
        match (change(before, -1.0), change(after, 1.0)) {
            (Some(a), Some(b)) if square([a[0] - b[0], a[1] - b[1]]) <= TEAR * TEAR => {
                [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
            }
            (Some(a), Some(b)) => {
                if square(a) <= square(b) {
                    a
                } else {
                    b
                }
            }
            (Some(only), None) | (None, Some(only)) => only,
            (None, None) => [0.0; 2],
        }
    }
}
