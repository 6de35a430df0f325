//! What a test run leaves out, said where everybody sees it.
//!
//! `PINWARP_SKIPPED` names a file that collects a line for each skip of all test programs; `.ci/run` counts them. A test that
//! cannot run here calls [`skip`] and returns: `tests/architecture.rs` refuses other ways.

use std::io::Write;

/// Says what is not tested. Test harnesses capture what macros print, so this goes past them.
pub(crate) fn skip(what: &str) {
    let _ = writeln!(std::io::stderr().lock(), "SKIPPED: {what}");
    if let Some(path) = std::env::var_os("PINWARP_SKIPPED") {
        let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
        let written = file.and_then(|mut file| file.write_all(format!("{what}\n").as_bytes()));
        written.expect("PINWARP_SKIPPED names a file that can be written");
    }
}
