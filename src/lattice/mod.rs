//! Stage 4: grids of handles, their bases, and the forward free-form deformation (2D and 3D).
//!
//! In: a rest box, dims, a basis and moved handles. Out: weights, gradients, warped points.

mod axis;
mod basis;
mod bezier;
mod display;
mod error;
#[cfg(any(test, feature = "cli"))]
mod fit;
mod folds;
mod folds_in_part;
mod forward;
mod grid;
mod scene_lattice;
mod transfer;

pub(crate) use axis::AxisTerms;
pub(crate) use axis::{MAX_HANDLES, MAX_HANDLES_IN_ALL, bernstein_values};
pub use basis::Basis;
pub(crate) use basis::Support;
pub use display::DisplayWarp;
pub use error::LatticeError;
pub(crate) use folds::Folds;
pub(crate) use folds::rough_determinant;
pub(crate) use folds_in_part::PartOfCell;
pub use grid::{Grid, Lattice, ScreenLattice};
pub use scene_lattice::{BoxFrame, SceneLattice};
pub(crate) use transfer::LatticeFit;
