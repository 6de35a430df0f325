//! pinwarp warps animated glTF scenes and finished frames with pins placed on the screen.
//!
//! The stages are listed in data-flow order; each is a function from plain data to plain data:
//!
//! ```text
//!  scene.glb ─load─▶ Scene ─pose(time)─▶ Pose ─project(camera)─▶ ScreenMesh ─┐
//!  shot.toml ─read─▶ Shot ──keys at a time──▶ PinTargets ────────────────────┤
//!                                                                            ▼
//!  frame.0101.exr ◀─write─ Frame ◀─raster─ Geometry ◀─assemble─ Lattice ◀─ solve ──▶ SolveReport
//!                                                                 │
//!  lattice.json, Nuke, Blender, glTF, After Effects ◀─export──────┤
//!                                                                 ▼
//!  warped.0101.exr ◀─write─ Plate ◀─composite─ warp ◀─ WarpMap ◀─ Field
//!                                                ▲         ▲
//!  plate.0101.exr ─read─▶ Plate ─────────────────┘         └◀─▶ STMap
//! ```
//!
//! The method is lp-FFD: Fukusato, Maejima and Igarashi, "Locality-Preserving Free-Form
//! Deformation", 2024, <https://arxiv.org/abs/2405.07450>. `docs/METHOD.md` maps its equations to files.

// Tests may panic; the program returns errors, or states the violated invariant with `expect`.
#![deny(clippy::panic, clippy::unwrap_used)]
// Each front end is a feature, and what only some of them use is built with these alone. Tests are built with all of it.
#![cfg_attr(
    all(test, not(all(feature = "cli", feature = "editor", feature = "ofx", feature = "python"))),
    allow(dead_code, unused_imports, reason = "front ends that are not built call it")
)]

pub mod space;

mod disjoint_sets;
mod files;
mod key_fault;
mod simd;
mod smoothstep;
mod spelling;

pub mod memory;

pub mod scene;

pub mod pose;

pub mod screen;

pub mod lattice;

pub mod shot;

pub mod solve;

pub mod raster;

pub mod plate;

pub mod image;

pub mod export;

pub mod compare;

pub mod pipeline;

pub mod live;

#[cfg(feature = "editor")]
#[cfg_attr(not(any(test, feature = "cli")), expect(dead_code, reason = "the program opens the window"))]
mod edit;

#[cfg(feature = "cli")]
pub mod cli;

#[cfg(feature = "ofx")]
pub mod ofx;

#[cfg(feature = "python")]
mod python;

/// Tests outside `src/` name the crate as its users do.
#[cfg(test)]
extern crate self as pinwarp;

#[cfg(test)]
#[path = "../tests/internal.rs"]
mod internal;
