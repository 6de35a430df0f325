//! Writes `picture.png` of every scene, one frame without and with its pins: `cargo run --release --example
//! make_pictures`. Also writes docs/branches.png (a raised arm under a plain and a branching lattice), docs/bulge.png
//! (a strong pull with the paper's preset, with pins that act on points, and with discs), docs/fit.png, docs/flag.png,
//! docs/transfer.png. Arguments select pictures by name.

mod fit_sheet;
mod flag_sheet;

use anyhow::{Context as _, bail};
use image::{RgbImage, RgbaImage, imageops};
use pinwarp::image::Durability;
use pinwarp::pipeline::{Event, Existing, PreparedShot, RenderOptions, lattices, render};
use pinwarp::raster::DeviceChoice;
use pinwarp::shot::{Shot, Transfer, TransferFit};
use pinwarp::solve::{Settings, SmoothingDisc, Topology};
use pinwarp::space::FrameSize;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// A picture of a scene.
struct Picture {
    /// Folder below `scenes/`.
    scene: &'static str,
    /// The frame to show.
    frame: i32,
    /// Height of the picture in pixels.
    height: u32,
    /// Width of each half in pixels, cut from the middle of the frame.
    width: u32,
    /// Shift of the cut to the right, in pixels.
    shift: i64,
}

const PICTURES: [Picture; 7] = [
    Picture { scene: "teapot", frame: 12, height: 336, width: 596, shift: 0 },
    Picture { scene: "gingerman", frame: 8, height: 480, width: 480, shift: 0 },
    Picture { scene: "flag", frame: 6, height: 336, width: 500, shift: 0 },
    Picture { scene: "cat", frame: 8, height: 400, width: 400, shift: 0 },
    Picture { scene: "puppet", frame: 11, height: 480, width: 400, shift: 0 },
    Picture { scene: "hare", frame: 8, height: 480, width: 400, shift: -10 },
    Picture { scene: "walker", frame: 7, height: 540, width: 520, shift: -40 },
];

/// Width of the white gap between the halves, in pixels.
const GAP: u32 = 8;

/// Draws a picture for docs/, given the folder of the scenes.
type Strip = fn(&Path) -> anyhow::Result<RgbImage>;

fn main() -> anyhow::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let is_wanted = |picture: &&Picture| wanted.is_empty() || wanted.iter().any(|name| name == picture.scene);
    for picture in PICTURES.iter().filter(is_wanted) {
        let place = folder.join(picture.scene);
        let halves = [half(picture, &place, 0.0)?, half(picture, &place, 1.0)?];
        let mut both = RgbImage::from_pixel(2 * picture.width + GAP, picture.height, image::Rgb([255; 3]));
        for (half, x) in halves.iter().zip([0, picture.width + GAP]) {
            imageops::replace(&mut both, half, i64::from(x), 0);
        }
        both.save(place.join("picture.png")).with_context(|| format!("writing the picture of {}", picture.scene))?;
    }
    let strips: [(&str, Strip); 5] = [
        ("branches", branches),
        ("bulge", bulge),
        ("fit", fit_sheet::strip),
        ("flag", flag_sheet::strip),
        ("transfer", transfer),
    ];
    for (name, strip) in strips.iter().filter(|(name, _)| wanted.is_empty() || wanted.iter().any(|other| other == name))
    {
        let path = folder.join(format!("../docs/{name}.png"));
        strip(&folder)?.save(&path).with_context(|| format!("writing {}", path.display()))?;
    }
    Ok(())
}

/// The teapot with its belly pulled down at 30 x 30 handles: the paper's preset, pins that act on points, pins with
/// discs.
fn bulge(folder: &Path) -> anyhow::Result<RgbImage> {
    const SIDE: u32 = 300;
    let read = || Shot::read(&folder.join("teapot/bulge.toml"));
    let (mut paper, mut point) = (read()?, read()?);
    paper.layers[0].settings = Settings::paper();
    point.layers[0].settings.disc = SmoothingDisc { radius: 0.0, weight: 0.0 };
    let mut strip = RgbImage::from_pixel(3 * SIDE + 2 * GAP, SIDE, image::Rgb([255; 3]));
    for (shot, column) in [paper, point, read()?].into_iter().zip(0..) {
        let whole = rendered(shot, 540, 12)?;
        let left = whole.width().saturating_sub(SIDE) / 2 - 40;
        let part = imageops::crop_imm(&whole, left, whole.height() - SIDE, SIDE, SIDE).to_image();
        imageops::replace(&mut strip, &part, column * i64::from(SIDE + GAP), 0);
    }
    Ok(strip)
}

/// The puppet at rest, and with her hand raised under a plain and a branching lattice of the same dims.
fn branches(folder: &Path) -> anyhow::Result<RgbImage> {
    const WIDTH: u32 = 320;
    const HEIGHT: u32 = 480;
    const FRAME: i32 = 11;
    let read = || Shot::read(&folder.join("puppet/shot.toml"));
    let (mut rest, mut plain) = (read()?, read()?);
    rest.layers[0].strength = 0.0;
    plain.layers[0].settings.topology = Topology::Plain;
    let mut strip = RgbImage::from_pixel(3 * WIDTH + 2 * GAP, HEIGHT, image::Rgb([255; 3]));
    for (shot, column) in [rest, plain, read()?].into_iter().zip(0..) {
        let whole = rendered(shot, HEIGHT, FRAME)?;
        imageops::replace(&mut strip, &whole, column * i64::from(WIDTH + GAP), 0);
    }
    Ok(strip)
}

/// The gingerman at rest and bent, and its lattices over a drawn cat.
fn transfer(folder: &Path) -> anyhow::Result<RgbImage> {
    const SIDE: u32 = 300;
    const FRAME: i32 = 8;
    let scratch = tempfile::tempdir()?;
    let file = scratch.path().join("ginger.json");
    let ginger = Shot::read(&folder.join("gingerman/shot.toml"))?;
    lattices(&PreparedShot::new(ginger.clone())?, &[1, FRAME], |_| ())?.write(&file)?;
    let mut cat = Shot::read(&folder.join("cat/shot.toml"))?;
    for layer in &mut cat.layers {
        layer.pins.clear();
        layer.transfer = Some(Transfer { file: file.clone(), layer: None, fit: TransferFit::Box, start: None });
    }
    let mut strip = RgbImage::from_pixel(4 * SIDE + 3 * GAP, SIDE, image::Rgb([255; 3]));
    for (column, (shot, frame)) in (0..).zip([(&ginger, 1), (&ginger, FRAME), (&cat, 1), (&cat, FRAME)]) {
        let panel = rendered(shot.clone(), SIDE, frame)?;
        imageops::replace(&mut strip, &panel, column * i64::from(SIDE + GAP), 0);
    }
    Ok(strip)
}

/// The frame with all strengths multiplied by `strength`, cut to one half of the picture.
fn half(picture: &Picture, place: &Path, strength: f64) -> anyhow::Result<RgbImage> {
    let mut shot = Shot::read(&place.join("shot.toml"))?;
    for layer in &mut shot.layers {
        layer.strength *= strength;
    }
    let whole = rendered(shot, picture.height, picture.frame)?;
    let left = (i64::from(whole.width()) - i64::from(picture.width)) / 2 + picture.shift;
    Ok(imageops::crop_imm(&whole, left.max(0) as u32, 0, picture.width, picture.height).to_image())
}

/// One frame of a shot, rendered at another height.
fn rendered(mut shot: Shot, height: u32, frame: i32) -> anyhow::Result<RgbImage> {
    let scratch = tempfile::tempdir()?;
    let columns = (shot.size.aspect() * f64::from(height)).round();
    shot.size = FrameSize::new(columns as u32, height);
    shot.samples = 64;
    shot.output.path = scratch.path().join("frame.####.exr");
    let path = shot.path.display().to_string();
    let options = RenderOptions {
        frames: vec![frame],
        device: DeviceChoice::Cpu,
        existing: Existing::Overwrite,
        has_preview: true,
        durability: Durability::Cached,
        ..RenderOptions::default()
    };
    let tell = |event: Event| {
        if let Event::FrameDone(report) = event {
            println!("{path}: {:?}", report.warnings);
        }
    };
    let summary = render(&PreparedShot::new(shot)?, &options, &AtomicBool::new(false), &tell)?;
    if summary.rendered != 1 {
        bail!("frame {frame} of {path} was not rendered");
    }
    Ok(over_white(&image::open(scratch.path().join(format!("frame.{frame:04}.png")))?.into_rgba8()))
}

/// Composites straight alpha over white.
fn over_white(picture: &RgbaImage) -> RgbImage {
    RgbImage::from_fn(picture.width(), picture.height(), |x, y| {
        let [r, g, b, a] = picture.get_pixel(x, y).0.map(f32::from);
        image::Rgb([r, g, b].map(|code| (code * a / 255.0 + 255.0 - a).round() as u8))
    })
}
