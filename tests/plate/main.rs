//! The plate stage: fields, maps, filters and semantics.

#[path = "../support/assets.rs"]
mod assets;
mod data;
mod fills;
mod filters;
mod layers;
mod map;
mod map_folds;
#[path = "../support/python.rs"]
mod python;
mod semantics;
mod stmap;
mod support;
mod warp;
