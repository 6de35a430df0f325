//! `pinwarp export`: dispatches to the format's writer.
//!
//! In: the arguments. Out: files, and a summary.

mod after_effects;
mod blender;
mod file_name;
mod gltf;
mod lattice_json;
mod map_size;
mod maps;
mod nuke;
mod source;
mod stmap;

use super::args::{ExportArgs, ExportFormat};
use super::outcome::Outcome;
use crate::image::Existing;
use anyhow::bail;

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    refuse_idle_flags(args)?;
    file_name::check(args)?;
    match args.to {
        ExportFormat::LatticeJson => lattice_json::run(args),
        ExportFormat::Stmap => stmap::run(args),
        ExportFormat::Nuke => nuke::run(args),
        ExportFormat::Blender => blender::run(args),
        ExportFormat::AfterEffects => after_effects::run(args),
        ExportFormat::Gltf => self::gltf::run(args),
    }
}

/// Rejects flags that have no effect with the chosen format.
fn refuse_idle_flags(args: &ExportArgs) -> anyhow::Result<()> {
    let has_maps = matches!(args.to, ExportFormat::Stmap | ExportFormat::Nuke | ExportFormat::AfterEffects);
    let format = args.to.name();
    if !args.layer.is_empty() && !has_maps && args.to != ExportFormat::LatticeJson {
        bail!(
            "--layer is for maps and lattices (--to stmap, nuke, after-effects or lattice-json), but --to {format} writes the \
             whole scene; leave it out"
        );
    }
    let given = [
        ("--inverse", args.inverse),
        ("--size", args.size.is_some()),
        ("--overscan", args.overscan > 0),
        ("--resume", Existing::from(args.existing).is_resume()),
    ];
    if let Some((flag, _)) = given.into_iter().find(|(_, is_given)| *is_given && !has_maps) {
        bail!("{flag} is for maps (--to stmap, nuke or after-effects), but --to {format} writes no maps; leave it out");
    }
    if args.inverse && args.to == ExportFormat::AfterEffects {
        bail!("displacement maps cannot be inverted; --inverse is for --to stmap and nuke");
    }
    Ok(())
}
