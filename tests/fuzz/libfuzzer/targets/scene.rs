//! glTF scenes, binary (GLB): read, and posed at a time of their first animation.
#![no_main]
#![allow(dead_code, reason = "each target uses one of the readers")]

mod harness;
#[path = "../../readers.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|data: &[u8]| harness::read(data, "glb", readers::read_scene));
