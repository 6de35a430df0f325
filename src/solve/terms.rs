//! The energy terms without rotations, and the factors of all terms.
//!
//! In: settings and rows. Out: [`Terms`], [`Scales`].

use super::least_squares::LeastSquaresRows;
use super::regularizer::RegularizerTerm;
use super::settings::{Scaling, Settings};
use super::yielding_rows::YieldingRows;
use crate::lattice::Grid;
use std::sync::Arc;

/// Factors of the energy terms, including the Tikhonov term towards the rigid fit and the proximal term.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scales {
    pub(crate) shape: f64,
    pub(crate) pins: f64,
    pub(crate) handles: f64,
    pub(crate) regularizer: f64,
    pub(crate) tikhonov: f64,
    /// Factor of the proximal term; 0 in a solve of a single time.
    pub(crate) proximal: f64,
}

/// The terms without rotations.
#[derive(Clone, Debug)]
pub(crate) struct Terms<const D: usize> {
    pub(crate) pins: LeastSquaresRows<D>,
    pub(crate) handles: LeastSquaresRows<D>,
    /// Shared, because it does not depend on targets.
    pub(crate) regularizer: Arc<RegularizerTerm<D>>,
    /// Points of the model with the positions to which they are drawn; none in a solve of a single time.
    pub(crate) proximal: LeastSquaresRows<D>,
    /// Rows of the pins if some give way.
    pub(crate) yielding: Option<Arc<YieldingRows<D>>>,
}

impl<const D: usize> Terms<D> {
    /// Rows of the pins in the energy: those of yielding pins if some give way.
    pub(crate) fn acting_pins(&self) -> &LeastSquaresRows<D> {
        self.yielding.as_ref().map_or(&self.pins, |yielding| &yielding.rows)
    }
}

impl Scales {
    pub(crate) fn of<const D: usize>(grid: &Grid<D>, settings: &Settings, mass: f64) -> Self {
        let lambdas = settings.lambdas;
        let [shape, pins] = match settings.scaling {
            Scaling::Plain => [1.0, 1.0],
            // Negative cotangents can make the mass zero or negative.
            Scaling::Dimensionless => [if mass > 0.0 { 1.0 / mass } else { 1.0 }, 1.0 / grid.diagonal().powi(2)],
        };
        Self {
            shape: shape * lambdas.shape,
            pins: pins * lambdas.pins,
            handles: pins * lambdas.handles,
            regularizer: lambdas.regularizer,
            tikhonov: 0.0,
            proximal: 0.0,
        }
    }
}
