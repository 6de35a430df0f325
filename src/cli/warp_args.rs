//! Arguments of `pinwarp warp`.

use super::frames::FrameList;
use super::shared_args::{ExistingArgs, FsyncArg, OutsideArg, ProgressArgs, device_parser};
use crate::plate::{Filter, Matte};
use crate::raster::DeviceChoice;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("warp").required(true))]
pub(super) struct WarpArgs {
    /// Frames to warp: a sequence such as beauty.####.exr, or one picture for all frames (EXR, PNG, JPEG); default: the shot's
    /// `plate`.
    #[arg(required_unless_present = "shot")]
    pub(super) plate: Option<PathBuf>,
    /// Shot whose layers define the warp.
    #[arg(long, group = "warp")]
    pub(super) shot: Option<PathBuf>,
    /// Lattice file that defines the warp, instead of a shot.
    #[arg(long, value_name = "FILE", group = "warp")]
    pub(super) lattice: Option<PathBuf>,
    /// STMaps that define the warp, instead of a shot: map.####.exr.
    #[arg(long, value_name = "MAP", group = "warp", conflicts_with = "inverse")]
    pub(super) stmap: Option<PathBuf>,
    /// Output path: warped.####.exr, or .png for PNG and JPEG plates; default: the shot's output path, if it has no scene.
    #[arg(short, long, value_name = "PATH", required_unless_present = "shot")]
    pub(super) output: Option<PathBuf>,
    /// Frames to warp, e.g. 1-48x2,60; default: the shot's range; without a shot, all existing frames.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub(super) frames: Option<FrameList>,
    /// Layers to apply, separated by commas; default: all screen layers.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', conflicts_with = "stmap")]
    pub(super) layer: Vec<String>,
    /// Part of the plate that a lattice file moves: alpha, mask.R, id.object=3,7 or crypto:Body*,Head; default: the whole
    /// picture.
    #[arg(long, value_name = "PART", value_parser = parse_matte, conflicts_with_all = ["shot", "stmap"])]
    pub(super) matte: Option<Matte>,
    /// Clean plate that fills areas uncovered by layers with a matte: clean.####.exr; replaces the shot's setting.
    #[arg(long, value_name = "PLATE")]
    pub(super) clean: Option<PathBuf>,
    /// Resampling filter for colour: ewa, cubic, lanczos or nearest; default: the shot's, else ewa.
    #[arg(long, value_parser = parse_filter)]
    pub(super) filter: Option<Filter>,
    /// Scale the displacement of all layers; 0 disables the warp.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = parse_number, allow_hyphen_values = true,
          conflicts_with = "stmap")]
    pub(super) strength: f64,
    /// Undo the warp, where it is one-to-one.
    #[arg(long)]
    pub(super) inverse: bool,
    /// Device that resamples colour, and draws the scene for `holes = "geometry"`: auto (a graphics card if there is one, else the
    /// CPU), cpu, vulkan (the best Vulkan device, including software drivers), or the index or part of the name of a Vulkan device.
    #[arg(long, value_name = "DEVICE", default_value = "auto", value_parser = device_parser())]
    pub(super) device: DeviceChoice,
    #[command(flatten)]
    pub(super) outside: OutsideArg,
    #[command(flatten)]
    pub(super) existing: ExistingArgs,
    #[command(flatten)]
    pub(super) fsync: FsyncArg,
    #[command(flatten)]
    pub(super) progress: ProgressArgs,
}

/// Parses a filter by its name in shot files.
fn parse_filter(text: &str) -> Result<Filter, String> {
    serde_json::from_value(text.into()).map_err(|_| "use ewa, cubic, lanczos or nearest".to_owned())
}

fn parse_number(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| "a number is needed, e.g. 0.5".to_owned())
}

/// Parses a matte: `alpha`, `mask.R`, `id.object=3,7`, `crypto:Body*,Head`.
fn parse_matte(text: &str) -> Result<Matte, String> {
    let wrong = || "use alpha, the name of a channel, id.object=3,7 or crypto:Body*,Head".to_owned();
    if let Some(names) = text.strip_prefix("crypto:") {
        let names: Vec<String> = names.split(',').map(|name| name.trim().to_owned()).collect();
        let is_good = names.iter().all(|name| !name.is_empty());
        return is_good.then_some(Matte::Cryptomatte { layer: None, names }).ok_or_else(wrong);
    }
    if let Some((channel, values)) = text.split_once('=') {
        let values: Option<Vec<u32>> = values.split(',').map(|value| value.trim().parse().ok()).collect();
        let id = |values| Matte::Id { channel: channel.trim().to_owned(), values };
        return values.filter(|_| !channel.trim().is_empty()).map(id).ok_or_else(wrong);
    }
    match text.trim() {
        "" => Err(wrong()),
        "alpha" => Ok(Matte::Alpha),
        channel => Ok(Matte::Channel(channel.to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_plates() {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        assert_eq!(parse_matte("alpha"), Ok(Matte::Alpha));
        assert_eq!(parse_matte("mask.R"), Ok(Matte::Channel("mask.R".into())));
        assert_eq!(parse_matte("id.object=3, 7"), Ok(Matte::Id { channel: "id.object".into(), values: vec![3, 7] }));
        let body = Matte::Cryptomatte { layer: None, names: names(&["Body*", "Head"]) };
        assert_eq!(parse_matte("crypto:Body*, Head"), Ok(body));
        for wrong in ["", " ", "crypto:", "crypto:a,,b", "id.object=", "id.object=a", "=3", "id=-1"] {
            assert!(parse_matte(wrong).is_err(), "{wrong}");
        }
    }
}
