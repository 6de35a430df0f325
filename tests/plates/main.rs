//! Finished frames through the whole way: real files of other programs, and the geometry path against the plate path.

#[path = "../support/assets.rs"]
mod assets;
#[path = "../support/drawn_girl.rs"]
mod drawn_girl;
#[path = "../support/tiny.rs"]
mod tiny;

mod agreement;
mod branches;
mod clean;
mod fronts;
mod real;
mod shared;
mod stage;
mod triangles;
