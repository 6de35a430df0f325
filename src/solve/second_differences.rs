//! Second differences of handles: over the whole grid (regulariser `bend`) or around a pin (its disc).
//!
//! In: a grid. Out: least-squares rows. A stencil has three handles in a line or four in a square, so it does not widen the band
//! of a matrix.

use super::least_squares::LeastSquaresRows;
use super::linalg::small_matrix::{dot, minus};
use super::settings::Scaling;
use crate::lattice::Grid;

/// Regulariser `bend`: Σ |Δaa|² + 2 Σ |Δab|², the second differences along each axis and the mixed ones of each pair of axes.
///
/// If dimensionless, it is s²·(mean |Δaa|²/ha⁴ + 2 mean |Δab|²/(ha²hb²)), with s the box diagonal and ha the handle spacing,
/// which tends to s² times the mean squared second derivative for any number of handles.
pub(crate) fn bend<const D: usize>(grid: &Grid<D>, scaling: Scaling) -> LeastSquaresRows<D> {
    let mut rows = LeastSquaresRows::new();
    for kind in SecondDifferences::of(grid) {
        let weight = kind.weight(grid, scaling);
        for &(start, _) in &kind.starts {
            rows.push(weight, kind.entries(start), [0.0; D]);
        }
    }
    rows
}

/// Second differences around a point: Σ ω (Σ_a |Δaa|²/ha⁴ + 2 Σ_ab |Δab|²/(ha²hb²)) / Σ ω, the mean squared second derivative
/// with weights ω that fade to the rim. The radius of the rim is at least one and a half handle spacings, so that it always
/// contains a stencil and nothing jumps as the point moves. A point outside the box counts as the nearest point of the box.
pub(crate) fn bend_around<const D: usize>(
    kinds: &[SecondDifferences<D>],
    grid: &Grid<D>,
    (at, radius): ([f64; D], f64),
) -> LeastSquaresRows<D> {
    let pitch = (0..D).map(|axis| grid.spacing(axis)).fold(0.0, f64::max);
    let (at, rim) = (grid.clamp_to_box(at), radius.max(1.5 * pitch));
    let mut rows = LeastSquaresRows::new();
    let mut near: Vec<(usize, f64)> = Vec::new();
    for kind in kinds {
        near.clear();
        near.extend(kind.starts.iter().filter_map(|(start, middle)| {
            let gap = minus(middle, &at);
            let share = fade((dot(&gap, &gap) / (rim * rim)).sqrt());
            (share > 0.0).then_some((*start, share))
        }));
        let total: f64 = near.iter().map(|entry| entry.1).sum();
        for &(start, share) in &near {
            rows.push(kind.share * share / total / kind.cell.powi(2), kind.entries(start), [0.0; D]);
        }
    }
    rows
}

/// Weight that falls from 1 at a pin to 0 at the rim of its neighbourhood and is C1: (1 − t²)², with t the distance in radii.
pub(crate) fn fade(t: f64) -> f64 {
    (1.0 - t * t).max(0.0).powi(2)
}

/// All second differences of one kind: Δaa along an axis, or the mixed Δab.
pub(crate) struct SecondDifferences<const D: usize> {
    /// 1 along an axis, 2 for a mixed difference, which also represents Δba.
    share: f64,
    /// ha·hb, by which a difference is divided to give a second derivative.
    cell: f64,
    stencil: Vec<(usize, f64)>,
    /// First handle of each difference, and the centre of its stencil at rest.
    starts: Vec<(usize, [f64; D])>,
}

impl<const D: usize> SecondDifferences<D> {
    /// Returns all kinds of a grid.
    pub(crate) fn of(grid: &Grid<D>) -> Vec<Self> {
        let places: Vec<[usize; D]> = (0..grid.handle_count()).map(|index| grid.handle_coords(index)).collect();
        let pairs = (0..D).flat_map(|a| (a..D).map(move |b| [a, b]));
        let kinds = pairs.map(|[a, b]| {
            let extent: [usize; D] = std::array::from_fn(|axis| usize::from(axis == a) + usize::from(axis == b));
            let rest = grid.rest_handle(0);
            let middle = |place: &[usize; D]| {
                std::array::from_fn(|axis| {
                    rest[axis] + (place[axis] as f64 + 0.5 * extent[axis] as f64) * grid.spacing(axis)
                })
            };
            let fits = |place: &[usize; D]| (0..D).all(|axis| place[axis] + extent[axis] < grid.dims[axis]);
            let starts = places.iter().enumerate().filter(|(_, place)| fits(place));
            Self {
                share: if a == b { 1.0 } else { 2.0 },
                cell: grid.spacing(a) * grid.spacing(b),
                stencil: stencil(grid, a, b),
                starts: starts.map(|(start, place)| (start, middle(place))).collect(),
            }
        });
        kinds.collect()
    }

    /// Whether the grid has such a difference.
    pub(crate) fn has_any(&self) -> bool {
        !self.starts.is_empty()
    }

    /// Weight of one of the differences of this kind over the whole grid.
    pub(crate) fn weight(&self, grid: &Grid<D>, scaling: Scaling) -> f64 {
        let mean = self.share * grid.diagonal().powi(2) / self.starts.len().max(1) as f64;
        match scaling {
            Scaling::Plain => self.share,
            Scaling::Dimensionless => mean / self.cell.powi(2),
        }
    }

    /// Handles and coefficients of the difference that starts at a handle.
    pub(crate) fn entries(&self, start: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.stencil.iter().map(move |&(step, c)| (start + step, c))
    }
}

/// Offsets of handle indices, with the coefficients, of one second difference.
fn stencil<const D: usize>(grid: &Grid<D>, a: usize, b: usize) -> Vec<(usize, f64)> {
    let (along, across) = (grid.stride(a), grid.stride(b));
    if a == b {
        vec![(0, 1.0), (along, -2.0), (2 * along, 1.0)]
    } else {
        vec![(0, 1.0), (along, -1.0), (across, -1.0), (along + across, 1.0)]
    }
}
