//! Second differences of handles: over the whole grid (regulariser `bend`) or around a pin (its disc).
//!
//! In: a grid. Out: least-squares rows. A row has three handles in a line or four in a square, so it does not widen the
//! band of a matrix.

use super::least_squares::LeastSquaresRows;
use super::linalg::small_matrix::{dot, minus};
use super::settings::Scaling;
use crate::lattice::Grid;

/// Σ |Δaa|² + 2 Σ |Δab|²: second differences along axes, mixed ones for every pair of axes.
///
/// Dimensionless: s²·(mean |Δaa|²/ha⁴ + 2 mean |Δab|²/(ha²hb²)), s the box diagonal, ha the handle distance,
/// which tends to s² times the mean squared second derivative whatever the dims.
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

/// Second differences around a point: Σ ω (Σ_a |Δaa|²/ha⁴ + 2 Σ_ab |Δab|²/(ha²hb²)) / Σ ω with ω fading to the rim, the mean
/// squared second derivative there. A rim nearer than a handle and a half is moved out, so that there is always something
/// inside and nothing jumps as the point moves. Points outside the box count as the nearest box point.
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

/// Falls from 1 at a pin to 0 at the rim of its neighbourhood, C1: (1 − t²)², t the distance in radii.
pub(crate) fn fade(t: f64) -> f64 {
    (1.0 - t * t).max(0.0).powi(2)
}

/// All second differences of one kind: Δaa along an axis, or Δab mixed.
pub(crate) struct SecondDifferences<const D: usize> {
    /// 1 along an axis, 2 for a mixed one, which also represents Δba.
    share: f64,
    /// ha·hb: a difference divided by it is a second derivative.
    cell: f64,
    stencil: Vec<(usize, f64)>,
    /// First handle of each difference, and the centre of its handles at rest.
    starts: Vec<(usize, [f64; D])>,
}

impl<const D: usize> SecondDifferences<D> {
    /// All kinds that a grid has.
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

    /// Weight of one difference among all of the grid.
    pub(crate) fn weight(&self, grid: &Grid<D>, scaling: Scaling) -> f64 {
        let mean = self.share * grid.diagonal().powi(2) / self.starts.len().max(1) as f64;
        match scaling {
            Scaling::Plain => self.share,
            Scaling::Dimensionless => mean / self.cell.powi(2),
        }
    }

    /// Handles and coefficients of the difference that begins at a handle.
    pub(crate) fn entries(&self, start: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.stencil.iter().map(move |&(step, c)| (start + step, c))
    }
}

/// Index steps and coefficients of one second difference.
fn stencil<const D: usize>(grid: &Grid<D>, a: usize, b: usize) -> Vec<(usize, f64)> {
    let (along, across) = (grid.stride(a), grid.stride(b));
    if a == b {
        vec![(0, 1.0), (along, -2.0), (2 * along, 1.0)]
    } else {
        vec![(0, 1.0), (along, -1.0), (across, -1.0), (along + across, 1.0)]
    }
}
