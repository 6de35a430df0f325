//! Writes the warped scene as a .glb file: deformed meshes become morph targets, one per frame; everything else is kept.
//!
//! In: the packed file of a scene, and its deformed meshes. Out: the bytes of a .glb file (glTF 2.0, section 4).

#[cfg(any(test, feature = "cli"))]
mod baked;
#[cfg(any(test, feature = "cli"))]
mod buffer;
#[cfg(any(test, feature = "cli"))]
mod cards;
#[cfg(any(test, feature = "cli"))]
mod clip;
mod container;
#[cfg(any(test, feature = "cli"))]
mod mesh;
#[cfg(any(test, feature = "cli"))]
mod warped;

#[cfg(any(test, feature = "cli"))]
pub(crate) use baked::{AddedCamera, NodeMotion, SampledNode};
#[cfg(any(test, feature = "cli"))]
pub(crate) use baked::{BakedNode, BakedPart, BakedScene, BakedShape};

#[cfg(any(test, feature = "cli"))]
pub(crate) use cards::packed_cards;
#[cfg(any(test, feature = "editor"))]
pub(crate) use container::packed_glb;
#[cfg(any(test, feature = "cli"))]
pub(crate) use warped::glb;
