//! The picture of the manual: a drawing before and after, with the overlay as the plugin draws it.
//! `UPDATE=1 cargo test --features ofx --test ofx picture` writes it anew.

use crate::host::api::RectI;
use crate::host::profile::BOOK;
use crate::host::{Drawn, Frame, Host, Pixels, Which};
use pinwarp::image::{Canvas, Preview, Rgba8, png_bytes, read_picture};
use pinwarp::space::ImagePoint;
use std::path::Path;

/// Width and height of a panel.
const SIDE: i32 = 320;
/// The drawing behind everything, sRGB.
const PAPER: f32 = 0.93;

/// A drawing of the repository at half its size.
fn drawing() -> Pixels {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cat/cat.png");
    let plate = read_picture(&path).expect("the drawing is part of the repository");
    let part = &plate.parts[0];
    let width = part.data_window.width as usize;
    let planes = ["R", "G", "B", "A"].map(|name| {
        let channel = part.channels.iter().find(|channel| channel.name == name);
        &channel.expect("the drawing has colour and alpha").samples
    });
    Pixels::new(RectI { x1: 0, y1: 0, x2: SIDE, y2: SIDE }, 4, |x, y, channel| {
        let [column, row] = [2 * x, 2 * (SIDE - 1 - y)].map(|place| place as usize);
        let near = [(0, 0), (1, 0), (0, 1), (1, 1)];
        near.iter().map(|(dx, dy)| planes[channel][(row + dy) * width + column + dx]).sum::<f32>() / 4.0
    })
}

fn srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Lays a picture on paper, into a panel.
fn show(preview: &mut Preview, panel: i32, pixels: &Pixels) {
    let paper = PAPER.powf(2.2);
    for y in 0..SIDE {
        for x in 0..SIDE {
            let left = 1.0 - pixels.at(x, y, 3);
            let colour = [0, 1, 2].map(|channel| (srgb(pixels.at(x, y, channel) + paper * left) * 255.0 + 0.5) as u8);
            let at = (((SIDE - 1 - y) * 2 * SIDE + panel * SIDE + x) * 4) as usize;
            preview.rgba[at..at + 3].copy_from_slice(&colour);
            preview.rgba[at + 3] = 255;
        }
    }
}

/// Draws what the plugin drew over a panel.
fn trace(preview: &mut Preview, panel: i32, drawn: &[Drawn]) {
    let mut canvas = Canvas::new(preview);
    for line in drawn {
        let colour = Rgba8(line.colour.map(|value| (value.clamp(0.0, 1.0) * 255.0) as u8));
        let place = |[x, y]: [f64; 2]| ImagePoint::new(x + f64::from(panel * SIDE), f64::from(SIDE) - y);
        for ends in line.points.windows(2) {
            canvas.line(place(ends[0]), place(ends[1]), f64::from(line.width), colour);
        }
    }
}

#[test]
fn the_picture_of_the_manual_is_what_the_plugin_draws() {
    let drawing = drawing();
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = host.node();
    host.through(node, &drawing);
    host.set(node, "holdBorder", 0);
    let side = f64::from(SIDE);
    let pins = [
        ([0.83, 0.49], [0.80, 0.70]),
        ([0.17, 0.49], [0.17, 0.49]),
        ([0.50, 0.42], [0.50, 0.42]),
        ([0.50, 0.80], [0.44, 0.80]),
        ([0.35, 0.12], [0.35, 0.12]),
        ([0.65, 0.12], [0.65, 0.12]),
    ];
    let panels = [false, true].map(|moves| {
        for (index, (rest, target)) in pins.iter().enumerate() {
            let target = if moves { target } else { rest };
            host.pin(node, index + 1, rest.map(|place| place * side), target.map(|place| place * side));
        }
        let picture = host.render(node, Frame::default()).expect("it renders");
        let overlay = host.overlay(node, 1.0).expect("there is one");
        let drawn = overlay.draw();
        overlay.close();
        (picture, drawn)
    });
    host.finish();
    let mut preview = Preview::transparent(2 * SIDE as u32, SIDE as u32);
    for (panel, (picture, drawn)) in panels.iter().enumerate() {
        show(&mut preview, panel as i32, picture);
        trace(&mut preview, panel as i32, drawn);
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/openfx.png");
    let bytes = png_bytes(&path, &preview).expect("a picture");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, bytes).expect("the manual can be written");
        return;
    }
    let shown = read_picture(&path).expect("the manual has its picture; UPDATE=1 writes it");
    assert_eq!([shown.display.width, shown.display.height], [2 * SIDE as u32, SIDE as u32]);
    let (width, panel) = (2 * SIDE as usize, &panels[1].0);
    let red = &shown.parts[0].channels.iter().find(|channel| channel.name == "R").expect("colour").samples;
    let differs = |(x, y): &(i32, i32)| {
        let paper = PAPER.powf(2.2) * (1.0 - panel.at(*x, *y, 3));
        let index = (SIDE - 1 - y) as usize * width + (SIDE + x) as usize;
        (red[index] - panel.at(*x, *y, 0) - paper).abs() > 0.02
    };
    // Lines cover some of it.
    let places = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
    let covered = places.filter(differs).count() as f64 / f64::from(SIDE * SIDE);
    assert!(covered < 0.25, "{covered}: the picture is out of date; UPDATE=1 writes it anew");
}
