//! Whole renders through the library: the same bytes whatever the order, pins that move what they should and no more,
//! motion vectors that point where things go.

#[path = "../support/assets.rs"]
mod assets;
#[path = "../support/bisection.rs"]
mod bisection;
#[path = "../support/python.rs"]
mod python;
#[path = "../support/tiny.rs"]
mod tiny;

mod boxes;
mod branches;
mod cameras;
mod connectivity;
mod crossing_limbs;
mod data;
mod far_apart;
mod faults;
mod layers;
mod lines;
mod mattes;
mod memory;
mod mirrored;
mod motion;
mod normal_maps;
mod own_cameras;
mod picture_cuts;
mod pictures;
mod pins;
mod repeat;
mod selection;
mod shared_cells;
mod stiffness;
mod support;
mod temporal;
mod trajectories;
mod trimmed;
mod winding;
mod world;
