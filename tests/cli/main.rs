//! The program, run as a user runs it: what it says, what it leaves behind, and how it exits.
#![allow(clippy::duplicate_mod, reason = "modules share what is in support/, each with what it needs of it")]

#[path = "../support/python.rs"]
mod python;
#[path = "../support/skip.rs"]
mod skip;
#[path = "../support/tiny.rs"]
mod tiny;

mod bake;
mod compare;
mod disks;
mod existing;
mod export;
mod farm;
mod fills;
mod fit;
mod guard;
mod help;
mod hints;
mod info;
mod lattices;
mod layer_lists;
mod maps;
mod names;
mod options;
mod pins;
mod resume;
mod scenes;
mod shots;
mod stopping;
mod support;
mod tools;
mod transfer;
mod warps;
mod words;
mod worlds;
