//! Terms of a solve over copies: the terms of a plain lattice, branch by branch, with copies in place of handles.
//!
//! In: a [`Branching`], pins, settings. Out: the distortion, and the rows of pins and regulariser.

use super::Branching;
use super::around_pin::AroundPin;
use super::copies::{Tie, first_handle_of_cell, handles_of_cell};
use super::row_shares::CopiedRow;
use crate::lattice::Support;
use crate::solve::barrier::{Barrier, BarrierPart};
use crate::solve::cancel::Cancel;
use crate::solve::counting_sort::counting_sort;
use crate::solve::energy::{Area, Distortion, WithPinNeighbourhoods};
use crate::solve::least_squares::LeastSquaresRows;
use crate::solve::pins;
use crate::solve::problem::{ModelPoint, PointPin, Shape};
use crate::solve::samples::samples_of_cell;
use crate::solve::second_differences::SecondDifferences;
use crate::solve::settings::{Scaling, Settings};
use std::collections::BTreeSet;

/// Stiffness of a tie between copies whose support has to grow by half a span, relative to that of the shape.
const TIE: f64 = 1e-4;

/// Largest stiffness of a tie, as a multiple of [`TIE`].
const MAX_TIE_FACTOR: f64 = 1e8;

/// Exponent of the weights by which a copy with a negligible area continuously chooses one of its siblings (other copies of its
/// handle).
const CHOICE_EXPONENT: i32 = 16;

/// Area of a part of the shape, as a fraction of a cell (in space, of a side of a cube as large), from which on its rows have full weight.
const FULL_FRACTION: f64 = 0.02;

/// Parts of sub-cells with a smaller area, as a fraction of that of the shape, are rounding errors.
const MIN_SAMPLE_AREA: f64 = 1e-12;

/// Pins, and what they hold.
#[derive(Clone, Copy)]
pub(crate) struct HeldPins<'a, const D: usize> {
    pub(crate) pins: &'a [PointPin<D>],
    /// The point of the shape that each pin holds, and its piece.
    pub(crate) snapped: &'a [([f64; D], usize)],
}

impl<const D: usize> Branching<D> {
    /// The energy `area` over all pieces, with the discs of pins and the ties between copies.
    pub(crate) fn distortion(
        &self,
        shape: &Shape<D>,
        HeldPins { pins, snapped }: HeldPins<D>,
        settings: &Settings,
        cancel: &Cancel,
    ) -> Box<dyn Distortion<D>> {
        let around: Vec<AroundPin<D>> =
            pins.iter().zip(snapped).map(|(pin, &snapped)| AroundPin::of(self, pin, snapped)).collect();
        let stiff: Vec<&AroundPin<D>> = around.iter().filter(|pin| pin.has_stiff_region()).collect();
        let mut cuts: Vec<u32> = (0..self.cuts.len() as u32).collect();
        let piece_of = |cut: &u32| self.pieces.of_cuts[*cut as usize];
        let ends = counting_sort(&mut cuts, self.pieces.list.len(), piece_of);
        let least = MIN_SAMPLE_AREA * self.pieces.list.iter().map(|piece| piece.area).sum::<f64>();
        let (mut samples, mut groups) = (Vec::new(), Vec::with_capacity(ends.len()));
        for (number, piece) in self.pieces.list.iter().enumerate() {
            let own = &cuts[if number == 0 { 0 } else { ends[number - 1] }..ends[number]];
            let polygons = own.iter().map(|&cut| &self.cuts[cut as usize]);
            let polygons = polygons.map(|cut| (&cut.polygon, shape.stiffness_of(cut.triangle)));
            let first = samples.len();
            samples.extend(samples_of_cell(&self.grid, piece.cell, polygons, least));
            for sample in &mut samples[first..] {
                stiff.iter().for_each(|pin| sample.stiffness *= pin.stiffness_at(number, sample.at));
            }
            if samples.len() > first {
                groups.push((first..samples.len(), &piece.copies[..]));
            }
        }
        let area = Box::new(Area::over_groups(&self.grid, &samples, &groups, cancel));
        WithPinNeighbourhoods::over(area, &self.grid, settings, (&around, self.tie_rows()))
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
    pub(crate) fn pin_rows(&self, HeldPins { pins, snapped }: HeldPins<D>, settings: &Settings) -> LeastSquaresRows<D> {
        let mut all = LeastSquaresRows::new();
        for (pin, &(at, piece)) in pins.iter().zip(snapped) {
            let mut rows = LeastSquaresRows::new();
            pins::push_pin(&mut rows, &self.grid, &pin.moved_to(at), settings);
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
        let offsets = handles_of_cell(&self.grid, width, 0);
        for kind in SecondDifferences::of(&self.grid).into_iter().filter(SecondDifferences::has_any) {
            // The positions in a cell of the handles of each difference that fits into it.
            let slots: Vec<Vec<usize>> = offsets
                .iter()
                .map(|&start| kind.entries(start).map(|(handle, _)| offsets.binary_search(&handle).ok()).collect())
                .collect::<Vec<Option<Vec<usize>>>>()
                .into_iter()
                .flatten()
                .collect();
            let mut copied = Vec::with_capacity(self.pieces.list.len() * slots.len());
            for piece in &self.pieces.list {
                let first = first_handle_of_cell(&self.grid, piece.cell);
                copied.extend(slots.iter().map(|slots| {
                    let copies = slots.iter().map(|&slot| piece.copies[slot]);
                    CopiedRow::new(first + offsets[slots[0]], copies, [piece.area, 1.0])
                }));
            }
            let weight = kind.weight(&self.grid, scaling);
            let coefficients: Vec<f64> = kind.entries(0).map(|(_, coefficient)| coefficient).collect();
            for (copied, share) in self.shares(copied, self.grid.handle_count()) {
                let entries = copied.copies().iter().copied().zip(coefficients.iter().copied());
                rows.push(weight * share, entries, [0.0; D]);
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

    /// The area from which on a part of the shape has full weight.
    pub(super) fn full_area(&self) -> f64 {
        let size: f64 = (0..D).map(|axis| self.grid.spacing(axis)).product();
        FULL_FRACTION * size.powf(2.0 / D as f64)
    }

    /// Converts rows over handles to rows over copies. A handle without a copy has a weight within rounding error of 0.
    pub(super) fn clipped(&self, branch: usize, rows: &LeastSquaresRows<D>) -> LeastSquaresRows<D> {
        rows.mapped(|handle| self.branches[branch][handle])
    }
}
