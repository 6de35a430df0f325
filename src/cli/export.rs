//! `pinwarp export`.

use super::args::{ExportArgs, ExportFormat};
use super::{Outcome, refuse_existing};
use crate::pipeline::{Setup, lattices};
use crate::shot::Shot;
use std::io::{self, Write};

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    let ExportFormat::LatticeJson = args.to;
    let output = args.output.clone().unwrap_or_else(|| args.shot.with_extension("lattice.json"));
    refuse_existing(&output, args.overwrite)?;
    let setup = Setup::new(Shot::read(&args.shot)?)?;
    for note in &setup.notes {
        writeln!(io::stderr(), "note: {note}")?;
    }
    let range = setup.shot.frames;
    let frames = args.frames.clone().map_or_else(|| (range.first..=range.last).collect(), |list| list.0);
    let file = lattices(&setup, &frames, |frame| tracing::info!("frame {frame} solved"))?;
    file.write(&output)?;
    let names: Vec<&str> = file.layers.iter().map(|layer| layer.name.as_str()).collect();
    writeln!(io::stdout(), "wrote {}: {} frames of {}", output.display(), frames.len(), names.join(", "))?;
    Ok(Outcome::Complete)
}
