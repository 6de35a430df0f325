//! Frames to files and back.

#[path = "../support/assets.rs"]
mod assets;
mod files;
mod foreign;
mod pictures;
mod plates;
#[path = "../support/python.rs"]
mod python;
mod support;
mod values;
