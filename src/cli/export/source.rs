//! The input, frames and output path of `pinwarp export`.
//!
//! In: the arguments. Out: a prepared shot or the lattices of a file; frame numbers; a writable path. A format gets the
//! shot from here alone, and only after the warnings about its frames are printed, so that none leaves them out.

use crate::cli::args::{ExportArgs, ExportFormat};
use crate::cli::layer_notes::LayerNotes;
use crate::cli::outputs;
use crate::cli::warnings::Warnings;
use crate::export::LatticeFile;
use crate::image::{Existing, FileKind, Inputs};
use crate::pipeline::{FrameChecks, Keeping, PreparedShot, input_files, lattices, solve_before_frames};
use crate::shot::LayerSpace;
use crate::space::FrameSize;
use crate::spelling;
use anyhow::{anyhow, bail};
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// The exported object.
pub(super) struct Source(Opened);

enum Opened {
    /// A shot with its scene.
    Shot(Box<PreparedShot>),
    /// Lattices solved earlier.
    Lattices(LatticeFile),
}

impl Source {
    /// Opens a shot, or a lattice file (`.json`).
    pub(super) fn open(args: &ExportArgs) -> anyhow::Result<Self> {
        if FileKind::of(&args.shot) == Some(FileKind::Json) {
            let file = LatticeFile::read(&args.shot)?;
            check_layers(args, file.layers.iter().map(|layer| &*layer.name))?;
            return Ok(Self(Opened::Lattices(file)));
        }
        let mut shot = args.outside.read(&args.shot)?;
        check_layers(args, shot.layers.iter().filter(|layer| layer.is_moved()).map(|layer| &*layer.name))?;
        if args.layer.len() > 1 && matches!(args.to, ExportFormat::Stmap | ExportFormat::Nuke) {
            shot = shot.with_only_layers(&args.layer);
        }
        // As for a render: trajectories of the shot's own frames are read, and new ones are written beside the export.
        let outputs: Vec<PathBuf> = args.output.iter().chain([&shot.output.path]).cloned().collect();
        let outputs = outputs.iter().map(PathBuf::as_path);
        let prepared = PreparedShot::new(shot)?.keeping_trajectories(outputs, Keeping::Write);
        for note in &prepared.notes {
            writeln!(io::stderr(), "note: {note}")?;
        }
        Ok(Self(Opened::Shot(Box::new(prepared))))
    }

    /// Opens and solves a shot, for exports that need its scene.
    pub(super) fn with_scene(args: &ExportArgs, why: &str) -> anyhow::Result<PreparedShot> {
        match Self::open(args)?.0 {
            Opened::Shot(prepared) => {
                solve(args, &prepared)?;
                Ok(*prepared)
            }
            Opened::Lattices(_) => bail!("{} holds lattices only, and {why}; give the shot", args.shot.display()),
        }
    }

    /// Returns all files that are read, so that none is overwritten.
    pub(super) fn inputs(&self, args: &ExportArgs) -> anyhow::Result<Inputs> {
        let mut inputs = match &self.0 {
            Opened::Shot(prepared) => input_files(prepared)?,
            Opened::Lattices(_) => Inputs::default(),
        };
        inputs.add(&args.shot);
        Ok(inputs)
    }

    /// Returns the frame's width relative to its height, and its size; lattice files do not store the size.
    pub(super) fn frame_shape(&self) -> (f64, Option<FrameSize>) {
        match &self.0 {
            Opened::Shot(prepared) => (prepared.shot.size.aspect(), Some(prepared.shot.size)),
            Opened::Lattices(file) => (file.frame_aspect, None),
        }
    }

    /// Returns the lattices of the selected frames and layers, and the shot that they were solved for.
    pub(super) fn lattices(self, args: &ExportArgs) -> anyhow::Result<(LatticeFile, Option<Box<PreparedShot>>)> {
        let (mut file, prepared) = self.lattices_of_all_layers(args)?;
        if !args.layer.is_empty() {
            file.layers.retain(|layer| args.layer.contains(&layer.name));
        }
        if file.layers.is_empty() {
            bail!("no layer of {} that was asked for (--layer) is warped in these frames", args.shot.display());
        }
        Ok((file, prepared))
    }

    fn lattices_of_all_layers(self, args: &ExportArgs) -> anyhow::Result<(LatticeFile, Option<Box<PreparedShot>>)> {
        match self.0 {
            Opened::Shot(prepared) => {
                solve(args, &prepared)?;
                let file =
                    lattices(&prepared, &frames(args, &prepared), |frame| tracing::info!("frame {frame} solved"))?;
                Ok((file, Some(prepared)))
            }
            Opened::Lattices(file) => {
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

/// Solves the layers over time, and prints the notes and warnings that a render of the exported frames would give about the exported
/// layers.
fn solve(args: &ExportArgs, prepared: &PreparedShot) -> anyhow::Result<()> {
    solve_before_frames(prepared, &AtomicBool::new(false));
    let is_exported = |layer: usize| args.layer.is_empty() || args.layer.contains(&prepared.shot.layers[layer].name);
    let (mut checks, mut notes, mut warnings) = (FrameChecks::default(), LayerNotes::default(), Warnings::default());
    for frame in frames(args, prepared) {
        let report = checks.report(prepared, frame, is_exported)?;
        notes.new_lines(&report.notes).iter().try_for_each(|line| writeln!(io::stderr(), "{line}"))?;
        report.warnings.iter().for_each(|warning| warnings.add(frame, warning));
    }
    warnings.lines().try_for_each(|line| writeln!(io::stderr(), "{line}"))?;
    Ok(())
}

/// Refuses names of layers that are not warped, before anything is solved.
fn check_layers<'a>(args: &ExportArgs, warped: impl Iterator<Item = &'a str> + Clone) -> anyhow::Result<()> {
    let Some(wrong) = args.layer.iter().find(|name| warped.clone().all(|other| other != *name)) else { return Ok(()) };
    bail!("{} has no warped layer '{wrong}'; {}", args.shot.display(), spelling::hint(wrong, warped))
}

/// Returns the selected frames, or the shot's range.
pub(super) fn frames(args: &ExportArgs, prepared: &PreparedShot) -> Vec<i32> {
    let range = prepared.shot.frames;
    args.frames.clone().map_or_else(|| (range.first..=range.last).collect(), |list| list.0)
}

/// Returns the requested path, or the input's with another extension; fails if it exists and may not be replaced. With
/// `--resume`, [`check_text`] must be called before the file is written.
pub(super) fn output(args: &ExportArgs, ending: &str) -> anyhow::Result<PathBuf> {
    let output = args.output.clone().unwrap_or_else(|| args.shot.with_extension(ending));
    outputs::as_text(&output)?;
    let inputs = outputs::inputs_of([&args.shot]);
    if Existing::from(args.existing).is_resume() {
        inputs.refuse(&output)?;
    } else {
        outputs::allow(&inputs, &output, args.existing)?;
    }
    Ok(output)
}

/// Returns the layers with a displacement, in the shot's order.
pub(super) fn moved_layers(prepared: &PreparedShot) -> Vec<usize> {
    let layers = prepared.shot.layers.iter().enumerate();
    layers.filter(|(_, layer)| layer.is_moved()).map(|(index, _)| index).collect()
}

/// Returns whether a layer is warped in screen space.
pub(super) fn is_on_screen(prepared: &PreparedShot, layer: usize) -> bool {
    matches!(prepared.shot.layers[layer].space, LayerSpace::Screen { .. })
}
