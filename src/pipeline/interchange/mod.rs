//! Prepares the warp of a shot for exports and other programs.
//!
//! In: a [`PreparedShot`](crate::pipeline::PreparedShot). Out: lattices per frame, baked meshes, problems, registered pictures.

pub(super) mod bake;
pub(super) mod lattice_objects;
pub(super) mod lattice_tracks;
pub(super) mod layer_problem;
pub(super) mod registration;
