//! Draws a picture under a branching lattice: each part is cut out, warped by its own lattice, and composited over those behind.
//!
//! In: a [`FlatPicture`], a solved [`BranchedLattice`] and its [`OrderedParts`]. Out: the warped picture.

use super::composite_parts::{PART_CHANNELS, composite_parts};
use super::read::{FlatPicture, plate_of};
use crate::image::{Frame, LabelMap, NO_LABEL, Plate, convex_spans, neighbours};
use crate::lattice::ScreenLattice;
use crate::pipeline::evaluate::ordered_parts::OrderedParts;
use crate::plate::PlateReport;
use crate::solve::BranchedLattice;
use crate::space::{FrameSize, FrameWindow, ImagePoint, PixelRect, ScreenPoint};

/// Width in pixels of the rim by which a part extends under connected parts in front, so that filtered edges leave no visible seam.
const RIM_WIDTH: usize = 3;

/// Distance in pixels between the images of a pixel under two lattices above which the two parts are not connected there.
const SAME_PLACE: f64 = 0.5;

/// The part of every pixel of a picture's window.
pub(super) struct PartMap {
    window: PixelRect,
    frame: FrameSize,
    /// The label is one more than the index of the part; [`NO_LABEL`] where no part is connected to the pixel.
    map: LabelMap,
}

impl PartMap {
    /// Labels the pixels of the shape; covered pixels outside the shape get the part of the nearest pixel inside, if possible of one that
    /// they are connected to.
    pub(super) fn of(flat_picture: &FlatPicture, branches: &BranchedLattice<2>, parts: &OrderedParts) -> Self {
        let (window, frame) = (flat_picture.window(), flat_picture.plate.frame_size());
        let labels = LabelMap { size: [window.width, window.height], labels: vec![NO_LABEL; window.area()] };
        let mut map = Self { window, frame, map: labels };
        for (&part, (_, corners)) in parts.of_pieces.iter().zip(branches.pieces()) {
            let corners = corners.iter().map(|&[x, y]| frame.image_from_screen(ScreenPoint::new(x, y)).0.to_array());
            map.fill(part, &corners.collect::<Vec<[f64; 2]>>());
        }
        let alpha = flat_picture.alpha();
        map.map.spread(|pixel| alpha[pixel] != 0.0);
        // Islands that are too small for the shape.
        if (0..alpha.len()).any(|pixel| alpha[pixel] != 0.0 && map.part(pixel).is_none()) {
            map.map.spread(|_| true);
        }
        map
    }

    /// Fills a convex polygon, given in pixels of the frame.
    fn fill(&mut self, part: u32, corners: &[[f64; 2]]) {
        let (width, height) = (self.window.width as usize, self.window.height as usize);
        // Coordinates are relative to the centre of the first pixel.
        let origin = [f64::from(self.window.x) + 0.5, f64::from(self.window.y) + 0.5];
        let corners: Vec<[f64; 2]> = corners.iter().map(|&[x, y]| [x - origin[0], y - origin[1]]).collect();
        for (row, columns) in convex_spans(&corners, [width, height]) {
            self.map.labels[row * width + columns.start..row * width + columns.end].fill(part + 1);
        }
    }

    /// Returns the part of a pixel.
    fn part(&self, pixel: usize) -> Option<usize> {
        self.map.labels[pixel].checked_sub(1).map(|part| part as usize)
    }

    /// Returns the image of a pixel's centre under a lattice, in pixels.
    fn image(&self, lattice: &ScreenLattice, pixel: usize) -> [f64; 2] {
        let width = self.window.width as usize;
        let place = |start: i32, step: usize| f64::from(start) + step as f64 + 0.5;
        let at = ImagePoint::new(place(self.window.x, pixel % width), place(self.window.y, pixel / width));
        self.frame.image_from_screen(lattice.warp(self.frame.screen_from_image(at))).0.to_array()
    }

    /// Returns the pixels of a part and its rim: those of connected parts in front of it up to [`RIM_WIDTH`] pixels away.
    fn mask(&self, part: usize, lattices: &[&ScreenLattice]) -> Vec<bool> {
        let mut ring: Vec<usize> = (0..self.window.area()).filter(|&pixel| self.part(pixel) == Some(part)).collect();
        let mut mask = vec![false; self.window.area()];
        ring.iter().for_each(|&pixel| mask[pixel] = true);
        for _ in 0..RIM_WIDTH {
            let mut next = Vec::new();
            for neighbour in ring.iter().flat_map(|&pixel| neighbours(self.map.size, pixel)).flatten() {
                let Some(in_front) = self.part(neighbour).filter(|&other| other > part && !mask[neighbour]) else {
                    continue;
                };
                let [own, other] = [part, in_front].map(|index| self.image(lattices[index], neighbour));
                if (own[0] - other[0]).hypot(own[1] - other[1]) <= SAME_PLACE {
                    mask[neighbour] = true;
                    next.push(neighbour);
                }
            }
            ring = next;
        }
        mask
    }
}

/// Returns a picture whose parts are warped by `warp`, and the warnings of those warps: of the parts that fold, those of the one that
/// folds most.
pub(super) fn warped_branches(
    flat_picture: &FlatPicture,
    (map, branches, parts): (&PartMap, &BranchedLattice<2>, &OrderedParts),
    warp: impl Fn(&Plate, ScreenLattice) -> (Frame, PlateReport),
) -> (Frame, Vec<String>) {
    let of_branches: Vec<ScreenLattice> = (0..branches.branch_count()).map(|k| branches.extended_lattice(k)).collect();
    let lattices: Vec<&ScreenLattice> = parts.list.iter().map(|part| &of_branches[part.branch]).collect();
    let (mut pictures, mut reports) = (Vec::new(), Vec::new());
    for part in 0..lattices.len() {
        let mask = map.mask(part, &lattices);
        let Some(plate) = cut_out(flat_picture, map, (part, &mask)) else { continue };
        let (picture, report) = warp(&plate, lattices[part].clone());
        pictures.push(picture);
        reports.push(report);
    }
    let most = reports.iter().map(|report| report.folded_pixels).max().unwrap_or(0);
    reports.retain(|report| [0, most].contains(&report.folded_pixels));
    let mut warnings: Vec<String> = reports.into_iter().flat_map(|report| report.warnings).collect();
    warnings.dedup();
    (composite_parts(map.frame, &pictures), warnings)
}

/// Cuts out the pixels of a part's mask, in their bounding window, with [`PART_CHANNELS`]; `None` if there are none.
fn cut_out(flat_picture: &FlatPicture, map: &PartMap, (part, mask): (usize, &[bool])) -> Option<Plate> {
    let width = map.window.width as usize;
    let rows: Vec<usize> =
        (0..map.window.height as usize).filter(|row| mask[row * width..][..width].contains(&true)).collect();
    let is_used = |column: &usize| rows.iter().any(|row| mask[row * width + column]);
    let (top, bottom) = (*rows.first()?, *rows.last()?);
    let (left, right) = ((0..width).find(is_used)?, (0..width).rev().find(is_used)?);
    let window = PixelRect {
        x: map.window.x + left as i32,
        y: map.window.y + top as i32,
        width: (right - left + 1) as u32,
        height: (bottom - top + 1) as u32,
    };
    let pixels = || (top..=bottom).flat_map(move |row| row * width + left..=row * width + right);
    let cut =
        |sample: &dyn Fn(usize) -> f32| pixels().map(|pixel| if mask[pixel] { sample(pixel) } else { 0.0 }).collect();
    let alpha = flat_picture.alpha();
    let is_own = |pixel: usize| map.part(pixel) == Some(part);
    let region = |pixel: usize| if is_own(pixel) && alpha[pixel] != 0.0 { 1.0 } else { 0.0 };
    let rim = |pixel: usize| if is_own(pixel) { 0.0 } else { alpha[pixel] };
    let colors = flat_picture.planes().map(|samples| cut(&|pixel| samples[pixel]));
    let planes = colors.chain([cut(&region), cut(&rim)]);
    Some(plate_of(FrameWindow { frame: map.frame, window }, PART_CHANNELS.into_iter().zip(planes)))
}
