//! Pins over a whole frame, in pixels.

use crate::internal::numbers::{Random, SplitMix, distance};
use pinwarp::live::Pin;
use pinwarp::space::{FrameSize, ImagePoint};

/// `PROPTEST_RNG_SEED`, or one of its own.
pub(crate) fn seed() -> u64 {
    let given = std::env::var("PROPTEST_RNG_SEED").ok().and_then(|text| text.parse().ok());
    given.unwrap_or_else(|| std::hash::BuildHasher::hash_one(&std::collections::hash_map::RandomState::new(), 0))
}

/// HD and 4K.
pub(crate) const FRAMES: [FrameSize; 2] = [super::frame(1920, 1080), super::frame(3840, 2160)];

/// Nearest that two pins lie to each other, pixels.
const APART: f64 = 20.0;
/// Nearest that a pin lies to the border, pixels.
const OFF_BORDER: f64 = 5.0;
/// Furthest that a pin goes, a part of its distance to another or to the border.
const FURTHEST: f64 = 0.4;

/// Pins of a frame: places and offsets, pixels, y down.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) frame: FrameSize,
    pub(crate) moves: Vec<([f64; 2], [f64; 2])>,
}

impl Case {
    pub(crate) fn pins(&self) -> Vec<Pin> {
        let point = |[x, y]: [f64; 2]| self.frame.screen_from_image(ImagePoint::new(x, y));
        self.moves.iter().map(|&(at, by)| Pin::new(point(at), point([at[0] + by[0], at[1] + by[1]]))).collect()
    }

    /// The furthest that a pin goes, pixels.
    pub(crate) fn longest(&self) -> f64 {
        self.moves.iter().map(|(_, by)| by[0].hypot(by[1])).fold(0.0, f64::max)
    }
}

/// Pins anywhere (some in a cluster, some at the border), each going up to 40 % of the room that it has.
pub(crate) fn scattered(random: &mut SplitMix, frame: FrameSize, count: usize) -> Case {
    let size = [f64::from(frame.width), f64::from(frame.height)];
    let mut places: Vec<[f64; 2]> = Vec::new();
    while places.len() < count {
        let anywhere: [f64; 2] = size.map(|side| OFF_BORDER + random.unit() * (side - 2.0 * OFF_BORDER));
        let place = match (random.unit() * 4.0) as u32 {
            0 => places
                .last()
                .map_or(anywhere, |last| std::array::from_fn(|axis| last[axis] + (random.unit() - 0.5) * 4.0 * APART)),
            1 => [OFF_BORDER, anywhere[1]],
            _ => anywhere,
        };
        if room(place, &places, size) >= 0.0 {
            places.push(place);
        }
    }
    let moves = (0..count).map(|pin| {
        let others: Vec<[f64; 2]> = places.iter().enumerate().filter(|(k, _)| *k != pin).map(|(_, at)| *at).collect();
        let nearest = others.iter().map(|at| distance(*at, places[pin])).fold(f64::INFINITY, f64::min);
        let most = FURTHEST * nearest.min(off_border(places[pin], size));
        let (length, angle) = (most * random.unit().sqrt(), random.unit() * std::f64::consts::TAU);
        (places[pin], [length * angle.cos(), length * angle.sin()])
    });
    Case { frame, moves: moves.collect() }
}

/// 0 or more where a place is free.
fn room(place: [f64; 2], taken: &[[f64; 2]], size: [f64; 2]) -> f64 {
    let nearest = taken.iter().map(|at| distance(*at, place)).fold(f64::INFINITY, f64::min);
    (nearest - APART).min(off_border(place, size) - OFF_BORDER)
}

fn off_border([x, y]: [f64; 2], [width, height]: [f64; 2]) -> f64 {
    x.min(y).min(width - x).min(height - y)
}
