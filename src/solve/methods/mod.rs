//! lp-FFD and the methods that it is compared with, behind one trait.
//!
//! In: a [`Problem`]. Out: a lattice. The methods are those of the paper's section 4.1.

mod arap;
mod hsu;
mod inverse;
mod lp_ffd;
mod mls;

pub use arap::Arap;
pub(crate) use hsu::Hsu;
pub(crate) use inverse::ArapAndInverse;
pub use inverse::inverse_ffd;
pub use lp_ffd::{DefaultLpFfd, PaperLpFfd};
pub(crate) use mls::Mls;

use super::cancel::Cancel;
use super::error::SolveError;
use super::least_squares::LeastSquaresRows;
use super::linalg::factorization::Factorization;
use super::linalg::normal_matrix::NormalMatrix;
use super::pins;
use super::problem::Problem;
use crate::lattice::{Basis, Grid, Lattice};

/// A method that deforms a lattice so that pins reach their targets.
pub trait Deformer<const D: usize>: Send + Sync {
    /// Name on the command line: `hsu`, `mls`, `arap`, `paper`, `default`.
    fn key(&self) -> &'static str;

    /// Name in tables and pictures.
    fn name(&self) -> &'static str;

    /// Basis with which the method was published; `None` for the basis of the problem.
    fn basis(&self) -> Option<Basis> {
        Some(Basis::Bernstein)
    }

    /// Computes the handles of the problem's grid.
    ///
    /// # Errors
    /// [`SolveError`] if the problem is malformed or does not determine all handles.
    fn deform(&self, problem: &Problem<D>) -> Result<Deformed<D>, SolveError>;
}

/// The result of a method.
#[derive(Clone, Debug, PartialEq)]
pub struct Deformed<const D: usize> {
    /// The lattice.
    pub lattice: Lattice<D>,
    /// Number of iterations; 1 for methods that solve once.
    pub iterations: usize,
}

/// All methods of the comparison; that of this program is the last.
#[must_use]
pub fn all<const D: usize>() -> Vec<Box<dyn Deformer<D>>> {
    vec![
        Box::new(Hsu::default()),
        Box::new(Mls::default()),
        Box::new(ArapAndInverse::default()),
        Box::new(PaperLpFfd::default()),
        Box::new(DefaultLpFfd),
    ]
}

/// Returns the lattice that minimises Σ weight · ‖rows·P − targets‖² over all terms. `what` names the system in errors.
fn least_squares<const D: usize>(
    grid: &Grid<D>,
    terms: &[(f64, &LeastSquaresRows<D>)],
    what: &str,
) -> Result<Lattice<D>, SolveError> {
    let bandwidth = terms.iter().map(|(_, rows)| rows.bandwidth()).max().unwrap_or(0);
    let cancel = &Cancel::never();
    let mut normal = NormalMatrix::zero(grid.handle_count(), bandwidth);
    let mut handles = vec![[0.0; D]; grid.handle_count()];
    for (weight, rows) in terms {
        rows.add_normal(*weight, &mut normal, cancel);
        rows.add_right_side(*weight, &mut handles);
    }
    let factor = Factorization::new(&normal, cancel).ok_or_else(|| SolveError::Singular {
        what: what.to_owned(),
        hint: "add pins, or raise the weight of its regulariser".into(),
    })?;
    factor.solve(&mut handles);
    Ok(Lattice { grid: grid.clone(), handles })
}

/// Returns the rows of the problem's pins and those of its moved handles.
fn constraint_rows<const D: usize>(problem: &Problem<D>) -> [LeastSquaresRows<D>; 2] {
    [pins::pin_rows(problem.grid, problem.pins, problem.settings), pins::handle_rows(problem.handles)]
}
