//! All command-line arguments; help, manual pages and completions are generated from these definitions.
//!
//! In: the words of the command line. Out: one struct of plain values per command.

use super::frames::{FrameList, Scale};
use super::job::JobArgs;
use super::report::ReportArgs;
use super::shared_args::{ExistingArgs, FsyncArg, OutsideArg, OverwriteArg, ProgressArgs, device_parser};
use super::warp_args::WarpArgs;
use crate::lattice::Basis;
use crate::memory::MemoryLimit;
use crate::raster::DeviceChoice;
use crate::shot::{CameraRule, Shot};
use clap::{ArgAction, Parser, Subcommand};
use clap_complete::Shell;
use std::path::PathBuf;

/// Warps animated glTF scenes with pins placed on the screen, and writes EXR sequences.
#[derive(Debug, Parser)]
#[command(name = "pinwarp", version, propagate_version = true, after_help = EXIT_CODES)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub(super) command: Command,

    /// Print more: -v what is done, -vv every detail.
    #[arg(short, long, action = ArgAction::Count, global = true)]
    pub(super) verbose: u8,

    /// Memory that pictures and frames may take together: 8G, 512M or a share of what the system has, 50% [default: 75%].
    /// A frame that needs more fails; the others go on.
    #[arg(long, value_name = "SIZE", global = true)]
    pub(super) max_memory: Option<MemoryLimit>,
}

const EXIT_CODES: &str = "Exit codes: 0 all good, 1 some frames failed, 2 bad input or usage.";

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Render a shot into an EXR sequence.
    #[command(
        after_long_help = "Examples:\n  pinwarp render shot.toml --frames 1 --preview --overlay\n  pinwarp render shot.toml --resume --json"
    )]
    Render(RenderArgs),
    /// Warp finished frames of any renderer: all their channels, by their meaning.
    #[command(
        after_long_help = "Examples:\n  pinwarp warp beauty.####.exr --shot shot.toml -o warped.####.exr\n  pinwarp warp frame.png --lattice arm.lattice.json -o bent.png"
    )]
    Warp(Box<WarpArgs>),
    /// Solve layers over time ahead of their frames, for farms.
    #[command(
        after_long_help = "Examples:\n  pinwarp bake shot.toml\n  pinwarp bake shot.toml -o /farm/out/frame.####.exr --json"
    )]
    Bake(BakeArgs),
    /// Write a commented, working shot file for a scene or a picture.
    #[command(
        after_long_help = "Examples:\n  pinwarp new character.glb -o shot.toml\n  pinwarp new drawing.png -o shot.toml"
    )]
    New(NewArgs),
    /// Report everything a render would fail on or warn of, without rendering.
    #[command(after_long_help = "Examples:\n  pinwarp check shot.toml\n  pinwarp check shot.toml --frames 1-48x4")]
    Check(CheckArgs),
    /// Open a window in which pins are placed and dragged.
    #[cfg(feature = "editor")]
    #[command(
        after_long_help = "Examples:\n  pinwarp edit\n  pinwarp edit character.glb\n  pinwarp edit shot.toml --frame 12 --screenshot editor.png"
    )]
    Edit(EditArgs),
    /// Cast a screen point onto the model and print a ready pin.
    #[command(
        after_long_help = "Examples:\n  pinwarp pick shot.toml --at-px 960,540\n  pinwarp pick shot.toml --at 0.9,0.5 --write nose --layer head"
    )]
    Pick(PickArgs),
    /// Tell the state of finished frames: missing and damaged ones, the worst figures; exit code 1 over limits.
    #[command(
        after_long_help = "Examples:\n  pinwarp report out/ --sheet sheet.png\n  pinwarp report shot.toml --verify --max-pin-error 0.5 --max-folds 0"
    )]
    Report(ReportArgs),
    /// Write a job for a render farm: an Open Job Description template, or a script for Slurm.
    #[command(
        after_long_help = "Examples:\n  pinwarp job shot.toml\n  pinwarp job shot.toml --to slurm --chunk 8 -- --device cpu"
    )]
    Job(JobArgs),
    /// Solve a bare lattice problem (JSON in, JSON out).
    #[command(after_long_help = "Examples:\n  pinwarp solve problem.json -o result.json")]
    Solve(SolveArgs),
    /// Deform a problem or a shot's layer with several methods, side by side.
    #[command(after_long_help = "Examples:\n  pinwarp compare shot.toml --frame 12 -o sheet.png")]
    Compare(CompareArgs),
    /// Write the warp of a shot for other shots and programs.
    #[command(
        after_long_help = "Examples:\n  pinwarp export shot.toml --to nuke -o comp/shot.nk\n  pinwarp export shot.toml --to stmap -o maps/m.####.exr --resume"
    )]
    Export(ExportArgs),
    /// Find the lattice that carries landmarks of one picture or pose onto those of another.
    #[command(
        after_long_help = "Examples:\n  pinwarp fit drawing.png render.png --pairs pairs.csv -o drawing.lattice.json"
    )]
    Fit(FitArgs),
    /// Lay the solved lattices of one shot over a picture, another model or another shot, and render it.
    #[command(
        after_long_help = "Examples:\n  pinwarp transfer --lattice arm.lattice.json --onto other.png -o out.####.exr"
    )]
    Transfer(TransferArgs),
    /// Give the lattices of a file other dims or another basis, and keep the edit.
    #[command(after_long_help = "Examples:\n  pinwarp resize arm.lattice.json --dims 20,20 -o fine.lattice.json")]
    Resize(ResizeArgs),
    /// List what a file holds: nodes, clips and cameras of a scene, channels of a picture, layers of a shot.
    #[command(after_long_help = "Examples:\n  pinwarp info character.glb\n  pinwarp info beauty.0001.exr --json")]
    Info(InfoArgs),
    /// List what can draw.
    #[command(
        after_long_help = "Choose one by its number or a part of its name:\n  pinwarp render shot.toml --device 0\n  pinwarp render shot.toml --device cpu"
    )]
    Devices,
    /// Print completions for a shell.
    #[command(
        after_long_help = "Examples:\n  pinwarp completions bash > ~/.local/share/bash-completion/completions/pinwarp"
    )]
    Completions {
        /// Which shell.
        shell: Shell,
    },
    /// Print the manual: the pages of all commands, or write them into a folder.
    #[command(after_long_help = "Examples:\n  pinwarp man | man -l -\n  pinwarp man -o ~/.local/share/man/man1")]
    Man(ManArgs),
}

#[derive(Debug, clap::Args)]
pub(super) struct ManArgs {
    /// Write one page for each command into this folder, e.g. ~/.local/share/man/man1; default: print them.
    #[arg(short, long, value_name = "FOLDER")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) overwrite: OverwriteArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct RenderArgs {
    /// The shot file.
    pub(super) shot: PathBuf,
    #[command(flatten)]
    pub(super) draw: DrawArgs,
}

#[derive(Debug, clap::Args)]
pub(super) struct BakeArgs {
    /// The shot file.
    pub(super) shot: PathBuf,
    /// Where the frames will go, instead of the shot's output: what is solved is kept in a folder beside them.
    #[arg(short, long, value_name = "PATH")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) camera: CameraArg,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
    #[command(flatten)]
    pub(super) progress: ProgressArgs,
}

/// What is drawn of a shot, how, and where it goes.
#[derive(Debug, clap::Args)]
pub(super) struct DrawArgs {
    /// Frames to render, e.g. 1-48x2,60; default: the shot's range.
    ///
    /// Numbers and ranges with commas between them; 1-48x2 is every second frame from 1 to 48. They are rendered in this
    /// order, and may lie outside the shot's range, where keys hold.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub(super) frames: Option<FrameList>,
    /// Size of the picture relative to the shot's: 1/2, 0.5, 50%.
    #[arg(long, value_name = "FACTOR", default_value = "1")]
    pub(super) scale: Scale,
    /// Samples per pixel, instead of the shot's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(super) samples: Option<u32>,
    /// Output path, instead of the shot's: frame.####.exr or frame.%04d.exr.
    #[arg(short, long, value_name = "PATH")]
    pub(super) output: Option<PathBuf>,
    /// What draws: auto (a graphics card where there is one, else the CPU), cpu, vulkan (the best Vulkan device, be it a
    /// software driver), or a Vulkan device by index or part of its name.
    #[arg(long, value_name = "DEVICE", default_value = "auto", value_parser = device_parser())]
    pub(super) device: DeviceChoice,
    #[command(flatten)]
    pub(super) camera: CameraArg,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
    #[command(flatten)]
    pub(super) existing: ExistingArgs,
    #[command(flatten)]
    pub(super) fsync: FsyncArg,
    /// Write an sRGB PNG beside every frame.
    #[arg(long)]
    pub(super) preview: bool,
    /// Write the preview with the lattice, pins, targets and folded cells drawn over it.
    ///
    /// A legend in the lower left corner names the marks. Filled red cells fold where the model lies, outlined ones where
    /// nothing is seen.
    #[arg(long)]
    pub(super) overlay: bool,
    #[command(flatten)]
    pub(super) progress: ProgressArgs,
}

/// Which camera sees a shot.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct CameraArg {
    /// Camera instead of the shot's: one of the scene by name, or a view: front, back, left, right, side, top, bottom,
    /// three-quarter or fit; front:body fits it to layer `body`.
    #[arg(long, value_name = "CAMERA", value_parser = clap::builder::NonEmptyStringValueParser::new())]
    camera: Option<String>,
}

impl CameraArg {
    /// Replaces the shot's camera if the arguments select another one.
    pub(super) fn choose(&self, shot: &mut Shot) {
        if let Some(name) = &self.camera {
            shot.camera = CameraRule::Named(name.clone());
        }
    }
}

#[derive(Debug, clap::Args)]
pub(super) struct NewArgs {
    /// The scene: .glb or .gltf; or a picture: .png, .jpg or .exr.
    pub(super) scene: PathBuf,
    /// The shot file to write.
    #[arg(short, long, value_name = "SHOT", default_value = "shot.toml")]
    pub(super) output: PathBuf,
    #[command(flatten)]
    pub(super) overwrite: OverwriteArg,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct InfoArgs {
    /// A scene (.glb, .gltf), a picture (.exr, .png, .jpg), a shot (.toml) or lattices (.json).
    pub(super) file: PathBuf,
    /// Print one JSON object instead of words.
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct CheckArgs {
    /// The shot file.
    pub(super) shot: PathBuf,
    /// Frames to check, e.g. 1-48x2,60; default: the shot's range.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub(super) frames: Option<FrameList>,
    #[command(flatten)]
    pub(super) camera: CameraArg,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct PickArgs {
    /// The shot file.
    pub(super) shot: PathBuf,
    /// Frame in which the point is seen; default: the shot's first.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub(super) frame: Option<i32>,
    /// Screen point in frame heights, x right, y up, from the lower left: 0.9,0.5.
    #[arg(long, value_name = "X,Y", value_parser = parse_pair, allow_hyphen_values = true,
          required_unless_present = "at_px", conflicts_with = "at_px")]
    pub(super) at: Option<[f64; 2]>,
    /// Screen point in pixels of the shot's size, y down, as picture viewers show it: 960,540.
    #[arg(long, value_name = "X,Y", value_parser = parse_pair, allow_hyphen_values = true)]
    pub(super) at_px: Option<[f64; 2]>,
    /// Put the pin into the shot file under this name.
    #[arg(long, value_name = "NAME")]
    pub(super) write: Option<String>,
    /// Layer that gets the pin; default: the one that claims the surface.
    #[arg(long, value_name = "LAYER")]
    pub(super) layer: Option<String>,
    #[command(flatten)]
    pub(super) camera: CameraArg,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
}

#[cfg(feature = "editor")]
#[derive(Debug, clap::Args)]
pub(super) struct EditArgs {
    /// A shot (.toml), a scene (.glb, .gltf), a picture, or plates (frame.####.exr); default: the editor offers some.
    pub(super) file: Option<PathBuf>,
    /// Frame that is seen; default: the shot's first.
    #[arg(long, value_name = "N", allow_hyphen_values = true, requires = "screenshot")]
    pub(super) frame: Option<i32>,
    /// Draw the editor into a PNG file instead of opening a window; needs no display.
    #[arg(long, value_name = "PNG", requires = "file")]
    pub(super) screenshot: Option<PathBuf>,
    /// Size of the screenshot in pixels.
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "1440x900")]
    pub(super) size: [u32; 2],
    /// The screenshot shows the light theme.
    #[arg(long, requires = "screenshot")]
    pub(super) light: bool,
    /// What draws, as for `pinwarp render`.
    #[arg(long, value_name = "DEVICE", default_value = "auto", value_parser = device_parser())]
    pub(super) device: DeviceChoice,
    #[command(flatten)]
    pub(super) overwrite: OverwriteArg,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct SolveArgs {
    /// The problem, JSON.
    pub(super) problem: PathBuf,
    /// Where the result goes; default: standard output.
    #[arg(short, long, value_name = "RESULT")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) overwrite: OverwriteArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct ExportArgs {
    /// The shot file; a lattice file (.json) where no scene is needed.
    #[arg(value_name = "SHOT-OR-LATTICES")]
    pub(super) shot: PathBuf,
    /// What is written.
    #[arg(long, value_name = "FORMAT", value_enum)]
    pub(super) to: ExportFormat,
    /// The file to write; default: the shot's name with the format's ending.
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Frames to export, e.g. 1-48x2,60; default: all of the shot or the file.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub(super) frames: Option<FrameList>,
    #[command(flatten)]
    pub(super) existing: ExistingArgs,
    /// Maps of this layer alone, for an element that is matted; default: of the whole picture.
    #[arg(long, value_name = "NAME")]
    pub(super) layer: Option<String>,
    /// Maps that undo the warp.
    #[arg(long)]
    pub(super) inverse: bool,
    /// Size of maps in pixels, e.g. 1920x1080; default: the shot's, else 1080 lines.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(super) size: Option<[u32; 2]>,
    /// Pixels around the frame that maps cover, too.
    #[arg(long, value_name = "PIXELS", default_value = "0", value_parser = clap::value_parser!(u32).range(0..=16384))]
    pub(super) overscan: u32,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
}

/// What `export` writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum ExportFormat {
    /// Solved lattices in the program's own open format, see docs/LATTICE.md.
    LatticeJson,
    /// Maps of where every pixel comes from, for any compositor (EXR, 32 bits).
    Stmap,
    /// A Nuke script: the STMaps applied, and the lattices as grids.
    Nuke,
    /// A Python script that builds lattice objects with keyed shapes, and the scene beside it.
    Blender,
    /// The warped scene, one morph target a frame (.glb).
    Gltf,
    /// Displacement maps for After Effects, and the settings of its effect.
    AfterEffects,
}

#[derive(Debug, clap::Args)]
pub(super) struct FitArgs {
    /// What is bent: a picture (its alpha is the shape), or a shot or scene in one frame.
    pub(super) a: PathBuf,
    /// What it should look like: a picture or a shot, of which only the size counts.
    pub(super) b: PathBuf,
    /// Points of A and where they are in B: JSON or CSV, see docs/EXPORT.md.
    #[arg(long, value_name = "FILE")]
    pub(super) pairs: PathBuf,
    /// Handles along each axis.
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_value = "10,10")]
    pub(super) dims: Vec<usize>,
    /// How handles are blended: bspline, bernstein, bilinear or barytri; default: bspline.
    #[arg(long, value_name = "BASIS", value_parser = parse_basis)]
    pub(super) basis: Option<Basis>,
    /// Frame of a shot, and number of the frame in the lattice file; default: the shot's first, else 1.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub(super) frame: Option<i32>,
    /// Layer of a shot; default: its only one.
    #[arg(long, value_name = "NAME")]
    pub(super) layer: Option<String>,
    /// The lattice file to write.
    #[arg(short, long, value_name = "FILE", default_value = "fit.lattice.json")]
    pub(super) output: PathBuf,
    #[command(flatten)]
    pub(super) overwrite: OverwriteArg,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct TransferArgs {
    /// The lattice file, as `pinwarp export --to lattice-json` writes it.
    #[arg(long, value_name = "FILE")]
    pub(super) lattice: PathBuf,
    /// What it bends: a picture (.png, .jpg, .exr), a scene (.glb, .gltf), or a shot (.toml).
    #[arg(long, value_name = "TARGET")]
    pub(super) onto: PathBuf,
    /// Layer of the lattice file; default: its only one, onto a shot the one of the same name.
    #[arg(long, value_name = "NAME")]
    pub(super) layer: Option<String>,
    /// Where the lattices go; default: box, with --landmarks landmarks.
    #[arg(long, value_name = "HOW", value_enum)]
    pub(super) fit: Option<FitKind>,
    /// Pairs of screen points there and here, frame heights: [[[0.5,0.5],[0.9,0.4]]], or a JSON file that holds them.
    #[arg(long, value_name = "PAIRS", allow_hyphen_values = true)]
    pub(super) landmarks: Option<String>,
    /// How much of the deformation: 0 none, 1 all, more exaggerates.
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = parse_strength, allow_hyphen_values = true)]
    pub(super) strength: f64,
    /// The shot file to write for a picture or a scene; default: none for pictures, NAME.toml beside the frames for scenes.
    #[arg(long, value_name = "SHOT")]
    pub(super) shot: Option<PathBuf>,
    #[command(flatten)]
    pub(super) draw: DrawArgs,
}

/// Where transferred lattices go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum FitKind {
    /// Their box becomes the box of what they bend.
    Box,
    /// Landmarks shift, turn and scale them.
    Landmarks,
    /// The same place on the screen.
    AsIs,
}

#[derive(Debug, clap::Args)]
pub(super) struct ResizeArgs {
    /// The lattice file.
    pub(super) lattices: PathBuf,
    /// Handles along each axis: 20,20, or 6,6,6 in the world.
    #[arg(long, value_name = "N,N", value_delimiter = ',', required = true)]
    pub(super) dims: Vec<usize>,
    /// How handles are blended: bspline, bernstein, bilinear or barytri; default: as before.
    #[arg(long, value_name = "BASIS", value_parser = parse_basis)]
    pub(super) basis: Option<Basis>,
    /// The lattice file to write.
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: PathBuf,
    #[command(flatten)]
    pub(super) overwrite: OverwriteArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct CompareArgs {
    /// A problem (JSON) or a shot (.toml).
    #[arg(value_name = "PROBLEM-OR-SHOT")]
    pub(super) input: PathBuf,
    /// Picture to draw, one panel for each method (PNG).
    #[arg(short, long, value_name = "SHEET")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) overwrite: OverwriteArg,
    /// Methods, in any order; default: all of hsu, mls, arap, paper, default.
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub(super) methods: Vec<String>,
    /// Pose of a problem that has several; default: its first.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["frame", "layer"])]
    pub(super) pose: Option<String>,
    /// Frame of a shot; default: its first.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub(super) frame: Option<i32>,
    /// Layer of a shot; default: its first.
    #[arg(long, value_name = "NAME")]
    pub(super) layer: Option<String>,
    /// Print one line of JSON for each method instead of a table.
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
}

/// Parses a basis by its name in shot files.
fn parse_basis(text: &str) -> Result<Basis, String> {
    serde_json::from_value(text.into()).map_err(|_| "use bspline, bernstein, bilinear or barytri".to_owned())
}

/// Parses a size in pixels.
fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.trim().parse::<u32>().ok().filter(|side| (1..=16384).contains(side));
    text.split_once('x')
        .and_then(|(width, height)| Some([side(width)?, side(height)?]))
        .ok_or_else(|| "two whole numbers from 1 to 16384 with an x between them are needed, e.g. 1920x1080".to_owned())
}

/// Parses a strength, with the limits of shot files.
fn parse_strength(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|number| (-100.0..=100.0).contains(number));
    number.ok_or_else(|| "a number from -100 to 100 is needed, e.g. 0.8".to_owned())
}

/// Parses two numbers separated by a comma.
fn parse_pair(text: &str) -> Result<[f64; 2], String> {
    let parse = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    text.split_once(',')
        .and_then(|(x, y)| Some([parse(x)?, parse(y)?]))
        .ok_or_else(|| "two numbers with a comma between them are needed, e.g. 0.9,0.5".to_owned())
}
