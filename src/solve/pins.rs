//! Pins and moved handles as least-squares rows, and conflicts among them.
//!
//! In: pins, handles, settings. Out: rows, conflicts.

use super::least_squares::LeastSquaresRows;
use super::linalg::small_matrix::distance;
use super::problem::{HandlePin, ModelPoint, PointPin};
use super::settings::{OutsidePins, Settings};
use crate::lattice::Grid;
use std::collections::BTreeMap;

/// Rows of the pins with λmp = 1 (paper, equation 6). A pin that prescribes a gradient has one additional row per axis.
pub(crate) fn pin_rows<const D: usize>(
    grid: &Grid<D>,
    pins: &[PointPin<D>],
    settings: &Settings,
) -> LeastSquaresRows<D> {
    let mut rows = LeastSquaresRows::new();
    pins.iter().for_each(|pin| push_pin(&mut rows, grid, pin, settings));
    rows
}

/// Appends the rows of one pin.
pub(crate) fn push_pin<const D: usize>(
    rows: &mut LeastSquaresRows<D>,
    grid: &Grid<D>,
    pin: &PointPin<D>,
    settings: &Settings,
) {
    let at = held_point(grid, pin, settings);
    rows.push(pin.weight, grid.weights(at), held_target(grid, pin, settings));
    for (axis, image) in pin.gradient.iter().flatten().enumerate() {
        let mut row = Vec::new();
        // Multiplied by the box diagonal, so that residuals of gradients are lengths, like those of positions.
        grid.for_each_weight(at, |term| row.push((term.handle, term.gradient[axis] * grid.diagonal())));
        rows.push(pin.weight, row, image.map(|x| x * grid.diagonal()));
    }
}

/// Returns the point at which the row of a pin is evaluated.
pub(crate) fn held_point<const D: usize>(grid: &Grid<D>, pin: &PointPin<D>, settings: &Settings) -> [f64; D] {
    match settings.outside_pins {
        OutsidePins::Nearest => grid.clamp_to_box(pin.at),
        OutsidePins::Extended => pin.at,
    }
}

/// Returns the target of a pin's row. For a pin outside the box the nearest point of the box gets the displacement of the pin.
pub(crate) fn held_target<const D: usize>(grid: &Grid<D>, pin: &PointPin<D>, settings: &Settings) -> [f64; D] {
    let held = held_point(grid, pin, settings);
    std::array::from_fn(|d| pin.target[d] + (held[d] - pin.at[d]))
}

/// Updates the targets of [`pin_rows`].
pub(crate) fn retarget<const D: usize>(
    rows: &mut LeastSquaresRows<D>,
    grid: &Grid<D>,
    pins: &[PointPin<D>],
    settings: &Settings,
) {
    let mut row = 0;
    for pin in pins {
        rows.set_target(row, held_target(grid, pin, settings));
        row += 1;
        for image in pin.gradient.iter().flatten() {
            rows.set_target(row, image.map(|x| x * grid.diagonal()));
            row += 1;
        }
    }
}

/// Rows of points of the model at their rest positions, with a total weight of 1.
pub(crate) fn point_rows<const D: usize>(grid: &Grid<D>, points: &[ModelPoint<D>]) -> LeastSquaresRows<D> {
    let mut rows = LeastSquaresRows::new();
    let weight = 1.0 / points.len().max(1) as f64;
    points.iter().for_each(|point| push_point(&mut rows, grid, point.at, weight));
    rows
}

/// Appends the row of a point, whose target is its rest position.
pub(crate) fn push_point<const D: usize>(rows: &mut LeastSquaresRows<D>, grid: &Grid<D>, point: [f64; D], weight: f64) {
    let point = grid.clamp_to_box(point);
    rows.push(weight, grid.weights(point), point);
}

/// Rows of the moved handles with λgp = 1 (paper, equation 7).
pub(crate) fn handle_rows<const D: usize>(handles: &[HandlePin<D>]) -> LeastSquaresRows<D> {
    let mut rows = LeastSquaresRows::new();
    for handle in handles {
        rows.push(1.0, [(handle.index, 1.0)], handle.target);
    }
    rows
}

/// Returns the pairs of pins at the same point with different targets, sorted by the later pin. Pins are sorted along the first
/// axis and compared only with near ones, so the cost is low for many pins.
pub(crate) fn conflicts<const D: usize>(grid: &Grid<D>, pins: &[PointPin<D>]) -> Vec<[usize; 2]> {
    let mut order: Vec<usize> = (0..pins.len()).collect();
    order.sort_by(|&a, &b| pins[a].at[0].total_cmp(&pins[b].at[0]));
    let mut pairs = Vec::new();
    for (position, &first) in order.iter().enumerate() {
        let a = &pins[first];
        let within = |later: &&usize| pins[**later].at[0] - a.at[0] <= NEAR * grid.diagonal();
        for &later in order[position + 1..].iter().take_while(within) {
            let b = &pins[later];
            if is_near(grid, &a.at, &b.at) && !is_near(grid, &a.target, &b.target) {
                pairs.push([first.min(later), first.max(later)]);
            }
        }
    }
    pairs.sort_unstable_by_key(|&[first, later]| [later, first]);
    pairs
}

/// Distance, in box diagonals, up to which two points count as the same.
const NEAR: f64 = 1e-9;

fn is_near<const D: usize>(grid: &Grid<D>, a: &[f64; D], b: &[f64; D]) -> bool {
    distance(a, b) <= NEAR * grid.diagonal()
}

/// Describes the handles that have several different targets, in words.
pub(crate) fn handle_conflicts<const D: usize>(grid: &Grid<D>, handles: &[HandlePin<D>]) -> Vec<String> {
    let mut warnings = Vec::new();
    let mut entries: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (later, b) in handles.iter().enumerate() {
        let same = entries.entry(b.index).or_default();
        for &first in same.iter().filter(|&&first| !is_near(grid, &handles[first].target, &b.target)) {
            warnings.push(format!(
                "handle {} is moved twice, to different targets (entries {first} and {later}); it is placed between them \
                 (least squares); remove one of them",
                b.index
            ));
        }
        same.push(later);
    }
    warnings
}
