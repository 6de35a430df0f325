//! The `pinwarp` program: hands its arguments to the library's command line.

// Tests may; the program states its invariants or returns errors.
#![deny(clippy::panic, clippy::unwrap_used)]

use std::process::ExitCode;

fn main() -> ExitCode {
    pinwarp::cli::main()
}
