//! Problem files of `pinwarp solve`; what can be read is solved.
#![no_main]
#![allow(dead_code, reason = "each target uses one of the readers")]

mod harness;
#[path = "../../readers.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|data: &[u8]| harness::read(data, "json", readers::read_problem));
