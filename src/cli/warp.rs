//! `pinwarp warp`: warps finished frames.
//!
//! In: plates, and a shot, a lattice file or STMaps. Out: files; progress events.

use super::outcome::Outcome;
use super::progress::EventPrinter;
use super::render::cancel_on_interrupt;
use super::warp_args::WarpArgs;
use crate::export::LatticeFile;
use crate::image::{SequencePath, sequence_size};
use crate::pipeline::{self, Keeping, PlateWarp, PreparedShot, WarpDirection, WarpJob};
use crate::plate::{Holes, WarpSettings};
use crate::shot::{Shot, Source};
use anyhow::{Context, bail};
use std::path::PathBuf;

pub(super) fn run(args: &WarpArgs) -> anyhow::Result<Outcome> {
    let prepared = args.shot.as_ref().map(|_| prepared(args)).transpose()?;
    let shot = prepared.as_ref().map(|prepared| &prepared.shot);
    let warp = match &prepared {
        Some(prepared) => PlateWarp::Shot(prepared),
        None => without_shot(args)?,
    };
    let job = WarpJob {
        plate: plate(args, shot)?,
        output: output(args, shot)?,
        warp,
        settings: settings(args, shot),
        direction: if args.inverse { WarpDirection::Inverse } else { WarpDirection::Forward },
        layers: args.layer.clone(),
        frames: args.frames.clone().map(|list| list.0).unwrap_or_default(),
        existing: args.existing.into(),
        device: args.device.clone(),
        durability: args.fsync.into(),
        inputs: args.lattice.iter().cloned().collect(),
    };
    let cancel = cancel_on_interrupt()?;
    let printer = EventPrinter::new(args.progress.into());
    let summary = pipeline::warp_frames(&job, &cancel, &|event| printer.print_warp(&event))?;
    printer.end()?;
    let is_complete = summary.failed == 0 && !summary.is_cancelled;
    Ok(if is_complete { Outcome::Complete } else { Outcome::Partial })
}

/// Prepares the shot. A shot without a size takes that of the first plate that can be read.
fn prepared(args: &WarpArgs) -> anyhow::Result<PreparedShot> {
    let path = args.shot.as_ref().context("clap asks for one of --shot, --lattice, --stmap")?;
    let mut shot = args.outside.read(path)?;
    shot.layers.iter_mut().for_each(|layer| layer.strength *= args.strength);
    if shot.source == Source::Frame && !shot.lines.has("size") {
        let plate = SequencePath::of_input(&plate(args, Some(&shot))?)?;
        let range = shot.frames.first..=shot.frames.last;
        let frames: Vec<i32> = args.frames.as_ref().map_or_else(|| range.collect(), |list| list.0.clone());
        let first = frames.first().copied().unwrap_or(shot.frames.first);
        shot.size = sequence_size(&plate, (first, frames.into_iter()))?;
    }
    let outputs = args.output.iter().chain([&shot.output.path]).cloned().collect::<Vec<_>>();
    Ok(PreparedShot::new(shot)?.keeping_trajectories(outputs.iter().map(PathBuf::as_path), Keeping::Write))
}

/// Returns the warp for arguments without a shot.
fn without_shot(args: &WarpArgs) -> anyhow::Result<PlateWarp<'static>> {
    match (&args.lattice, &args.stmap) {
        (Some(path), _) => {
            let file = LatticeFile::read(path)?;
            Ok(PlateWarp::Lattices { file, strength: args.strength, matte: args.matte.clone() })
        }
        (None, Some(maps)) => Ok(PlateWarp::Maps(maps.clone())),
        (None, None) => bail!("no warp is given; use --shot, --lattice or --stmap"),
    }
}

fn plate(args: &WarpArgs, shot: Option<&Shot>) -> anyhow::Result<PathBuf> {
    let plate = args.plate.clone().or_else(|| shot?.plate.clone());
    plate.context("the shot names no `plate`; give one: pinwarp warp beauty.####.exr --shot SHOT")
}

/// Returns the output path. The shot's own output is for renders of its scene, or for its own plate.
fn output(args: &WarpArgs, shot: Option<&Shot>) -> anyhow::Result<PathBuf> {
    let of_shot = || shot.filter(|shot| shot.source == Source::Frame).map(|shot| shot.output.path.clone());
    let output = args.output.clone().or_else(of_shot);
    output.context(
        "the shot's output is for frames rendered from its scene or pictures; say where warped ones go: -o warped.####.exr",
    )
}

/// Returns the shot's settings with the overrides of the arguments.
fn settings(args: &WarpArgs, shot: Option<&Shot>) -> WarpSettings {
    let mut settings = shot.map(|shot| shot.warp.clone()).unwrap_or_default();
    settings.filter = args.filter.unwrap_or(settings.filter);
    if let Some(clean) = &args.clean {
        settings.holes = Holes::Plate(clean.clone());
    }
    settings
}
