//! Stage 3: a [`Pose`](crate::pose::Pose) seen through a camera becomes a [`ScreenMesh`] of projected vertices.
//!
//! Near-plane policy: nothing in front of the near plane exists. Triangles that cross it are clipped before anything
//! else happens (`clip_near`), so every later stage divides by a w that is greater than zero. There is no far plane.

mod bounds;
mod camera;
mod clip;
mod mesh;
mod pick;

pub(crate) use bounds::{Extent, bounds, reach_of_frame};
pub use camera::{Camera, CameraPlacement, Projected};
pub(crate) use camera::{automatic, fit_distance};
pub(crate) use clip::{Corner, clip_near};
pub(crate) use mesh::project;
pub use mesh::{ScreenMesh, ScreenPart, primitive};
pub(crate) use pick::{Hit, pick};
