//! Stage 9: exports animated lattices to other shots and programs.
//!
//! In: lattices. Out: files. Lattice files can also be read: see [`LatticeFile`].

mod after_effects;
pub(crate) mod blender;
mod error;
pub(crate) mod gltf;
mod landmarks;
mod lattice_branches;
mod lattice_file;
pub(crate) mod nuke;
mod raw;

pub(crate) use after_effects::{DisplacementNote, displacement, greatest_offset};
pub use error::ExportError;
pub(crate) use landmarks::LandmarkUnit;
pub use landmarks::{Landmark, Landmarks};
pub(crate) use lattice_branches::LatticeBranch;
pub use lattice_branches::LatticeBranches;
pub use lattice_file::{LatticeFile, LatticeTrack, Track, lattice_at};
