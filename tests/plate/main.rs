//! The plate stage: fields, maps, filters and meanings.

#[path = "../support/assets.rs"]
mod assets;
mod data;
mod fills;
mod filters;
mod layers;
mod map;
mod map_folds;
mod meanings;
#[path = "../support/python.rs"]
mod python;
mod stmap;
mod support;
mod warp;
