//! Tests of the crate from inside: each module is a folder or file beside this one, and may use what is not public.
//!
//! `src/lib.rs` includes this file in the unit tests of the library; `cargo test --lib internal::edit` runs a part. All
//! these tests share one process: a test that changes what belongs to a process starts one of its own.
#![allow(clippy::duplicate_mod, reason = "modules share what is in support/, each with what it needs of it")]

#[path = "barrier.rs"]
mod barrier;
#[path = "branching.rs"]
mod branching;
#[path = "branching_in_time.rs"]
mod branching_in_time;
#[path = "close_pins.rs"]
mod close_pins;
#[path = "cpu_mattes.rs"]
mod cpu_mattes;
#[path = "cpu_raster.rs"]
mod cpu_raster;
#[path = "cpu_textures.rs"]
mod cpu_textures;
#[path = "drags.rs"]
mod drags;
#[cfg(feature = "editor")]
#[path = "edit/main.rs"]
mod edit;
#[path = "geometry.rs"]
mod geometry;
#[path = "guard.rs"]
mod guard;
#[path = "image/main.rs"]
mod image;
#[path = "literal/main.rs"]
mod literal;
#[path = "live/main.rs"]
mod live;
#[path = "minima.rs"]
mod minima;
#[path = "support/numbers.rs"]
mod numbers;
#[path = "oracle.rs"]
mod oracle;
#[path = "plate/main.rs"]
mod plate;
#[path = "quality.rs"]
mod quality;
#[path = "render/main.rs"]
mod render;
#[path = "robust.rs"]
mod robust;
#[path = "scene.rs"]
mod scene;
#[path = "shot/main.rs"]
mod shot;
#[path = "support/skip.rs"]
pub(crate) mod skip;
#[path = "solver.rs"]
mod solver;
#[path = "solver_pins/main.rs"]
mod solver_pins;
#[path = "support/solving.rs"]
mod solving;
#[path = "space.rs"]
mod space;
#[path = "trajectories.rs"]
mod trajectories;
#[path = "vulkan.rs"]
mod vulkan;
#[path = "whole/main.rs"]
mod whole;
