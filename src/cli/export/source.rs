//! What `pinwarp export` exports, of which frames, to where.
//!
//! In: the arguments. Out: a shot made ready or the lattices of a file; frame numbers; a path that may be written.

use crate::cli::args::ExportArgs;
use crate::cli::outputs;
use crate::export::LatticeFile;
use crate::image::{Existing, FileKind, Inputs};
use crate::pipeline::{PreparedShot, input_files, lattices};
use crate::shot::LayerSpace;
use anyhow::{anyhow, bail};
use std::io::{self, Write};
use std::path::PathBuf;

/// What is exported.
pub(super) enum Source {
    /// A shot with its scene.
    Shot(Box<PreparedShot>),
    /// Lattices that were solved before.
    Lattices(LatticeFile),
}

impl Source {
    /// Reads a shot, or a lattice file (`.json`).
    pub(super) fn open(args: &ExportArgs) -> anyhow::Result<Self> {
        if FileKind::of(&args.shot) == Some(FileKind::Json) {
            return Ok(Self::Lattices(LatticeFile::read(&args.shot)?));
        }
        let prepared = PreparedShot::new(args.outside.read(&args.shot)?)?;
        for note in &prepared.notes {
            writeln!(io::stderr(), "note: {note}")?;
        }
        Ok(Self::Shot(Box::new(prepared)))
    }

    /// A shot, for exports that need its scene.
    pub(super) fn with_scene(args: &ExportArgs, why: &str) -> anyhow::Result<PreparedShot> {
        match Self::open(args)? {
            Self::Shot(prepared) => Ok(*prepared),
            Self::Lattices(_) => bail!("{} holds lattices only, and {why}; give the shot", args.shot.display()),
        }
    }

    /// All files that are read, so that none is written over.
    pub(super) fn inputs(&self, args: &ExportArgs) -> anyhow::Result<Inputs> {
        let mut inputs = match self {
            Self::Shot(prepared) => input_files(prepared)?,
            Self::Lattices(_) => Inputs::default(),
        };
        inputs.add(&args.shot);
        Ok(inputs)
    }

    /// The lattices of the frames asked for, and the shot that they were solved for.
    pub(super) fn lattices(self, args: &ExportArgs) -> anyhow::Result<(LatticeFile, Option<Box<PreparedShot>>)> {
        match self {
            Self::Shot(prepared) => {
                let file =
                    lattices(&prepared, &frames(args, &prepared), |frame| tracing::info!("frame {frame} solved"))?;
                Ok((file, Some(prepared)))
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
pub(super) fn frames(args: &ExportArgs, prepared: &PreparedShot) -> Vec<i32> {
    let range = prepared.shot.frames;
    args.frames.clone().map_or_else(|| (range.first..=range.last).collect(), |list| list.0)
}

/// The path asked for, else the input's with another ending; refuses to replace what is there. Whoever resumes has to ask
/// [`check_text`] before the file is written.
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

/// Layers that something moves, in the shot's order.
pub(super) fn moved_layers(prepared: &PreparedShot) -> Vec<usize> {
    let layers = prepared.shot.layers.iter().enumerate();
    let is_moved =
        |layer: &crate::shot::Layer| !layer.pins.is_empty() || !layer.handles.is_empty() || layer.transfer.is_some();
    layers.filter(|(_, layer)| is_moved(layer)).map(|(index, _)| index).collect()
}

/// Whether a layer is warped on the screen.
pub(super) fn is_on_screen(prepared: &PreparedShot, layer: usize) -> bool {
    matches!(prepared.shot.layers[layer].space, LayerSpace::Screen { .. })
}
