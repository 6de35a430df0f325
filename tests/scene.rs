//! Loading and posing of glTF scenes: sample files of others, small files written here, and damaged ones.

#[path = "scene/access.rs"]
mod access;
#[path = "scene/animation.rs"]
mod animation;
#[path = "scene/assets.rs"]
mod assets;
#[path = "scene/attributes.rs"]
mod attributes;
#[path = "scene/build.rs"]
mod build;
#[path = "scene/damage.rs"]
mod damage;
#[path = "scene/extensions.rs"]
mod extensions;
#[path = "scene/files.rs"]
mod files;
#[path = "scene/materials.rs"]
mod materials;
