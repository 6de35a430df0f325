//! Programs of others, in Python, that check what we write.
//!
//! `PINWARP_PYTHON` names an interpreter that has numpy, OpenImageIO, OpenEXR and cv2 (and bpy, where Blender is asked).
//! Without it tests skip and say so; with `PINWARP_REQUIRE_PYTHON=1` they fail instead, but for modules that
//! `PINWARP_PYTHON_WITHOUT` names (`bpy`).

#[path = "skip.rs"]
mod skip;

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::process::{Command, Output};
use std::sync::{Mutex, PoisonError};

/// What a script prints, run with the modules it needs; `None`, and a skip, where they are not there.
///
/// # Panics
/// Where the script fails, with all that it said.
pub(crate) fn run(modules: &[&str], script: &str, arguments: &[&OsStr]) -> Option<String> {
    let python = python_with(modules)?;
    let output = start(&python, script, arguments).unwrap_or_else(|error| panic!("{python} does not start: {error}"));
    let (out, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "the script failed:\n{out}{said}");
    Some(out.into_owned())
}

/// The interpreter, where there is one and it has the modules.
fn python_with(modules: &[&str]) -> Option<String> {
    let Ok(python) = std::env::var("PINWARP_PYTHON") else { return absent("PINWARP_PYTHON is not set") };
    let known_absent = std::env::var("PINWARP_PYTHON_WITHOUT").unwrap_or_default();
    if let Some(module) = modules.iter().find(|module| known_absent.split(',').any(|absent| absent == **module)) {
        skip::skip(&format!("{module} is not at hand (PINWARP_PYTHON_WITHOUT)"));
        return None;
    }
    // Modules that were imported once need not be again: some take seconds.
    static PRESENT: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let imports: String = modules.iter().map(|module| format!("import {module}\n")).collect();
    let mut present = PRESENT.lock().unwrap_or_else(PoisonError::into_inner);
    if present.contains(&imports) {
        return Some(python);
    }
    match start(&python, &imports, &[]) {
        Ok(output) if output.status.success() => {
            present.insert(imports);
            Some(python)
        }
        Ok(output) => absent(&String::from_utf8_lossy(&output.stderr)),
        Err(error) => absent(&format!("{python} does not start: {error}")),
    }
}

fn start(python: &str, script: &str, arguments: &[&OsStr]) -> std::io::Result<Output> {
    Command::new(python).args(["-c", script]).args(arguments).env("OPENCV_IO_ENABLE_OPENEXR", "1").output()
}

fn absent(why: &str) -> Option<String> {
    let is_required = std::env::var_os("PINWARP_REQUIRE_PYTHON").is_some_and(|value| value == "1");
    assert!(!is_required, "PINWARP_REQUIRE_PYTHON is set, but {why}");
    skip::skip(&format!("no Python with the modules of this test: {why}"));
    None
}
