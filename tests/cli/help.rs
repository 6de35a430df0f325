//! The help of every command as it was when somebody last read it: `help/`, one file for each command.
//!
//! `UPDATE=1` writes them anew.
#![cfg(feature = "editor")]

use crate::support::{Bench, PROGRAM};
use std::path::{Path, PathBuf};

fn stored(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/help").join(format!("{name}.txt"))
}

/// Help at a width of 100 columns, on any terminal.
fn help(bench: &Bench, command: Option<&str>, flag: &str) -> String {
    let mut program = bench.command(PROGRAM);
    program.env("COLUMNS", "100").args(command).arg(flag);
    let said = bench.checked(program.output().expect("the program starts")).says(0, &[]).stdout;
    let called: Vec<&str> = ["pinwarp"].into_iter().chain(command).chain([flag]).collect();
    format!("$ {}\n{said}", called.join(" "))
}

#[test]
fn help_is_as_it_was() {
    let bench = Bench::new();
    let names = super::words::commands(&bench);
    let is_update = std::env::var_os("UPDATE").is_some();
    let mut different = Vec::new();
    for command in std::iter::once(None).chain(names.iter().map(|name| Some(name.as_str()))) {
        let name = command.unwrap_or("pinwarp");
        let found = [help(&bench, command, "-h"), help(&bench, command, "--help")].join("\n");
        if is_update {
            std::fs::write(stored(name), &found).expect("the folder can be written to");
        }
        let expected = std::fs::read_to_string(stored(name)).unwrap_or_default();
        // The first line that differs says where to look.
        let mut lines = found.lines().zip(expected.lines().chain(std::iter::repeat("")));
        let line = lines.find(|(found, expected)| found != expected);
        if found != expected {
            different.push(format!("{}: {line:?}", stored(name).display()));
        }
    }
    assert!(different.is_empty(), "UPDATE=1 writes the help anew, for you to read:\n{}", different.join("\n"));
    for entry in std::fs::read_dir(stored("x").with_file_name("")).expect("the folder exists").flatten() {
        let name = entry.path().file_stem().unwrap_or_default().to_string_lossy().into_owned();
        assert!(name == "pinwarp" || names.contains(&name), "there is no command {name}");
    }
}
