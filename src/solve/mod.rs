//! Stage 6: finds the lattice that brings pins and moved handles to their targets with the least distortion of a shape.
//!
//! lp-FFD: Fukusato, Maejima and Igarashi 2024, <https://arxiv.org/abs/2405.07450>.

mod active_cells;
mod anderson;
mod barrier;
mod blocked_weights;
mod box_rotation;
mod branching;
mod cached_factor;
mod cancel;
mod constraints;
mod continuation;
mod counting_sort;
mod drag;
mod energy;
mod error;
mod factor_reuse;
mod folds_on_polygons;
mod least_squares;
mod linalg;
mod local_global;
mod merge_duplicates;
pub mod methods;
mod minimization;
mod model_folds;
mod newton;
mod newton_cg;
mod overdetermined;
mod pin_residuals;
mod pins;
mod point_weights;
mod prefactored;
mod problem;
pub mod problem_file;
mod regularizer;
mod report;
mod rigid_motion;
mod samples;
mod search;
mod second_differences;
mod separable_rows;
mod separable_weights;
mod settings;
mod solver;
mod stiffness;
mod system;
mod targets;
mod terms;
mod trajectory;
mod upright;
mod validate;
mod winding;
mod yielding;
mod yielding_rows;

#[cfg(test)]
pub(crate) use active_cells::active_cells;
pub(crate) use branching::nearest_barycentric;
pub(crate) use linalg::small_matrix::{distance, symmetric_eigen};
pub(crate) use model_folds::ModelCells;

pub(crate) use branching::Bending;
pub(crate) use branching::{BranchedLattice, Crossing, Link};
pub(crate) use branching::{FarPoints, far_points};
pub(crate) use branching::{LinkEnd, LinkKind};
pub(crate) use branching::{
    continued, inner_widths, islands_of, link_at, link_length, nearest_link, sampled_solid_links, solid_links,
    surface_links,
};
pub use cancel::Cancel;
pub use constraints::ConstraintOwner;
pub use drag::Drag;
pub use error::SolveError;
pub use pin_residuals::{PinResidual, ResidualReason};
pub use problem::{HandlePin, PointPin, Problem, Shape};
pub(crate) use problem::{ModelPoint, Region};
pub use report::{Solution, SolveReport, Stationarity};
pub use settings::{
    DuplicateVertices, EdgeWeights, Energy, Guard, Lambdas, Minima, OutsidePins, PinHold, Regularizer, Sampling,
    Scaling, Settings, SmoothingDisc, Start, Topology,
};
pub use solver::{CancellableSolver, Solver, solve};
pub use targets::Targets;
pub(crate) use trajectory::knots_per_gib;
pub(crate) use trajectory::{Coupling, Spread, TimedProblem, Timeline, Trajectory};
#[cfg(any(test, feature = "cli"))]
pub(crate) use upright::Upright;
