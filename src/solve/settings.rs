//! Settings of a solve: the energy that is minimised, its units, and when to stop.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Distortion energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Energy {
    /// Gradient of the lattice at samples of the model (default); shapes that have only lines use `stroke`.
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
    /// Whether [`EdgeWeights`] apply to this energy.
    #[must_use]
    pub(crate) const fn has_edge_weights(self) -> bool {
        match self {
            Self::Edge | Self::Vertex => true,
            Self::Area | Self::Element | Self::SpokesAndRims | Self::Stroke => false,
        }
    }
}

/// Term that determines handles which neither pins nor the shape constrain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Regularizer {
    /// Distance from the rest handles (the paper's E_gr).
    Rest,
    /// Differences of neighbouring handles from those at rest.
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
    /// Cotangents of the angles opposite the edge.
    Cot,
}

/// Units of the four terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scaling {
    /// Plain sums as in the paper; their balance depends on mesh density, grid size and model scale.
    Plain,
    /// Means: mean ‖J−R‖² over the area, pins in units of the box diagonal s, bend = s²·mean(second derivative²).
    Dimensionless,
}

/// Points at which [`Energy::Area`] samples the gradient and [`Energy::Stroke`] samples lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Samples that match the area, centroid and covariance of the model in every sub-cell; on lines evenly spaced points.
    Subcells,
    /// One sample per triangle; on lines their own points. Energies are used as requested, even if the shape has no triangles or
    /// no lines for them.
    Centroids,
}

/// Start state of the iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// The rigid motion that best fits the pins to their targets.
    RigidFit,
    /// The rest pose, with the identity as every rotation.
    Rest,
}

/// Treatment of pins outside the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutsidePins {
    /// The pin moves the nearest point of the box by its displacement, like [`crate::lattice::Lattice::warp`].
    Nearest,
    /// The pin holds its own point, with the basis polynomials extrapolated beyond the box.
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

/// Disc around every pin that stays smooth, so that a pin pulls out a bulge and not a spike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothingDisc {
    /// Radius as a fraction of the box diagonal; 0 for pins that act on their points alone.
    pub radius: f64,
    /// Weight of the disc, as a multiple of the weight of the model.
    pub weight: f64,
}

/// Which points of a shape share handles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Topology {
    /// All points near a handle, however far apart they are along the shape.
    #[default]
    Plain,
    /// Each connected piece near a handle has its own copy of it.
    Branching,
}

/// Minimum in which a solve ends that is not part of a trajectory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Minima {
    /// The minimum that the solve from the rigid fit reaches. It is continuous in the targets as long as it exists.
    Nearest,
    /// The lowest of the minima that several starts lead to. It may change from frame to frame.
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
    /// Cells that contain part of the shape cannot fold: a barrier keeps det J above 0 there, and pins that need more force than
    /// its limit give way (docs/METHOD.md, "Barrier").
    Limit,
}

/// Treatment of duplicate vertices in energies over the edges of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DuplicateVertices {
    /// Duplicates are merged, so that the mesh does not tear at texture seams.
    Merged,
    /// The mesh is used as given.
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

/// Settings of a solve; [`Settings::default`] has the defaults of this program, [`Settings::paper`] the paper's preset.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Distortion energy.
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
    /// Start state of the iteration.
    pub start: Start,
    /// Enforcement of pins and moved handles.
    pub pin_hold: PinHold,
    /// Stretch, above 1, up to which two hard pins less than a span of the lattice apart hold exactly; the limit falls for pins
    /// less than 0.44 spans apart. Beyond the limit they give way (docs/METHOD.md, "Pins that give way").
    pub max_stretch: f64,
    /// Smooth disc around each pin.
    pub disc: SmoothingDisc,
    /// Treatment of pins outside the box.
    pub outside_pins: OutsidePins,
    /// Which points of the shape share handles.
    pub topology: Topology,
    /// Handling of folds.
    pub guard: Guard,
    /// Minimum in which a solve ends.
    pub minima: Minima,
    /// Treatment of duplicate vertices.
    pub duplicate_vertices: DuplicateVertices,
    /// Maximum number of linear solves.
    pub iteration_limit: usize,
    /// The iteration stops when no handle moves farther than this fraction of the box diagonal; 0 stops only at steps of zero or
    /// rounding size, and with negative values plain iterations run to the limit.
    pub tolerance: f64,
    /// Window of the Anderson acceleration, which precedes Newton steps (docs/METHOD.md, "Convergence"); 0 gives the plain
    /// local-global iteration without acceleration and Newton steps.
    pub acceleration: usize,
    /// Temporal weight in frames: how strongly a layer couples neighbouring times; 0 solves each time alone.
    pub temporal: f64,
}

impl Settings {
    /// λgr of [`Regularizer::Bend`] in dimensionless units, tuned on poses (docs/METHOD.md).
    pub(crate) const BEND: f64 = 3e-5;

    /// Temporal weight in frames that keeps a layer of a shot from snapping between frames.
    pub(crate) const TEMPORAL: f64 = 0.3;
    /// λgr of [`Regularizer::Rest`] in dimensionless units.
    pub(crate) const REST: f64 = 5.3;
    /// λgr of [`Regularizer::Noh`] in dimensionless units: 1e-2 of the plain sum at 10 x 10.
    pub(crate) const NOH: f64 = 0.2;
    /// λgr of [`Regularizer::Affine`] in dimensionless units: 1e-3 of the plain sum at 10 x 10.
    pub(crate) const AFFINE: f64 = 1.1;

    /// Returns the paper's preset: `edge`, uniform weights, `rest`, plain sums, λ = 1, 1e2, 1e2, 1e-2, started at rest.
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

    /// Returns the same settings with another regulariser at its default weight.
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

    /// Returns a setting that a branching lattice does not support, and what to use instead; `None` if it supports all settings.
    #[must_use]
    pub(crate) fn branching_fault(&self) -> Option<[&'static str; 2]> {
        if self.energy != Energy::Area || self.sampling != Sampling::Subcells {
            Some(["another energy than `area`", "use energy = \"area\" and no preset"])
        } else if self.regularizer != Regularizer::Bend {
            Some(["another regulariser than `bend`", "use regularizer = \"bend\""])
        } else {
            None
        }
    }

    /// Returns the same settings with a smoother warp (`smoothness` above 1) or a less smooth one. The weight of the regulariser
    /// is multiplied by the cube of `smoothness`, so that values from 1 to 10 range from shapes that follow each pin to one
    /// smooth deformation.
    #[must_use]
    pub(crate) fn with_smoothness(mut self, smoothness: f64) -> Self {
        self.lambdas.regularizer *= smoothness.powi(3);
        self
    }
}

impl Default for Settings {
    /// `area` and `bend`, dimensionless, accelerated, with exact pins.
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
