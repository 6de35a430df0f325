//! `pinwarp export --to gltf`: the warped scene as a .glb file with one morph target per frame.

use super::source::{Source, frames, is_on_screen, moved_layers, output};
use crate::cli::args::ExportArgs;
use crate::cli::outcome::Outcome;
use crate::export::gltf::{NodeMotion, glb};
use crate::image::replace_bytes;
use crate::pipeline::{BakeTimes, PreparedShot, input_files};
use crate::spelling::pluralised;
use anyhow::bail;
use std::io::{self, Write};

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    let output = output(args, "warped.glb")?;
    let prepared = Source::with_scene(args, "a glTF file needs the scene")?;
    input_files(&prepared)?.refuse(&output)?;
    let layers = moved_layers(&prepared);
    if layers.is_empty() {
        bail!("no layer of {} is warped: there is nothing to export; add pins", args.shot.display());
    }
    let frames = frames(args, &prepared);
    let baked = prepared.bake(
        &frames,
        BakeTimes::Clip,
        |layer| layers.contains(&layer),
        |frame| {
            tracing::info!("frame {frame} deformed");
        },
    )?;
    replace_bytes(&output, &glb(prepared.packed()?, &baked)?)?;
    let frames = pluralised(frames.len(), "frame", "frames");
    let nodes = pluralised(baked.nodes.len(), "deformed node", "deformed nodes");
    writeln!(io::stdout(), "wrote {}: {frames}, {nodes}", output.display())?;
    match baked.motion {
        NodeMotion::Keys { shift_secs } if shift_secs > 0.0 => {
            writeln!(io::stdout(), "note: its clip starts {shift_secs:.3} s later than the scene's")?;
        }
        NodeMotion::Sampled(_) => writeln!(io::stdout(), "note: the clip loops, so its nodes have one key per frame")?,
        NodeMotion::Keys { .. } => {}
    }
    for layer in layers {
        writeln!(io::stdout(), "layer '{}': {}", prepared.shot.layers[layer].name, accuracy(&prepared, layer))?;
    }
    Ok(Outcome::Complete)
}

/// Describes how exact the export of a layer is.
fn accuracy(prepared: &PreparedShot, layer: usize) -> &'static str {
    if is_on_screen(prepared, layer) {
        "warped on the screen: its vertices move across the view at their own depth, so the picture is right from the \
         shot's camera only; its normals stay"
    } else {
        "warped in the scene: exact at the exported frames"
    }
}
