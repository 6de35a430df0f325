//! `pinwarp export --to blender`: a script that builds lattice objects, and the scene that it imports.

use super::source::{Source, frames, moved_layers, output};
use crate::cli::args::ExportArgs;
use crate::cli::outcome::Outcome;
use crate::cli::outputs;
use crate::export::blender::{BlenderLayer, BlenderMethod, BlenderScene, number_nodes, script};
use crate::export::gltf::glb;
use crate::image::{replace_bytes, replace_text};
use crate::pipeline::{BakeTimes, PreparedShot, input_files};
use anyhow::bail;
use std::io::{self, Write};
use std::path::Path;

pub(super) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    let output = output(args, "blender.py")?;
    let scene_path = output.with_extension("glb");
    if scene_path == output {
        bail!("{}: the script needs another name than the scene beside it; let it end in .py", output.display());
    }
    outputs::allow(&outputs::inputs_of([&args.shot]), &scene_path, args.existing)?;
    let prepared = Source::with_scene(args, "Blender needs the scene")?;
    let inputs = input_files(&prepared)?;
    [&output, &scene_path].into_iter().try_for_each(|path| inputs.refuse(path))?;
    let moved = moved_layers(&prepared);
    if moved.is_empty() {
        bail!("no layer of {} is warped: there is nothing to export; add pins", args.shot.display());
    }
    let mut frames = frames(args, &prepared);
    frames.sort_unstable();
    let layers = moved.iter().map(|&layer| prepared.blender_layer(layer, &frames)).collect::<Result<Vec<_>, _>>()?;
    let is_baked = |layer: usize| {
        moved.iter().zip(&layers).any(|(&moved, told)| moved == layer && matches!(told.method, BlenderMethod::Baked(_)))
    };
    let baked =
        prepared.bake(&frames, BakeTimes::Frames, is_baked, |frame| tracing::info!("frame {frame} deformed"))?;
    let mut packed = prepared.packed()?;
    number_nodes(&mut packed, &prepared.scene);
    replace_bytes(&scene_path, &glb(packed, &baked)?)?;
    drop(baked);
    let scene = blender_scene(&prepared, (&frames, &scene_path), layers);
    replace_text(&output, &script(&scene))?;
    report(&scene, (&output, &scene_path))?;
    Ok(Outcome::Complete)
}

fn blender_scene(prepared: &PreparedShot, (frames, path): (&[i32], &Path), layers: Vec<BlenderLayer>) -> BlenderScene {
    let ends = [frames.first(), frames.last()].map(|frame| frame.copied().unwrap_or_default());
    let (_, camera) = prepared.view(f64::from(ends[0]));
    BlenderScene {
        scene_file: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        rate: prepared.shot.frames.rate,
        frames: ends,
        frame_offset: prepared.file_frames(frames),
        size: prepared.shot.size,
        camera: (prepared.blender_camera(), camera.lens()),
        layers,
    }
}

fn report(scene: &BlenderScene, (script, file): (&Path, &Path)) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "wrote {} and {}", script.display(), file.display())?;
    writeln!(out, "run it: blender --python {}", script.display())?;
    if scene.frame_offset > 0 {
        writeln!(out, "note: frames in Blender are {} later than the shot's, which start below 0", scene.frame_offset)?;
    }
    for layer in &scene.layers {
        match &layer.method {
            BlenderMethod::Lattice(lattice) => {
                let [x, y, z] = lattice.dims;
                writeln!(out, "layer '{}': a lattice object of {x} x {y} x {z} points, exact", layer.name)?;
            }
            BlenderMethod::Baked(why) => {
                writeln!(out, "layer '{}': baked shape keys, no lattice: {why}", layer.name)?;
            }
        }
    }
    Ok(())
}
