//! The Python package: the library for scripts, pipelines and notebooks, with NumPy arrays for pixels and points.
//!
//! In: Python values. Out: the library's results. Nothing is computed here; the library works on a separate thread
//! without the GIL, while the calling thread reports progress, polls for cancellation and handles Ctrl-C.
//! Usage: `docs/PYTHON.md`. The part written in Python: `src/python/pinwarp/`.

mod arrays;
mod drawer;
mod failure;
mod frame;
mod image;
mod lattice;
mod lattice_file;
mod named;
mod options;
mod pin;
mod program;
mod report;
mod scene;
mod sequence;
mod shot;
mod solve;
mod warp;
mod work;

use pyo3::prelude::*;

/// The compiled part of the package `pinwarp`.
#[pymodule]
fn _pinwarp(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<shot::Shot>()?;
    module.add_class::<sequence::RenderedFrames>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<lattice::Lattice>()?;
    module.add_class::<lattice_file::LatticeFile>()?;
    module.add_class::<pin::Pin>()?;
    module.add_class::<solve::Solution>()?;
    module.add_function(wrap_pyfunction!(solve::solve, module)?)?;
    module.add_function(wrap_pyfunction!(warp::warp, module)?)?;
    module.add_function(wrap_pyfunction!(program::main, module)?)
}
