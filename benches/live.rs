//! Latency of the live interface: a frame with a cached solve, a drag, and their parts. 1080p RGBA, 10 x 10 handles, 8 pins.

use criterion::{Criterion, criterion_group, criterion_main};
use pinwarp::live::{Alpha, Controls, Mix, Picture, Pin, Render, ShapeSource, render_pieces, warp};
use pinwarp::plate::Filter;
use pinwarp::space::{FrameSize, ScreenPoint};
use std::hint::black_box;
use std::sync::atomic::{AtomicU32, Ordering};

const FRAME: FrameSize = FrameSize::new(1920, 1080);

fn controls(nudge: f64) -> Controls {
    let pin = |k: usize| {
        let (x, y) = (0.3 + 0.35 * (k % 4) as f64, 0.3 + 0.4 * (k / 4) as f64);
        let by = 0.03 * ((k * 7 % 5) as f64 - 2.0);
        Pin::new(ScreenPoint::new(x, y), ScreenPoint::new(x + by + nudge, y + 0.5 * by))
    };
    Controls { pins: (0..8).map(pin).collect(), ..Controls::default() }
}

fn solves(criterion: &mut Criterion) {
    let count = AtomicU32::new(0);
    // All drags differ, so that none is found in the cache.
    let drag = || controls(1e-5 * f64::from(count.fetch_add(1, Ordering::Relaxed)));
    criterion.bench_function("live/solve/dragged", |b| {
        b.iter(|| warp(&drag(), &ShapeSource::Frame, FRAME).expect("solves"))
    });
    let still = controls(0.0);
    criterion
        .bench_function("live/solve/cached", |b| b.iter(|| warp(&still, &ShapeSource::Frame, FRAME).expect("solves")));
}

fn frames(criterion: &mut Criterion) {
    let window = FRAME.window();
    let plane = |channel: usize| (0..window.area()).map(|k| ((k + 99 * channel) % 1023) as f32 / 1023.0).collect();
    let planes: Vec<Vec<f32>> = (0..4).map(plane).collect();
    let planes = planes.iter().map(Vec::as_slice).collect();
    let source = Picture { window, planes, alpha: Alpha::Premultiplied };
    let draw = |nudge: f64, filter: Filter| {
        let warp = warp(&controls(nudge), &ShapeSource::Frame, FRAME).expect("solves");
        let job = Render {
            frame: FRAME,
            window,
            source: &source,
            mask: None,
            background: None,
            filter,
            mix: Mix::FULL,
            abort: &|| false,
        };
        render_pieces(&warp, &job, |piece| _ = black_box(piece)).expect("rendered");
    };
    for (name, filter) in [("cubic", Filter::Cubic), ("ewa", Filter::Ewa)] {
        criterion.bench_function(&format!("live/frame/still/{name}"), |b| b.iter(|| draw(0.0, filter)));
    }
    let count = AtomicU32::new(0);
    let next = || 1e-4 * f64::from(count.fetch_add(1, Ordering::Relaxed));
    criterion.bench_function("live/frame/moving/cubic", |b| b.iter(|| draw(next(), Filter::Cubic)));
}

criterion_group! { name = benches; config = Criterion::default().sample_size(20); targets = solves, frames }
criterion_main!(benches);
