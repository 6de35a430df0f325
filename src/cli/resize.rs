//! `pinwarp resize`: gives the lattices of a file other dims or another basis.
//!
//! In: a lattice file. Out: another lattice file, and the largest change of the warp.

use super::args::ResizeArgs;
use super::outcome::Outcome;
use super::outputs;
use crate::export::{LatticeBranches, LatticeFile, Track};
use crate::lattice::{Basis, Lattice};
use crate::pipeline::lattices_of_file;
use crate::spelling::pluralised;
use anyhow::{Context, anyhow};
use std::collections::BTreeMap;
use std::io::{self, Write};

pub(super) fn run(args: &ResizeArgs) -> anyhow::Result<Outcome> {
    outputs::allow(&outputs::inputs_of([&args.lattices]), &args.output, args.overwrite)?;
    let mut file = LatticeFile::read(&args.lattices)?;
    for layer in &mut file.layers {
        let error = match &mut layer.track {
            Track::Screen(lattices) => {
                let of_branches = resize_branches(lattices, &mut layer.branches, args);
                let resized = of_branches.and_then(|branches| Ok(resize(lattices, args)?.max(branches)));
                resized.map(|error| (error, "frame heights"))
            }
            Track::World(lattices) => resize(lattices, args).map(|error| (error, "scene units")),
        };
        let (error, unit) = error.with_context(|| format!("layer '{}'", layer.name))?;
        writeln!(io::stdout(), "layer '{}': the warp changes by {error:.1e} {unit} at most", layer.name)?;
    }
    file.write(&args.output)?;
    writeln!(io::stdout(), "wrote {}", args.output.display())?;
    Ok(Outcome::Complete)
}

/// Resizes the branches of all frames, keeping their regions; returns the largest error. `lattices` are those before
/// resizing.
fn resize_branches(
    lattices: &BTreeMap<i32, Lattice<2>>,
    branches: &mut BTreeMap<i32, LatticeBranches>,
    args: &ResizeArgs,
) -> anyhow::Result<f64> {
    let mut worst = 0.0_f64;
    for (frame, branches) in branches {
        // The branches take the place of frames, as all lattices are resized alike.
        let mut alone: BTreeMap<i32, Lattice<2>> =
            (0..).zip(lattices_of_file(branches, &lattices[frame].grid)).collect();
        worst = worst.max(resize(&mut alone, args)?);
        *branches = branches.with_lattices(alone.into_values().collect());
    }
    Ok(worst)
}

/// Resizes the lattices of all frames; returns the largest error.
fn resize<const D: usize>(lattices: &mut BTreeMap<i32, Lattice<D>>, args: &ResizeArgs) -> anyhow::Result<f64> {
    let dims = <[usize; D]>::try_from(args.dims.as_slice()).map_err(|_| {
        anyhow!("--dims has {}, the lattice has {D} axes", pluralised(args.dims.len(), "number", "numbers"))
    })?;
    let mut worst = 0.0_f64;
    for lattice in lattices.values_mut() {
        let basis: Basis = args.basis.unwrap_or(lattice.grid.basis);
        let fitted = lattice.resized(dims, basis)?;
        worst = worst.max(fitted.error);
        *lattice = fitted.lattice;
    }
    Ok(worst)
}
