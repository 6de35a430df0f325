//! Regularisers, which determine the handles that neither pins nor the shape constrain.
//!
//! In: the grid, and which handles are moved explicitly. Out: least-squares rows, and for `affine` a projector.

use super::cancel::Cancel;
use super::least_squares::LeastSquaresRows;
use super::linalg::normal_matrix::NormalMatrix;
use super::second_differences::bend;
use super::settings::{Regularizer, Scaling};
use crate::lattice::Grid;

/// A regulariser with λgr = 1: least-squares rows, or the distance from the affine images of the rest handles.
#[derive(Clone, Debug)]
pub(crate) enum RegularizerTerm<const D: usize> {
    /// Least-squares rows.
    Rows(LeastSquaresRows<D>),
    /// Distance from the affine images of the rest handles.
    Affine(Affine),
}

/// weight · Σ ‖((I − Π)P')_i‖² over free handles, where Π = QQᵀ projects onto span{1, P⁰}, the affine images of the rest handles.
#[derive(Clone, Debug)]
pub(crate) struct Affine {
    weight: f64,
    /// Handles that are not moved explicitly.
    free: Vec<usize>,
    /// Orthonormal columns of Q: up to D + 1, #handles each, zero at handles that are moved explicitly.
    columns: Vec<Vec<f64>>,
}

impl<const D: usize> RegularizerTerm<D> {
    /// Builds the regulariser of a grid; `moved` marks handles that are moved explicitly.
    pub(crate) fn new(kind: Regularizer, grid: &Grid<D>, moved: &[bool], scaling: Scaling) -> Self {
        match kind {
            Regularizer::Rest => Self::Rows(rest(grid, moved, scaling)),
            Regularizer::Noh => Self::Rows(noh(grid, scaling)),
            Regularizer::Bend => Self::Rows(bend(grid, scaling)),
            Regularizer::Affine => Self::Affine(Affine::new(grid, moved, scaling)),
        }
    }

    /// Largest difference between handle indices that share a matrix entry; the projector is not part of the band.
    pub(crate) fn bandwidth(&self) -> usize {
        match self {
            Self::Rows(rows) => rows.bandwidth(),
            Self::Affine(_) => 0,
        }
    }

    /// Adds `scale` times the constant matrix.
    pub(crate) fn add_normal(&self, scale: f64, normal: &mut NormalMatrix, cancel: &Cancel) {
        match self {
            Self::Rows(rows) => rows.add_normal(scale, normal, cancel),
            Self::Affine(affine) => {
                let weight = scale * affine.weight;
                affine.free.iter().for_each(|&handle| normal.add(handle, handle, weight));
                normal.downdate(weight, &affine.columns);
            }
        }
    }

    /// Adds `scale` times the right-hand side, which is 0 for `affine`.
    pub(crate) fn add_right_side(&self, scale: f64, right_side: &mut [[f64; D]]) {
        if let Self::Rows(rows) = self {
            rows.add_right_side(scale, right_side);
        }
    }

    /// Energy of the regulariser.
    pub(crate) fn energy(&self, handles: &[[f64; D]]) -> f64 {
        match self {
            Self::Rows(rows) => rows.energy(handles),
            Self::Affine(affine) => affine.energy(handles),
        }
    }
}

impl Affine {
    /// Plain scaling gives a sum; dimensionless scaling gives the mean over free handles, in units of the box diagonal.
    fn new<const D: usize>(grid: &Grid<D>, moved: &[bool], scaling: Scaling) -> Self {
        let free: Vec<usize> = (0..moved.len()).filter(|&index| !moved[index]).collect();
        let coordinate = |axis: usize| {
            // Indices span the same space as coordinates, and are exact wherever the box lies.
            let value = |index: usize| grid.handle_coords(index)[axis] as f64;
            (0..moved.len()).map(|index| if moved[index] { 0.0 } else { value(index) }).collect::<Vec<f64>>()
        };
        let one = moved.iter().map(|&is_moved| f64::from(u8::from(!is_moved))).collect();
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for column in std::iter::once(one).chain((0..D).map(coordinate)) {
            push_orthonormal(&mut columns, column);
        }
        let weight = weight_of_mean(scaling, free.len(), grid.diagonal());
        Self { weight, free, columns }
    }

    fn energy<const D: usize>(&self, handles: &[[f64; D]]) -> f64 {
        let shares: Vec<[f64; D]> = self
            .columns
            .iter()
            .map(|column| std::array::from_fn(|d| column.iter().zip(handles).map(|(q, p)| q * p[d]).sum()))
            .collect();
        let squares = self.free.iter().map(|&index| {
            let affine = |d: usize| self.columns.iter().zip(&shares).map(|(q, share)| q[index] * share[d]).sum::<f64>();
            (0..D).map(|d| (handles[index][d] - affine(d)).powi(2)).sum::<f64>()
        });
        self.weight * squares.sum::<f64>()
    }
}

/// Appends the component of `column` that is orthogonal to `columns`, normalised (Gram-Schmidt, twice), unless it is linearly
/// dependent.
fn push_orthonormal(columns: &mut Vec<Vec<f64>>, mut column: Vec<f64>) {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let before = product(&column, &column);
    for _ in 0..2 {
        for known in columns.iter() {
            let share = product(known, &column);
            column.iter_mut().zip(known).for_each(|(x, q)| *x -= share * q);
        }
    }
    let left = product(&column, &column);
    if left > 1e-20 * before {
        let inverse = 1.0 / left.sqrt();
        column.iter_mut().for_each(|x| *x *= inverse);
        columns.push(column);
    }
}

/// Weight that turns a plain sum of squared distances into the mean of `count` terms, in units of `diagonal`.
fn weight_of_mean(scaling: Scaling, count: usize, diagonal: f64) -> f64 {
    match scaling {
        Scaling::Plain => 1.0,
        Scaling::Dimensionless => 1.0 / (count.max(1) as f64 * diagonal.powi(2)),
    }
}

/// Σ ‖P'_i − P⁰_i‖² over handles that are not moved explicitly (paper, equation 8); if dimensionless, the mean in units of the
/// box diagonal.
fn rest<const D: usize>(grid: &Grid<D>, moved: &[bool], scaling: Scaling) -> LeastSquaresRows<D> {
    let free = moved.iter().filter(|&&is_moved| !is_moved).count();
    let weight = weight_of_mean(scaling, free, grid.diagonal());
    let mut rows = LeastSquaresRows::new();
    for index in (0..moved.len()).filter(|&index| !moved[index]) {
        rows.push(weight, [(index, 1.0)], grid.rest_handle(index));
    }
    rows
}

/// Differences of neighbouring handles: Σ ‖(P'_a − P'_b) − (P⁰_a − P⁰_b)‖² over all grid edges.
///
/// If dimensionless, it is the mean over the edges, each in units of its rest length, which tends to the mean of ‖J − I‖²/D.
pub(crate) fn noh<const D: usize>(grid: &Grid<D>, scaling: Scaling) -> LeastSquaresRows<D> {
    let counts = (0..D).map(|axis| grid.handle_count() / grid.dims[axis] * (grid.dims[axis] - 1));
    let edges: usize = counts.sum();
    let mut rows = LeastSquaresRows::new();
    for axis in 0..D {
        let (stride, pitch) = (grid.stride(axis), grid.spacing(axis));
        let weight = weight_of_mean(scaling, edges, pitch);
        let offset = std::array::from_fn(|d| if d == axis { pitch } else { 0.0 });
        for start in (0..grid.handle_count()).filter(|&index| grid.handle_coords(index)[axis] + 1 < grid.dims[axis]) {
            rows.push(weight, [(start, -1.0), (start + stride, 1.0)], offset);
        }
    }
    rows
}
