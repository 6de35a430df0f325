//! The methods that lp-FFD is compared with, and lp-FFD itself, behind one trait.
//!
//! In: a [`Problem`]. Out: a lattice, and where it takes the vertices. The line-up is that of the paper's section 4.1.

mod arap;
mod hsu;
mod inverse;
mod mls;
mod own;
mod sparse;

pub use arap::Arap;
pub use hsu::Hsu;
pub use inverse::{ArapAndInverse, inverse_ffd};
pub use mls::Mls;
pub use own::{House, Paper};

use super::matrix::{Factor, Normal};
use super::rows::RowSet;
use super::{Problem, SolveError, pins};
use crate::lattice::{Basis, Grid, Lattice};

/// A method that moves a lattice so that pins reach their targets.
pub trait Deformer<const D: usize>: Send + Sync {
    /// The word that asks for it: `hsu`, `mls`, `arap`, `paper`, `default`.
    fn key(&self) -> &'static str;

    /// Short name, as tables and pictures print it.
    fn name(&self) -> &'static str;

    /// The basis it is published with; `None`: that of the problem.
    fn basis(&self) -> Option<Basis> {
        Some(Basis::Bernstein)
    }

    /// Moves the handles of the problem's grid.
    ///
    /// # Errors
    /// [`SolveError`] where the problem is malformed or nothing decides where handles go.
    fn deform(&self, problem: &Problem<D>) -> Result<Deformed<D>, SolveError>;
}

/// What a method makes of a problem.
#[derive(Clone, Debug, PartialEq)]
pub struct Deformed<const D: usize> {
    /// The lattice.
    pub lattice: Lattice<D>,
    /// Iterations run; 1 for methods that solve once.
    pub iterations: usize,
}

/// All methods of the comparison, ours last.
#[must_use]
pub fn all<const D: usize>() -> Vec<Box<dyn Deformer<D>>> {
    vec![
        Box::new(Hsu::default()),
        Box::new(Mls::default()),
        Box::new(ArapAndInverse::default()),
        Box::new(Paper::default()),
        Box::new(House),
    ]
}

/// The handles that minimise Σ of the terms, each a weight and its rows.
fn least_squares<const D: usize>(
    grid: &Grid<D>,
    terms: &[(f64, &RowSet<D>)],
    what: &str,
) -> Result<Lattice<D>, SolveError> {
    let reach = terms.iter().map(|(_, rows)| rows.reach()).max().unwrap_or(0);
    let mut normal = Normal::zero(grid.handle_count(), reach);
    let mut handles = vec![[0.0; D]; grid.handle_count()];
    for (weight, rows) in terms {
        rows.add_normal(*weight, &mut normal);
        rows.add_right_side(*weight, &mut handles);
    }
    let factor = Factor::new(&normal).ok_or_else(|| SolveError::Singular {
        what: what.to_owned(),
        hint: "add pins, or raise the weight of its regulariser".into(),
    })?;
    factor.solve(&mut handles);
    Ok(Lattice { grid: grid.clone(), handles })
}

/// Rows of the problem's pins and moved handles.
fn held<const D: usize>(problem: &Problem<D>) -> [RowSet<D>; 2] {
    [pins::pin_rows(problem.grid, problem.pins, problem.settings), pins::handle_rows(problem.handles)]
}
