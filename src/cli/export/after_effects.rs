//! `pinwarp export --to after-effects`: displacement maps, and the settings of the effect that applies them.

use super::maps::{Maps, write_frames};
use super::stmap::told;
use crate::cli::Outcome;
use crate::cli::args::ExportArgs;
use crate::export::{DisplacementNote, displacement, greatest_offset};
use crate::image::{replace_text, write_codes};
use anyhow::bail;
use std::io::{self, Write};

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    let stem = args.output.clone().unwrap_or_else(|| args.shot.with_extension(""));
    let maps = Maps::open(args)?;
    let frames = maps.frames();
    // All frames share one scale, so the farthest way of all has to be known first.
    let farthest = frames.iter().map(|&frame| greatest_offset(&maps.map(frame))).fold(0.0, f64::max);
    let reach_px = farthest.ceil().max(1.0) as u32;
    if reach_px > 32000 {
        bail!("pixels come from up to {reach_px} pixels away, more than After Effects can displace (32000)");
    }
    let pattern = stem.with_extension(format!("displacement_{reach_px}px.####.png"));
    let written = write_frames(args, &pattern, &frames, |frame, path| {
        let map = maps.map(frame);
        Ok(write_codes(path, maps.pixels(), &displacement(&map, f64::from(reach_px)))?)
    })?;
    let note = DisplacementNote {
        maps: pattern.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        reach_px,
        size: maps.pixels(),
        frames: [frames.first(), frames.last()].map(|frame| frame.copied().unwrap_or_default()),
        rate: maps.lattices.rate,
    };
    let note_path = stem.with_extension("after-effects.txt");
    replace_text(&note_path, &note.text())?;
    told(&pattern, &written)?;
    let step = f64::from(reach_px) / 32767.0;
    writeln!(io::stdout(), "wrote {}: max displacement {reach_px} px, steps of {step:.5} px", note_path.display())?;
    Ok(Outcome::Complete)
}
