//! Frames to files and back.

#[path = "../support/assets.rs"]
mod assets;
mod files;
mod pictures;
mod plates;
mod support;
mod values;
