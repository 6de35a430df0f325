//! The terms of a solve over copies: each is that of a plain lattice, branch by branch, with copies in place of handles.
//!
//! In: a [`Branching`], pins, settings. Out: distortion, rows of pins and regulariser.

use super::{Branching, handles_of_cell};
use crate::lattice::Support;
use crate::solve::barrier::{Barrier, BarrierPart};
use crate::solve::cancel::Cancel;
use crate::solve::energy::{Area, Distortion, WithPinNeighbourhoods};
use crate::solve::least_squares::LeastSquaresRows;
use crate::solve::pins;
use crate::solve::problem::{PointPin, Shape};
use crate::solve::samples::samples_of_pieces;
use crate::solve::second_differences::SecondDifferences;
use crate::solve::settings::{Scaling, Settings};
use crate::solve::stiffness::region_stiffness_at;
use std::collections::{BTreeMap, BTreeSet};

/// Stiffness of a tie at which the support has to grow by half a span, relative to that of the shape.
const TIE: f64 = 1e-4;

/// Ties are never stiffer than this multiple of that.
const STIFFEST: f64 = 1e6;

/// Second differences of a piece have their full weight from this share of its cell on, and at least [`LEAST_BEND`].
const FULL_PIECE: f64 = 0.02;

/// What remains of the weight of second differences over nearly empty pieces, so that their copies are determined.
const LEAST_BEND: f64 = 1e-2;

impl<const D: usize> Branching<D> {
    /// `area` over all branches, with the discs of pins and the ties of copies.
    pub(crate) fn distortion(
        &self,
        shape: &Shape<D>,
        pins: &[PointPin<D>],
        settings: &Settings,
        cancel: &Cancel,
    ) -> Box<dyn Distortion<D>> {
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
            samples.iter_mut().for_each(|sample| sample.stiffness *= region_stiffness_at(pins, sample.at));
            let mut area = Area::new(&self.grid, &samples, cancel);
            area.relabel(|handle| self.copy(branch, handle));
            area
        };
        let shape = Box::new(Area::joined((0..self.branches.len()).map(area)));
        let held: Vec<(PointPin<D>, usize)> = pins.iter().map(|pin| self.held(pin)).collect();
        let points: Vec<PointPin<D>> = held.iter().map(|(pin, _)| *pin).collect();
        let relabel = |pin: usize, rows: &LeastSquaresRows<D>| self.rows_around(held[pin].1, rows);
        WithPinNeighbourhoods::with_rows(shape, &self.grid, &points, settings, (&relabel, self.tie_rows()))
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
        for (pin, piece) in pins.iter().map(|pin| self.held(pin)) {
            let mut rows = LeastSquaresRows::new();
            pins::push_pin(&mut rows, &self.grid, &pin, settings);
            all.extend(&self.clipped(self.branch_of(piece), &rows));
        }
        all
    }

    /// The regulariser `bend`: every second difference of copies that act on a common piece, once.
    pub(crate) fn bend(&self, scaling: Scaling) -> LeastSquaresRows<D> {
        let Support::Tensor { width } = self.grid.basis.support() else { return LeastSquaresRows::new() };
        let cell = (0..D).map(|axis| self.grid.spacing(axis)).product::<f64>();
        let mut rows = LeastSquaresRows::new();
        for kind in SecondDifferences::of(&self.grid) {
            let mut known: BTreeMap<Vec<usize>, f64> = BTreeMap::new();
            for piece in &self.pieces.list {
                let handles = handles_of_cell(&self.grid, width, piece.cell);
                let fill = (piece.area / (FULL_PIECE * cell)).clamp(LEAST_BEND, 1.0);
                for &start in &handles {
                    let places = kind.entries(start).map(|(handle, _)| handles.binary_search(&handle).ok());
                    if let Some(places) = places.collect::<Option<Vec<usize>>>() {
                        let copies = places.into_iter().map(|place| piece.copies[place]).collect();
                        let share = known.entry(copies).or_insert(0.0);
                        *share = share.max(fill);
                    }
                }
            }
            let weight = kind.weight(&self.grid, scaling);
            let coefficients: Vec<f64> = kind.entries(0).map(|(_, coefficient)| coefficient).collect();
            for (copies, share) in known {
                rows.push(weight * share, copies.into_iter().zip(coefficients.iter().copied()), [0.0; D]);
            }
        }
        rows
    }

    /// Differences of tied copies, free where the support has to grow by a whole span, equal where it does not have to.
    fn tie_rows(&self) -> LeastSquaresRows<D> {
        let mut rows = LeastSquaresRows::new();
        for tie in &self.ties {
            let [one, other] = tie.copies;
            let weight = (TIE * ((1.0 - tie.growth) / tie.growth).powi(2)).min(TIE * STIFFEST);
            rows.push(weight, [(one, 1.0), (other, -1.0)], [0.0; D]);
        }
        rows
    }

    /// The copy of a handle in a branch.
    ///
    /// # Panics
    /// Where the branch has none.
    fn copy(&self, branch: usize, handle: usize) -> usize {
        self.branches[branch][handle].expect("a branch has copies of all handles over its pieces")
    }

    /// Rows over handles around a point of a piece as rows over copies: of each, those that act on a common piece from which the
    /// way to this one leads over pieces with such rows, so that no row joins what is apart.
    fn rows_around(&self, piece: usize, rows: &LeastSquaresRows<D>) -> LeastSquaresRows<D> {
        let Support::Tensor { width } = self.grid.basis.support() else { return LeastSquaresRows::new() };
        let (mut around, mut known) = (LeastSquaresRows::new(), BTreeSet::new());
        let (mut waiting, mut is_seen) = (vec![piece], BTreeSet::from([piece]));
        while let Some(number) = waiting.pop() {
            let piece = &self.pieces.list[number];
            let handles = handles_of_cell(&self.grid, width, piece.cell);
            let copy_of = |handle: usize| Some(piece.copies[handles.binary_search(&handle).ok()?]);
            let here = rows.mapped(copy_of, true);
            if here.len() > 0 {
                waiting.extend(self.pieces.neighbours[number].iter().filter(|&&next| is_seen.insert(next)));
            }
            around.extend_where(&here, |row| known.insert(row.iter().map(|entry| entry.0).collect::<Vec<usize>>()));
        }
        around
    }

    /// Rows over copies instead of handles; handles without a copy have no weight but that of rounding.
    fn clipped(&self, branch: usize, rows: &LeastSquaresRows<D>) -> LeastSquaresRows<D> {
        rows.mapped(|handle| self.branches[branch][handle], false)
    }
}
