//! The region of a picture whose alpha gives the shape, before that alpha is known.
//!
//! In: [`Controls`], the picture's window. Out: a window that holds what any alpha within it becomes. The solve of a picture
//! that is covered everywhere is not enough: parts that lie apart and thin strokes are held by few pins, and swing about
//! them. So each pin may carry the whole window along, turned and stretched as far as the moves of the pins ask for.

use super::regions::{SOFT_EDGE, around};
use super::{Controls, LiveError, Moved, Pin, ShapeSource, Stop, warp_until};
use crate::space::{FrameSize, ImagePoint, PixelRect, ScreenPoint};
use glam::DVec2;
use std::f64::consts::PI;

/// Radians by which a part turns where two pins move by their distance against each other: across the line between them,
/// and along it. Chosen on 900 seeded cases (discs, strokes, crosses, rings; one to five pins; four bases), of which the
/// solve alone cut 68, by up to 101 of 180 pixels, and this none. Of 900 with another seed this still cuts three: by 2
/// pixels, and by 29 and 1718 where pins lie beside a thin stroke, which then flies off.
const TURN: [f64; 2] = [2.0, 1.0];

/// By how much of itself a part grows where two pins move by their distance along the line between them.
const STRETCH: f64 = 0.25;

/// More is asked for only by pins that nearly coincide, and given by none.
const MOST_STRETCH: f64 = 2.0;

/// Pixels further away than any picture.
const FURTHEST: f64 = 1e7;

/// Every pixel that a picture of that window may be carried to whose alpha, not known yet, gives the shape. Where all pins
/// move alike that is the moved picture; where they do not, parts of the shape may swing about any of them, and it is
/// larger than most alphas need. The limits of that swing are measured, not proven: pins beside a thin stroke can throw it
/// further.
///
/// # Errors
/// As [`warp_until`].
pub fn destination_of_any_alpha(
    controls: &Controls,
    window: PixelRect,
    frame: FrameSize,
    stop: &Stop,
) -> Result<PixelRect, LiveError> {
    let free = Controls { moved: Moved::Masked, ..controls.clone() };
    // Of a picture that has no end, what lies within the frame gives the shape.
    let shape = if window.intersection(around(frame)) == window { window } else { frame.window() };
    let warp = warp_until(&free, &ShapeSource::Window(shape), frame, stop)?;
    if controls.is_at_rest() {
        return Ok(window);
    }
    let swung = Swing::of(controls).of_window(controls, window, frame).grown(SOFT_EDGE);
    Ok(window.union(warp.destination_of(window, frame)).union(swung))
}

/// What pins may do to a part of the shape beside moving it.
struct Swing {
    /// Radians by which it turns at most, either way.
    turn: f64,
    /// Factor by which it grows at most.
    stretch: f64,
}

impl Swing {
    fn of(controls: &Controls) -> Self {
        let (mut turn, mut growth, mut scale) = (0.0_f64, 0.0_f64, 1.0_f64);
        for (k, pin) in controls.pins.iter().enumerate() {
            for other in &controls.pins[..k] {
                let line = (pin.rest - other.rest).0;
                let moved = (pin.target - pin.rest).0 - (other.target - other.rest).0;
                // Of two pins at one place the fractions are infinite, or no numbers if they move alike: `max` skips those.
                let [across, along] =
                    [moved.perp_dot(line), moved.dot(line)].map(|part| part.abs() / line.length_squared());
                turn = turn.max(TURN[0] * across + TURN[1] * along);
                growth = growth.max(STRETCH * along);
            }
            scale = scale.max(pin.scale.map_or(1.0, |scale| scale.powf(controls.strength)));
        }
        let held = controls.pins.iter().filter_map(|pin| pin.rotation).map(f64::abs).fold(0.0, f64::max);
        let strength = controls.strength.abs();
        Self { turn: (strength * (turn + held)).min(PI), stretch: (1.0 + strength * growth).min(MOST_STRETCH) * scale }
    }

    /// What becomes of a window that each of the pins carries along.
    fn of_window(&self, controls: &Controls, window: PixelRect, frame: FrameSize) -> PixelRect {
        let [left, top] = [window.x, window.y].map(f64::from);
        let [right, bottom] = [left + f64::from(window.width), top + f64::from(window.height)];
        let corners = [[left, top], [right, top], [left, bottom], [right, bottom]]
            .map(|[x, y]| frame.screen_from_image(ImagePoint::new(x, y)).0);
        let furthest = |direction: DVec2| {
            let carried = |pin: &Pin, corner: DVec2| {
                let target = pin.rest.0 + (pin.target - pin.rest).0 * controls.strength;
                target.dot(direction) + self.along(corner - pin.rest.0, direction)
            };
            let places = controls.pins.iter().flat_map(|pin| corners.map(|corner| carried(pin, corner)));
            places.fold(f64::NEG_INFINITY, f64::max)
        };
        let upper_left = ScreenPoint::new(-furthest(DVec2::NEG_X), furthest(DVec2::Y));
        let lower_right = ScreenPoint::new(furthest(DVec2::X), -furthest(DVec2::NEG_Y));
        let [upper_left, lower_right] = [upper_left, lower_right].map(|corner| frame.image_from_screen(corner).0);
        let [from, to] = [upper_left.floor(), lower_right.ceil()]
            .map(|corner| corner.clamp(DVec2::splat(-FURTHEST), DVec2::splat(FURTHEST)).as_ivec2());
        let size = (to - from).as_uvec2();
        PixelRect { x: from.x, y: from.y, width: size.x, height: size.y }
    }

    /// How far a turned and stretched arm reaches in a direction.
    fn along(&self, arm: DVec2, direction: DVec2) -> f64 {
        let angle = (arm.angle_to(direction).abs() - self.turn).max(0.0);
        let along = arm.length() * angle.cos();
        along.max(along * self.stretch)
    }
}
