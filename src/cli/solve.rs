//! `pinwarp solve`: solves a problem file.
//!
//! In: JSON. Out: JSON, to a file or standard output.

use super::args::SolveArgs;
use super::outcome::Outcome;
use super::outputs;
use crate::files::GENERATOR;
use crate::image::replace_text;
use crate::solve::problem_file::{self, ResultFile};
use serde::Serialize;
use std::io::Write;

/// The result with the program that wrote it.
#[derive(Serialize)]
struct Written {
    generator: &'static str,
    #[serde(flatten)]
    result: ResultFile,
}

pub(super) fn run(args: &SolveArgs) -> anyhow::Result<Outcome> {
    if let Some(path) = &args.output {
        outputs::allow(&outputs::inputs_of([&args.problem]), path, args.overwrite)?;
    }
    let result = problem_file::run_file(&args.problem)?;
    let text = serde_json::to_string(&Written { generator: GENERATOR, result })?;
    match &args.output {
        Some(path) => replace_text(path, &(text + "\n"))?,
        None => writeln!(std::io::stdout(), "{text}")?,
    }
    Ok(Outcome::Complete)
}
