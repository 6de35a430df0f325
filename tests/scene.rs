//! Loading and posing of glTF scenes: sample files of others, small files written here, and damaged ones.

#[path = "scene/assets.rs"]
mod assets;
