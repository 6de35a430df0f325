//! How long a large solve keeps its host from being asked whether it wants to stop: printed with `--ignored --nocapture`.

use pinwarp::lattice::Basis;
use pinwarp::live::{Controls, Coverage, Moved, Pin, ShapeSource, warp_until};
use pinwarp::space::{FrameSize, ScreenPoint};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// The greatest gap that a host should see.
const GREATEST: Duration = Duration::from_millis(200);

const FRAME: FrameSize = FrameSize::new(1920, 1080);

/// 32 pins in rows, moved by up to 50 pixels, each its own way.
fn pins() -> Vec<Pin> {
    let pin = |k: u32| {
        let [x, y] = [0.15 + 0.2 * f64::from(k % 8), 0.15 + 0.22 * f64::from(k / 8)];
        let [dx, dy] = [0.025 * (f64::from(k * 7 % 5) - 2.0), 0.025 * (f64::from(k * 3 % 4) - 1.5)];
        Pin::new(ScreenPoint::new(x, y), ScreenPoint::new(x + dx, y + dy))
    };
    (0..32).map(pin).collect()
}

/// Bubbles that touch here and there: an outline with many holes.
fn foam() -> Vec<f32> {
    let wave = |k: u32| (k as f32 / 40.0).sin();
    let pixels = (0..FRAME.height).flat_map(|y| (0..FRAME.width).map(move |x| wave(x) + wave(y)));
    pixels.map(|height| if height > -0.3 { 1.0 } else { 0.0 }).collect()
}

#[test]
#[ignore = "measures time, which other programs take, too"]
fn polls_of_large_solves_follow_each_other_closely() {
    let alpha = foam();
    let alpha = ShapeSource::Coverage(Coverage { window: FRAME.window(), alpha: &alpha });
    let cases = [
        ("B-spline 10 x 10, alpha", 10, Basis::Bspline, Moved::Masked, &alpha),
        ("B-spline 64 x 64, border held", 64, Basis::Bspline, Moved::Picture, &ShapeSource::Frame),
        ("B-spline 64 x 64, free", 64, Basis::Bspline, Moved::Masked, &ShapeSource::Frame),
        ("Bernstein 24 x 24, border held", 24, Basis::Bernstein, Moved::Picture, &ShapeSource::Frame),
        ("Bernstein 24 x 24, free", 24, Basis::Bernstein, Moved::Masked, &ShapeSource::Frame),
    ];
    for (name, count, basis, moved, shape) in cases {
        let controls = Controls { dims: [count; 2], basis, moved, pins: pins(), ..Controls::default() };
        let begun = Instant::now();
        let state = Mutex::new((begun, Duration::ZERO, 0));
        let poll = || {
            let (last, longest, polls) = &mut *state.lock().expect("no panic");
            (*longest, *polls) = ((*longest).max(last.elapsed()), *polls + 1);
            *last = Instant::now();
            false
        };
        warp_until(&controls, shape, FRAME, &poll).expect("solves");
        poll();
        let (_, longest, polls) = *state.lock().expect("no panic");
        let all = begun.elapsed();
        println!("{name}: {} ms, {polls} polls, {} ms apart at most", all.as_millis(), longest.as_millis());
        assert!(longest < GREATEST, "{name}: {longest:?}");
    }
}
