//! Stage 6: pins, handles and a shape become the lattice that bends it with the least distortion.
//!
//! lp-FFD: Fukusato, Maejima and Igarashi 2024, <https://arxiv.org/abs/2405.07450>.

mod anderson;
mod bend;
mod buckets;
mod check;
mod cholesky;
mod constraints;
mod drag;
mod energy;
mod error;
mod gram;
mod iterate;
mod matrix;
pub mod methods;
mod misses;
mod newton;
mod occupied;
mod packs;
mod pins;
mod point_weights;
pub mod problem;
mod product;
mod products;
mod regularizer;
mod rows;
mod samples;
mod settings;
mod small;
mod solver;
mod stiffness;
mod walk;
mod waypoint;
mod weld;

pub use constraints::Holder;
pub use drag::Drag;
pub use error::SolveError;
pub use iterate::Energies;
pub use misses::{MissReason, PinMiss};
pub use settings::{Disc, EqualVertices, Guard, Lambdas, OutsidePins, PinHold, Sampling, Scaling, Settings, Start};
pub use solver::Solver;
pub use waypoint::Waypoint;

use crate::lattice::{Grid, Lattice};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the shape's distortion is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Energy {
    /// The lattice's own gradient at sample points spread over the model (default); on lines alone `stroke`.
    Area,
    /// One rotation a vertex over its edges (the paper's).
    Edge,
    /// Differential coordinates of the vertices, the paper's equation to the letter; not rigid inside flat meshes.
    Vertex,
    /// One rotation a triangle.
    Element,
    /// One rotation a vertex over all edges of its triangles.
    Rims,
    /// One rotation a point of a line over its neighbours along the line.
    Stroke,
}

/// What holds handles that nothing else holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Regularizer {
    /// Distance from the rest handles (the paper's E_gr).
    Rest,
    /// Offsets of neighbouring handles.
    Noh,
    /// Distance from the affine images of the rest handles.
    Affine,
    /// Second differences of the handles (default).
    Bend,
}

/// Weights of the edges in [`Energy::Edge`] and [`Energy::Vertex`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum EdgeWeights {
    /// 1 a mesh edge.
    Uniform,
    /// Cotangents.
    Cot,
}

/// The shape inside the lattice: #vertices points, triangles over them (any orientation; slivers allowed) and lines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape<const D: usize> {
    /// Rest points, #vertices.
    pub points: Vec<[f64; D]>,
    /// Corners.
    pub triangles: Vec<[u32; 3]>,
    /// Polylines: vertices one after the other; a closed one repeats its first.
    pub strokes: Vec<Vec<u32>>,
    /// How stiff each triangle is, 0 or more, #triangles; empty: 1 everywhere.
    pub stiffness: Vec<f64>,
}

impl<const D: usize> Shape<D> {
    /// Triangles of even stiffness.
    #[must_use]
    pub fn of_triangles(points: Vec<[f64; D]>, triangles: Vec<[u32; 3]>) -> Self {
        Self { points, triangles, ..Self::default() }
    }
}

/// A point that has to go somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointPin<const D: usize> {
    /// Where the pinned point is at rest.
    pub at: [f64; D],
    /// Where it has to go.
    pub target: [f64; D],
    /// 0..=1, times the pin weight of the settings; a pin fades out with it.
    pub weight: f64,
    /// Wanted gradient at the pin (columns: images of the axes), for pins that hold a rotation and scale.
    pub gradient: Option<[[f64; D]; D]>,
    /// What the pin takes along; `None`: the point alone.
    pub region: Option<Region>,
}

impl<const D: usize> PointPin<D> {
    /// A pin of full weight that holds nothing but its point.
    #[must_use]
    pub fn new(at: [f64; D], target: [f64; D]) -> Self {
        Self { at, target, weight: 1.0, gradient: None, region: None }
    }
}

/// The neighbourhood that a pin takes along, fading out smoothly from the pin to the rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Distance of the rim from the pin at rest, in units of the space.
    pub radius: f64,
    /// How firmly the neighbourhood moves with the pin as one piece, 0 (not at all) to 1 (rigidly).
    pub grip: f64,
    /// How stiff the shape is at the pin, as a multiple of its own stiffness; 1 at the rim.
    pub starch: f64,
}

/// A handle that has to go somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandlePin<const D: usize> {
    /// Handle index.
    pub index: usize,
    /// Where it has to go.
    pub target: [f64; D],
}

/// How good a solve is.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SolveReport {
    /// Distance of each pin from its target, in units of the space (screen: frame heights), as many as pins.
    pub pin_errors: Vec<f64>,
    /// The pins that are off their targets, and why.
    pub pin_misses: Vec<PinMiss>,
    /// Cells that turn over somewhere, in the plane or in space.
    pub folded_cells: usize,
    /// Those of them that hold some of the model; the others fold unseen.
    pub folded_model_cells: usize,
    /// Least determinant of the gradient over the cells that hold some of the model: a lower bound, 1e-3 near. Above 0
    /// nothing folds, which is proven for all bases but Bernstein's, whose cells are probed.
    pub least_cell_det: f64,
    /// Least determinant of the gradient over the samples.
    pub least_det: f64,
    /// Angular distortion: mean over area of s1/s2 + s2/s1 − 2.
    pub angular: f64,
    /// Area distortion: mean over area of s1·s2 + 1/(s1·s2) − 2.
    pub area: f64,
    /// Where the guard stopped pins and handles, as a share of the (uneven) steps of their way; `None`: they went all the way.
    pub stopped_at: Option<f64>,
    /// Distance of each moved handle from its target, in units of the space.
    pub handle_errors: Vec<f64>,
    /// Linear solves: local-global and Newton steps, those taken back and those on the way included.
    pub iterations: usize,
    /// The last step was below the tolerance.
    pub is_converged: bool,
    /// Pairs of pins, by index, that hold the same point but have different targets: it goes between them (least
    /// squares).
    pub conflicts: Vec<[usize; 2]>,
    /// What the user should know, in words (handles that contradict each other, no pins, empty shape...).
    pub warnings: Vec<String>,
}

/// A solved lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution<const D: usize> {
    /// The lattice.
    pub lattice: Lattice<D>,
    /// How good it is.
    pub report: SolveReport,
}

/// Everything a solve needs.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a, const D: usize> {
    /// The rest grid.
    pub grid: &'a Grid<D>,
    /// What is to keep its shape.
    pub shape: &'a Shape<D>,
    /// Pins.
    pub pins: &'a [PointPin<D>],
    /// Moved handles.
    pub handles: &'a [HandlePin<D>],
    /// Settings.
    pub settings: &'a Settings,
}

/// Solves for the handles.
///
/// # Errors
/// [`SolveError`] where the problem is malformed (dims, indices, non-finite numbers) or the factorisation fails.
pub fn solve<const D: usize>(problem: &Problem<D>) -> Result<Solution<D>, SolveError> {
    Ok(Solver::new(problem)?.solve())
}
