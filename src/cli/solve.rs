//! `pinwarp solve`.

use super::Outcome;
use super::args::SolveArgs;
use crate::image::replace_text;
use crate::solve::problem;
use std::io::Write;

pub(super) fn run(args: &SolveArgs) -> anyhow::Result<Outcome> {
    let result = problem::run_file(&args.problem)?;
    let text = serde_json::to_string(&result)?;
    match &args.output {
        Some(path) => replace_text(path, &(text + "\n"))?,
        None => writeln!(std::io::stdout(), "{text}")?,
    }
    Ok(Outcome::Complete)
}
