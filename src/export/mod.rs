//! Stage 9: exports animated lattices to other shots and programs.
//!
//! In: lattices. Out: files. Lattice files can also be read: see [`LatticeFile`].

#[cfg(any(test, feature = "cli"))]
mod after_effects;
#[cfg(any(test, feature = "cli"))]
pub(crate) mod blender;
mod error;
#[cfg(any(test, feature = "cli", feature = "editor"))]
pub(crate) mod gltf;
mod landmarks;
mod lattice_branches;
mod lattice_file;
#[cfg(any(test, feature = "cli"))]
pub(crate) mod nuke;
mod raw;

#[cfg(any(test, feature = "cli"))]
pub(crate) use after_effects::{DisplacementNote, displacement, greatest_offset};
pub use error::ExportError;
#[cfg(any(test, feature = "cli"))]
pub(crate) use landmarks::LandmarkUnit;
pub use landmarks::{Landmark, Landmarks};
pub(crate) use lattice_branches::LatticeBranch;
pub use lattice_branches::LatticeBranches;
pub use lattice_file::{LatticeFile, LatticeTrack, Track, lattice_at};
