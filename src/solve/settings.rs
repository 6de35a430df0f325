//! Settings of a solve: what is minimised, in which units, and when to stop.

use super::{EdgeWeights, Energy, Regularizer};
use schemars::JsonSchema;
use serde::Deserialize;

/// Units of the four terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scaling {
    /// Sums as the paper writes them; the balance shifts with mesh density, grid size and model scale.
    Plain,
    /// Means: mean ‖J−R‖² over the area, pins in units of the box diagonal s, bend = s²·mean(second derivative²).
    Dimensionless,
}

/// Where [`Energy::Area`] looks at the gradient, and [`Energy::Stroke`] at lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Points that match the model's area, centroid and covariance in every sub-cell; on lines points at even distances.
    Subcells,
    /// One point a triangle; on lines their own points. A shape that has none of what the energy looks at has no energy.
    Centroids,
}

/// The state the iteration starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// The rigid motion that brings the pins nearest to their targets.
    RigidFit,
    /// The rest pose, all rotations the identity.
    Rest,
}

/// What a pin outside the box holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutsidePins {
    /// The nearest box point, moved by the same displacement, as [`crate::lattice::Lattice::warp`] does.
    Nearest,
    /// The polynomial, extended.
    Extended,
}

/// How firmly pins of full weight and moved handles hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PinHold {
    /// By their weight: the shape pulls them back a little (the paper's).
    Soft,
    /// Exactly, wherever they do not contradict each other.
    Hard,
}

/// The disc around every pin that stays smooth, so that a pin pulls a bulge and not a spike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Radius as a part of the box diagonal; 0: pins act on their points alone.
    pub radius: f64,
    /// How firmly the disc keeps its shape, as a multiple of the model's own firmness.
    pub weight: f64,
}

/// What happens where a lattice would fold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Guard {
    /// The report tells.
    #[default]
    Report,
    /// Pins and handles stop on their way, before a cell that holds some of the shape folds.
    Limit,
}

/// Treatment of vertices at equal places, in energies that look at the edges of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EqualVertices {
    /// One neighbourhood: seams of texture coordinates do not tear.
    Welded,
    /// The mesh as it is given.
    Apart,
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

/// Settings of a solve; [`Settings::default`] is the house default, [`Settings::paper`] the paper's preset.
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
    /// First state.
    pub start: Start,
    /// How firmly pins and moved handles hold.
    pub pin_hold: PinHold,
    /// What stays smooth around a pin.
    pub disc: Disc,
    /// Pins outside the box.
    pub outside_pins: OutsidePins,
    /// Folds.
    pub guard: Guard,
    /// Vertices at equal places.
    pub equal_vertices: EqualVertices,
    /// Most linear solves.
    pub iteration_limit: usize,
    /// Stop when no handle moves farther than this part of the box diagonal; 0 runs to the limit.
    pub tolerance: f64,
    /// Previous steps that Anderson acceleration looks at, up to the Newton steps at the end (docs/METHOD.md, "Convergence");
    /// 0: the plain local-global iteration, without either.
    pub acceleration: usize,
}

impl Settings {
    /// λgr of [`Regularizer::Bend`] in dimensionless units, tuned on poses (docs/METHOD.md).
    pub const BEND: f64 = 3e-5;
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
            disc: Disc { radius: 0.0, weight: 0.0 },
            acceleration: 0,
            ..Self::default()
        }
    }

    /// The same settings with another regulariser, at the weight that suits it.
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

    /// The same settings with a lattice that resists bending more (above 1) or less: the regulariser's weight times the
    /// cube of `stiffness`, so that 1 to 10 leads from shapes that follow each pin to one smooth sweep.
    #[must_use]
    pub fn with_stiffness(mut self, stiffness: f64) -> Self {
        self.lambdas.regularizer *= stiffness.powi(3);
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
            disc: Disc { radius: 0.05, weight: 100.0 },
            outside_pins: OutsidePins::Nearest,
            guard: Guard::Report,
            equal_vertices: EqualVertices::Welded,
            iteration_limit: 200,
            tolerance: 1e-6,
            acceleration: 5,
        }
    }
}
