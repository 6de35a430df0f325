//! `pinwarp export --to lattice-json`: solved lattices in pinwarp's own format.

use super::source::{Source, output};
use crate::cli::args::ExportArgs;
use crate::cli::outcome::Outcome;
use crate::export::{LatticeTrack, Track};
use crate::spelling::pluralised;
use std::io::{self, Write};

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    let output = output(args, "lattice.json")?;
    let source = Source::open(args)?;
    source.inputs(args)?.refuse(&output)?;
    let (file, _) = source.lattices(args)?;
    file.write(&output)?;
    for layer in file.layers.iter().filter(|layer| !layer.wholes.is_empty()) {
        let text = "its lattice is only part of its warp, which rests at the border and meets the pins; maps hold all of it \
                    (--to stmap, nuke, after-effects)";
        writeln!(io::stderr(), "note: layer '{}': {text}", layer.name)?;
    }
    let names: Vec<&str> = file.layers.iter().map(|layer| layer.name.as_str()).collect();
    let count = file.layers.iter().map(frame_count).max().unwrap_or(0);
    let frames = pluralised(count, "frame", "frames");
    writeln!(io::stdout(), "wrote {}: {frames} of {}", output.display(), names.join(", "))?;
    Ok(Outcome::Complete)
}

fn frame_count(layer: &LatticeTrack) -> usize {
    match &layer.track {
        Track::Screen(lattices) => lattices.len(),
        Track::World(lattices) => lattices.len(),
    }
}
