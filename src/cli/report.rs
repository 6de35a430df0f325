//! `pinwarp report`: the state of finished frames (missing, damaged, inconsistent), and the worst figures of every
//! layer.
//!
//! In: a folder, a sequence or a shot; limits. Out: a table or JSON on standard output, a contact sheet; exit code 1 if
//! frames are missing or damaged, come from different states of the shot, or a figure exceeds its limit.

use super::frames::FrameList;
use super::outcome::{Outcome, OutputCutOff};
use super::outputs;
use super::shared_args::OverwriteArg;
use super::warnings::Warnings;
use crate::image::{ContactSheet, FileKind, SequencePath, preview, read_any, write_png};
use crate::pipeline::{LayerPeaks, Peak, SequenceReport};
use crate::shot::Shot;
use crate::spelling::{pluralised, ranges};
use anyhow::bail;
use std::io::{self, Write};
use std::path::PathBuf;

/// Maximum number of tiles of a contact sheet; longer sequences show every n-th frame, and those with the worst
/// figures.
const MAX_TILES: usize = 120;
/// Width of a tile in pixels.
const TILE_WIDTH: u32 = 320;

#[derive(Debug, clap::Args)]
pub(super) struct ReportArgs {
    /// Finished frames: a folder, a sequence such as out/f.####.exr, or the shot that they were rendered from.
    #[arg(value_name = "FRAMES")]
    source: PathBuf,
    /// Frames that should exist, e.g. 1-48x2,60; default: the shot's range, or without a shot all frames from the first to the
    /// last found.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<FrameList>,
    /// Read every file completely and compare the pixels with their checksums.
    #[arg(long)]
    verify: bool,
    /// Draw a contact sheet (PNG); frames with the worst quality figures get a coloured border.
    #[arg(long, value_name = "SHEET")]
    sheet: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArg,
    #[command(flatten)]
    limits: Limits,
    /// Print one JSON object per sequence instead of text.
    #[arg(long)]
    json: bool,
}

/// Limits that no frame may exceed.
#[derive(Debug, clap::Args)]
struct Limits {
    /// Fail if a pin is farther than this from its target, in pixels.
    #[arg(long, value_name = "PX", value_parser = parse_limit)]
    max_pin_error: Option<f64>,
    /// Fail if more cells than this fold over the model in any frame.
    #[arg(long, value_name = "CELLS")]
    max_folds: Option<usize>,
    /// Fail if the jerk of the warp exceeds this, in pixels.
    #[arg(long, value_name = "PX", value_parser = parse_limit)]
    max_jerk: Option<f64>,
    /// Fail if more pixels than this are uncovered in any frame of a warped plate.
    #[arg(long, value_name = "PIXELS")]
    max_holes: Option<usize>,
    /// Fail if there are more warnings than this in total.
    #[arg(long, value_name = "COUNT")]
    max_warnings: Option<usize>,
}

fn parse_limit(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number: &f64| *number >= 0.0 && number.is_finite());
    number.ok_or_else(|| "a number from 0 up is needed, e.g. 0.5".to_owned())
}

pub(super) fn run(args: &ReportArgs) -> anyhow::Result<Outcome> {
    let sequences = sequences(args)?;
    if args.sheet.is_some() && sequences.len() > 1 {
        let names: Vec<String> = sequences.iter().map(|(path, _)| path.pattern().display().to_string()).collect();
        bail!("--sheet shows one sequence, and there are several; give one of them: {}", names.join(", "));
    }
    let mut is_good = true;
    for (path, frames) in &sequences {
        let report = SequenceReport::read(path, frames, args.verify);
        let faults = faults(&report, &args.limits);
        is_good &= faults.is_empty();
        if args.json {
            let pattern = path.pattern().to_string_lossy();
            let line = serde_json::json!({"path": pattern, "faults": faults, "report": report});
            io::stdout().write_all((line.to_string() + "\n").as_bytes()).map_err(OutputCutOff)?;
        } else {
            print(path, &report, &faults)?;
        }
        if let Some(sheet) = &args.sheet {
            outputs::allow(&outputs::inputs_of([&args.source]), sheet, args.overwrite)?;
            write_png(sheet, &contact_sheet(path, frames, &report)?)?;
        }
    }
    Ok(if is_good { Outcome::Complete } else { Outcome::Partial })
}

/// Returns the requested sequences, and the frames that each should have.
fn sequences(args: &ReportArgs) -> anyhow::Result<Vec<(SequencePath, Vec<i32>)>> {
    let source = &args.source;
    let wanted = args.frames.clone().map(|list| list.0);
    if FileKind::of(source) == Some(FileKind::Shot) {
        let shot = Shot::read(source)?;
        let frames = wanted.unwrap_or_else(|| (shot.frames.first..=shot.frames.last).collect());
        return Ok(vec![(SequencePath::parse(&shot.output.path)?, frames)]);
    }
    let paths = if source.is_dir() { SequencePath::in_folder(source)? } else { vec![SequencePath::of_input(source)?] };
    if paths.is_empty() {
        bail!("{}: there is no sequence in the folder; give for example {0}/frame.####.exr", source.display());
    }
    let of_path = |path: SequencePath| {
        let frames = match (&wanted, path.frames_on_disk()?) {
            (Some(wanted), _) => wanted.clone(),
            (None, None) => vec![own_frame(&path)?],
            (None, Some(there)) => {
                let (Some(&first), Some(&last)) = (there.first(), there.last()) else {
                    bail!("{}: no frame of this sequence exists", path.pattern().display());
                };
                (first..=last).collect()
            }
        };
        Ok((path, frames))
    };
    paths.into_iter().map(of_path).collect()
}

/// Returns the frame number stored in a single file.
fn own_frame(path: &SequencePath) -> anyhow::Result<i32> {
    let file = path.path_of(0);
    crate::image::read_whole(&file, crate::image::Depth::Head)
        .map(|metadata| metadata.frame)
        .map_err(|reason| anyhow::anyhow!("{}: {reason}", file.display()))
}

/// Returns every reason why the frames are unfit for use, one sentence each.
fn faults(report: &SequenceReport, limits: &Limits) -> Vec<String> {
    let mut faults = Vec::new();
    if !report.missing.is_empty() {
        let count = pluralised(report.missing.len(), "frame is missing", "frames are missing");
        faults.push(format!("{count}: {}", ranges(&report.missing)));
    }
    for damaged in &report.damaged {
        faults.push(format!("frame {}: {}", damaged.frame, damaged.reason));
    }
    if report.states.len() > 1 {
        let counts: Vec<String> = report.states.values().map(ToString::to_string).collect();
        let text = "the frames were made from different states of the shot or on different classes of device";
        faults.push(format!("{text} ({} frames); render again with --resume", counts.join(" and ")));
    }
    let mut over = |what: &str, peak: Option<Peak>, limit: Option<f64>| {
        if let (Some(peak), Some(limit)) = (peak, limit)
            && peak.value > limit
        {
            faults.push(format!("frame {}: {what} is {}, at most {limit} is allowed", peak.frame, short(peak.value)));
        }
    };
    for layer in &report.layers {
        let named = |what: &str| format!("layer '{}': {what}", layer.layer);
        over(&named("distance of a pin from its target, in pixels,"), layer.pin_error_px, limits.max_pin_error);
        over(&named("number of folded cells"), layer.folded_cells, limits.max_folds.map(|count| count as f64));
        over(&named("jerk of the warp, in pixels,"), layer.jerk_px, limits.max_jerk);
    }
    over("number of uncovered pixels", report.hole_pixels, limits.max_holes.map(|count| count as f64));
    if let Some(most) = limits.max_warnings.filter(|&most| report.warnings.len() > most) {
        faults.push(format!("{}, at most {most} allowed", pluralised(report.warnings.len(), "warning", "warnings")));
    }
    faults
}

fn print(path: &SequencePath, report: &SequenceReport, faults: &[String]) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "{}: {}", path.pattern().display(), pluralised(report.frames, "complete frame", "complete frames"))?;
    let mut warnings = Warnings::default();
    report.warnings.iter().for_each(|(frame, warning)| warnings.add(*frame, warning));
    for line in warnings.lines() {
        writeln!(out, "{line}")?;
    }
    for layer in &report.layers {
        writeln!(out, "layer '{}': {}", layer.layer, figures(layer))?;
    }
    if let Some(peak) = report.hole_pixels {
        writeln!(out, "uncovered pixels: at most {} (frame {})", short(peak.value), peak.frame)?;
    }
    for fault in faults {
        writeln!(out, "error: {fault}")?;
    }
    Ok(())
}

/// Describes the worst figures of a layer.
fn figures(layer: &LayerPeaks) -> String {
    let told = |what: &str, peak: Option<Peak>, unit: &str| {
        peak.map(|peak| format!("{what} {}{unit} (frame {})", short(peak.value), peak.frame))
    };
    let frames =
        |count: usize, what: &str| (count > 0).then(|| format!("{what} in {}", pluralised(count, "frame", "frames")));
    let words = [
        told("pins off by at most", layer.pin_error_px, " px"),
        told("least det J", layer.min_det, ""),
        told("angular distortion up to", layer.angular, ""),
        told("area distortion up to", layer.area, ""),
        told("jerk up to", layer.jerk_px, " px"),
        told("most folded cells", layer.folded_cells, ""),
        frames(layer.folded_frames, "folds"),
        frames(layer.unconverged_frames, "not converged"),
    ];
    words.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// Formats integers without a decimal point, other numbers with three significant digits.
fn short(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e9 {
        return format!("{value}");
    }
    if value.abs() < 1e-3 {
        return "0.000".to_owned();
    }
    let digits = (2 - value.abs().log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.digits$}")
}

/// Draws the contact sheet, with the worst frames outlined.
fn contact_sheet(
    path: &SequencePath,
    frames: &[i32],
    report: &SequenceReport,
) -> anyhow::Result<crate::image::Preview> {
    let worst = report.worst_frames();
    let step = frames.len().div_ceil(MAX_TILES.saturating_sub(worst.len()).max(1)).max(1);
    let chosen = |(index, frame): (usize, &i32)| (index % step == 0 || worst.contains(frame)).then_some(*frame);
    let shown: Vec<i32> = frames.iter().enumerate().filter_map(chosen).collect();
    // A missing or damaged frame has an empty tile, even if only its pixels are damaged.
    let read = |frame: i32| read_any(&path.path_of(frame)).ok().map(|plate| preview(&plate.into_frame()));
    let first = shown.iter().find_map(|&frame| read(frame));
    let Some(first) = first else { bail!("there is no complete frame to show on a contact sheet") };
    let columns = ((shown.len() as f64).sqrt().ceil() as usize).clamp(1, 12);
    let mut sheet = ContactSheet::new(shown.len(), columns, TILE_WIDTH, [first.width, first.height]);
    for frame in shown {
        let picture = read(frame);
        let label = if picture.is_none() { format!("{frame} missing or damaged") } else { frame.to_string() };
        sheet.add(picture.as_ref(), &label, worst.contains(&frame) || picture.is_none());
    }
    Ok(sheet.into_picture())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            [0.0, 7.0, 1e-9, 0.012_345, 2.718_9, 1234.5].map(short),
            ["0", "7", "0.000", "0.0123", "2.72", "1234"]
        );
    }
}
