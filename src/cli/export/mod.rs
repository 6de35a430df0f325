//! `pinwarp export`: what is exported, of which frames, to where.

mod after_effects;
mod blender;
mod gltf;
mod lattice_json;
mod maps;
mod nuke;
mod stmap;

use super::args::{ExportArgs, ExportFormat};
use super::{Outcome, holds_text, refuse_existing};
use crate::export::LatticeFile;
use crate::image::FileKind;
use crate::pipeline::{Existing, Inputs, Setup, lattices};
use crate::shot::{LayerSpace, Shot};
use anyhow::{anyhow, bail};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    refuse_idle_flags(args)?;
    match args.to {
        ExportFormat::LatticeJson => lattice_json::run(args),
        ExportFormat::Stmap => stmap::run(args),
        ExportFormat::Nuke => nuke::run(args),
        ExportFormat::Blender => blender::run(args),
        ExportFormat::AfterEffects => after_effects::run(args),
        ExportFormat::Gltf => self::gltf::run(args),
    }
}

/// A flag that does nothing would be a trap.
fn refuse_idle_flags(args: &ExportArgs) -> anyhow::Result<()> {
    let has_maps = matches!(args.to, ExportFormat::Stmap | ExportFormat::Nuke | ExportFormat::AfterEffects);
    let given = [
        ("--layer", args.layer.is_some()),
        ("--inverse", args.inverse),
        ("--size", args.size.is_some()),
        ("--overscan", args.overscan > 0),
        ("--resume", Existing::from(args.existing) == Existing::Resume),
    ];
    if let Some((flag, _)) = given.into_iter().find(|(_, is_given)| *is_given && !has_maps) {
        bail!("{flag} is for maps (--to stmap, nuke or after-effects), this export has none; leave it out");
    }
    if args.inverse && args.to == ExportFormat::AfterEffects {
        bail!("displacement maps push one way only; --inverse is for --to stmap and nuke");
    }
    Ok(())
}

/// What is exported.
enum Source {
    /// A shot with its scene.
    Shot(Box<Setup>),
    /// Lattices that were solved before.
    Lattices(LatticeFile),
}

impl Source {
    /// Reads a shot, or a lattice file (`.json`).
    fn open(args: &ExportArgs) -> anyhow::Result<Self> {
        if FileKind::of(&args.shot) == Some(FileKind::Json) {
            return Ok(Self::Lattices(LatticeFile::read(&args.shot)?));
        }
        let setup = Setup::new(Shot::read(&args.shot)?)?;
        for note in &setup.notes {
            writeln!(io::stderr(), "note: {note}")?;
        }
        Ok(Self::Shot(Box::new(setup)))
    }

    /// A shot, for exports that need its scene.
    fn with_scene(args: &ExportArgs, why: &str) -> anyhow::Result<Setup> {
        match Self::open(args)? {
            Self::Shot(setup) => Ok(*setup),
            Self::Lattices(_) => bail!("{} holds lattices only, and {why}; give the shot", args.shot.display()),
        }
    }

    /// All files that are read, so that none is written over.
    fn inputs(&self, args: &ExportArgs) -> anyhow::Result<Inputs> {
        let mut inputs = match self {
            Self::Shot(setup) => setup.inputs()?,
            Self::Lattices(_) => Inputs::default(),
        };
        inputs.add(&args.shot);
        Ok(inputs)
    }

    /// The lattices of the frames asked for, and the shot that they were solved for.
    fn lattices(self, args: &ExportArgs) -> anyhow::Result<(LatticeFile, Option<Box<Setup>>)> {
        match self {
            Self::Shot(setup) => {
                let file = lattices(&setup, &frames(args, &setup), |frame| tracing::info!("frame {frame} solved"))?;
                Ok((file, Some(setup)))
            }
            Self::Lattices(file) => {
                let asked = match &args.frames {
                    Some(list) => file.of_frames(&list.0),
                    None => Some(file),
                };
                let none = || anyhow!("{} has no lattice in the frames asked for (--frames)", args.shot.display());
                Ok((asked.ok_or_else(none)?, None))
            }
        }
    }
}

/// The frames asked for, else the shot's range.
fn frames(args: &ExportArgs, setup: &Setup) -> Vec<i32> {
    let range = setup.shot.frames;
    args.frames.clone().map_or_else(|| (range.first..=range.last).collect(), |list| list.0)
}

/// The path asked for, else the input's with another ending; refuses to replace what is there. Whoever resumes has to ask
/// [`check_text`] before the file is written.
fn output(args: &ExportArgs, ending: &str) -> anyhow::Result<PathBuf> {
    let output = args.output.clone().unwrap_or_else(|| args.shot.with_extension(ending));
    let mut inputs = Inputs::default();
    inputs.add(&args.shot);
    inputs.refuse(&output)?;
    if Existing::from(args.existing) != Existing::Resume {
        refuse_existing(&output, args.existing)?;
    }
    Ok(output)
}

/// A text may be written where it is not there, or where it says the same; what says something else has to be replaced
/// with --overwrite.
fn check_text(args: &ExportArgs, path: &Path, text: &str) -> anyhow::Result<()> {
    if holds_text(path, text) { Ok(()) } else { refuse_existing(path, args.existing) }
}

/// Layers that something moves, in the shot's order.
fn moved_layers(setup: &Setup) -> Vec<usize> {
    let layers = setup.shot.layers.iter().enumerate();
    let is_moved =
        |layer: &crate::shot::Layer| !layer.pins.is_empty() || !layer.handles.is_empty() || layer.transfer.is_some();
    layers.filter(|(_, layer)| is_moved(layer)).map(|(index, _)| index).collect()
}

/// Whether a layer is warped on the screen.
fn is_on_screen(setup: &Setup, layer: usize) -> bool {
    matches!(setup.shot.layers[layer].space, LayerSpace::Screen { .. })
}
