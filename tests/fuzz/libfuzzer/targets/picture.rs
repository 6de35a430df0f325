//! PNG and JPEG files.
#![no_main]
#![allow(dead_code, reason = "each target uses one of the readers")]

mod harness;
#[path = "../../readers.rs"]
mod readers;

/// First bytes of a JPEG file.
const JPEG: &[u8] = &[0xff, 0xd8];

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    harness::read(data, if data.starts_with(JPEG) { "jpg" } else { "png" }, readers::read_image);
});
