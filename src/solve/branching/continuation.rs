//! Extrapolation of handles that no other condition determines.
//!
//! In: a grid, the positions of some of its handles. Out: a lattice with these, in which the others minimise the second
//! differences.

use crate::lattice::{Grid, Lattice};
use crate::solve::cancel::Cancel;
use crate::solve::linalg::factorization::Factorization;
use crate::solve::linalg::normal_matrix::NormalMatrix;
use crate::solve::second_differences::bend;
use crate::solve::settings::Scaling;

/// Weight of known handles relative to that of second differences in the system for the unknown ones.
const KNOWN: f64 = 1e6;

/// A lattice with the known handles, in which the others minimise the sum of squared second differences. `known`: #handles.
#[must_use]
pub(crate) fn continued<const D: usize>(grid: &Grid<D>, known: &[Option<[f64; D]>]) -> Lattice<D> {
    let mut lattice = grid.at_rest();
    let rows = bend(grid, Scaling::Plain);
    let mut normal = NormalMatrix::zero(lattice.handles.len(), rows.bandwidth());
    rows.add_normal(1.0, &mut normal, &Cancel::never());
    let mut extended = vec![[0.0; D]; lattice.handles.len()];
    for (handle, place) in known.iter().enumerate() {
        if let Some(place) = place {
            normal.add(handle, handle, KNOWN);
            extended[handle] = place.map(|x| KNOWN * x);
            lattice.handles[handle] = *place;
        }
    }
    if let Some(factor) = Factorization::new(&normal, &Cancel::never()) {
        factor.solve(&mut extended);
        let unknown = lattice.handles.iter_mut().zip(known).zip(extended).filter(|((_, known), _)| known.is_none());
        unknown.for_each(|((handle, _), place)| *handle = place);
    }
    lattice
}
