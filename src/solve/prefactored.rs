//! Factored data for given pins: the matrix of one coordinate, its factor, and the operator that enforces hard rows.
//!
//! In: a matrix and terms. Out: [`Prefactored`], and the types that combine it with targets.

use super::cancel::Cancel;
use super::constraints::{Constraints, FactoredMatrix};
use super::error::SolveError;
use super::linalg::factorization::Factorization;
use super::linalg::normal_matrix::NormalMatrix;
use super::problem::PointPin;
use super::settings::Settings;
use super::targets::Targets;
use super::terms::Terms;

/// A matrix with its factor and constraints.
#[derive(Debug)]
pub(crate) struct Prefactored {
    pub(crate) normal: NormalMatrix,
    pub(crate) factor: Factorization,
    pub(crate) constraints: Constraints,
}

impl Prefactored {
    /// Factors a matrix that was assembled from `terms`.
    pub(crate) fn new<const D: usize>(
        normal: NormalMatrix,
        terms: &Terms<D>,
        pins: &[PointPin<D>],
        settings: &Settings,
        cancel: &Cancel,
    ) -> Result<Self, SolveError> {
        let factor = Factorization::new(&normal, cancel);
        cancel.check()?;
        let factor = factor.ok_or_else(|| singular(settings))?;
        let matrix = FactoredMatrix { normal: &normal, factor: &factor };
        let constraints = Constraints::new(matrix, terms, pins, settings, cancel)?;
        Ok(Self { normal, factor, constraints })
    }
}

/// Terms with new targets; if some pins give way for these targets, also the matrix that was factored for them.
#[derive(Debug)]
pub(crate) struct Retargeted<const D: usize> {
    pub(crate) terms: Terms<D>,
    pub(crate) yielded: Option<Prefactored>,
}

/// Targets, the terms that contain them, and the factored matrix for them.
pub(crate) struct TargetTerms<'a, const D: usize> {
    pub(crate) goal: &'a Targets<D>,
    pub(crate) terms: &'a Terms<D>,
    pub(crate) prefactored: &'a Prefactored,
}

fn singular(settings: &Settings) -> SolveError {
    SolveError::Singular {
        what: format!("{:?} with {:?}", settings.energy, settings.regularizer),
        hint: "add a pin, use the `rest` regulariser, or uniform edge weights".into(),
    }
}
