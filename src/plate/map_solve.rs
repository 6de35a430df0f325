//! Solves a field for the map of a window: backward by searches that start from a mesh, forward by evaluation.
//!
//! In: a [`Field`], a window of pixels. Out: a [`WarpMap`], NaN where a pixel has no source.

use super::Field;
use super::map_blocks::{self, MapNodes};
use super::map_folds::{FOLDED, MapFolds, Preimage};
use super::map_mesh::WarpedMesh;
use super::map_patch::LARGEST;
use super::pixel_field::{Direction, PixelField, center, corner, extent};
use super::warp_map::{HALF, WarpMap, nearest_source};
use crate::space::{FrameSize, FrameWindow, PixelRect};
use glam::DVec2;
use rayon::prelude::*;
use std::collections::BTreeSet;

impl WarpMap {
    /// Returns the source of every pixel of the warped picture.
    ///
    /// Where the picture folds over itself, this is the front preimage: one that is not flipped, and of several the one that moved
    /// furthest (what is pulled lies over what stays). Every pixel has a source unless the field contains NaN.
    #[must_use]
    pub fn backward(field: &Field, frame: FrameSize, window: PixelRect) -> Self {
        let (mut map, folds) = Self::without_folds(field, frame, window);
        folds.first_preimages().for_each(|preimage| map.set(preimage));
        map
    }

    /// As [`Self::backward`], but transparent pixels do not hide anything: in folds, selects the first preimage with a
    /// coverage of at least half, or else the one with the highest.
    ///
    /// `coverage`: coverage of a pixel of the unwarped picture, 0 to 1, relative to the upper left corner of the
    /// display window. Folds in which nothing is visible are not counted.
    #[must_use]
    pub(crate) fn backward_showing(
        field: &Field,
        FrameWindow { frame, window }: FrameWindow,
        coverage: impl Fn([i32; 2]) -> f32,
    ) -> Self {
        let (mut map, folds) = Self::without_folds(field, frame, window);
        let of = |preimage: &Preimage| {
            let pixel = window.pixel_at(preimage.pixel as usize);
            nearest_source(pixel, preimage.offset.as_vec2().to_array()).map_or(0.0, &coverage)
        };
        let mut unseen = BTreeSet::new();
        for group in folds.preimages.chunk_by(|a, b| a.pixel == b.pixel) {
            let (mut best, mut most) = (&group[0], of(&group[0]));
            for preimage in &group[1..] {
                let covered = of(preimage);
                if most < HALF && covered > most {
                    (best, most) = (preimage, covered);
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

    /// Returns all preimages that are not flipped, front first: the map of [`Self::backward`], followed by maps that are NaN except where
    /// the picture folds over itself. A matted layer needs them because its transparent front does not hide what lies behind.
    #[must_use]
    pub(crate) fn backward_preimages(field: &Field, frame: FrameSize, window: PixelRect) -> Vec<Self> {
        if let Some(surfaces) = field.surfaces() {
            return vec![surfaces.backward_over(window)];
        }
        let (map, folds) = Self::without_folds(field, frame, window);
        let mut maps = vec![map];
        for group in folds.preimages.chunk_by(|a, b| a.pixel == b.pixel) {
            for (depth, preimage) in group.iter().enumerate() {
                if depth == maps.len() {
                    let nothing = vec![[f32::NAN; 2]; window.area()];
                    maps.push(Self { offsets: nothing, ..Self::identity(frame, PixelRect::default()) });
                }
                maps[depth].set(preimage);
            }
        }
        let (front, behind) = maps.split_first_mut().expect("the preimage in front is always there");
        for map in behind {
            map.window = window;
            let is_seen = |&&index: &&u32| !map.offsets[index as usize][0].is_nan();
            map.folded_pixels = front.folded_pixels.iter().filter(is_seen).copied().collect();
        }
        maps
    }

    /// Computes the map except where preimages overlap.
    fn without_folds(field: &Field, frame: FrameSize, window: PixelRect) -> (Self, MapFolds) {
        let pixel_field = PixelField { field, frame, direction: Direction::Backward };
        let mut map = Self::identity(frame, window);
        if field.is_identity() || window.area() == 0 {
            return (map, MapFolds::NONE);
        }
        if field.is_one_to_one() {
            let starts = vec![DVec2::ZERO; MapNodes::count(window).iter().product()];
            let nodes = MapNodes::solve(pixel_field, window, &starts);
            map_blocks::fill(pixel_field, &nodes, &[], &mut map);
            return (map, MapFolds::NONE);
        }
        let mesh = WarpedMesh::behind(pixel_field, window);
        let starts = mesh.starts(center(window.x, window.y), LARGEST as f64, MapNodes::count(window));
        let nodes = MapNodes::solve(pixel_field, window, &starts);
        let folds = MapFolds::find(pixel_field, &mesh, window);
        let is_complete = map_blocks::fill(pixel_field, &nodes, &folds.flags, &mut map);
        if !is_complete {
            let missing = MapFolds::of_missing(pixel_field, &mesh, window, &map.offsets);
            missing.first_preimages().for_each(|preimage| map.set(preimage));
        }
        map.folded_pixels = folds.pixels();
        (map, folds)
    }

    /// Returns the target of every pixel centre of a picture. Pixels that are flipped, and pixels that land on another
    /// part of the picture, count as folded.
    #[must_use]
    pub(crate) fn forward(field: &Field, frame: FrameSize, window: PixelRect) -> Self {
        let mut map = Self::forward_alone(field, frame, window);
        if !(field.is_one_to_one() || window.area() == 0) {
            map.folded_pixels = map.overlapping(PixelField { field, frame, direction: Direction::Forward });
        }
        map
    }

    /// As [`Self::forward`], without finding folds.
    pub(super) fn forward_alone(field: &Field, frame: FrameSize, window: PixelRect) -> Self {
        if let Some(surfaces) = field.surfaces() {
            return surfaces.forward_over(window);
        }
        let pixel_field = PixelField { field, frame, direction: Direction::Forward };
        let mut map = Self::identity(frame, window);
        if !(field.is_identity() || window.area() == 0) {
            let nodes =
                MapNodes::solve(pixel_field, window, &vec![DVec2::ZERO; MapNodes::count(window).iter().product()]);
            map_blocks::fill(pixel_field, &nodes, &[], &mut map);
        }
        map
    }

    /// Returns the pixels that land on a fold.
    fn overlapping(&self, pixel_field: PixelField) -> Vec<u32> {
        let lands_in = pixel_field.field.warped_window(self.frame, self.window);
        let mesh = WarpedMesh::behind(pixel_field, lands_in);
        let folds = MapFolds::find(pixel_field, &mesh, lands_in);
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

    fn set(&mut self, preimage: &Preimage) {
        self.offsets[preimage.pixel as usize] = preimage.offset.as_vec2().to_array();
    }
}
