//! What the tests of the core share.

use pinwarp::live::{Alpha, Controls, Mix, Picture, Pin, Render, ShapeSource, Warp, warp};
use pinwarp::plate::Filter;
use pinwarp::space::{FrameSize, PixelRect, ScreenPoint};
use std::sync::Arc;

pub(crate) const HD: FrameSize = FrameSize::new(1920, 1080);

/// Eight pins, spread over the frame, some of them moved.
pub(crate) fn eight_pins() -> Controls {
    let place = |k: usize| ScreenPoint::new(0.3 + 0.35 * (k % 4) as f64, 0.3 + 0.4 * (k / 4) as f64);
    let target = |k: usize| {
        let ScreenPoint(at) = place(k);
        ScreenPoint::new(at.x + 0.03 * ((k * 7 % 5) as f64 - 2.0), at.y + 0.02 * ((k * 3 % 4) as f64 - 1.5))
    };
    Controls { pins: (0..8).map(|k| Pin::new(place(k), target(k))).collect(), ..Controls::default() }
}

/// A frame that spans several map_tiles, and does not end where they do.
pub(crate) const WIDE: FrameSize = FrameSize::new(700, 290);

/// Three pins that bend it.
pub(crate) fn bent() -> Arc<Warp> {
    let pins = [[0.6, 0.5, 0.15, 0.1], [1.8, 0.5, -0.2, -0.1], [1.2, 0.3, 0.0, 0.0]];
    let pin = |[x, y, dx, dy]: [f64; 4]| Pin::new(ScreenPoint::new(x, y), ScreenPoint::new(x + dx, y + dy));
    let controls = Controls { dims: [12, 10], pins: pins.map(pin).to_vec(), ..Controls::default() };
    warp(&controls, &ShapeSource::Frame, WIDE).expect("solves")
}

/// Samples between 0 and 1 that no neighbour predicts.
pub(crate) fn noise(window: PixelRect, seed: u32) -> Vec<f32> {
    let sample = |k: usize| {
        let word = (k as u32 ^ seed.wrapping_mul(0x9E37_79B9)).wrapping_mul(0x85EB_CA6B);
        (word ^ word >> 15).wrapping_mul(0xC2B2_AE35) as f32 / 4_294_967_296.0
    };
    (0..window.area()).map(sample).collect()
}

/// A job without mask and background.
pub(crate) fn job<'a>(source: &'a Picture<'a>, window: PixelRect) -> Render<'a> {
    Render {
        frame: WIDE,
        window,
        source,
        mask: None,
        background: None,
        filter: Filter::Cubic,
        mix: Mix::FULL,
        abort: &|| false,
    }
}

/// Planes as a picture.
pub(crate) fn picture<'a>(window: PixelRect, planes: &'a [Vec<f32>], alpha: Alpha) -> Picture<'a> {
    Picture { window, planes: planes.iter().map(|plane| &plane[..]).collect(), alpha }
}
