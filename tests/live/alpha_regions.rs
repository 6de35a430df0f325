//! Regions of pictures whose alpha gives the shape: told before the alpha is known, they hold what any shape becomes.

use crate::internal::numbers::{Congruential, Random};
use pinwarp::live::{Controls, Coverage, Moved, Pin, ShapeSource, destination_of_any_alpha, warp};
use pinwarp::space::{FrameSize, PixelRect, ScreenPoint};

const FRAME: FrameSize = FrameSize::new(320, 180);

/// Pixels beyond the picture that filters reach, and one for rounding.
const SOFT: f64 = 4.0;

const SEED: u64 = 7;

/// A name, and whether a pixel's centre belongs to the shape.
type Shape = (&'static str, fn(f64, f64) -> bool);

const SHAPES: [Shape; 8] = [
    ("everything", |_, _| true),
    ("ellipse", |x, y| ((x - 160.0) / 160.0).powi(2) + ((y - 90.0) / 90.0).powi(2) < 1.0),
    ("disc", |x, y| (x - 220.0).hypot(y - 80.0) < 60.0),
    ("two discs", |x, y| (x - 80.0).hypot(y - 90.0) < 60.0 || (x - 250.0).hypot(y - 90.0) < 50.0),
    ("stroke", |x, y| is_near(x, y, [5.0, 90.0, 315.0, 90.0])),
    ("slanting stroke", |x, y| is_near(x, y, [10.0, 10.0, 310.0, 170.0])),
    ("cross", |x, y| is_near(x, y, [10.0, 90.0, 310.0, 90.0]) || is_near(x, y, [160.0, 5.0, 160.0, 175.0])),
    ("ring", |x, y| ((x - 160.0).hypot(y - 90.0) - 75.0).abs() < 5.0),
];

/// Whether a point lies on a stroke ten pixels wide, given by its ends.
fn is_near(x: f64, y: f64, [x0, y0, x1, y1]: [f64; 4]) -> bool {
    let [dx, dy] = [x1 - x0, y1 - y0];
    let along = (((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    (x - x0 - along * dx).hypot(y - y0 - along * dy) < 5.0
}

fn at([x, y]: [f64; 2]) -> ScreenPoint {
    ScreenPoint::new(x / 180.0, 1.0 - y / 180.0)
}

fn centre(index: usize) -> [f64; 2] {
    [(index % 320) as f64 + 0.5, (index / 320) as f64 + 0.5]
}

/// Pins on the shape, 25 pixels apart at least; the first moves, others move or stay.
fn pins(count: usize, is_in: fn(f64, f64) -> bool, draws: &mut Congruential) -> Vec<Pin> {
    let mut places: Vec<[f64; 2]> = Vec::new();
    let mut pins = Vec::new();
    while pins.len() < count {
        let [x, y] = [draws.between(0.0, 320.0), draws.between(0.0, 180.0)];
        if !is_in(x, y) || places.iter().any(|place| (place[0] - x).hypot(place[1] - y) < 25.0) {
            continue;
        }
        let moves = pins.is_empty() || draws.between(0.0, 1.0) < 0.4;
        let [dx, dy] = [0, 1].map(|_| if moves { draws.between(-23.0, 23.0) } else { 0.0 });
        pins.push(Pin::new(at([x, y]), at([x + dx, y + dy])));
        places.push([x, y]);
    }
    pins
}

/// Pixels by which each side grows: left, top, right, bottom.
fn growth(sides: [f64; 4]) -> [f64; 4] {
    [-sides[0], -sides[1], sides[2] - 320.0, sides[3] - 180.0]
}

/// What the solved warp of this alpha covers, beside the picture itself.
fn needed(controls: &Controls, alpha: &[f32]) -> [f64; 4] {
    let coverage = Coverage { window: FRAME.window(), alpha };
    let warp = warp(controls, &ShapeSource::Coverage(coverage), FRAME).expect("solves");
    let is_covered = |x: usize, y: usize| x < 320 && y < 180 && alpha[y * 320 + x] > 0.0;
    let mut sides = [0.0_f64, 0.0, 320.0, 180.0];
    // Corners of pixels, of which each is one of up to four.
    for [x, y] in (0..=180_usize).flat_map(|y| (0..=320_usize).map(move |x| [x, y])) {
        let pixels = [[x, y], [x.wrapping_sub(1), y], [x, y.wrapping_sub(1)], [x.wrapping_sub(1), y.wrapping_sub(1)]];
        if pixels.into_iter().any(|[x, y]| is_covered(x, y)) {
            let moved = warp.field.carry(at([x as f64, y as f64])).0;
            let [x, y] = [moved.x * 180.0, 180.0 - moved.y * 180.0];
            sides = [sides[0].min(x), sides[1].min(y), sides[2].max(x), sides[3].max(y)];
        }
    }
    growth(sides)
}

/// By how much each side of the region grows, told without the alpha.
fn told(controls: &Controls) -> [f64; 4] {
    let told = destination_of_any_alpha(controls, FRAME.window(), FRAME, &|| false).expect("solves");
    let PixelRect { x, y, width, height } = told;
    let [x, y, width, height] = [f64::from(x), f64::from(y), f64::from(width), f64::from(height)];
    growth([x, y, x + width, y + height])
}

#[test]
fn regions_of_an_unknown_alpha_hold_what_any_shape_becomes() {
    let mut draws = Congruential(SEED);
    for (name, is_in) in SHAPES {
        let is_there = |index| is_in(centre(index)[0], centre(index)[1]);
        let alpha: Vec<f32> = (0..FRAME.window().area()).map(|index| if is_there(index) { 1.0 } else { 0.0 }).collect();
        for round in 0..40 {
            let pins = pins(1 + round % 5, is_in, &mut draws);
            let controls = Controls { moved: Moved::Masked, pins, ..Controls::default() };
            for (told, needed) in told(&controls).into_iter().zip(needed(&controls, &alpha)) {
                let case = format!("{name}, seed {SEED}, round {round}: told {told:.1}, needed {needed:.1}");
                assert!(told >= needed - 1e-6, "{case}");
            }
        }
    }
}

#[test]
fn where_pins_move_alike_the_region_is_the_moved_picture() {
    let mut draws = Congruential(SEED);
    for round in 0..12 {
        let by = [0, 1].map(|_| draws.between(-23.0, 23.0) / 180.0);
        let mut pins = pins(1 + round % 4, |_, _| true, &mut draws);
        pins.iter_mut().for_each(|pin| pin.target = ScreenPoint::new(pin.rest.0.x + by[0], pin.rest.0.y + by[1]));
        let controls = Controls { moved: Moved::Masked, pins, ..Controls::default() };
        let [x, y] = by.map(|by| by * 180.0);
        for (told, needed) in told(&controls).into_iter().zip([-x, y, x, -y].map(|side| side.max(0.0))) {
            let case = format!("seed {SEED}, round {round}: told {told:.1}, needed {needed:.1}");
            assert!((needed..=needed + SOFT).contains(&told), "{case}");
        }
    }
}
