//! Stage 9: exports animated lattices to other shots and programs.
//!
//! In: lattices. Out: files. Lattice files can also be read: see [`LatticeFile`].

mod after_effects;
pub mod blender;
mod error;
pub mod gltf;
mod landmarks;
mod lattice_branches;
mod lattice_file;
pub mod nuke;
mod raw;

pub(crate) use after_effects::{DisplacementNote, displacement, greatest_offset};
pub use error::ExportError;
pub(crate) use landmarks::LandmarkUnit;
pub use landmarks::{Landmark, Landmarks};
pub use lattice_branches::{LatticeBranch, LatticeBranches};
pub use lattice_file::{LatticeFile, LatticeTrack, Track, lattice_at};
