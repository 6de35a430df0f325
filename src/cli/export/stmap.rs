//! `pinwarp export --to stmap`: a sequence of maps for any compositor.

use super::maps::{Maps, Written, check_frames, write_frames};
use crate::cli::Outcome;
use crate::cli::args::ExportArgs;
use crate::image::{Compression, FrameMetadata, write_exr};
use crate::pipeline::{is_stale, stale_words};
use crate::plate::stmap_of;
use crate::spelling::counted;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    let pattern = args.output.clone().unwrap_or_else(|| args.shot.with_extension("stmap.####.exr"));
    let (maps, _) = Maps::open(args)?;
    let written = write(args, &maps, &pattern)?;
    told(&pattern, &written)?;
    Ok(Outcome::Complete)
}

/// Writes the maps of all frames.
pub(super) fn write(args: &ExportArgs, maps: &Maps, pattern: &Path) -> anyhow::Result<Written> {
    let frames = maps.frames();
    let sequence = check_frames(args, (pattern, &maps.inputs), &frames)?;
    let written = write_frames(args, &sequence, &frames, |frame, path| {
        let map = maps.map(frame);
        if !map.folded_pixels.is_empty() {
            let folded = counted(map.folded_pixels.len(), "pixel lies", "pixels lie");
            writeln!(io::stderr(), "note: frame {frame}: {folded} in folds, where a map shows one of the sheets")?;
        }
        let metadata = FrameMetadata {
            frame,
            frames_per_second: maps.lattices.rate,
            shot_hash: maps.digest(frame),
            device: "CPU".into(),
            camera: None,
            mattes: Default::default(),
        };
        Ok(write_exr(path, &stmap_of(&map), &metadata, Compression::Zip)?)
    })?;
    let is_other = |(frame, path): &&(i32, PathBuf)| is_stale(path, &maps.digest(*frame));
    if let Some(note) = stale_words(written.kept.iter().filter(is_other).count()) {
        writeln!(io::stderr(), "note: {note}")?;
    }
    Ok(written)
}

pub(super) fn told(pattern: &Path, Written { new, kept }: &Written) -> io::Result<()> {
    let kept = if kept.is_empty() { String::new() } else { format!(", {} kept", kept.len()) };
    let new = counted(*new, "frame", "frames");
    writeln!(io::stdout(), "wrote {}: {new}{kept}", pattern.display())
}
