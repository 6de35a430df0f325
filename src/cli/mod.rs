//! The command line: arguments in, one of the library's jobs run, words and an exit code out.
//!
//! Exit codes: 0 all good, 1 some frames failed or were not reached, 2 bad input or usage.

mod args;
mod check;
mod compare;
mod devices;
mod export;
mod fit;
mod frames;
mod new;
mod pick;
mod progress;
mod render;
mod resize;
mod solve;
mod transfer;
mod warp;
mod warp_args;

pub use args::Args;

use crate::pipeline::Existing;
use anyhow::bail;
use args::Command;
use clap::{CommandFactory, Parser};
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;

/// What a command ends with, when it does not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// Everything asked for was done.
    Complete,
    /// Some frames are missing.
    Partial,
}

/// Runs the program on its own arguments.
#[must_use]
pub fn main() -> ExitCode {
    let args = Args::parse();
    log_to_stderr(args.verbose);
    match run(args.command) {
        Ok(Outcome::Complete) => ExitCode::SUCCESS,
        Ok(Outcome::Partial) => ExitCode::from(1),
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(io::stderr(), "pinwarp: error: {}", in_words(&error));
            ExitCode::from(2)
        }
    }
}

fn run(command: Command) -> anyhow::Result<Outcome> {
    match command {
        Command::Render(args) => render::run(&args),
        Command::Warp(args) => warp::run(&args),
        Command::Check(args) => check::run(&args),
        Command::New(args) => new::run(&args),
        Command::Pick(args) => pick::run(&args),
        Command::Solve(args) => solve::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Fit(args) => fit::run(&args),
        Command::Transfer(args) => transfer::run(&args),
        Command::Resize(args) => resize::run(&args),
        Command::Devices => devices::run(),
        Command::Completions { shell } => {
            // Into memory first: the generator does not survive a reader that hangs up.
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Args::command(), "pinwarp", &mut script);
            io::stdout().write_all(&script)?;
            Ok(Outcome::Complete)
        }
        Command::Man => {
            clap_mangen::Man::new(Args::command()).render(&mut io::stdout())?;
            Ok(Outcome::Complete)
        }
    }
}

/// Files are replaced only where the user says so; to resume is not to replace.
fn refuse_existing(path: &Path, existing: impl Into<Existing>) -> anyhow::Result<()> {
    if path.exists() && existing.into() != Existing::Overwrite {
        bail!("{} exists already; use --overwrite to replace it or -o to write another", path.display());
    }
    Ok(())
}

/// Whether a file holds that text already: then there is nothing to replace.
fn holds_text(path: &Path, text: &str) -> bool {
    std::fs::read_to_string(path).is_ok_and(|there| there == text)
}

/// The message, and its causes as far as it does not tell them itself.
fn in_words(error: &anyhow::Error) -> String {
    error
        .chain()
        .skip(1)
        .map(ToString::to_string)
        .fold(error.to_string(), |told, cause| if told.contains(&cause) { told } else { format!("{told}: {cause}") })
}

/// Whoever read our output has seen enough.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .any(|cause| cause.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe))
}

/// Sends the library's log to stderr: warnings, with -v information, with -vv everything.
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
