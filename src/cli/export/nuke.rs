//! `pinwarp export --to nuke`: a script with the maps and the grids, and the maps beside it.

use super::maps::Maps;
use super::source::output;
use super::stmap;
use crate::cli::args::ExportArgs;
use crate::cli::outcome::Outcome;
use crate::cli::outputs;
use crate::export::nuke::{LostBranches, NukeScene, script};
use crate::image::{replace_text, without_counter};
use crate::spelling::pluralised;
use std::io::{self, Write};

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    let output = output(args, "nk")?;
    let (maps, prepared) = Maps::open(args)?;
    let pattern = without_counter(&output).with_extension("stmap.####.exr");
    let frames = &maps.frames;
    let ends = [frames.first(), frames.last()].map(|frame| frame.copied().unwrap_or_default());
    let name = pattern.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let text = script(&NukeScene { lattices: &maps.lattices, stmap: name, frames: ends, size: maps.size });
    outputs::allow_text(&maps.inputs, (&output, &text), args.existing)?;
    let written = stmap::write(args, (&maps, prepared.as_deref()), &pattern)?;
    replace_text(&output, &text)?;
    stmap::print_written(&pattern, &written)?;
    for layer in &maps.lattices.layers {
        let Some(lost) = LostBranches::of(layer, maps.size) else { continue };
        let remedy = "the STMap beside it holds all of them, `pinwarp warp` gives them soft edges, and --to gltf and blender bake them into \
                      the meshes of a scene";
        writeln!(
            io::stderr(),
            "note: layer '{}': its grid holds the largest branch only, {lost}; {remedy}",
            layer.name
        )?;
    }
    let grids = pluralised(maps.lattices.layers.len(), "grid", "grids");
    writeln!(io::stdout(), "wrote {}: an STMap and {grids} (GridWarp3, not verified in Nuke)", output.display())?;
    Ok(Outcome::Complete)
}
