//! OpenEXR files: all parts, channels and attributes.
#![no_main]
#![allow(dead_code, reason = "each target uses one of the readers")]

mod harness;
#[path = "../../readers.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|data: &[u8]| harness::read(data, "exr", readers::read_image));
