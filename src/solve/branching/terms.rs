//! Terms of a solve over copies: the terms of a plain lattice, branch by branch, with copies in place of handles.
//!
//! In: a [`Branching`], pins, settings. Out: the distortion, and the rows of pins and regulariser.

use super::around_pin::AroundPin;
use super::copies::Tie;
use super::{Branching, handles_of_cell};
use crate::lattice::Support;
use crate::solve::barrier::{Barrier, BarrierPart};
use crate::solve::cancel::Cancel;
use crate::solve::energy::{Area, Distortion, WithPinNeighbourhoods};
use crate::solve::least_squares::LeastSquaresRows;
use crate::solve::pins;
use crate::solve::problem::{ModelPoint, PointPin, Shape};
use crate::solve::samples::samples_of_pieces;
use crate::solve::second_differences::SecondDifferences;
use crate::solve::settings::{Scaling, Settings};
use std::collections::{BTreeMap, BTreeSet};

/// Stiffness of a tie between copies whose support has to grow by half a span, relative to that of the shape.
const TIE: f64 = 1e-4;

/// Largest stiffness of a tie, as a multiple of [`TIE`].
const MAX_TIE_FACTOR: f64 = 1e8;

/// Exponent of the weights by which a copy with a negligible area continuously chooses one of its siblings (other copies of its
/// handle).
const CHOICE_EXPONENT: i32 = 16;

/// Area of a part of the shape, as a fraction of a cell (in space, of a side of a cube as large), from which on its rows have full weight.
const FULL_FRACTION: f64 = 0.02;

impl<const D: usize> Branching<D> {
    /// The energy `area` over all branches, with the discs of pins and the ties between copies.
    pub(crate) fn distortion(
        &self,
        shape: &Shape<D>,
        pins: &[PointPin<D>],
        settings: &Settings,
        cancel: &Cancel,
    ) -> Box<dyn Distortion<D>> {
        let around: Vec<AroundPin<D>> = pins.iter().map(|pin| AroundPin::of(self, pin)).collect();
        let area = |branch: usize| {
            let mut parts = Shape::default();
            let in_branch = self.pieces.of_cuts.iter().map(|&piece| self.branch_of[piece] == branch);
            for (cut, _) in self.cuts.iter().zip(in_branch).filter(|(_, is_in)| *is_in) {
                let base = parts.points.len() as u32;
                let corners = cut.polygon.corners();
                parts.points.extend(corners);
                for k in 2..corners.len() as u32 {
                    parts.triangles.push([base, base + k - 1, base + k]);
                    parts.stiffness.push(shape.stiffness_of(cut.triangle));
                }
            }
            let mut samples = samples_of_pieces(&self.grid, &parts);
            // Rounding can move a sliver across the border of its cell.
            samples.retain(|sample| self.acts_at(branch, sample.at));
            for pin in &around {
                samples.iter_mut().for_each(|sample| sample.stiffness *= pin.stiffness_at(branch, sample.at));
            }
            Area::new(&self.grid, &samples, cancel).relabelled(|handle| self.copy(branch, handle))
        };
        let shape = Box::new(Area::joined((0..self.branches.len()).map(area)));
        WithPinNeighbourhoods::over(shape, &self.grid, settings, (&around, self.tie_rows()))
    }

    /// The barrier over the pieces of all branches.
    pub(crate) fn barrier(&self, cancel: &Cancel) -> Barrier<D> {
        let of = |branch: usize| {
            let own = self.pieces.list.iter().zip(&self.branch_of).filter(|(_, of)| **of == branch);
            let cells: BTreeSet<usize> = own.map(|(piece, _)| piece.cell).collect();
            BarrierPart { cells: cells.into_iter().collect(), unknowns: Some(self.branches[branch].clone()) }
        };
        Barrier::new(&self.grid, (0..self.branches.len()).map(of).collect(), cancel)
    }

    /// Rows of the pins over copies.
    pub(crate) fn pin_rows(&self, pins: &[PointPin<D>], settings: &Settings) -> LeastSquaresRows<D> {
        let mut all = LeastSquaresRows::new();
        for (pin, piece) in pins.iter().map(|pin| self.snapped_pin(pin)) {
            let mut rows = LeastSquaresRows::new();
            pins::push_pin(&mut rows, &self.grid, &pin, settings);
            all.extend(&self.clipped(self.branch_of(piece), &rows));
        }
        all
    }

    /// Rows of the model's points over copies, with a total weight of 1.
    pub(crate) fn point_rows(&self, points: &[ModelPoint<D>]) -> LeastSquaresRows<D> {
        let mut rows = LeastSquaresRows::new();
        let weight = 1.0 / points.len().max(1) as f64;
        for point in points {
            let (at, piece) = self.snapped_point(point.at, point.triangle);
            let mut row = LeastSquaresRows::new();
            pins::push_point(&mut row, &self.grid, at, weight);
            rows.extend(&self.clipped(self.branch_of(piece), &row));
        }
        rows
    }

    /// The regulariser `bend`: each second difference of copies that act on a common piece, once.
    pub(crate) fn bend(&self, scaling: Scaling) -> LeastSquaresRows<D> {
        let Support::Tensor { width } = self.grid.basis.support() else { return LeastSquaresRows::new() };
        let mut rows = LeastSquaresRows::new();
        for kind in SecondDifferences::of(&self.grid) {
            let mut areas: BTreeMap<Vec<usize>, f64> = BTreeMap::new();
            for piece in &self.pieces.list {
                let handles = handles_of_cell(&self.grid, width, piece.cell);
                for &start in &handles {
                    let places = kind.entries(start).map(|(handle, _)| handles.binary_search(&handle).ok());
                    if let Some(places) = places.collect::<Option<Vec<usize>>>() {
                        let copies = places.into_iter().map(|place| piece.copies[place]).collect();
                        *areas.entry(copies).or_insert(0.0) += piece.area;
                    }
                }
            }
            let weight = kind.weight(&self.grid, scaling);
            let coefficients: Vec<f64> = kind.entries(0).map(|(_, coefficient)| coefficient).collect();
            for (copies, share) in self.shares(areas) {
                rows.push(weight * share, copies.into_iter().zip(coefficients.iter().copied()), [0.0; D]);
            }
        }
        rows
    }

    /// Ties: rows for the difference of two copies. The stiffness is 0 if their support has to grow by a whole span to connect
    /// them, and unbounded but for [`MAX_TIE_FACTOR`] as the growth approaches 0. Copies that are closer to each other than to a
    /// third have one tie to it in total, shared in proportion to their areas. A copy with a negligible area is tied to one
    /// sibling only, so that it does not couple others.
    fn tie_rows(&self) -> LeastSquaresRows<D> {
        let mut area = vec![0.0; self.handles.len()];
        for piece in &self.pieces.list {
            piece.copies.iter().for_each(|&copy| area[copy] += piece.area);
        }
        let mut siblings = vec![Vec::new(); self.handles.len()];
        for tie in &self.ties {
            let [one, other] = tie.copies;
            siblings[one].push((other, tie.growth));
            siblings[other].push((one, tie.growth));
        }
        let weight = |growth: f64| (TIE * ((1.0 - growth) / growth).powi(2)).min(TIE * MAX_TIE_FACTOR);
        let among_near = |copy: usize, growth: f64| {
            let nearer = siblings[copy].iter().filter(|(_, own)| *own < growth);
            let others: f64 = nearer.map(|(sibling, own)| area[*sibling] * (1.0 - own / growth)).sum();
            if others > 0.0 { area[copy] / (area[copy] + others) } else { 1.0 }
        };
        // Strength of a copy's tie to a sibling when it chooses one: the nearest and largest sibling has the greatest.
        let pull = |copy: usize, sibling: usize, growth: f64| weight(growth) * area[sibling] * among_near(copy, growth);
        let sums = (0..self.handles.len()).map(|copy| {
            let pulls = || siblings[copy].iter().map(|&(sibling, growth)| pull(copy, sibling, growth));
            let greatest = pulls().fold(f64::MIN_POSITIVE, f64::max);
            (greatest, pulls().map(|pull| (pull / greatest).powi(CHOICE_EXPONENT)).sum::<f64>())
        });
        let sums: Vec<(f64, f64)> = sums.collect();
        let choice = |copy: usize, sibling: usize, growth: f64| {
            let (greatest, sum) = sums[copy];
            if sum > 0.0 { (pull(copy, sibling, growth) / greatest).powi(CHOICE_EXPONENT) / sum } else { 1.0 }
        };
        let needs = |copy: usize| (area[copy] / self.full_area()).min(1.0);
        let mut rows = LeastSquaresRows::new();
        for Tie { copies: [one, other], growth } in self.ties.iter().copied() {
            let alone = [(one, other), (other, one)].map(|(copy, to)| (1.0 - needs(copy)) * choice(copy, to, growth));
            let share = (needs(one) * needs(other) + alone[0] + alone[1]).min(1.0);
            let weight = weight(growth) * share * among_near(one, growth) * among_near(other, growth);
            rows.push(weight, [(one, 1.0), (other, -1.0)], [0.0; D]);
        }
        rows
    }

    /// Whether a branch has copies of all handles with a non-zero weight at a point.
    fn acts_at(&self, branch: usize, point: [f64; D]) -> bool {
        let mut acts = true;
        self.grid.for_each_weight(point, |term| acts &= self.branches[branch][term.handle].is_some());
        acts
    }

    /// The area from which on a part of the shape has full weight.
    pub(super) fn full_area(&self) -> f64 {
        let size: f64 = (0..D).map(|axis| self.grid.spacing(axis)).product();
        FULL_FRACTION * size.powf(2.0 / D as f64)
    }

    /// The copy of a handle in a branch.
    ///
    /// # Panics
    /// If the branch has no copy of it.
    fn copy(&self, branch: usize, handle: usize) -> usize {
        self.branches[branch][handle].expect("a branch has copies of all handles over its pieces")
    }

    /// Converts rows over handles to rows over copies. A handle without a copy has a weight within rounding error of 0.
    pub(super) fn clipped(&self, branch: usize, rows: &LeastSquaresRows<D>) -> LeastSquaresRows<D> {
        rows.mapped(|handle| self.branches[branch][handle])
    }
}
