//! Lattice files: the lattices of a shot's layers over its frames.
//!
//! In: a path, or lattices by layer and frame. Out: lattices; files as written by `pinwarp export --to lattice-json`.

use super::failure::Failure;
use super::lattice::{Handles, Lattice};
use crate::export::{self, LatticeTrack, Track};
use crate::spelling;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Solved lattices of layers by frame, as written by `pinwarp export --to lattice-json`.
///
/// lattices: {layer: {frame: Lattice}}. All lattices of a layer have the same dims, basis and space.
/// frame_aspect: width of the frame in frame heights.
/// rate: frames per second.
///
/// Branches of branching lattices are kept when a file is read and written; `lattice` returns the largest branch.
#[pyclass(frozen, module = "pinwarp")]
pub(super) struct LatticeFile {
    file: export::LatticeFile,
    warnings: Vec<(i32, String)>,
}

#[pymethods]
impl LatticeFile {
    #[new]
    #[pyo3(signature = (lattices, frame_aspect, rate=24.0))]
    fn new(lattices: BTreeMap<String, BTreeMap<i32, Lattice>>, frame_aspect: f64, rate: f64) -> Result<Self, Failure> {
        for (key, value) in [("frame_aspect", frame_aspect), ("rate", rate)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(Failure::argument(key, format!("is {value}"), "give a number above 0"));
            }
        }
        let layers = lattices.into_iter().map(|(name, frames)| track(name, frames)).collect::<Result<_, _>>()?;
        Ok(Self::of(export::LatticeFile { frame_aspect, rate, layers }, Vec::new()))
    }

    /// Reads a lattice file (.json).
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> Result<Self, Failure> {
        py.detach(|| Ok(Self::of(export::LatticeFile::read(&path)?, Vec::new())))
    }

    /// Writes the file atomically; an existing file is replaced.
    fn write(&self, py: Python<'_>, path: PathBuf) -> Result<(), Failure> {
        py.detach(|| Ok(self.file.write(&path)?))
    }

    /// Names of the layers.
    #[getter]
    fn layers(&self) -> Vec<String> {
        self.file.layers.iter().map(|layer| layer.name.clone()).collect()
    }

    /// Width of the frame in frame heights.
    #[getter]
    const fn frame_aspect(&self) -> f64 {
        self.file.frame_aspect
    }

    /// Frames per second.
    #[getter]
    const fn rate(&self) -> f64 {
        self.file.rate
    }

    /// The warnings that a render of these frames would give, as (frame, text); empty unless `Shot.lattices` returned the file.
    #[getter]
    fn warnings(&self) -> Vec<(i32, String)> {
        self.warnings.clone()
    }

    /// Returns the frames of a layer in order; the layer may be omitted if it is the only one.
    #[pyo3(signature = (layer=None))]
    fn frames(&self, layer: Option<&str>) -> Result<Vec<i32>, Failure> {
        Ok(match &self.layer(layer)?.track {
            Track::Screen(lattices) => lattices.keys().copied().collect(),
            Track::World(lattices) => lattices.keys().copied().collect(),
        })
    }

    /// Returns the lattice of a layer at a frame. Between two frames it is interpolated from both; before the first and after the last
    /// frame the nearest one is used. The layer may be omitted if it is the only one.
    #[pyo3(signature = (frame, layer=None))]
    fn lattice(&self, frame: f64, layer: Option<&str>) -> Result<Lattice, Failure> {
        if !frame.is_finite() {
            return Err(Failure::argument("frame", format!("is {frame}"), "give a finite number"));
        }
        Ok(Lattice(match &self.layer(layer)?.track {
            Track::Screen(lattices) => Handles::Screen(export::lattice_at(lattices, frame)),
            Track::World(lattices) => Handles::World(export::lattice_at(lattices, frame)),
        }))
    }

    fn __repr__(&self) -> String {
        format!("<LatticeFile of {}>", spelling::pluralised(self.file.layers.len(), "layer", "layers"))
    }
}

impl LatticeFile {
    pub(super) const fn of(file: export::LatticeFile, warnings: Vec<(i32, String)>) -> Self {
        Self { file, warnings }
    }

    fn layer(&self, name: Option<&str>) -> Result<&LatticeTrack, Failure> {
        let names = || self.file.layers.iter().map(|layer| layer.name.as_str());
        match (name, self.file.layers.as_slice()) {
            (None, [only]) => Ok(only),
            (None, _) => Err(Failure::argument("layer", "is not given", spelling::list(names()))),
            (Some(name), layers) => layers.iter().find(|layer| layer.name == name).ok_or_else(|| {
                Failure::argument("layer", format!("there is no layer {name:?}"), spelling::hint(name, names()))
            }),
        }
    }
}

/// Creates the track of one layer.
fn track(name: String, frames: BTreeMap<i32, Lattice>) -> Result<LatticeTrack, Failure> {
    let key = format!("lattices[{name:?}]");
    let Some(first) = frames.values().next().cloned() else {
        return Err(Failure::argument(key, "is empty", "give at least one frame"));
    };
    let (mut screen, mut world) = (BTreeMap::new(), BTreeMap::new());
    for (frame, Lattice(handles)) in frames {
        match (handles, &first.0) {
            (Handles::Screen(own), Handles::Screen(other))
                if (own.grid.dims, own.grid.basis) == (other.grid.dims, other.grid.basis) =>
            {
                screen.insert(frame, own);
            }
            (Handles::World(own), Handles::World(other))
                if (own.grid.dims, own.grid.basis) == (other.grid.dims, other.grid.basis) =>
            {
                world.insert(frame, own);
            }
            _ => {
                let what = format!("has another space, dims or basis in frame {frame} than before");
                return Err(Failure::argument(key, what, "give lattices of one kind"));
            }
        }
    }
    let track = if world.is_empty() { Track::Screen(screen) } else { Track::World(world) };
    let (placements, branches, wholes) = Default::default();
    Ok(LatticeTrack { name, track, placements, branches, has_branches_in_scene: false, wholes })
}
