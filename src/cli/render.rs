//! `pinwarp render`: renders a shot into an EXR sequence.
//!
//! In: a shot and overriding arguments. Out: files; progress events.

use super::args::{DrawArgs, RenderArgs};
use super::outcome::Outcome;
use super::progress::EventPrinter;
use crate::pipeline::{self, Keeping, PreparedShot, RenderOptions};
use crate::shot::Shot;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

pub(super) fn run(args: &RenderArgs) -> anyhow::Result<Outcome> {
    draw(Shot::read(&args.shot)?, &args.draw, Vec::new())
}

/// Renders a shot with overrides. `inputs`: files that it was made from, besides those it refers to.
pub(super) fn draw(mut shot: Shot, args: &DrawArgs, inputs: Vec<PathBuf>) -> anyhow::Result<Outcome> {
    shot.size = args.scale.of(shot.size);
    args.camera.choose(&mut shot);
    shot = args.outside.allow(shot);
    shot.samples = args.samples.unwrap_or(shot.samples);
    let own_output = shot.output.path.clone();
    if let Some(output) = &args.output {
        shot.output.path.clone_from(output);
    }
    let options = RenderOptions {
        frames: args.frames.clone().map(|list| list.0).unwrap_or_default(),
        device: args.device.clone(),
        existing: args.existing.into(),
        has_preview: args.preview,
        has_overlay: args.overlay,
        durability: args.fsync.into(),
        inputs,
        ..RenderOptions::default()
    };
    let outputs = [shot.output.path.clone(), own_output];
    let outputs = outputs.iter().map(PathBuf::as_path);
    let prepared = PreparedShot::new(shot)?.keeping_trajectories(outputs, Keeping::Write);
    // Until here Ctrl-C ends the program at once: nothing is written yet.
    let cancel = cancel_on_interrupt()?;
    let printer = EventPrinter::new(args.progress.into());
    let summary = pipeline::render(&prepared, &options, &cancel, &|event| printer.print_render(&event))?;
    printer.end()?;
    let is_complete = summary.failed == 0 && !summary.is_cancelled;
    Ok(if is_complete { Outcome::Complete } else { Outcome::Partial })
}

/// Installs a Ctrl-C handler: the first press finishes the frames in flight, the second ends the program.
pub(super) fn cancel_on_interrupt() -> anyhow::Result<Arc<AtomicBool>> {
    let cancel = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&cancel);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(1);
        }
        eprintln!("pinwarp: stopping after the frames in flight; press Ctrl-C again to stop now");
    })?;
    Ok(cancel)
}
