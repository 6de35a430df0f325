//! The keys of a problem file as written, and their conversion to settings.
//!
//! In: JSON text. Out: raw keys; names converted to enums and lists to points, with errors that name the key.

use super::error::ProblemError;
use crate::lattice::Basis;
use crate::solve::settings::{
    DuplicateVertices, EdgeWeights, Energy, Lambdas, OutsidePins, PinHold, Regularizer, Sampling, Scaling, Settings,
    Start,
};
use crate::spelling::pluralised;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Keys that the solver ignores.
const SILENT: [&str; 2] = ["note", "expected"];
/// Keys that the solver reads.
const KEYS: [&str; 18] = [
    "name",
    "dims",
    "bbox",
    "basis",
    "weights",
    "form",
    "lambdas",
    "regulariser",
    "regularizer",
    "vertices",
    "triangles",
    "strokes",
    "parts",
    "poses",
    "samples",
    "pins",
    "handles",
    "iterations",
];

/// Maximum number of iterations.
const MAX_ITERATIONS: usize = 100_000;

/// A problem file.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct ProblemFile {
    pub(super) name: Option<String>,
    dims: Option<Vec<usize>>,
    pub(super) bbox: Option<[Vec<f64>; 2]>,
    basis: Option<String>,
    weights: Option<String>,
    form: Option<String>,
    pub(super) lambdas: Option<RawLambdas>,
    #[serde(alias = "regularizer")]
    regulariser: Option<String>,
    pub(super) vertices: Vec<Vec<f64>>,
    #[serde(default)]
    pub(super) triangles: Vec<[u32; 3]>,
    /// Polylines as lists of vertex indices.
    #[serde(default)]
    pub(super) strokes: Vec<Vec<u32>>,
    /// Samples as position and area: x, y(, z), a.
    pub(super) samples: Option<Vec<Vec<f64>>>,
    #[serde(default)]
    pub(super) pins: Vec<RawPin>,
    #[serde(default)]
    pub(super) handles: Vec<RawHandle>,
    /// Consecutive triangles with their colours, for pictures.
    #[serde(default)]
    pub(super) parts: Vec<RawPart>,
    /// Named sets of pins. In a file without `pins` the first set takes their place.
    #[serde(default)]
    pub(super) poses: Vec<RawPose>,
    pub(super) iterations: Option<usize>,
    #[serde(flatten)]
    others: BTreeMap<String, serde_json::Value>,
}

/// Weights λ of the terms, by default those of the paper.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLambdas {
    ml: Option<f64>,
    mp: Option<f64>,
    gp: Option<f64>,
    gr: Option<f64>,
}

/// A pin, given by exactly one of `vertex`, `point`, or `triangle` with `bary`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPin {
    pub(super) vertex: Option<usize>,
    pub(super) point: Option<Vec<f64>>,
    pub(super) triangle: Option<usize>,
    pub(super) bary: Option<[f64; 3]>,
    pub(super) target: Vec<f64>,
}

/// Consecutive triangles of one colour.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPart {
    pub(super) name: String,
    /// Colour as `#rrggbb`.
    pub(super) color: String,
    /// Number of triangles.
    pub(super) triangles: usize,
}

/// A named set of pins.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPose {
    pub(super) name: String,
    pub(super) pins: Vec<RawPin>,
}

/// A moved handle.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawHandle {
    pub(super) index: usize,
    pub(super) target: Vec<f64>,
}

impl ProblemFile {
    /// Reads the keys; fails on an unknown key that resembles a known one.
    pub(super) fn parse(text: &str) -> Result<Self, ProblemError> {
        let mut file: Self = serde_json::from_str(text)?;
        for key in file.others.keys().filter(|key| !SILENT.contains(&key.as_str())) {
            let near = KEYS.iter().find(|known| strsim::jaro_winkler(known, key) > 0.85);
            if let Some(near) = near {
                return Err(ProblemError::key(key, "is not a key of problem files", format!("did you mean `{near}`?")));
            }
        }
        if let (true, Some(first)) = (file.pins.is_empty(), file.poses.first()) {
            file.pins = first.pins.clone();
        }
        Ok(file)
    }

    /// Number of coordinates: the length of `dims`, or that of the first vertex if there is no `dims`.
    pub(super) fn axes(&self) -> Result<usize, ProblemError> {
        let axes = self.dims.as_ref().map_or(self.vertices.first().map_or(2, Vec::len), Vec::len);
        if axes == 2 || axes == 3 {
            return Ok(axes);
        }
        Err(ProblemError::key("dims", format!("has {}", pluralised(axes, "entry", "entries")), "give two or three"))
    }

    /// Number of handles per axis; by default ten in 2D, five in 3D.
    pub(super) fn dims<const D: usize>(&self) -> [usize; D] {
        let least = if D == 2 { 10 } else { 5 };
        std::array::from_fn(|axis| self.dims.as_ref().map_or(least, |dims| dims[axis]))
    }

    /// Basis of the lattice.
    pub(super) fn basis(&self) -> Result<Basis, ProblemError> {
        let Some(name) = self.basis.as_deref() else { return Ok(Basis::default()) };
        let named = serde_json::from_value(serde_json::Value::from(name));
        named.map_err(|_| unknown("basis", name, "bernstein, bspline, bilinear or barytri"))
    }

    fn energy(&self) -> Result<Energy, ProblemError> {
        match self.form.as_deref() {
            None | Some("quad" | "area") => Ok(Energy::Area),
            Some("edge") => Ok(Energy::Edge),
            Some("vrd" | "vertex") => Ok(Energy::Vertex),
            Some("elem" | "element") => Ok(Energy::Element),
            Some("rims" | "spokes-and-rims") => Ok(Energy::SpokesAndRims),
            Some("stroke") => Ok(Energy::Stroke),
            Some(other) => Err(unknown("form", other, "edge, vrd, elem, rims, quad or stroke")),
        }
    }

    fn regularizer(&self) -> Result<Regularizer, ProblemError> {
        match self.regulariser.as_deref() {
            None | Some("bend") => Ok(Regularizer::Bend),
            Some("gr" | "rest") => Ok(Regularizer::Rest),
            Some("noh") => Ok(Regularizer::Noh),
            Some("affproj" | "affine") => Ok(Regularizer::Affine),
            Some(other) => Err(unknown("regulariser", other, "gr, noh, affproj or bend")),
        }
    }

    /// Edge weights; the names of weights of other forms are accepted and ignored.
    fn edge_weights(&self, energy: Energy) -> Result<EdgeWeights, ProblemError> {
        match self.weights.as_deref() {
            None | Some("uniform") => Ok(EdgeWeights::Uniform),
            Some("cot") => Ok(EdgeWeights::Cot),
            Some("tri" | "area") if !matches!(energy, Energy::Edge | Energy::Vertex) => Ok(EdgeWeights::Uniform),
            Some(other) => Err(unknown("weights", other, "uniform or cot")),
        }
    }

    /// Converts the keys to settings: `lambdas` selects plain sums, `iterations` an exact number of plain steps.
    pub(super) fn settings(&self) -> Result<Settings, ProblemError> {
        let energy = self.energy()?;
        let weights = self.edge_weights(energy)?;
        let mut settings =
            Settings { energy, weights, duplicate_vertices: DuplicateVertices::Separate, ..Settings::default() };
        if self.lambdas.is_some() {
            settings.scaling = Scaling::Plain;
            settings.sampling = Sampling::Centroids;
            settings.start = Start::Rest;
            settings.pin_hold = PinHold::Soft;
            settings.disc = Settings::paper().disc;
            settings.outside_pins = OutsidePins::Extended;
            settings.lambdas = Settings::paper().lambdas;
        }
        settings = settings.with_regularizer(self.regularizer()?);
        if let Some(raw) = self.lambdas {
            let given = settings.lambdas;
            settings.lambdas = Lambdas {
                shape: raw.ml.unwrap_or(given.shape),
                pins: raw.mp.unwrap_or(given.pins),
                handles: raw.gp.unwrap_or(given.handles),
                regularizer: raw.gr.unwrap_or(given.regularizer),
            };
        }
        if let Some(iterations) = self.iterations {
            if iterations > MAX_ITERATIONS {
                let hint = format!("give at most {MAX_ITERATIONS}");
                return Err(ProblemError::key("iterations", format!("is {iterations}"), hint));
            }
            settings.iteration_limit = iterations;
            settings.acceleration = 0;
            settings.tolerance = -1.0;
        }
        Ok(settings)
    }
}

/// Converts a list to a point, or returns an error that names the key.
pub(super) fn point<const D: usize>(values: &[f64], key: impl Fn() -> String) -> Result<[f64; D], ProblemError> {
    <[f64; D]>::try_from(values).map_err(|_| {
        let given = pluralised(values.len(), "coordinate", "coordinates");
        ProblemError::key(key(), format!("has {given}"), format!("give {D} coordinates, one per entry of `dims`"))
    })
}

fn unknown(key: &str, value: &str, known: &str) -> ProblemError {
    ProblemError::key(key, format!("\"{value}\" is not known"), format!("use {known}"))
}
