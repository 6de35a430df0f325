//! Regions of pictures whose alpha gives the shape: told before the alpha is known, they hold what compact shapes become.

use pinwarp::live::{Controls, Coverage, Moved, Pin, ShapeSource, destination_of_any_alpha, warp};
use pinwarp::space::{FrameSize, PixelRect, ScreenPoint};

const FRAME: FrameSize = FrameSize::new(320, 180);

/// Pixels beyond the picture that filters reach, and one for rounding.
const SOFT: f64 = 4.0;

/// How much more than needed a side may grow: a tenth, and these pixels.
const SLACK: f64 = 2.0;

const SEED: u64 = 7;

/// Numbers that look like chance.
struct Draws(u64);

impl Draws {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A name, and whether a pixel's centre belongs to the shape.
type Shape = (&'static str, fn(f64, f64) -> bool);

const SHAPES: [Shape; 3] = [
    ("everything", |_, _| true),
    ("ellipse", |x, y| ((x - 160.0) / 160.0).powi(2) + ((y - 90.0) / 90.0).powi(2) < 1.0),
    ("disc", |x, y| (x - 220.0).hypot(y - 80.0) < 60.0),
];

fn at([x, y]: [f64; 2]) -> ScreenPoint {
    ScreenPoint::new(x / 180.0, 1.0 - y / 180.0)
}

fn centre(index: usize) -> [f64; 2] {
    [(index % 320) as f64 + 0.5, (index / 320) as f64 + 0.5]
}

/// Pins on the shape, 25 pixels apart at least; the first moves, others move or stay.
fn pins(count: usize, is_in: fn(f64, f64) -> bool, draws: &mut Draws) -> Vec<Pin> {
    let mut places: Vec<[f64; 2]> = Vec::new();
    let mut pins = Vec::new();
    while pins.len() < count {
        let [x, y] = [draws.within(0.0, 320.0), draws.within(0.0, 180.0)];
        if !is_in(x, y) || places.iter().any(|place| (place[0] - x).hypot(place[1] - y) < 25.0) {
            continue;
        }
        let moves = pins.is_empty() || draws.within(0.0, 1.0) < 0.4;
        let [dx, dy] = [0, 1].map(|_| if moves { draws.within(-23.0, 23.0) } else { 0.0 });
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
    let mut sides = [0.0_f64, 0.0, 320.0, 180.0];
    for (index, _) in alpha.iter().enumerate().filter(|(_, alpha)| **alpha > 0.0) {
        let [x, y] = centre(index);
        for corner in [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]] {
            let moved = warp.field.carry(at([x + corner[0], y + corner[1]])).0;
            let [x, y] = [moved.x * 180.0, 180.0 - moved.y * 180.0];
            sides = [sides[0].min(x), sides[1].min(y), sides[2].max(x), sides[3].max(y)];
        }
    }
    growth(sides)
}

#[test]
fn regions_of_an_unknown_alpha_hold_compact_shapes_and_little_more() {
    let mut draws = Draws(SEED);
    let window = FRAME.window();
    for (name, is_in) in SHAPES {
        let is_there = |index| is_in(centre(index)[0], centre(index)[1]);
        let alpha: Vec<f32> = (0..window.area()).map(|index| if is_there(index) { 1.0 } else { 0.0 }).collect();
        for round in 0..40 {
            let pins = pins(1 + round % 4, is_in, &mut draws);
            let controls = Controls { moved: Moved::Masked, pins, ..Controls::default() };
            let told = destination_of_any_alpha(&controls, window, FRAME, &|| false).expect("solves");
            let PixelRect { x, y, width, height } = told;
            let [x, y, width, height] = [f64::from(x), f64::from(y), f64::from(width), f64::from(height)];
            let told = growth([x, y, x + width, y + height]);
            let needed = needed(&controls, &alpha);
            for (told, needed) in told.into_iter().zip(needed) {
                let case = format!("{name}, seed {SEED}, round {round}: told {told:.1}, needed {needed:.1}");
                assert!(told >= needed - 1e-6, "{case}");
                assert!(name != "everything" || told <= 1.1 * needed + SOFT + SLACK, "{case}");
            }
        }
    }
}
