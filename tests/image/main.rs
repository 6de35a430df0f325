//! Frames to files and back.

mod files;
mod support;
mod values;
