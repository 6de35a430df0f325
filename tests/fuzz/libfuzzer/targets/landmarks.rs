//! Pairs of landmarks for `pinwarp fit`, as JSON or CSV.
#![no_main]
#![allow(dead_code, reason = "each target uses one of the readers")]

mod harness;
#[path = "../../readers.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    harness::read(data, if data.starts_with(b"{") { "json" } else { "csv" }, readers::read_pairs);
});
