//! Prepares the warp of a shot for exports and other programs.
//!
//! In: a [`PreparedShot`](crate::pipeline::PreparedShot). Out: lattices per frame, baked meshes, problems, registered pictures.

#[cfg(any(test, feature = "cli"))]
pub(super) mod bake;
#[cfg(any(test, feature = "cli"))]
pub(super) mod lattice_objects;
pub(super) mod lattice_tracks;
#[cfg(any(test, feature = "cli"))]
pub(super) mod layer_problem;
pub(super) mod registration;
