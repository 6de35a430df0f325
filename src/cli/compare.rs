//! `pinwarp compare`: deforms a problem, or a layer of a shot, with several methods.
//!
//! In: a problem file, or a shot and a frame. Out: a table or JSON lines; a picture with one panel per method.

use super::args::CompareArgs;
use super::outcome::{Outcome, OutputCutOff};
use super::outputs;
use crate::compare::{self, ColorRun, Entry, SheetModel};
use crate::image::{FileKind, write_png};
use crate::lattice::Basis;
use crate::pipeline::{Keeping, PreparedShot, input_files, layer_problem};
use crate::shot::{Layer, LayerSpace, Shot};
use crate::solve::methods::{self, Deformer};
use crate::solve::problem_file::{self, Figures};
use crate::solve::{Problem, Topology};
use crate::spelling;
use anyhow::{Context, bail};
use std::io::Write;

pub(super) fn run(args: &CompareArgs) -> anyhow::Result<Outcome> {
    if let Some(path) = &args.output {
        outputs::allow(&outputs::inputs_of([&args.input]), path, args.overwrite)?;
    }
    if FileKind::of(&args.input) == Some(FileKind::Shot) {
        if args.pose.is_some() {
            bail!("--pose: {} is a shot, which has frames; give --frame", args.input.display());
        }
        return run_shot(args);
    }
    if args.frame.is_some() || args.layer.is_some() {
        let given = if args.frame.is_some() { "--frame" } else { "--layer" };
        bail!("{given}: {} is a problem, which has poses; give --pose", args.input.display());
    }
    match problem_file::read_figure(&args.input)? {
        Figures::Plane(figure) => {
            let color_runs: Vec<ColorRun> = figure.parts.iter().map(|part| (part.triangles, part.color)).collect();
            let pose = pose(args, &figure)?;
            let (problem, title) = (figure.problem(pose), titled(&figure.name, &pose.name));
            run_plane(args, &SheetModel { problem: &problem, color_runs: &color_runs, title: &title })
        }
        Figures::Space(figure) => {
            if let Some(path) = &args.output {
                bail!("{}: sheets show problems in the plane; leave out -o to get the table", path.display());
            }
            print(args, &entries(args, &figure.problem(pose(args, &figure)?))?)
        }
    }
}

/// Compares on a layer's screen-space shape at the requested frame.
fn run_shot(args: &CompareArgs) -> anyhow::Result<Outcome> {
    let shot = args.outside.read(&args.input)?;
    let frame = args.frame.unwrap_or(shot.frames.first);
    let names: Vec<&str> = shot.layers.iter().map(|layer| layer.name.as_str()).collect();
    let layer = match &args.layer {
        None => 0,
        Some(name) => {
            let found = names.iter().position(|known| known == name);
            found.with_context(|| format!("there is no layer '{name}'; {}", spelling::list(names.iter().copied())))?
        }
    };
    let title = names.get(layer).map(|name| titled(name, &format!("frame {frame}"))).unwrap_or_default();
    let output = shot.output.path.clone();
    let prepared = PreparedShot::new(shot)?.keeping_trajectories([output.as_path()], Keeping::Read);
    if let Some(path) = &args.output {
        input_files(&prepared)?.refuse(path)?;
    }
    let Some(posed) = layer_problem(&prepared, layer, f64::from(frame))? else {
        bail!("{}", why_unsolved(&prepared.shot, layer, frame));
    };
    if prepared.shot.layers[layer].settings.topology == Topology::Branching {
        let name = &prepared.shot.layers[layer].name;
        writeln!(
            std::io::stderr(),
            "note: the lattice of layer '{name}' branches; methods are compared without branches"
        )?;
    }
    run_plane(args, &SheetModel { problem: &posed.problem(), color_runs: &[], title: &title })
}

/// Returns why a layer of a shot has nothing to compare in a frame, and how to fix it.
fn why_unsolved(shot: &Shot, layer: usize, frame: i32) -> String {
    match shot.layers.get(layer) {
        None => "the shot has no layers; add one with pins".to_owned(),
        Some(Layer { name, space: LayerSpace::World { .. }, .. }) => {
            format!("layer '{name}' is a world layer; choose a screen layer (--layer)")
        }
        Some(Layer { name, .. }) => format!(
            "layer '{name}' has nothing to solve in frame {frame}: it is out of sight, or has no active pins; choose \
             another frame (--frame) or layer (--layer)"
        ),
    }
}

fn run_plane(args: &CompareArgs, figure: &SheetModel) -> anyhow::Result<Outcome> {
    let entries = entries(args, figure.problem)?;
    if let Some(path) = &args.output {
        write_png(path, &compare::comparison_sheet(figure, &entries))?;
    }
    print(args, &entries)
}

fn entries<const D: usize>(args: &CompareArgs, problem: &Problem<D>) -> anyhow::Result<Vec<Entry<D>>> {
    let known = methods::all::<D>();
    let keys: Vec<&str> = known.iter().map(|method| method.key()).collect();
    if let Some(wrong) = args.methods.iter().find(|key| !keys.contains(&key.as_str())) {
        bail!("there is no method '{wrong}'; {}", spelling::list(keys.iter().copied()));
    }
    let is_chosen =
        |method: &dyn Deformer<D>| args.methods.is_empty() || args.methods.iter().any(|key| key == method.key());
    let chosen: Vec<&dyn Deformer<D>> = known.iter().map(AsRef::as_ref).filter(|method| is_chosen(*method)).collect();
    let mut entries = Vec::new();
    let published = known.iter().find_map(|method| method.basis());
    for basis in bases(&args.basis, published, problem.grid.basis) {
        for method in &chosen {
            let entry = compare::run_on(*method, problem, basis);
            entries.push(entry.with_context(|| format!("method '{}', {}", method.key(), basis.label()))?);
        }
    }
    Ok(entries)
}

/// Returns the bases to compare: the chosen ones, or that of the published methods and that of the problem.
fn bases(chosen: &[Basis], published: Option<Basis>, own: Basis) -> Vec<Basis> {
    let default = if chosen.is_empty() { [published, Some(own)] } else { [None; 2] };
    let mut bases: Vec<Basis> = Vec::new();
    for basis in default.into_iter().flatten().chain(chosen.iter().copied()) {
        if !bases.contains(&basis) {
            bases.push(basis);
        }
    }
    bases
}

fn print<const D: usize>(args: &CompareArgs, entries: &[Entry<D>]) -> anyhow::Result<Outcome> {
    let mut out = std::io::stdout();
    if args.json {
        for entry in entries {
            let line = serde_json::json!({"method": entry.method, "basis": entry.basis, "figures": entry.metrics});
            out.write_all((line.to_string() + "\n").as_bytes()).map_err(OutputCutOff)?;
        }
    } else {
        write!(out, "{}", compare::table(entries))?;
    }
    Ok(Outcome::Complete)
}

/// Returns the requested pose, or the first.
fn pose<'a, const D: usize>(
    args: &CompareArgs,
    figure: &'a problem_file::Figure<D>,
) -> anyhow::Result<&'a problem_file::FigurePose<D>> {
    let Some(name) = &args.pose else { return Ok(&figure.poses[0]) };
    let names = figure.poses.iter().map(|pose| pose.name.as_str());
    let hint = spelling::list(names);
    let found = figure.poses.iter().find(|pose| pose.name == *name);
    found.with_context(|| format!("{}: there is no pose '{name}'; {hint}", args.input.display()))
}

fn titled(name: &str, pose: &str) -> String {
    [name, pose].into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>().join(": ")
}
