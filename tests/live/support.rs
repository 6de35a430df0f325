//! What the tests of the core share.

use pinwarp::live::{Controls, Pin};
use pinwarp::space::{FrameSize, ScreenPoint};

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
