//! Neighbourhood of a pin along the shape: the nearby parts that are connected with the part which the pin holds.
//!
//! In: a [`Branching`], a pin. Out: the connectedness of each piece with the pin's own, and the rows and gradients of the pin's
//! neighbourhoods.

use super::Branching;
use super::copies::first_handle_of_cell;
use super::row_shares::CopiedRow;
use super::support_box::cell_at;
use crate::lattice::{Grid, Support};
use crate::solve::energy::Neighbourhood;
use crate::solve::least_squares::LeastSquaresRows;
use crate::solve::linalg::small_matrix::distance;
use crate::solve::problem::PointPin;
use crate::solve::stiffness::region_stiffness;
use std::collections::{BTreeMap, BinaryHeap};

/// A pin and the piece of the shape that it holds.
#[derive(Debug)]
pub(super) struct AroundPin<'a, const D: usize> {
    branching: &'a Branching<D>,
    /// The pin, moved to the nearest point of the shape.
    pin: PointPin<D>,
    piece: usize,
    /// Connectedness of each piece with the pin's own over pieces inside the pin's region, 0 to 1, #pieces; empty if the pin has
    /// no region.
    in_region: Vec<f64>,
}

impl<'a, const D: usize> AroundPin<'a, D> {
    /// `at`, `piece`: the point of the shape that the pin holds, and its piece.
    pub(super) fn of(branching: &'a Branching<D>, pin: &PointPin<D>, (at, piece): ([f64; D], usize)) -> Self {
        let pin = pin.moved_to(at);
        let is_within = |radius: f64| {
            move |piece: usize| {
                let nearest = branching.clamped_to_cell(branching.pieces.list[piece].cell, pin.at);
                distance(&nearest, &pin.at) < radius
            }
        };
        let in_region = pin.region.map_or_else(Vec::new, |region| branching.nearness(piece, is_within(region.radius)));
        Self { branching, pin, piece, in_region }
    }

    /// Whether the pin changes the stiffness of its region.
    pub(super) fn has_stiff_region(&self) -> bool {
        self.pin.region.is_some_and(|region| region.stiffness != 1.0)
    }

    /// The factor by which the pin's region changes the stiffness at a point of a piece, to the degree to which the piece is connected
    /// with the pin.
    pub(super) fn stiffness_at(&self, piece: usize, point: [f64; D]) -> f64 {
        1.0 + (region_stiffness(&self.pin, point) - 1.0) * self.in_region[piece]
    }
}

/// The first and last place of a row's handles along each axis.
struct RowExtent<const D: usize>([[usize; 2]; D]);

impl<const D: usize> RowExtent<D> {
    fn of(grid: &Grid<D>, row: &[(usize, f64)]) -> Self {
        let mut extent = [[usize::MAX, 0]; D];
        for place in row.iter().map(|entry| grid.handle_coords(entry.0)) {
            for (own, place) in extent.iter_mut().zip(place) {
                *own = [own[0].min(place), own[1].max(place)];
            }
        }
        Self(extent)
    }

    /// Whether all of these handles act on the cell at a place.
    fn fits(&self, place: &[usize; D], width: usize) -> bool {
        self.0.iter().zip(place).all(|([low, high], &first)| first <= *low && *high < first + width)
    }
}

impl<const D: usize> Neighbourhood<D> for AroundPin<'_, D> {
    fn pin(&self) -> &PointPin<D> {
        &self.pin
    }

    /// Replaces each row by rows over copies that act on a common piece, weighted by connectedness with the pin's own piece, so
    /// that no row couples separate parts.
    fn rows(&self, rows: &LeastSquaresRows<D>) -> LeastSquaresRows<D> {
        let branching = self.branching;
        let mut around = LeastSquaresRows::new();
        let Support::Tensor { width } = branching.grid.basis.support() else { return around };
        let extents: Vec<RowExtent<D>> =
            (0..rows.len()).map(|row| RowExtent::of(&branching.grid, rows.row(row))).collect();
        let place_of = |piece: usize| branching.grid.cell_coords(branching.pieces.list[piece].cell);
        let nearness = branching.nearness(self.piece, |piece| {
            let place = place_of(piece);
            extents.iter().any(|extent| extent.fits(&place, width))
        });
        let mut copied = Vec::new();
        for (number, near) in nearness.into_iter().enumerate().filter(|(_, near)| *near > 0.0) {
            let piece = &branching.pieces.list[number];
            let area = if number == self.piece { piece.area.max(branching.full_area()) } else { piece.area };
            let (place, first) = (place_of(number), first_handle_of_cell(&branching.grid, piece.cell));
            for (row, _) in extents.iter().enumerate().filter(|(_, extent)| extent.fits(&place, width)) {
                let copies = rows.row(row).iter().map(|entry| piece.copies[branching.slot(entry.0 - first)]);
                copied.push(CopiedRow::new(row, copies, [area, near]));
            }
        }
        for (copied, share) in branching.shares(copied, rows.len()) {
            let entries = copied.copies().iter().copied().zip(rows.row(copied.row).iter().map(|entry| entry.1));
            around.push(rows.weight(copied.row) * share * copied.near, entries, rows.target(copied.row));
        }
        around
    }

    /// The mean gradient over the pieces connected with the pin's own, weighted by connectedness and area.
    fn mean_gradient(&self, points: &[([f64; D], f64)]) -> Vec<(usize, [f64; D])> {
        let branching = self.branching;
        let mut mean = BTreeMap::new();
        let mut total = 0.0;
        for (point, weight) in points {
            let in_cell = branching.pieces.in_cell(cell_at(&branching.grid, point));
            let shares: Vec<(usize, f64)> = in_cell.map(|piece| (piece, self.share(piece))).collect();
            let sum: f64 = shares.iter().map(|(_, share)| share).sum();
            for (piece, share) in shares.into_iter().filter(|(_, share)| *share > 0.0) {
                let weight = weight * share / sum.max(1.0);
                total += weight;
                add_gradient(branching, (branching.branch_of(piece), *point), weight, &mut mean);
            }
        }
        if total <= 0.0 {
            total = 1.0;
            add_gradient(branching, (branching.branch_of(self.piece), self.pin.at), 1.0, &mut mean);
        }
        mean.into_iter().map(|(copy, gradient)| (copy, gradient.map(|entry| entry / total))).collect()
    }
}

impl<const D: usize> AroundPin<'_, D> {
    /// Weight of a piece in the mean over the region, 0 to 1.
    fn share(&self, piece: usize) -> f64 {
        if piece == self.piece {
            return 1.0;
        }
        self.in_region[piece] * (self.branching.pieces.list[piece].area / self.branching.full_area()).min(1.0)
    }
}

/// Adds the gradients of the weights at a point of a branch, times a factor.
fn add_gradient<const D: usize>(
    branching: &Branching<D>,
    (branch, point): (usize, [f64; D]),
    factor: f64,
    sums: &mut BTreeMap<usize, [f64; D]>,
) {
    branching.grid.for_each_weight(point, |term| {
        if let Some(copy) = branching.branches[branch][term.handle] {
            let slot = sums.entry(copy).or_insert([0.0; D]);
            (0..D).for_each(|axis| slot[axis] += factor * term.gradient[axis]);
        }
    });
}

impl<const D: usize> Branching<D> {
    /// Connectedness of each piece with the given one, 0 to 1, #pieces: the value of the widest path, whose width is the smallest
    /// [`Self::coupling_degree`] of the copies of handles that act on two consecutive pieces. Paths continue only through pieces for which
    /// `leads_on` is true.
    fn nearness(&self, piece: usize, leads_on: impl Fn(usize) -> bool) -> Vec<f64> {
        let mut nearness = vec![0.0; self.pieces.list.len()];
        // Widest first, so that every piece is reached once. The bits of positive numbers are ordered as they are.
        let mut waiting = BinaryHeap::from([(1.0_f64.to_bits(), piece)]);
        while let Some((near, number)) = waiting.pop() {
            let near = f64::from_bits(near);
            if near <= nearness[number] {
                continue;
            }
            nearness[number] = near;
            if number == piece || leads_on(number) {
                let adjacent = self.pieces.adjacent_pieces[number].iter();
                let adjacent = adjacent.filter(|(next, _)| nearness[*next] < near);
                waiting.extend(adjacent.map(|(next, degree)| (near.min(*degree).to_bits(), *next)));
            }
        }
        nearness
    }

    /// The point of a cell that is nearest to a point.
    fn clamped_to_cell(&self, cell: usize, point: [f64; D]) -> [f64; D] {
        let place = self.grid.cell_coords(cell);
        std::array::from_fn(|axis| {
            let low = self.grid.lo[axis] + place[axis] as f64 * self.grid.spacing(axis);
            point[axis].clamp(low, low + self.grid.spacing(axis))
        })
    }
}
