//! Settings of a solve: what is minimised, in which units, and when to stop.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Distortion measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Energy {
    /// The gradient of the lattice at samples of the model (default); `stroke` for shapes of lines only.
    Area,
    /// One rotation per vertex over its one-ring (the paper's).
    Edge,
    /// Differential coordinates of the vertices, the paper's equation taken literally; no rigidity inside flat meshes.
    Vertex,
    /// One rotation per triangle.
    Element,
    /// One rotation per vertex over all edges of its triangles.
    SpokesAndRims,
    /// One rotation per point of a line over its neighbours along the line.
    Stroke,
}

impl Energy {
    /// Whether [`EdgeWeights`] apply.
    #[must_use]
    pub const fn has_edge_weights(self) -> bool {
        match self {
            Self::Edge | Self::Vertex => true,
            Self::Area | Self::Element | Self::SpokesAndRims | Self::Stroke => false,
        }
    }
}

/// Term that determines handles which nothing else constrains.
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
    /// 1 per mesh edge.
    Uniform,
    /// Cotangents.
    Cot,
}

/// Units of the four terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scaling {
    /// Sums as the paper writes them; the balance shifts with mesh density, grid size and model scale.
    Plain,
    /// Means: mean ‖J−R‖² over the area, pins in units of the box diagonal s, bend = s²·mean(second derivative²).
    Dimensionless,
}

/// Where [`Energy::Area`] samples the gradient, and [`Energy::Stroke`] lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Points that match the model's area, centroid and covariance in every sub-cell; on lines evenly spaced points.
    Subcells,
    /// One point per triangle; on lines their own points. A shape without triangles, or lines, has no energy.
    Centroids,
}

/// Initial state of the iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// The rigid motion that brings the pins nearest to their targets.
    RigidFit,
    /// The rest pose, all rotations the identity.
    Rest,
}

/// Treatment of pins outside the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutsidePins {
    /// They hold the nearest box point, with the same displacement, like [`crate::lattice::Lattice::warp`].
    Nearest,
    /// They hold the extended polynomial.
    Extended,
}

/// Enforcement of pins of full weight and moved handles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PinHold {
    /// By their weight: the shape pulls them back slightly (the paper's).
    Soft,
    /// Exactly, unless they contradict each other.
    Hard,
}

/// The disc around every pin that stays smooth, so that a pin pulls a bulge and not a spike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothingDisc {
    /// Radius as a fraction of the box diagonal; 0: pins act on their points alone.
    pub radius: f64,
    /// Weight of the disc, as a multiple of that of the model.
    pub weight: f64,
}

/// Which points of a shape share handles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Topology {
    /// All points near a handle, however far apart they are along the shape.
    #[default]
    Plain,
    /// Those that hang together near the handle: every connected piece has a copy of it.
    Branching,
}

/// Which minimum a solve without neighbours in time ends in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Minima {
    /// The one that the rigid fit leads to: continuous in the targets as long as it exists.
    Nearest,
    /// The least that several starts lead to; from frame to frame another one may be it.
    #[default]
    Least,
}

/// Handling of folds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Guard {
    /// Folds are reported.
    #[default]
    Report,
    /// Cells that hold some of the shape do not fold: a barrier keeps det J above 0 there, and pins that would need more force than it has
    /// give way (docs/METHOD.md, "Barrier").
    Limit,
}

/// Treatment of duplicate vertices, in energies over the edges of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DuplicateVertices {
    /// They are merged, so that seams of texture coordinates do not tear.
    Merged,
    /// The mesh as it is given.
    Separate,
}

/// Weights of the terms (paper, equation 9: λml, λmp, λgp, λgr).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambdas {
    /// Distortion, λml.
    pub shape: f64,
    /// Pins, λmp.
    pub pins: f64,
    /// Moved handles, λgp.
    pub handles: f64,
    /// Regulariser, λgr.
    pub regularizer: f64,
}

/// Settings of a solve; [`Settings::default`] is the default of this program, [`Settings::paper`] the paper's preset.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Distortion measure.
    pub energy: Energy,
    /// Regulariser.
    pub regularizer: Regularizer,
    /// Edge weights of [`Energy::Edge`] and [`Energy::Vertex`].
    pub weights: EdgeWeights,
    /// Weights of the terms.
    pub lambdas: Lambdas,
    /// Units of the terms.
    pub scaling: Scaling,
    /// Samples of [`Energy::Area`] and [`Energy::Stroke`].
    pub sampling: Sampling,
    /// Initial state.
    pub start: Start,
    /// Enforcement of pins and moved handles.
    pub pin_hold: PinHold,
    /// Stretch, above 1, up to which two hard pins less than a span of the lattice apart hold exactly; nearer than 0.44 spans less. Beyond
    /// they give way (docs/METHOD.md, "Pins that give way").
    pub max_stretch: f64,
    /// The smooth disc around a pin.
    pub disc: SmoothingDisc,
    /// Pins outside the box.
    pub outside_pins: OutsidePins,
    /// Which points share handles.
    pub topology: Topology,
    /// Folds.
    pub guard: Guard,
    /// Which minimum is looked for.
    pub minima: Minima,
    /// Duplicate vertices.
    pub duplicate_vertices: DuplicateVertices,
    /// Maximum number of linear solves.
    pub iteration_limit: usize,
    /// Stop when no handle moves farther than this fraction of the box diagonal; 0 runs to the limit.
    pub tolerance: f64,
    /// Window of the Anderson acceleration, which precedes Newton steps (docs/METHOD.md, "Convergence");
    /// 0: the plain local-global iteration without either.
    pub acceleration: usize,
    /// Temporal weight, frames: how firmly a [`super::Trajectory`] holds neighbouring times together; 0: each time is solved alone.
    pub temporal: f64,
}

impl Settings {
    /// λgr of [`Regularizer::Bend`] in dimensionless units, tuned on poses (docs/METHOD.md).
    pub const BEND: f64 = 3e-5;

    /// Temporal weight that keeps a layer of a shot from snapping between frames, frames.
    pub const TEMPORAL: f64 = 0.3;
    /// λgr of [`Regularizer::Rest`] in dimensionless units.
    pub const REST: f64 = 5.3;
    /// λgr of [`Regularizer::Noh`] in dimensionless units: 1e-2 of the plain sum at 10 x 10.
    pub const NOH: f64 = 0.2;
    /// λgr of [`Regularizer::Affine`] in dimensionless units: 1e-3 of the plain sum at 10 x 10.
    pub const AFFINE: f64 = 1.1;

    /// The paper's preset: `edge`, uniform weights, `rest`, plain sums, λ = 1, 1e2, 1e2, 1e-2, started at rest.
    #[must_use]
    pub fn paper() -> Self {
        Self {
            energy: Energy::Edge,
            regularizer: Regularizer::Rest,
            lambdas: Lambdas { shape: 1.0, pins: 1e2, handles: 1e2, regularizer: 1e-2 },
            scaling: Scaling::Plain,
            start: Start::Rest,
            pin_hold: PinHold::Soft,
            disc: SmoothingDisc { radius: 0.0, weight: 0.0 },
            acceleration: 0,
            ..Self::default()
        }
    }

    /// The same settings with another regulariser at its default weight.
    #[must_use]
    pub fn with_regularizer(mut self, regularizer: Regularizer) -> Self {
        self.lambdas.regularizer = match (self.scaling, regularizer) {
            (Scaling::Plain, Regularizer::Rest | Regularizer::Noh) => 1e-2,
            (Scaling::Plain, Regularizer::Bend | Regularizer::Affine) => 1e-3,
            (Scaling::Dimensionless, Regularizer::Rest) => Self::REST,
            (Scaling::Dimensionless, Regularizer::Noh) => Self::NOH,
            (Scaling::Dimensionless, Regularizer::Affine) => Self::AFFINE,
            (Scaling::Dimensionless, Regularizer::Bend) => Self::BEND,
        };
        self.regularizer = regularizer;
        self
    }

    /// Which of these settings a branching lattice cannot have, and what to do; `None`: it can have them all.
    #[must_use]
    pub fn branching_fault(&self) -> Option<[&'static str; 2]> {
        if self.energy != Energy::Area || self.sampling != Sampling::Subcells {
            Some(["another energy than `area`", "use energy = \"area\" and no preset"])
        } else if self.regularizer != Regularizer::Bend {
            Some(["another regulariser than `bend`", "use regularizer = \"bend\""])
        } else {
            None
        }
    }

    /// The same settings with a smoother warp (above 1) or a less smooth one: the weight of the regulariser is multiplied by
    /// the cube of `smoothness`, so that values from 1 to 10 range from shapes that follow each pin to one smooth deformation.
    #[must_use]
    pub fn with_smoothness(mut self, smoothness: f64) -> Self {
        self.lambdas.regularizer *= smoothness.powi(3);
        self
    }
}

impl Default for Settings {
    /// `area` and `bend`, dimensionless, accelerated, pins exact.
    fn default() -> Self {
        Self {
            energy: Energy::Area,
            regularizer: Regularizer::Bend,
            weights: EdgeWeights::Uniform,
            lambdas: Lambdas { shape: 4.0, pins: 1e6, handles: 1e6, regularizer: Self::BEND },
            scaling: Scaling::Dimensionless,
            sampling: Sampling::Subcells,
            start: Start::RigidFit,
            pin_hold: PinHold::Hard,
            max_stretch: 4.0,
            disc: SmoothingDisc { radius: 0.05, weight: 100.0 },
            outside_pins: OutsidePins::Nearest,
            topology: Topology::Plain,
            guard: Guard::Report,
            minima: Minima::Least,
            duplicate_vertices: DuplicateVertices::Merged,
            iteration_limit: 200,
            tolerance: 1e-6,
            acceleration: 5,
            temporal: 0.0,
        }
    }
}
