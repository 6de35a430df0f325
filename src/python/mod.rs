//! The Python package: the library for scripts, pipelines and notebooks, with NumPy arrays for pixels and points.
//!
//! In: Python's values. Out: what the library makes of them. Nothing is computed here; what the library computes is computed
//! on a thread of its own, without Python's lock, while the calling thread passes on progress, asks for cancellation and
//! sees Ctrl-C.
//!
//! ```text
//! numpy ─arrays, image─▶ plain data ─work─▶ the library ─▶ plain data ─arrays, frame─▶ numpy
//! ```
//!
//! `docs/PYTHON.md` shows how it is used, `src/python/pinwarp/` holds what is written in Python.

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
