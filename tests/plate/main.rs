//! The plate stage: fields, maps, filters and meanings.

#[path = "../support/assets.rs"]
mod assets;
mod data;
mod layers;
mod map;
mod meanings;
mod support;
mod warp;
