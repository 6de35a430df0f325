//! Stage 9: solved lattices over time travel to other shots and programs.
//!
//! In: lattices. Out: files. Lattice files are read back, too: see [`LatticeFile`].

pub mod blender;
mod error;
pub mod gltf;
mod lattice_file;
mod raw;

pub use error::ExportError;
pub use lattice_file::{LatticeFile, LatticeTrack, Track, lattice_at};
