//! `pinwarp export --to stmap`: a sequence of maps for any compositor.

use super::maps::{Maps, Written, check_frames, write_frames};
use crate::cli::args::ExportArgs;
use crate::cli::outcome::Outcome;
use crate::image::{Compression, without_counter, write_exr};
use crate::pipeline::PreparedShot;
use crate::plate::stmap_of;
use crate::spelling::pluralised;
use std::io::{self, Write};
use std::path::Path;

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    let pattern = args.output.clone().unwrap_or_else(|| without_counter(&args.shot).with_extension("stmap.####.exr"));
    let (maps, prepared) = Maps::open(args)?;
    let written = write(args, (&maps, prepared.as_deref()), &pattern)?;
    print_written(&pattern, &written)?;
    Ok(Outcome::Complete)
}

/// Writes the maps of all frames.
pub(super) fn write(
    args: &ExportArgs,
    (maps, prepared): (&Maps, Option<&PreparedShot>),
    pattern: &Path,
) -> anyhow::Result<Written> {
    let mut drawings = prepared.map(|prepared| maps.drawings(prepared)).transpose()?;
    let sequence = check_frames(args, (pattern, &maps.inputs), &maps.frames)?;
    write_frames(args, (maps, &sequence), |path, metadata| {
        let map = maps.map(metadata.frame, drawings.as_mut())?;
        write_exr(path, &stmap_of(&map), metadata, Compression::Zip)?;
        Ok(maps.fold_warning(&map))
    })
}

pub(super) fn print_written(pattern: &Path, Written { new, kept }: &Written) -> io::Result<()> {
    let kept = if *kept == 0 { String::new() } else { format!(", {kept} kept") };
    let new = pluralised(*new, "frame", "frames");
    writeln!(io::stdout(), "wrote {}: {new}{kept}", pattern.display())
}
