//! docs/flag.png, after the paper's image figure: a flag of 21 vertices and eight pins at rest, its triangles deformed
//! as rigidly as possible with the picture mapped onto them, and the picture warped by the lattice solved for the same
//! pins.

use anyhow::{Context as _, anyhow};
use glam::DVec2;
use image::{RgbImage, imageops};
use pinwarp::image::{Canvas, Channel, Frame, Rgba8, Storage, preview, read_picture};
use pinwarp::lattice::{Basis, Grid};
use pinwarp::plate::{Field, Filter, Planes, WarpMap, resampled};
use pinwarp::solve::methods::Arap;
use pinwarp::solve::{PointPin, Problem, Settings, Shape, solve};
use pinwarp::space::{FrameSize, ImagePoint, ScreenPoint};
use std::path::Path;

/// Lower left and upper right corner of the flag in its picture, frame heights (scenes/make/flag.rs).
const FLAG: [DVec2; 2] = [DVec2::new(0.25, 0.22), DVec2::new(1.25, 0.84)];

/// Vertices across and up.
const VERTICES: [usize; 2] = [7, 3];

/// Displacements of the pins of the upper border, frame heights; those of the lower border are equal.
const PULLS: [DVec2; 4] = [DVec2::ZERO, DVec2::new(-0.03, 0.1), DVec2::new(-0.06, -0.1), DVec2::new(-0.1, 0.07)];

const WIRE: Rgba8 = Rgba8([40, 40, 60, 150]);
const PIN: Rgba8 = Rgba8([255, 214, 10, 255]);
const RIM: Rgba8 = Rgba8([30, 30, 30, 255]);

/// The three panels side by side.
pub(crate) fn strip(scenes: &Path) -> anyhow::Result<RgbImage> {
    const GAP: u32 = 8;
    let plate = read_picture(&scenes.join("flag/flag.png"))?;
    let size = plate.frame_size();
    let frame = plate.into_frame();
    let shape = mesh();
    let pins = pins();
    let (moved, _) = Arap::default().deform(&shape, &pins)?;
    let grid = Grid { dims: [5, 5], basis: Basis::Bernstein, lo: [0.2, 0.17], hi: [1.3, 0.89], angle: 0.0 };
    let problem = Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[], settings: &Settings::default() };
    let lattice = solve(&problem)?.lattice;
    let carried: Vec<[f64; 2]> =
        shape.points.iter().map(|&[x, y]| lattice.warp(ScreenPoint::new(x, y)).0.to_array()).collect();
    let smooth = WarpMap::backward(&Field::of_layer(lattice), size, size.window());
    let maps = [WarpMap::identity(size, size.window()), mapped(size, &shape, &moved), smooth];
    let mut strip = RgbImage::from_pixel(3 * size.width + 2 * GAP, size.height, image::Rgb([255; 3]));
    for (column, (map, points)) in (0..).zip(maps.iter().zip([&shape.points, &moved, &carried])) {
        let is_rest = column == 0;
        let panel = panel(&frame, map, (&shape, points), is_rest)?;
        imageops::replace(&mut strip, &panel, column * i64::from(size.width + GAP), 0);
    }
    Ok(imageops::resize(&strip, strip.width() / 2, strip.height() / 2, imageops::FilterType::CatmullRom))
}

/// A mesh of 21 vertices on the flag.
fn mesh() -> Shape<2> {
    let [columns, rows] = VERTICES;
    let share = |k: usize, of: usize| k as f64 / (of - 1) as f64;
    let point =
        |i: usize, j: usize| (FLAG[0] + (FLAG[1] - FLAG[0]) * DVec2::new(share(i, columns), share(j, rows))).to_array();
    let points = (0..rows).flat_map(|j| (0..columns).map(move |i| point(i, j))).collect();
    let corner = |i: usize, j: usize| (i + j * columns) as u32;
    let cells = (0..rows - 1).flat_map(|j| (0..columns - 1).map(move |i| (i, j)));
    let halves = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    });
    Shape::of_triangles(points, halves.collect())
}

/// Every second vertex of the upper and lower border.
fn pins() -> Vec<PointPin<2>> {
    let [columns, rows] = VERTICES;
    let points = mesh().points;
    let pin = |row: usize, k: usize| {
        let at = points[row * columns + 2 * k];
        PointPin::new(at, (DVec2::from(at) + PULLS[k]).to_array())
    };
    [0, rows - 1].into_iter().flat_map(|row| (0..4).map(move |k| pin(row, k))).collect()
}

/// The backward map that moves the picture with the triangles.
fn mapped(size: FrameSize, shape: &Shape<2>, moved: &[[f64; 2]]) -> WarpMap {
    let mut map = WarpMap::identity(size, size.window());
    for (index, offset) in map.offsets.iter_mut().enumerate() {
        let pixel = DVec2::new((index % size.width as usize) as f64 + 0.5, (index / size.width as usize) as f64 + 0.5);
        let at = size.screen_from_image(ImagePoint(pixel)).0;
        let source = shape.triangles.iter().find_map(|corners| {
            let [a, b, c] = corners.map(|corner| DVec2::from(moved[corner as usize]));
            let area = (b - a).perp_dot(c - a);
            let weights =
                [(c - b).perp_dot(at - b) / area, (a - c).perp_dot(at - c) / area, (b - a).perp_dot(at - a) / area];
            let rest = corners.map(|corner| DVec2::from(shape.points[corner as usize]));
            let place: DVec2 = weights.iter().zip(rest).map(|(weight, rest)| rest * *weight).sum();
            weights.iter().all(|weight| *weight >= -1e-9).then_some(place)
        });
        let found = source.map(|place| size.image_from_screen(ScreenPoint(place)).0 - pixel);
        *offset = found.unwrap_or(DVec2::NAN).as_vec2().to_array();
    }
    map
}

/// A panel with the warped flag over white and its pins; the panel at rest also shows the triangles.
fn panel(
    frame: &Frame,
    map: &WarpMap,
    (shape, points): (&Shape<2>, &[[f64; 2]]),
    is_rest: bool,
) -> anyhow::Result<RgbImage> {
    let names = ["R", "G", "B", "A"];
    let channel = |name| frame.channel(name).map(|channel| channel.samples.as_slice());
    let planes = names.iter().map(|name| channel(name).context("the flag has colour and alpha"));
    let source = Planes { window: frame.data_window, planes: planes.collect::<Result<_, _>>()? };
    let samples = resampled(map, &source, Filter::Ewa);
    let channels = names.iter().zip(samples).map(|(name, samples)| Channel {
        name: (*name).to_owned(),
        storage: Storage::Half,
        samples,
    });
    let warped = Frame { channels: channels.collect(), ..Frame::blank(frame.display, map.window, &[]) };
    let mut shown = preview(&warped);
    let place = |vertex: usize| map.frame.image_from_screen(ScreenPoint(points[vertex].into()));
    let mut canvas = Canvas::new(&mut shown);
    for [a, b, c] in shape.triangles.iter().filter(|_| is_rest) {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            canvas.line(place(*from as usize), place(*to as usize), 1.2, WIRE);
        }
    }
    let [columns, rows] = VERTICES;
    for vertex in [0, rows - 1].into_iter().flat_map(|row| (0..4).map(move |k| row * columns + 2 * k)) {
        canvas.disc(place(vertex), 9.0, RIM);
        canvas.disc(place(vertex), 7.0, PIN);
    }
    let picture =
        image::RgbaImage::from_raw(shown.width, shown.height, shown.rgba).ok_or_else(|| anyhow!("a whole picture"))?;
    Ok(super::over_white(&picture))
}
