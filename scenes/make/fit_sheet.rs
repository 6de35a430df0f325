//! docs/fit.png: the cat, a key pose sketched with sticks, and the cat fitted to it by landmarks (`pinwarp fit`).

use anyhow::{Context as _, anyhow};
use image::{RgbImage, RgbaImage, imageops};
use pinwarp::export::{LatticeFile, LatticeTrack, Track};
use pinwarp::image::{Canvas, Preview, Rgba8, read_picture};
use pinwarp::lattice::Basis;
use pinwarp::pipeline::{picture_shape, register};
use pinwarp::shot::{Shot, Transfer, TransferFit};
use pinwarp::space::{FrameWindow, ImagePoint, ScreenPoint};
use std::collections::BTreeMap;
use std::path::Path;

/// Side of a panel, pixels.
const SIDE: u32 = 360;
/// Side of the cat's canvas, pixels. Landmarks are given in its pixels, y down.
const CANVAS: f64 = 640.0;

/// Name, position in the cat's picture, position in the sketch.
const PAIRS: [(&str, [f64; 2], [f64; 2]); 14] = [
    ("left ear", [228.0, 43.0], [264.0, 33.0]),
    ("right ear", [412.0, 43.0], [447.0, 75.0]),
    ("nose", [320.0, 191.0], [328.0, 200.0]),
    ("neck", [320.0, 275.0], [320.0, 282.0]),
    ("left shoulder", [240.0, 292.0], [242.0, 302.0]),
    ("left elbow", [172.0, 312.0], [178.0, 344.0]),
    ("left paw", [105.0, 328.0], [134.0, 400.0]),
    ("right shoulder", [400.0, 292.0], [398.0, 292.0]),
    ("right elbow", [468.0, 312.0], [468.0, 262.0]),
    ("right paw", [535.0, 328.0], [528.0, 214.0]),
    ("belly", [320.0, 390.0], [318.0, 396.0]),
    ("left knee", [250.0, 505.0], [232.0, 492.0]),
    ("left foot", [226.0, 570.0], [184.0, 540.0]),
    ("right foot", [414.0, 570.0], [414.0, 570.0]),
];

/// Pairs of landmarks connected by a stick.
const STICKS: [[usize; 2]; 14] = [
    [0, 1],
    [0, 2],
    [1, 2],
    [2, 3],
    [3, 4],
    [4, 5],
    [5, 6],
    [3, 7],
    [7, 8],
    [8, 9],
    [3, 10],
    [10, 11],
    [11, 12],
    [10, 13],
];

const PENCIL: Rgba8 = Rgba8([70, 95, 150, 255]);
const FAINT: Rgba8 = Rgba8([70, 95, 150, 110]);
const RIM: Rgba8 = Rgba8([30, 30, 30, 255]);
const DOT: Rgba8 = Rgba8([255, 214, 10, 255]);

/// The three panels side by side.
pub(crate) fn strip(scenes: &Path) -> anyhow::Result<RgbImage> {
    let scratch = tempfile::tempdir()?;
    let file = scratch.path().join("fit.lattice.json");
    fit(&scenes.join("cat/cat.png"), &file)?;
    let mut cat = Shot::read(&scenes.join("cat/shot.toml"))?;
    for layer in &mut cat.layers {
        layer.pins.clear();
        layer.transfer = Some(Transfer { file: file.clone(), layer: None, fit: TransferFit::AsIs, start: None });
    }
    let carried = super::rendered(cat.clone(), SIDE, 1)?;
    cat.layers.clear();
    let still = super::rendered(cat, SIDE, 1)?;
    let blank = RgbImage::from_pixel(SIDE, SIDE, image::Rgb([255; 3]));
    let panels = [
        marked(&still, |pair| pair.1, None)?,
        marked(&blank, |pair| pair.2, Some(PENCIL))?,
        marked(&carried, |pair| pair.2, Some(FAINT))?,
    ];
    let mut strip = RgbImage::from_pixel(3 * SIDE + 2 * super::GAP, SIDE, image::Rgb([255; 3]));
    for (column, panel) in (0..).zip(&panels) {
        imageops::replace(&mut strip, panel, column * i64::from(SIDE + super::GAP), 0);
    }
    Ok(strip)
}

/// Writes the lattice that `pinwarp fit` finds to a file.
fn fit(picture: &Path, file: &Path) -> anyhow::Result<()> {
    let plate = read_picture(picture)?;
    let size = plate.frame_size();
    let part = plate.parts.first().context("the cat is a picture")?;
    let alpha = part.channel("A").map(|channel| channel.samples.as_slice());
    let shape = picture_shape(picture, FrameWindow { frame: size, window: part.data_window }, alpha)?;
    let place = |[x, y]: [f64; 2]| -> ScreenPoint { size.screen_from_image(ImagePoint::new(x, y)) };
    let pairs: Vec<_> = PAIRS.iter().map(|&(_, from, to)| [place(from), place(to)]).collect();
    let found = register(&shape, &pairs, [10, 10], Basis::Bspline)?;
    let track = Track::Screen(BTreeMap::from([(1, found.lattice)]));
    let layer = LatticeTrack {
        name: "cat".into(),
        track,
        placements: BTreeMap::new(),
        has_branches_in_scene: false,
        wholes: BTreeMap::new(),
        branches: BTreeMap::new(),
    };
    Ok(LatticeFile { frame_aspect: size.aspect(), rate: 24.0, layers: vec![layer] }.write(file)?)
}

type Pair = (&'static str, [f64; 2], [f64; 2]);

/// A panel with its landmarks and, if there is a pencil, the sticks between them.
fn marked(panel: &RgbImage, place: impl Fn(&Pair) -> [f64; 2], pencil: Option<Rgba8>) -> anyhow::Result<RgbImage> {
    let rgba = panel.pixels().flat_map(|pixel| [pixel.0[0], pixel.0[1], pixel.0[2], 255]).collect();
    let mut shown = Preview { width: SIDE, height: SIDE, rgba };
    let at = |index: usize| {
        let [x, y] = place(&PAIRS[index]);
        let scale = f64::from(SIDE) / CANVAS;
        ImagePoint::new(x * scale, y * scale)
    };
    let mut canvas = Canvas::new(&mut shown);
    if let Some(pencil) = pencil {
        for [from, to] in STICKS {
            canvas.line(at(from), at(to), 2.5, pencil);
        }
    }
    for index in 0..PAIRS.len() {
        canvas.disc(at(index), 5.5, RIM);
        canvas.disc(at(index), 4.0, DOT);
    }
    let picture =
        RgbaImage::from_raw(shown.width, shown.height, shown.rgba).ok_or_else(|| anyhow!("a whole picture"))?;
    Ok(super::over_white(&picture))
}
