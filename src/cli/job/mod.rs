//! `pinwarp job`: writes a job for a render farm. Schedulers run `pinwarp` itself on chunks of frames and need nothing
//! else.
//!
//! In: a shot, frames, the chunk size. Out: an Open Job Description template, or a script for Slurm.

mod openjd;
mod slurm;

use super::frames::FrameList;
use super::outcome::Outcome;
use super::outputs;
use super::shared_args::OverwriteArg;
use crate::image::{Inputs, SequencePath};
use crate::pipeline::{PreparedShot, input_files};
use crate::shot::{Shot, Source};
use crate::spelling::pluralised;
use anyhow::{Context, bail};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Approximate number of tasks of a job with the default chunk size.
const TARGET_TASKS: usize = 100;
/// Smallest default chunk in frames, so that loading the scene is a small part of a task.
const MIN_CHUNK: usize = 5;

#[derive(Debug, clap::Args)]
pub(super) struct JobArgs {
    /// Shot file.
    shot: PathBuf,
    /// Scheduler to write the job for.
    #[arg(long, value_name = "SCHEDULER", value_enum, default_value = "openjd")]
    to: Scheduler,
    /// Frames of the job, e.g. 1-48x2,60; default: the shot's range.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<FrameList>,
    /// Number of frames per task; default: enough for about 100 tasks, at least 5.
    #[arg(long, value_name = "FRAMES", value_parser = clap::value_parser!(u32).range(1..))]
    chunk: Option<u32>,
    /// Warp finished frames instead of rendering the shot's scene: the path of the plates and the output path.
    #[arg(long, num_args = 2, value_names = ["PLATE", "WARPED"])]
    warp: Vec<PathBuf>,
    /// Command that starts pinwarp on the farm's machines.
    #[arg(long, value_name = "PROGRAM", default_value = "pinwarp")]
    program: String,
    /// File to write; default: the shot's name with .openjd.json or .slurm.sh, beside the shot.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArg,
    /// Arguments passed to every `render` or `warp` of the job, e.g. -- --device cpu --preview.
    #[arg(last = true, value_name = "ARGUMENTS")]
    extra_arguments: Vec<String>,
}

/// The supported schedulers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Scheduler {
    /// Open Job Description, jobtemplate-2023-09: for AWS Deadline Cloud, or for `openjd run` on one machine.
    Openjd,
    /// A script that submits itself to Slurm: one job before all frames, an array job for the frames, one job after them.
    Slurm,
}

/// The work of a job, independent of the scheduler.
struct Plan {
    /// Name of the job: that of the shot file.
    name: String,
    program: String,
    shot: PathBuf,
    /// `bake SHOT`, with -o WARPED for plates.
    bake: Vec<String>,
    /// `render SHOT`, or `warp PLATE --shot SHOT -o WARPED`.
    work: Vec<String>,
    /// `report SHOT`, or `report WARPED`.
    report: Vec<String>,
    /// Arguments common to all tasks.
    extra_arguments: Vec<String>,
    /// In ascending order.
    frames: Vec<i32>,
    chunk: usize,
    /// Files that are read.
    inputs: Inputs,
    /// Folder of the written file.
    template_folder: PathBuf,
    /// Folder of the finished frames.
    folder: PathBuf,
}

pub(super) fn run(args: &JobArgs) -> anyhow::Result<Outcome> {
    let ending = match args.to {
        Scheduler::Openjd => "openjd.json",
        Scheduler::Slurm => "slurm.sh",
    };
    let output = args.output.clone().unwrap_or_else(|| args.shot.with_extension(ending));
    let plan = Plan::new(args, &output)?;
    let text = match args.to {
        Scheduler::Openjd => openjd::template(&plan)?,
        Scheduler::Slurm => slurm::script(&plan)?,
    };
    outputs::allow_text(&plan.inputs, (&output, &text), args.overwrite)?;
    std::fs::write(&output, &text).with_context(|| format!("{} cannot be written", output.display()))?;
    let tasks = pluralised(plan.frames.len().div_ceil(plan.chunk), "task", "tasks");
    let frames = pluralised(plan.frames.len(), "frame", "frames");
    let next = match args.to {
        Scheduler::Openjd => format!("openjd run {} --step Report --run-dependencies", output.display()),
        Scheduler::Slurm => format!("bash {}", output.display()),
    };
    writeln!(io::stdout(), "wrote {}: {frames} in {tasks}; next: {next}", output.display())?;
    Ok(Outcome::Complete)
}

impl Plan {
    /// Loads the shot, so that its errors are found before the farm is busy.
    fn new(args: &JobArgs, output: &Path) -> anyhow::Result<Self> {
        let shot_path = std::path::absolute(&args.shot)?;
        let shot = Shot::read(&shot_path)?;
        let is_over_plates = shot.source == Source::Frame;
        let prepared = PreparedShot::new(shot)?;
        let shot = &prepared.shot;
        let shot_text = outputs::as_text(&shot_path)?.to_owned();
        let mut inputs = input_files(&prepared)?;
        let (bake, work, report, frames_path) = match (args.warp.as_slice(), is_over_plates) {
            ([plate, warped], _) => {
                let [plate, warped] = [std::path::absolute(plate)?, std::path::absolute(warped)?];
                inputs.add_sequence(&SequencePath::of_input(&plate)?)?;
                let [plate, pattern] = [outputs::as_text(&plate)?, outputs::as_text(&warped)?].map(str::to_owned);
                let work = ["warp", &plate, "--shot", &shot_text, "-o", &pattern].map(str::to_owned).to_vec();
                let bake = ["bake", &shot_text, "-o", &pattern].map(str::to_owned).to_vec();
                (bake, work, vec!["report".to_owned(), pattern], warped)
            }
            (_, true) => bail!(
                "{}: this shot warps finished frames; say which, and where warped ones go: --warp beauty.####.exr warped.####.exr",
                args.shot.display()
            ),
            _ => {
                let folder = shot.output.path.clone();
                let [bake, work, report] =
                    ["bake", "render", "report"].map(|command| vec![command.to_owned(), shot_text.clone()]);
                (bake, work, report, std::path::absolute(folder)?)
            }
        };
        let mut frames =
            args.frames.clone().map_or_else(|| (shot.frames.first..=shot.frames.last).collect(), |list| list.0);
        frames.sort_unstable();
        SequencePath::parse(&frames_path)?.check_frame_count(frames.len())?;
        let chunk =
            args.chunk.map_or_else(|| frames.len().div_ceil(TARGET_TASKS).max(MIN_CHUNK), |chunk| chunk as usize);
        let name = name_of(&shot_path);
        let folder = frames_path.parent().unwrap_or(Path::new("/")).to_owned();
        let template_folder = std::path::absolute(output)?.parent().unwrap_or(Path::new("/")).to_owned();
        let (program, extra_arguments) = (args.program.clone(), args.extra_arguments.clone());
        Ok(Self {
            bake,
            name,
            program,
            shot: shot_path,
            work,
            report,
            extra_arguments,
            frames,
            chunk,
            inputs,
            template_folder,
            folder,
        })
    }
}

/// Returns the name of the shot's file, or of its folder if the file is called `shot.toml`.
fn name_of(shot: &Path) -> String {
    let folder = shot.parent().and_then(Path::file_name);
    let name = shot.file_stem().filter(|stem| *stem != "shot").or(folder).or(shot.file_stem());
    name.unwrap_or_default().to_string_lossy().into_owned()
}

/// Formats frames in the notation of Open Job Description, which `--frames` accepts, too: `1-4,7,9-13:2`.
fn list_of(frames: &[i32]) -> String {
    let mut items = Vec::new();
    let mut rest = frames;
    while let [first, ..] = rest {
        let step = rest.get(1).map_or(1, |second| second - first);
        let count = 1 + rest.windows(2).take_while(|pair| pair[1] - pair[0] == step).count();
        // Two frames with a gap are listed separately: 1,9.
        let count = if count == 2 && step > 1 { 1 } else { count };
        let last = first + (count as i32 - 1) * step;
        items.push(match (count, step) {
            (1, _) => first.to_string(),
            (_, 1) => format!("{first}-{last}"),
            _ => format!("{first}-{last}:{step}"),
        });
        rest = &rest[count..];
    }
    items.join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_frames_are_read_back() {
        for (frames, text) in [
            (vec![1, 2, 3, 4], "1-4"),
            (vec![7], "7"),
            (vec![1, 9], "1,9"),
            (vec![1, 3, 5, 7, 8], "1-7:2,8"),
            (vec![-3, -2, 0, 10, 20, 30], "-3--2,0-30:10"),
        ] {
            let list = list_of(&frames);
            assert_eq!(list.parse(), Ok(FrameList(frames.clone())), "{list}");
            if text != "-3--2,0-30:10" {
                assert_eq!(list, text);
            }
        }
    }
}
