//! `pinwarp check`: solves every frame and prints the warnings that a render would give.
//!
//! In: a shot and frames. Out: notes, warnings and the worst figures of each layer on standard output.

use super::args::CheckArgs;
use super::layer_notes::LayerNotes;
use super::outcome::Outcome;
use super::warnings::Warnings;
use crate::image::SequencePath;
use crate::pipeline::{FrameChecks, Jerk, Keeping, LayerReport, PreparedShot};
use crate::spelling::pluralised;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Explains the jerk figures.
const JERK_IN_WORDS: &str = "jerk: how much the acceleration of a point changes from frame to frame, in pixels per frame \
    cubed. It is 0 in steady motion, and high where a motion starts, stops, turns fast or flickers. A warning is given if the warp \
    is not smooth and jerks by more than 2 px and more than 6 times as much as the model and the keys that it follows.";

/// The worst figures of a layer over all frames.
#[derive(Default)]
struct Peaks {
    iterations: usize,
    /// Jerk of the warp, and its frame.
    jerk: Option<(Jerk, i32)>,
}

impl Peaks {
    fn add(&mut self, frame: i32, layer: &LayerReport) {
        self.iterations = self.iterations.max(layer.solve.iterations);
        let highest = self.jerk.map_or(f64::NEG_INFINITY, |(jerk, _)| jerk.warp_px);
        self.jerk = layer.jerk.filter(|jerk| jerk.warp_px > highest).map(|jerk| (jerk, frame)).or(self.jerk);
    }

    fn words(&self) -> String {
        let jerk = |(jerk, frame): &(Jerk, i32)| {
            let Jerk { warp_px, input_px } = jerk;
            format!("; its warp jerks by at most {warp_px:.1} px, in frame {frame} (model and keys: {input_px:.1} px)")
        };
        let jerk = self.jerk.as_ref().map(jerk).unwrap_or_default();
        // No iterations are counted per frame for layers solved over time, as their solve precedes the frames.
        match self.iterations {
            0 => format!("its frames are solved jointly{jerk}"),
            most => format!("solved in at most {} per frame{jerk}", pluralised(most, "iteration", "iterations")),
        }
    }
}

pub(super) fn run(args: &CheckArgs) -> anyhow::Result<Outcome> {
    let mut shot = args.outside.read(&args.shot)?;
    args.camera.choose(&mut shot);
    let output = shot.output.path.clone();
    let prepared = PreparedShot::new(shot)?.keeping_trajectories([output.as_path()], Keeping::Read);
    let shot = &prepared.shot;
    let frames = args.frames.clone().map_or_else(|| (shot.frames.first..=shot.frames.last).collect(), |list| list.0);
    let output = SequencePath::parse(&shot.output.path)?;
    output.check_frame_count(frames.len())?;
    let mut out = io::stdout().lock();
    for note in &prepared.notes {
        writeln!(out, "note: {note}")?;
    }
    let there = frames.iter().filter(|&&frame| output.path_of(frame).exists()).count();
    if there > 0 {
        let there = pluralised(there, "of the frames exists", "of the frames exist");
        writeln!(out, "note: {there} already; render with --resume or --overwrite")?;
    }
    let mut is_solved = true;
    let mut peaks: BTreeMap<String, Peaks> = BTreeMap::new();
    let mut checks = FrameChecks::default();
    let mut warnings = Warnings::default();
    let mut notes = LayerNotes::default();
    for &frame in &frames {
        match checks.report(&prepared, frame, |_| true) {
            Ok(report) => {
                report.warnings.iter().for_each(|warning| warnings.add(frame, warning));
                for line in notes.new_lines(&report.notes) {
                    writeln!(out, "{line}")?;
                }
                for layer in report.layers {
                    peaks.entry(layer.layer.clone()).or_default().add(frame, &layer);
                }
            }
            Err(error) => {
                is_solved = false;
                writeln!(out, "error: frame {frame}: {error}")?;
            }
        }
    }
    for warning in warnings.lines() {
        writeln!(out, "{warning}")?;
    }
    let triangles: usize =
        prepared.scene.meshes.iter().flat_map(|mesh| &mesh.primitives).map(|p| p.triangles.len()).sum();
    writeln!(
        out,
        "{}: {}, {}, {}, {}",
        args.shot.display(),
        pluralised(frames.len(), "frame", "frames"),
        pluralised(shot.layers.len(), "layer", "layers"),
        pluralised(prepared.scene.nodes.len(), "node", "nodes"),
        pluralised(triangles, "triangle", "triangles")
    )?;
    for (layer, peaks) in &peaks {
        writeln!(out, "layer '{layer}': {}", peaks.words())?;
    }
    if peaks.values().any(|peaks| peaks.jerk.is_some()) {
        writeln!(out, "{JERK_IN_WORDS}")?;
    }
    Ok(if is_solved { Outcome::Complete } else { Outcome::Partial })
}
