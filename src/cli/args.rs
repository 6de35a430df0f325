//! The arguments of all commands. The help, the manual pages and the shell completions are generated from these definitions.
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

/// Warp animated glTF scenes with pins placed on the screen, and write EXR sequences.
#[derive(Debug, Parser)]
#[command(name = "pinwarp", bin_name = "pinwarp", version, propagate_version = true, after_help = EXIT_CODES)]
pub(crate) struct Args {
    /// The command to run.
    #[command(subcommand)]
    pub(super) command: Command,

    /// Print more messages: -v for information, -vv for all details.
    #[arg(short, long, action = ArgAction::Count, global = true)]
    pub(super) verbose: u8,

    /// Limit the memory for scenes, pictures and frames: 8G, 512M, or a percentage of the system's memory such as 50% [default:
    /// 75%]. A frame that needs more fails; the other frames continue.
    #[arg(long, value_name = "SIZE", global = true)]
    pub(super) max_memory: Option<MemoryLimit>,
}

const EXIT_CODES: &str = "Exit codes: 0 success, 1 some frames failed, 2 bad input or usage.";

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Render a shot to an EXR sequence.
    #[command(
        after_long_help = "Examples:\n  pinwarp render shot.toml --frames 1 --preview --overlay\n  pinwarp render shot.toml --resume --json"
    )]
    Render(RenderArgs),
    /// Warp finished frames from any renderer, treating every channel according to its meaning.
    #[command(
        after_long_help = "Examples:\n  pinwarp warp beauty.####.exr --shot shot.toml -o warped.####.exr\n  pinwarp warp frame.png --lattice arm.lattice.json -o bent.png"
    )]
    Warp(Box<WarpArgs>),
    /// Solve layers with a temporal weight before rendering, for render farms.
    #[command(
        after_long_help = "Examples:\n  pinwarp bake shot.toml\n  pinwarp bake shot.toml -o /farm/out/frame.####.exr --json"
    )]
    Bake(BakeArgs),
    /// Write a commented, ready-to-render shot file for a scene or a picture.
    #[command(
        after_long_help = "Examples:\n  pinwarp new character.glb -o shot.toml\n  pinwarp new drawing.png -o shot.toml"
    )]
    New(NewArgs),
    /// Report all errors and warnings that a render would give, without rendering.
    #[command(after_long_help = "Examples:\n  pinwarp check shot.toml\n  pinwarp check shot.toml --frames 1-48x4")]
    Check(CheckArgs),
    /// Open the editor window, in which you place and drag pins.
    #[cfg(feature = "editor")]
    #[command(
        after_long_help = "Examples:\n  pinwarp edit\n  pinwarp edit character.glb\n  pinwarp edit shot.toml --frame 12 --screenshot editor.png"
    )]
    Edit(EditArgs),
    /// Find the surface point under a screen point and print it as a pin.
    #[command(
        after_long_help = "Examples:\n  pinwarp pick shot.toml --at-px 960,540\n  pinwarp pick shot.toml --at 0.9,0.5 --write nose --layer head"
    )]
    Pick(PickArgs),
    /// Report missing and damaged frames and the worst quality figures of finished frames.
    ///
    /// The exit code is 1 if frames are missing, damaged or made from different states of the shot, or if a figure exceeds a limit.
    #[command(
        after_long_help = "Examples:\n  pinwarp report out/ --sheet sheet.png\n  pinwarp report shot.toml --verify --max-pin-error 0.5 --max-folds 0"
    )]
    Report(ReportArgs),
    /// Write a render farm job: an Open Job Description template or a Slurm script.
    #[command(
        after_long_help = "Examples:\n  pinwarp job shot.toml\n  pinwarp job shot.toml --to slurm --chunk 8 -- --device cpu"
    )]
    Job(JobArgs),
    /// Solve a stand-alone lattice problem (JSON in, JSON out).
    #[command(after_long_help = "Examples:\n  pinwarp solve problem.json -o result.json")]
    Solve(SolveArgs),
    /// Compare several deformation methods on a problem or on a layer of a shot.
    #[command(after_long_help = "Examples:\n  pinwarp compare shot.toml --frame 12 -o sheet.png")]
    Compare(CompareArgs),
    /// Export the warp of a shot for other shots and programs.
    #[command(
        after_long_help = "Examples:\n  pinwarp export shot.toml --to nuke -o comp/shot.nk\n  pinwarp export shot.toml --to stmap -o maps/m.####.exr --resume"
    )]
    Export(ExportArgs),
    /// Fit a lattice that maps landmarks of one picture or pose to those of another.
    #[command(
        after_long_help = "Examples:\n  pinwarp fit drawing.png render.png --pairs pairs.csv -o drawing.lattice.json"
    )]
    Fit(FitArgs),
    /// Apply the solved lattices of one shot to a picture, a scene or another shot, and render it.
    #[command(
        after_long_help = "Examples:\n  pinwarp transfer --lattice arm.lattice.json --onto other.png -o out.####.exr"
    )]
    Transfer(TransferArgs),
    /// Convert the lattices of a file to another number of handles or another basis, with nearly the same deformation.
    #[command(after_long_help = "Examples:\n  pinwarp resize arm.lattice.json --dims 20,20 -o fine.lattice.json")]
    Resize(ResizeArgs),
    /// Describe a file: nodes, clips and cameras of a scene, channels of a picture, layers of a shot or lattice file.
    #[command(after_long_help = "Examples:\n  pinwarp info character.glb\n  pinwarp info beauty.0001.exr --json")]
    Info(InfoArgs),
    /// List the rendering devices.
    #[command(
        after_long_help = "Choose a device by its index or part of its name:\n  pinwarp render shot.toml --device 0\n  pinwarp render shot.toml --device cpu"
    )]
    Devices,
    /// Print a completion script for a shell.
    #[command(
        after_long_help = "Examples:\n  pinwarp completions bash > ~/.local/share/bash-completion/completions/pinwarp"
    )]
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// Print the manual pages of all commands, or write them to a folder.
    #[command(after_long_help = "Examples:\n  pinwarp man | man -l -\n  pinwarp man -o ~/.local/share/man/man1")]
    Man(ManArgs),
}

#[derive(Debug, clap::Args)]
pub(super) struct ManArgs {
    /// Write one page per command to this folder, e.g. ~/.local/share/man/man1; default: print the pages.
    #[arg(short, long, value_name = "FOLDER")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) overwrite: OverwriteArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct RenderArgs {
    /// Shot file.
    pub(super) shot: PathBuf,
    #[command(flatten)]
    pub(super) draw: DrawArgs,
}

#[derive(Debug, clap::Args)]
pub(super) struct BakeArgs {
    /// Shot file.
    pub(super) shot: PathBuf,
    /// Output path of the frames, if it differs from the shot's. The solved layers are stored in a folder beside the frames.
    #[arg(short, long, value_name = "PATH")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) camera: CameraArg,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
    #[command(flatten)]
    pub(super) progress: ProgressArgs,
}

/// What to draw of a shot, how, and where to write it.
#[derive(Debug, clap::Args)]
pub(super) struct DrawArgs {
    /// Frames to render, e.g. 1-48x2,60; default: the shot's range.
    ///
    /// Frame numbers and ranges, separated by commas; 1-48x2 is every second frame from 1 to 48. Frames are rendered in the order
    /// given. They may lie outside the shot's range, where keys hold their first or last value.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub(super) frames: Option<FrameList>,
    /// Resolution relative to the shot's size: 1/2, 0.5 or 50%.
    #[arg(long, value_name = "FACTOR", default_value = "1")]
    pub(super) scale: Scale,
    /// Samples per pixel; replaces the shot's value.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(super) samples: Option<u32>,
    /// Output path, such as frame.####.exr or frame.%04d.exr; replaces the shot's path.
    #[arg(short, long, value_name = "PATH")]
    pub(super) output: Option<PathBuf>,
    /// Rendering device: auto (a graphics card if there is one, else the CPU), cpu, vulkan (the best Vulkan device, including
    /// software drivers), or the index or part of the name of a Vulkan device.
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
    /// Also write an sRGB PNG beside every frame.
    #[arg(long)]
    pub(super) preview: bool,
    /// Write a preview PNG beside every frame, with the lattice, pins, targets and folded cells drawn over it.
    ///
    /// A legend in the lower left corner explains the marks. Red cells fold: filled cells contain part of the model, outlined
    /// cells contain nothing visible.
    #[arg(long)]
    pub(super) overlay: bool,
    #[command(flatten)]
    pub(super) progress: ProgressArgs,
}

/// The camera of a shot.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct CameraArg {
    /// Camera; replaces the shot's. Either the name of a camera in the scene, or a view: front, back, left, right, side, top,
    /// bottom, three-quarter or fit. A view with a layer name, such as front:body, frames that layer.
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
    /// Scene (.glb, .gltf) or picture (.png, .jpg, .exr).
    pub(super) scene: PathBuf,
    /// Shot file to write.
    #[arg(short, long, value_name = "SHOT", default_value = "shot.toml")]
    pub(super) output: PathBuf,
    #[command(flatten)]
    pub(super) overwrite: OverwriteArg,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct InfoArgs {
    /// Scene (.glb, .gltf), picture (.exr, .png, .jpg), shot (.toml) or lattice file (.json).
    pub(super) file: PathBuf,
    /// Print one JSON object instead of text.
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct CheckArgs {
    /// Shot file.
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
    /// Shot file.
    pub(super) shot: PathBuf,
    /// Frame in which to pick the point; default: the shot's first frame.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub(super) frame: Option<i32>,
    /// Screen point in frame heights, x right and y up from the lower left corner: 0.9,0.5.
    #[arg(long, value_name = "X,Y", value_parser = parse_pair, allow_hyphen_values = true,
          required_unless_present = "at_px", conflicts_with = "at_px")]
    pub(super) at: Option<[f64; 2]>,
    /// Screen point in pixels at the shot's size, x right and y down from the upper left corner, as in picture viewers: 960,540.
    #[arg(long, value_name = "X,Y", value_parser = parse_pair, allow_hyphen_values = true)]
    pub(super) at_px: Option<[f64; 2]>,
    /// Add the pin to the shot file under this name, instead of printing it.
    #[arg(long, value_name = "NAME")]
    pub(super) write: Option<String>,
    /// Layer for the pin; default: the layer that the surface belongs to.
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
    /// Shot (.toml), scene (.glb, .gltf), picture, or plates (frame.####.exr); default: open the start page, which offers bundled scenes.
    pub(super) file: Option<PathBuf>,
    /// Frame to show in the screenshot; default: the shot's first frame.
    #[arg(long, value_name = "N", allow_hyphen_values = true, requires = "screenshot")]
    pub(super) frame: Option<i32>,
    /// Draw the editor to a PNG file instead of opening a window; no display is needed.
    #[arg(long, value_name = "PNG", requires = "file")]
    pub(super) screenshot: Option<PathBuf>,
    /// Size of the screenshot in pixels.
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "1440x900")]
    pub(super) size: [u32; 2],
    /// Select a pin in the screenshot, by its name; may be repeated.
    #[arg(long, value_name = "PIN", requires = "screenshot")]
    pub(super) select: Vec<String>,
    /// Show curves of the selected pins in the screenshot in place of rows of keys.
    #[arg(long, requires = "screenshot")]
    pub(super) curves: bool,
    /// Use the light theme for the screenshot.
    #[arg(long, requires = "screenshot")]
    pub(super) light: bool,
    /// Rendering device, as for `pinwarp render`.
    #[arg(long, value_name = "DEVICE", default_value = "auto", value_parser = device_parser())]
    pub(super) device: DeviceChoice,
    #[command(flatten)]
    pub(super) overwrite: OverwriteArg,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct SolveArgs {
    /// Problem file (JSON).
    pub(super) problem: PathBuf,
    /// Result file (JSON); default: standard output.
    #[arg(short, long, value_name = "RESULT")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) overwrite: OverwriteArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct ExportArgs {
    /// Shot file, or a lattice file (.json) for formats that need no scene.
    #[arg(value_name = "SHOT-OR-LATTICES")]
    pub(super) shot: PathBuf,
    /// Format to write.
    #[arg(long, value_name = "FORMAT", value_enum)]
    pub(super) to: ExportFormat,
    /// File to write; default: the name of the shot with the format's extension.
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Frames to export, e.g. 1-48x2,60; default: all frames of the shot or the lattice file.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub(super) frames: Option<FrameList>,
    #[command(flatten)]
    pub(super) existing: ExistingArgs,
    /// Layers to export, separated by commas; default: all. The maps of one layer are for a matted element; those of several
    /// layers are for the whole picture, in which the other layers rest.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(super) layer: Vec<String>,
    /// Write inverse maps, which undo the warp.
    #[arg(long)]
    pub(super) inverse: bool,
    /// Size of the maps in pixels, e.g. 1920x1080; default: the shot's size, or a height of 1080 pixels for a lattice file.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(super) size: Option<[u32; 2]>,
    /// Number of pixels that the maps extend beyond the frame on each side.
    #[arg(long, value_name = "PIXELS", default_value = "0", value_parser = clap::value_parser!(u32).range(0..=16384))]
    pub(super) overscan: u32,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
}

/// The formats of `export`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum ExportFormat {
    /// Solved lattices in pinwarp's own open format (docs/LATTICE.md).
    LatticeJson,
    /// STMaps for any compositor: the source position of every pixel (EXR, 32 bits).
    Stmap,
    /// A Nuke script that applies the STMaps and contains the lattices as grid nodes.
    Nuke,
    /// A Python script that builds lattice objects with animated shape keys, and the scene beside it (.glb).
    Blender,
    /// The warped scene with one morph target per frame (.glb).
    Gltf,
    /// Displacement maps for After Effects, with the settings of its effect.
    AfterEffects,
}

impl ExportFormat {
    /// Its name on the command line.
    pub(super) fn name(self) -> String {
        clap::ValueEnum::to_possible_value(&self).map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

#[derive(Debug, clap::Args)]
pub(super) struct FitArgs {
    /// Source to deform: a picture (its alpha defines the shape), or one frame of a shot or scene.
    pub(super) a: PathBuf,
    /// Picture or shot to match; only its size is used.
    pub(super) b: PathBuf,
    /// Points of A and the matching points of B: JSON or CSV, see docs/EXPORT.md.
    #[arg(long, value_name = "FILE")]
    pub(super) pairs: PathBuf,
    /// Number of handles along each axis.
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_value = "10,10")]
    pub(super) dims: Vec<usize>,
    /// Basis that blends the handles: bspline, bernstein, bilinear or barytri; default: bspline.
    #[arg(long, value_name = "BASIS", value_parser = parse_basis)]
    pub(super) basis: Option<Basis>,
    /// Frame of a shot, and frame number in the lattice file; default: the shot's first frame, 1 for a picture.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub(super) frame: Option<i32>,
    /// Layer of a shot; default: the only one.
    #[arg(long, value_name = "NAME")]
    pub(super) layer: Option<String>,
    /// Lattice file to write.
    #[arg(short, long, value_name = "FILE", default_value = "fit.lattice.json")]
    pub(super) output: PathBuf,
    #[command(flatten)]
    pub(super) overwrite: OverwriteArg,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct TransferArgs {
    /// Lattice file, as written by `pinwarp export --to lattice-json`.
    #[arg(long, value_name = "FILE")]
    pub(super) lattice: PathBuf,
    /// Picture (.png, .jpg, .exr), scene (.glb, .gltf) or shot (.toml) to deform.
    #[arg(long, value_name = "TARGET")]
    pub(super) onto: PathBuf,
    /// Layer of the lattice file; default: the only one, or for a shot the layer with the same name.
    #[arg(long, value_name = "NAME")]
    pub(super) layer: Option<String>,
    /// How to place the lattices; default: landmarks with --landmarks, else box.
    #[arg(long, value_name = "HOW", value_enum)]
    pub(super) fit: Option<FitKind>,
    /// Pairs of matching screen points (source, target) in frame heights: [[[0.5,0.5],[0.9,0.4]]], or a JSON file of them.
    #[arg(long, value_name = "PAIRS", allow_hyphen_values = true)]
    pub(super) landmarks: Option<String>,
    /// Strength of the deformation: 0 none, 1 full; values above 1 exaggerate it.
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = parse_strength, allow_hyphen_values = true)]
    pub(super) strength: f64,
    /// Shot file to write for a picture or a scene; default: none for a picture, NAME.toml for a scene.
    ///
    /// NAME.toml is written beside the frames and named after them; without --output it is named after the scene and written to
    /// the current folder.
    #[arg(long, value_name = "SHOT")]
    pub(super) shot: Option<PathBuf>,
    #[command(flatten)]
    pub(super) draw: DrawArgs,
}

/// The placements of transferred lattices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum FitKind {
    /// Map the box of the lattice to the box of the target.
    Box,
    /// Shift, rotate and scale the lattice to match the landmarks.
    Landmarks,
    /// Keep the position on the screen.
    AsIs,
}

#[derive(Debug, clap::Args)]
pub(super) struct ResizeArgs {
    /// Lattice file.
    pub(super) lattices: PathBuf,
    /// Number of handles along each axis: 20,20, or 6,6,6 for world layers.
    #[arg(long, value_name = "N,N", value_delimiter = ',', required = true)]
    pub(super) dims: Vec<usize>,
    /// Basis that blends the handles: bspline, bernstein, bilinear or barytri; default: unchanged.
    #[arg(long, value_name = "BASIS", value_parser = parse_basis)]
    pub(super) basis: Option<Basis>,
    /// Lattice file to write.
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: PathBuf,
    #[command(flatten)]
    pub(super) overwrite: OverwriteArg,
}

#[derive(Debug, clap::Args)]
pub(super) struct CompareArgs {
    /// Problem file (JSON) or shot (.toml).
    #[arg(value_name = "PROBLEM-OR-SHOT")]
    pub(super) input: PathBuf,
    /// PNG to draw, with one panel per method.
    #[arg(short, long, value_name = "SHEET")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) overwrite: OverwriteArg,
    /// Methods to compare, separated by commas; default: all of hsu, mls, arap, paper, default.
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub(super) methods: Vec<String>,
    /// Bases to run every method on, separated by commas: bernstein, bspline, bilinear, barytri; default: bernstein, as the methods
    /// were published, and that of the problem.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse_basis)]
    pub(super) basis: Vec<Basis>,
    /// Pose of a problem with several poses; default: the first.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["frame", "layer"])]
    pub(super) pose: Option<String>,
    /// Frame of a shot; default: the first.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub(super) frame: Option<i32>,
    /// Layer of a shot; default: the first.
    #[arg(long, value_name = "NAME")]
    pub(super) layer: Option<String>,
    /// Print one line of JSON per method instead of a table.
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
