//! Gives the lines of a drawing to the regions that they bound, in their whole width.
//!
//! In: regions and [`Ink`]. Out: the region of every cell of ink. A region takes the ink that lies as near to it as the line is wide, those that
//! come first before others; a solid black area keeps its own corners.

use super::LabelMap;
use super::ink::Ink;
use super::label_map::{NO_LABEL, around};
use std::collections::{BTreeMap, VecDeque};

/// How far a region reaches into a line, widths of the line: to the point of a corner, whose diagonal is longer.
const REACH: f32 = 1.5;

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
            self.flood(map, *label, rim, |_, to, square| {
                let reach = REACH * self.ink.widths[to] + 0.5;
                square <= reach * reach
            });
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
    fn flood(&self, map: &mut LabelMap, label: u32, rim: Vec<usize>, reaches: impl Fn(usize, usize, f32) -> bool) {
        let [width, height] = map.size.map(|side| side as usize);
        let square = |a: usize, b: usize| {
            let [x, y] = [(a % width).abs_diff(b % width), (a / width).abs_diff(b / width)];
            (x * x + y * y) as f32
        };
        let mut open: VecDeque<[usize; 2]> = rim.into_iter().map(|cell| [cell, cell]).collect();
        while let Some([cell, from]) = open.pop_front() {
            for near in around(width, height, cell) {
                if self.is_free(map, near) && reaches(from, near, square(from, near)) {
                    map.labels[near] = label;
                    open.push_back([near, from]);
                }
            }
        }
    }
}
