//! Gives the lines of a drawing to the regions that they bound, in their whole width.
//!
//! In: regions and [`Ink`]. Out: the region of every cell of ink. A region takes the ink that lies as near to it as its outline is wide, those
//! that come first before others, with the points of corners. Lines that meet or cross the outline end there. A solid black area keeps its own
//! corners.

use super::LabelMap;
use super::ink::Ink;
use super::label_map::NO_LABEL;
use crate::space::around;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// How far a region reaches into a line that ends there, widths of the line: to the point of a corner, whose diagonal is longer.
const CORNER_REACH: f32 = 1.5;

/// Length of outline, to both sides of a place, over which its width is measured, widths of the line: where another line meets it, it is
/// wider for less than half of that.
const LENGTH: f32 = 2.0;

/// By how much a region reaches farther than its outline is wide, cells: the steps of cells.
const STEP: f32 = 0.5;

/// How far a solid area reaches into lines of its own colour, greatest widths of a line: into its square corners, which a disc of that width
/// does not fill.
const CORNER: f32 = 0.21;

/// A drawing whose lines are given away.
pub(super) struct Lines<'a> {
    pub(super) ink: &'a Ink,
    /// #cells.
    pub(super) light: &'a [u8],
    /// Greatest difference of light within a solid area.
    pub(super) contrast: u8,
    /// Greatest width of a line, cells.
    pub(super) widest: f32,
}

impl Lines<'_> {
    /// Extends solid areas, which have the colour of the lines that they touch, into their corners.
    pub(super) fn complete_corners(&self, map: &mut LabelMap) {
        let reach = CORNER * self.widest + 1.0;
        for (label, rim) in self.rims(map) {
            self.flood(map, label, rim, |from, to, square| {
                square <= reach * reach && self.light[from].abs_diff(self.light[to]) <= self.contrast
            });
        }
    }

    /// Gives lines to regions, in this order.
    pub(super) fn give(&self, map: &mut LabelMap, order: &[u32]) {
        let mut rims = self.rims(map);
        for label in order {
            let rim = rims.remove(label).unwrap_or_default();
            let outline = self.outline_widths(map, &rim);
            let reach = |from: usize, widths: f32| widths * outline.get(&from).copied().unwrap_or(0.0) + STEP;
            let taken = self.flood(map, *label, rim, |from, _, square| square <= reach(from, 1.0).powi(2));
            self.take_corners(map, *label, &taken, |from, square| square <= reach(from, CORNER_REACH).powi(2));
        }
    }

    /// Returns the width of a region's outline at every cell of its rim: the median of those around it.
    fn outline_widths(&self, map: &LabelMap, rim: &[usize]) -> BTreeMap<usize, f32> {
        let [width, height] = map.size.map(|side| side as usize);
        let beside = |cell: usize| {
            let ink = around(width, height, cell).filter(|&near| self.is_free(map, near));
            ink.map(|near| self.ink.widths[near]).fold(0.0, f32::max)
        };
        let own: Vec<(usize, f32)> = rim.iter().map(|&cell| (cell, beside(cell))).collect();
        let side = (LENGTH * self.widest).ceil().max(1.0) as usize;
        let place = |cell: usize| [cell % width / side, cell / width / side];
        let mut places: BTreeMap<[usize; 2], Vec<(usize, f32)>> = BTreeMap::new();
        own.iter().for_each(|&(cell, wide)| places.entry(place(cell)).or_default().push((cell, wide)));
        let median = |(cell, wide): (usize, f32)| {
            let [column, row] = place(cell);
            let rows = row.saturating_sub(1)..row + 2;
            let near = rows.flat_map(|row| (column.saturating_sub(1)..column + 2).map(move |column| [column, row]));
            let reach = (LENGTH * wide.min(self.widest)).powi(2);
            let near = near.filter_map(|place| places.get(&place)).flatten();
            let mut widths: Vec<f32> =
                near.filter(|(other, _)| square(cell, *other, width) <= reach).map(|(_, wide)| *wide).collect();
            let middle = widths.len() / 2;
            let (_, median, _) = widths.select_nth_unstable_by(middle, f32::total_cmp);
            (cell, *median)
        };
        own.into_iter().map(median).collect()
    }

    /// Gives a region what is left of the lines beside the cells that it has taken, each with its cell of the rim, if it all lies within
    /// reach: the points of corners. What leads farther is another line.
    fn take_corners(&self, map: &mut LabelMap, label: u32, taken: &[[usize; 2]], reaches: impl Fn(usize, f32) -> bool) {
        let [width, height] = map.size.map(|side| side as usize);
        let mut seen = BTreeSet::new();
        for &[cell, from] in taken {
            for seed in around(width, height, cell) {
                if !self.is_free(map, seed) || !seen.insert(seed) {
                    continue;
                }
                let (mut rest, mut next) = (vec![seed], 0);
                let mut is_corner = reaches(from, square(from, seed, width));
                while let Some(&cell) = rest.get(next).filter(|_| is_corner) {
                    next += 1;
                    let is_new = |near: &usize| self.is_free(map, *near) && !rest.contains(near);
                    let beside: Vec<usize> = around(width, height, cell).filter(is_new).collect();
                    for near in beside {
                        // What was seen before belongs to a line that leads farther.
                        is_corner &= seen.insert(near) && reaches(from, square(from, near, width));
                        rest.push(near);
                    }
                }
                if is_corner {
                    rest.into_iter().for_each(|cell| map.labels[cell] = label);
                }
            }
        }
    }

    /// Returns the cells of every region that lie beside ink without a region.
    fn rims(&self, map: &LabelMap) -> BTreeMap<u32, Vec<usize>> {
        let mut rims: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        let [width, height] = map.size.map(|side| side as usize);
        for cell in (0..map.labels.len()).filter(|&cell| map.labels[cell] != NO_LABEL) {
            if around(width, height, cell).any(|near| self.is_free(map, near)) {
                rims.entry(map.labels[cell]).or_default().push(cell);
            }
        }
        rims
    }

    fn is_free(&self, map: &LabelMap, cell: usize) -> bool {
        map.labels[cell] == NO_LABEL && self.ink.is_ink[cell]
    }

    /// Labels ink from the cells `rim` on, as far as `reaches` says: of a cell of the rim, a cell of ink, and the square of their distance.
    /// Returns the labelled cells, each with its cell of the rim.
    fn flood(
        &self,
        map: &mut LabelMap,
        label: u32,
        rim: Vec<usize>,
        reaches: impl Fn(usize, usize, f32) -> bool,
    ) -> Vec<[usize; 2]> {
        let [width, height] = map.size.map(|side| side as usize);
        let mut open: VecDeque<[usize; 2]> = rim.into_iter().map(|cell| [cell, cell]).collect();
        let mut taken = Vec::new();
        while let Some([cell, from]) = open.pop_front() {
            for near in around(width, height, cell) {
                if self.is_free(map, near) && reaches(from, near, square(from, near, width)) {
                    map.labels[near] = label;
                    open.push_back([near, from]);
                    taken.push([near, from]);
                }
            }
        }
        taken
    }
}

/// Returns the square of the distance of two cells.
fn square(a: usize, b: usize, width: usize) -> f32 {
    let [x, y] = [(a % width).abs_diff(b % width), (a / width).abs_diff(b / width)];
    (x * x + y * y) as f32
}
