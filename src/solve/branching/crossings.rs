//! Parts of a shape that lie over each other after the warp, as crossing legs do.
//!
//! In: a solved [`BranchedLattice`]. Out: its [`Crossing`]s, and a level for each piece once it is decided which side of each
//! crossing lies in front. Method: the images of the pieces are sampled on a grid. Pairs of pieces that share samples belong to one
//! crossing if the pieces of the one are beside those of the other on both sides, so a crossing is a connected area of the picture.

use super::along_shape::MIN_CONNECTEDNESS;
use super::{BranchedLattice, Branching};
use crate::lattice::Lattice;
use crate::solve::linalg::small_matrix::distance;
use crate::space::ScreenPoint;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};

/// Samples along the shorter side of a cell at rest.
const SAMPLES_PER_CELL: f64 = 8.0;

/// Samples across a shape after the warp, at most.
const MAX_SAMPLES: f64 = 2048.0;

/// Area in samples below which two parts only touch.
const MIN_AREA: u64 = 4;

/// Number of levels above the lowest. Crossings that go round in a circle end at the highest.
const MAX_LEVEL: u32 = 8;

/// Pieces up to so many cells beside a crossing get its level, for what samples miss at its rim.
const RIM: usize = 2;

/// A connected area in which two parts of a shape lie over each other.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Crossing {
    /// The pieces that lie over each other, of the one and of the other side, with the number of samples that they share. A piece may
    /// be in several pairs.
    pairs: Vec<([usize; 2], u64)>,
    /// Mean distance that the surface moves, of each side.
    pub(crate) moved: [f64; 2],
    /// The side of the greater order, over most of the area; `None` if both are of one order.
    pub(crate) ordered: Option<usize>,
    /// The side of the smaller branches, over most of the area; `None` if both are of one branch.
    pub(crate) smaller: Option<usize>,
}

impl Crossing {
    /// The mean of a value of the pieces over the area of a side.
    pub(crate) fn mean(&self, side: usize, of_piece: impl Fn(usize) -> f64) -> f64 {
        let sum: f64 = self.pairs.iter().map(|(pair, count)| *count as f64 * of_piece(pair[side])).sum();
        sum / self.area() as f64
    }

    /// Its area in samples.
    pub(crate) fn area(&self) -> u64 {
        self.pairs.iter().map(|(_, count)| count).sum()
    }

    /// The side on which a value of the pieces is greater over most of the area.
    fn greater<V: Ord>(&self, of_piece: impl Fn(usize) -> V) -> Option<usize> {
        let excess = |(pair, count): &([usize; 2], u64)| {
            let [one, other] = pair.map(&of_piece);
            *count as i64 * one.cmp(&other) as i64
        };
        let excess: i64 = self.pairs.iter().map(excess).sum();
        (excess != 0).then_some(usize::from(excess < 0))
    }

    /// The same crossing, with its sides exchanged if `is_swapped`.
    #[must_use]
    pub(crate) fn oriented(self, is_swapped: bool) -> Self {
        if !is_swapped {
            return self;
        }
        let Self { pairs, moved: [a, b], ordered, smaller } = self;
        let pairs = pairs.into_iter().map(|([a, b], count)| ([b, a], count)).collect();
        let [ordered, smaller] = [ordered, smaller].map(|side| side.map(|side| 1 - side));
        Self { pairs, moved: [b, a], ordered, smaller }
    }

    /// Whether the sides of this crossing are the other way round than those of one that is the same; `None` if it is another one.
    /// `near`: [`BranchedLattice::near_pairs`] of the other.
    pub(crate) fn is_swapped_near(&self, near: &BTreeSet<[usize; 2]>) -> Option<bool> {
        let areas = [false, true].map(|is_swapped| {
            let is_near = |&([a, b], _): &([usize; 2], u64)| near.contains(&if is_swapped { [b, a] } else { [a, b] });
            self.pairs.iter().copied().filter(is_near).map(|(_, count)| count).sum::<u64>()
        });
        (areas != [0, 0]).then_some(areas[1] > areas[0])
    }
}

impl BranchedLattice<2> {
    /// Finds where pieces that are not beside each other along the shape lie over each other. `orders`: one per polygon, in the order
    /// of [`Self::pieces`]. Polygons that are turned over do not count.
    #[must_use]
    pub(crate) fn crossings(&self, orders: &[i32]) -> Vec<Crossing> {
        let images = self.images();
        let branching = self.branching.as_ref();
        let samples = branching.shared_samples(&images);
        let pieces: BTreeSet<usize> = samples.iter().map(|(_, piece)| *piece).collect();
        let beside = pieces.into_iter().map(|piece| (piece, branching.beside(piece))).collect();
        let pairs = pairs(&samples, &beside);
        if pairs.is_empty() {
            return Vec::new();
        }
        let (moved, orders) = (self.moved(&images), self.of_pieces(orders));
        let crossing = |pairs| {
            let mut crossing = Crossing { pairs, moved: [0.0; 2], ordered: None, smaller: None };
            crossing.moved = [0, 1].map(|side| crossing.mean(side, |piece| moved[piece]));
            crossing.ordered = crossing.greater(|piece| orders[piece]);
            crossing.smaller = crossing.greater(|piece| branching.branch_of[piece]);
            crossing
        };
        let found = connected(&pairs, &beside).into_iter().map(crossing);
        found.filter(|crossing| crossing.area() >= MIN_AREA).collect()
    }

    /// All pairs of pieces that lie beside those of a crossing, on either side.
    pub(crate) fn near_pairs(&self, crossing: &Crossing) -> BTreeSet<[usize; 2]> {
        let pieces: BTreeSet<usize> = crossing.pairs.iter().flat_map(|(pair, _)| *pair).collect();
        let beside: BTreeMap<usize, Vec<usize>> =
            pieces.into_iter().map(|piece| (piece, self.branching.beside(piece))).collect();
        let near = |&([a, b], _): &([usize; 2], u64)| {
            beside[&a].iter().flat_map(|&one| beside[&b].iter().map(move |&other| [one, other])).collect::<Vec<_>>()
        };
        crossing.pairs.iter().flat_map(near).collect()
    }

    /// Joins crossings of several times, each with whether its sides are exchanged, to one over all of them.
    ///
    /// # Panics
    /// If there are none.
    pub(crate) fn joined_crossing(&self, parts: &[(&Crossing, bool)]) -> Crossing {
        let mut pairs: BTreeMap<[usize; 2], u64> = BTreeMap::new();
        let (mut moved, mut area) = ([0.0; 2], 0);
        for &(crossing, is_swapped) in parts {
            let crossing = crossing.clone().oriented(is_swapped);
            crossing.pairs.iter().for_each(|(pair, count)| *pairs.entry(*pair).or_insert(0) += count);
            (0..2).for_each(|side| moved[side] += crossing.area() as f64 * crossing.moved[side]);
            area += crossing.area();
        }
        assert!(area > 0, "a crossing has an area");
        let moved = moved.map(|sum| sum / area as f64);
        let mut joined = Crossing { pairs: pairs.into_iter().collect(), moved, ordered: None, smaller: None };
        joined.smaller = joined.greater(|piece| self.branching.branch_of[piece]);
        joined
    }

    /// A digest of the pieces; lattices with the same one have the same pieces.
    pub(crate) fn digest_of_pieces(&self) -> u64 {
        let Branching { grid, pieces, branch_of, .. } = self.branching.as_ref();
        let mut hasher = DefaultHasher::new();
        let box_bits = [grid.lo, grid.hi].map(|corner| corner.map(f64::to_bits));
        (grid.dims, box_bits, &pieces.of_cuts, branch_of).hash(&mut hasher);
        hasher.finish()
    }

    /// Returns a level for every polygon, in the order of [`Self::pieces`]: of what has one order, the higher level lies in front, and
    /// on one level the smaller branch. `fronts`: crossings, each with the side in front.
    #[must_use]
    pub(crate) fn levels(&self, fronts: &[(&Crossing, usize)], orders: &[i32]) -> Vec<u32> {
        let Branching { pieces, branch_of, .. } = self.branching.as_ref();
        let orders = self.of_pieces(orders);
        let of_crossing = |&(crossing, front): &(&Crossing, usize)| {
            crossing.pairs.iter().map(move |(pair, _)| [pair[front], pair[1 - front]]).collect::<Vec<_>>()
        };
        let pairs: Vec<[usize; 2]> = fronts.iter().flat_map(of_crossing).collect();
        let mut levels: BTreeMap<usize, u32> = pairs.iter().flatten().map(|piece| (*piece, 0)).collect();
        for _ in 0..MAX_LEVEL {
            for &[front, back] in pairs.iter().filter(|[front, back]| orders[*front] == orders[*back]) {
                let above = levels[&back] + u32::from(branch_of[front] <= branch_of[back]);
                levels.entry(front).and_modify(|level| *level = above.min(MAX_LEVEL).max(*level));
            }
        }
        if levels.values().all(|level| *level == 0) {
            return Vec::new();
        }
        let mut rim: Vec<usize> = levels.keys().copied().collect();
        for _ in 0..RIM {
            let mut next: BTreeMap<usize, u32> = BTreeMap::new();
            for &piece in &rim {
                let beside = self.branching.beside(piece).into_iter();
                for other in beside.filter(|other| !levels.contains_key(other)) {
                    let level = next.entry(other).or_insert(MAX_LEVEL);
                    *level = levels[&piece].min(*level);
                }
            }
            rim = next.keys().copied().collect();
            levels.extend(next);
        }
        pieces.of_cuts.iter().map(|piece| levels.get(piece).copied().unwrap_or(0)).collect()
    }

    /// Returns the corners of every polygon after the warp, in the order of [`Self::pieces`].
    fn images(&self) -> Vec<Vec<[f64; 2]>> {
        let lattices: Vec<Lattice<2>> = (0..self.branch_count()).map(|branch| self.lattice(branch)).collect();
        let image = |branch: usize, [x, y]: [f64; 2]| lattices[branch].warp(ScreenPoint::new(x, y)).0.to_array();
        self.pieces().map(|(branch, corners)| corners.iter().map(|&at| image(branch, at)).collect()).collect()
    }

    /// Returns the mean distance that each piece moves, from the corners of its polygons. `images`: corners after the warp.
    fn moved(&self, images: &[Vec<[f64; 2]>]) -> Vec<f64> {
        let Branching { cuts, pieces, .. } = self.branching.as_ref();
        let mut moved = vec![0.0; pieces.list.len()];
        for ((cut, &piece), image) in cuts.iter().zip(&pieces.of_cuts).zip(images) {
            let corners = cut.polygon.corners();
            let sum: f64 = corners.iter().zip(image).map(|(from, to)| distance(from, to)).sum();
            moved[piece] += cut.area / pieces.list[piece].area * sum / corners.len() as f64;
        }
        moved
    }

    /// Returns values of the polygons for the pieces that they are part of.
    fn of_pieces(&self, of_polygons: &[i32]) -> Vec<i32> {
        let pieces = &self.branching.pieces;
        let mut of_pieces = vec![0; pieces.list.len()];
        pieces.of_cuts.iter().zip(of_polygons).for_each(|(&piece, &value)| of_pieces[piece] = value);
        of_pieces
    }
}

impl Branching<2> {
    /// A piece and the connected pieces in the cells around its own.
    fn beside(&self, piece: usize) -> Vec<usize> {
        let cell = |piece: usize| self.grid.cell_coords(self.pieces.list[piece].cell);
        let next = |piece: usize| {
            let adjacent = self.pieces.adjacent_pieces[piece].iter();
            adjacent.filter(|(_, degree)| *degree >= MIN_CONNECTEDNESS).map(|(next, _)| *next)
        };
        let [column, row] = cell(piece);
        let is_around = |&other: &usize| {
            let [x, y] = cell(other);
            x.abs_diff(column) <= 1 && y.abs_diff(row) <= 1
        };
        let second = next(piece).flat_map(next).filter(is_around);
        let all: BTreeSet<usize> = next(piece).chain(second).chain([piece]).collect();
        all.into_iter().collect()
    }

    /// Returns the samples that the images of several pieces cover, each with one of the pieces, ascending.
    fn shared_samples(&self, images: &[Vec<[f64; 2]>]) -> Vec<(usize, usize)> {
        let is_sound = |rest: &[[f64; 2]], moved: &[[f64; 2]]| {
            moved.as_flattened().iter().all(|x| x.is_finite()) && signed_area(rest) * signed_area(moved) > 0.0
        };
        let polygons = || {
            let all = self.cuts.iter().zip(&self.pieces.of_cuts).zip(images);
            let sound = all.filter(|((cut, _), moved)| is_sound(cut.polygon.corners(), moved));
            sound.map(|((_, piece), moved)| (*piece, moved))
        };
        let ranges = [0, 1].map(|axis| range(polygons().flat_map(|(_, corners)| corners).map(|corner| corner[axis])));
        let extent = ranges.map(|[low, high]| (high - low).max(0.0));
        let cell = self.grid.spacing(0).min(self.grid.spacing(1));
        let step = (cell / SAMPLES_PER_CELL).max(extent[0].max(extent[1]) / MAX_SAMPLES);
        // One more than there are, for rounding errors of the last.
        let [width, height] = extent.map(|extent| (extent / step) as usize + 2);
        let mut first_pieces: Vec<Option<u32>> = vec![None; width * height];
        let mut samples = Vec::new();
        for (piece, corners) in polygons() {
            let place = |corner: &[f64; 2]| [0, 1].map(|axis| (corner[axis] - ranges[axis][0]) / step);
            let corners: Vec<[f64; 2]> = corners.iter().map(place).collect();
            for k in 2..corners.len() {
                visit([corners[0], corners[k - 1], corners[k]], |[column, row]| {
                    let sample = row * width + column;
                    let first = *first_pieces[sample].get_or_insert(piece as u32) as usize;
                    if first != piece {
                        samples.extend([(sample, first), (sample, piece)]);
                    }
                });
            }
        }
        samples.sort_unstable();
        samples.dedup();
        samples
    }
}

/// Returns the pairs of pieces that have samples in common and are not beside each other at rest, the smaller piece first, with the
/// number of these samples.
fn pairs(samples: &[(usize, usize)], beside: &BTreeMap<usize, Vec<usize>>) -> BTreeMap<[usize; 2], u64> {
    let mut pairs = BTreeMap::new();
    for here in samples.chunk_by(|a, b| a.0 == b.0) {
        for (index, &(_, one)) in here.iter().enumerate() {
            let apart = here[index + 1..].iter().filter(|(_, other)| !beside[&one].contains(other));
            apart.for_each(|&(_, other)| *pairs.entry([one, other]).or_insert(0) += 1);
        }
    }
    pairs
}

/// Groups pairs whose pieces are beside each other on both sides.
fn connected(pairs: &BTreeMap<[usize; 2], u64>, beside: &BTreeMap<usize, Vec<usize>>) -> Vec<Vec<([usize; 2], u64)>> {
    let sorted = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
    let mut seen: BTreeSet<[usize; 2]> = BTreeSet::new();
    let mut groups = Vec::new();
    for &first in pairs.keys() {
        if !seen.insert(first) {
            continue;
        }
        let mut group = Vec::new();
        let mut waiting = vec![first];
        while let Some(pair) = waiting.pop() {
            group.push((pair, pairs[&sorted(pair)]));
            let nexts =
                beside[&pair[0]].iter().flat_map(|&one| beside[&pair[1]].iter().map(move |&other| [one, other]));
            waiting.extend(nexts.filter(|&next| pairs.contains_key(&sorted(next)) && seen.insert(sorted(next))));
        }
        groups.push(group);
    }
    groups
}

/// Twice the signed area of a polygon.
fn signed_area(corners: &[[f64; 2]]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum()
}

/// The least and the greatest of some values.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

/// Visits the integer places on a triangle of positive coordinates, including its border.
fn visit(corners: [[f64; 2]; 3], mut visit: impl FnMut([usize; 2])) {
    let [bottom, top] = range(corners.iter().map(|corner| corner[1]));
    for row in bottom.ceil() as usize..=top.floor() as usize {
        let y = row as f64;
        let crossings = (0..3).filter_map(|k| {
            let [a, b] = [corners[k], corners[(k + 1) % 3]];
            let is_met = a[1] != b[1] && a[1].min(b[1]) <= y && y <= a[1].max(b[1]);
            is_met.then(|| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
        });
        let [left, right] = range(crossings);
        if left <= right {
            (left.ceil() as usize..=right.floor() as usize).for_each(|column| visit([column, row]));
        }
    }
}
