//! The command line: parses arguments, runs one of the library's operations, prints the result, returns an exit code.
//!
//! Exit codes: 0 success, 1 some frames failed or were not reached, 2 bad input or usage.

/// Like the standard macro, but escapes control characters, since output meant for people may contain text from files.
/// Used by all modules of the command line; JSON is written as bytes instead.
macro_rules! writeln {
    ($out:expr, $($words:tt)*) => {
        $out.write_fmt(format_args!("{}\n", crate::spelling::escaped(&format!($($words)*))))
    };
}

mod args;
mod bake;
mod check;
mod compare;
mod devices;
#[cfg(feature = "editor")]
mod edit;
mod export;
mod fit;
mod frames;
mod info;
mod job;
mod layer_notes;
mod man;
mod new;
mod outcome;
mod outputs;
mod pick;
mod progress;
mod render;
mod report;
mod resize;
mod shared_args;
mod solve;
mod transfer;
mod warnings;
mod warp;
mod warp_args;

pub(crate) use args::Args;

use crate::memory;
use crate::shot::ShotError;
use args::Command;
use clap::{CommandFactory, Parser};
use outcome::{Outcome, OutputCutOff, code_of, in_words, is_broken_pipe};
use std::ffi::OsString;
use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;

/// Runs the program with the process's arguments.
#[must_use]
pub fn main() -> ExitCode {
    ExitCode::from(main_with(std::env::args_os()))
}

/// Runs the program with other arguments, the first of which is its name; returns the exit code. Usage errors, `--help`
/// and `--version` end the process.
#[must_use]
pub(crate) fn main_with(args: impl IntoIterator<Item = OsString>) -> u8 {
    let args = Args::parse_from(args);
    log_to_stderr(args.verbose);
    args.max_memory.into_iter().for_each(memory::set_limit);
    let outcome = run(args.command).and_then(|outcome| {
        io::stdout().flush().map_err(OutputCutOff)?;
        Ok(outcome)
    });
    match outcome {
        Ok(outcome) => outcome.code(),
        Err(error) if is_broken_pipe(&error) => 0,
        Err(error) => {
            report_error(&error);
            code_of(&error)
        }
    }
}

fn run(command: Command) -> anyhow::Result<Outcome> {
    match command {
        Command::Render(args) => render::run(&args),
        Command::Warp(args) => warp::run(&args),
        Command::Bake(args) => bake::run(&args),
        Command::Check(args) => check::run(&args),
        Command::New(args) => new::run(&args),
        Command::Pick(args) => pick::run(&args),
        #[cfg(feature = "editor")]
        Command::Edit(args) => edit::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Job(args) => job::run(&args),
        Command::Solve(args) => solve::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Fit(args) => fit::run(&args),
        Command::Transfer(args) => transfer::run(&args),
        Command::Resize(args) => resize::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Devices => devices::run(),
        Command::Completions { shell } => {
            // Buffered, because the generator panics if the reader hangs up.
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Args::command(), "pinwarp", &mut script);
            io::stdout().write_all(&script)?;
            Ok(Outcome::Complete)
        }
        Command::Man(args) => man::run(&args),
    }
}

/// Prints an error; a shot's faults take one line each.
fn report_error(error: &anyhow::Error) {
    let lines: Vec<String> = match error.downcast_ref::<ShotError>() {
        Some(ShotError::Many(faults)) => faults.iter().map(ToString::to_string).collect(),
        _ => vec![in_words(error)],
    };
    let mut out = io::stderr().lock();
    for (number, line) in lines.iter().enumerate() {
        let head = if number == 0 { "pinwarp: error: " } else { "" };
        let _ = writeln!(out, "{head}{line}");
    }
}

/// Sends the library's log to stderr: warnings; with -v information, with -vv everything.
fn log_to_stderr(verbose: u8) {
    let level = match verbose {
        0 => tracing::Level::WARN,
        1 => tracing::Level::INFO,
        _ => tracing::Level::TRACE,
    };
    let is_colored = io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let log = tracing_subscriber::fmt().with_max_level(level).with_ansi(is_colored);
    log.with_writer(io::stderr).without_time().init();
}
