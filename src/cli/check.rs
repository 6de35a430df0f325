//! `pinwarp check`.

use super::Outcome;
use super::args::CheckArgs;
use crate::image::SequencePath;
use crate::pipeline::{Setup, report};
use crate::shot::Shot;
use std::collections::BTreeMap;
use std::io::{self, Write};

pub(super) fn run(args: &CheckArgs) -> anyhow::Result<Outcome> {
    let setup = Setup::new(Shot::read(&args.shot)?)?;
    let shot = &setup.shot;
    let frames = args.frames.clone().map_or_else(|| (shot.frames.first..=shot.frames.last).collect(), |list| list.0);
    let output = SequencePath::parse(&shot.output.path)?;
    output.check_frame_count(frames.len())?;
    let mut out = io::stdout().lock();
    for note in &setup.notes {
        writeln!(out, "note: {note}")?;
    }
    let there = frames.iter().filter(|&&frame| output.path_of(frame).exists()).count();
    if there > 0 {
        writeln!(out, "note: {there} of the frames exist already; render with --resume or --overwrite")?;
    }
    let mut is_solved = true;
    let mut iterations: BTreeMap<String, usize> = BTreeMap::new();
    for &frame in &frames {
        match setup.exposed(frame) {
            Ok(moment) => {
                let report = report(&setup, frame, &moment);
                for warning in &report.warnings {
                    writeln!(out, "warning: frame {frame}: {warning}")?;
                }
                for layer in report.layers {
                    let most = iterations.entry(layer.layer).or_default();
                    *most = layer.solve.iterations.max(*most);
                }
            }
            Err(error) => {
                is_solved = false;
                writeln!(out, "error: frame {frame}: {error}")?;
            }
        }
    }
    let triangles: usize = setup.scene.meshes.iter().flat_map(|mesh| &mesh.primitives).map(|p| p.triangles.len()).sum();
    writeln!(
        out,
        "{}: {} frames, {} layers, {} nodes, {triangles} triangles",
        args.shot.display(),
        frames.len(),
        shot.layers.len(),
        setup.scene.nodes.len()
    )?;
    for (layer, most) in iterations {
        writeln!(out, "layer '{layer}': solved in at most {most} iterations a frame")?;
    }
    Ok(if is_solved { Outcome::Complete } else { Outcome::Partial })
}
