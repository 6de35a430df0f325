//! `pinwarp bake`: solves the layers that are solved over time, before their frames are rendered.
//!
//! In: a shot. Out: trajectories in a folder next to its frames; progress events.

use super::args::BakeArgs;
use super::outcome::Outcome;
use super::progress::EventPrinter;
use super::render::cancel_on_interrupt;
use crate::image::SequencePath;
use crate::pipeline::{Keeping, PreparedShot, solve_ahead};

pub(super) fn run(args: &BakeArgs) -> anyhow::Result<Outcome> {
    let mut shot = args.outside.read(&args.shot)?;
    args.camera.choose(&mut shot);
    let output = args.output.clone().unwrap_or_else(|| shot.output.path.clone());
    SequencePath::parse(&output)?;
    let prepared = PreparedShot::new(shot)?.keeping_trajectories([output.as_path()], Keeping::Write);
    // Until here Ctrl-C ends the program at once: nothing is written yet.
    let cancel = cancel_on_interrupt()?;
    let printer = EventPrinter::new(args.progress.into());
    let summary = solve_ahead(&prepared, &cancel, &|event| printer.print_bake(&event));
    printer.end()?;
    let is_complete = summary.failed == 0 && !summary.is_cancelled;
    Ok(if is_complete { Outcome::Complete } else { Outcome::Partial })
}
