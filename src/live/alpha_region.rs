//! Bounds the output region of a picture whose shape comes from its alpha, before that alpha is known.
//!
//! In: [`Controls`], the picture's window. Out: a window that contains the result for any alpha. Solving for a fully
//! covered picture is not enough: separate parts and thin strokes are held by few pins and swing about them. Each pin
//! may therefore move the whole window, rotated and stretched as far as the displacements of the pins suggest.

use super::regions::{SOFT_EDGE, around};
use super::{Controls, LiveError, Moved, Pin, ShapeSource, Stop, warp_until};
use crate::space::{FrameSize, ImagePoint, PixelRect, ScreenPoint};
use glam::DVec2;
use std::f64::consts::PI;

/// Rotation in radians of a part if two pins move relative to each other by their distance: perpendicular to the line between them, and
/// along it. Chosen on 900 seeded cases (discs, strokes, crosses, rings; one to five pins; four bases): the solve alone cuts 68 of them,
/// by up to 101 of 180 pixels, and this bound none. With another seed this bound still cuts three of 900: by 2 pixels, and by 29 and 1718
/// where pins lie beside a thin stroke, which is then thrown far off.
const TURN: [f64; 2] = [2.0, 1.0];

/// Relative growth of a part if two pins move by their distance along the line between them.
const STRETCH: f64 = 0.25;

/// Upper bound of the stretch; larger values, which arise only from pins that nearly coincide, are clamped to it.
const MAX_STRETCH: f64 = 2.0;

/// Bound of coordinates in pixels, larger than any picture.
const FURTHEST: f64 = 1e7;

/// Returns a window that contains every pixel to which a picture of this window may be moved when its alpha, which
/// gives the shape, is not yet known.
///
/// If all pins move alike this is the moved picture. Otherwise parts of the shape may swing about any pin, and the window is larger than
/// most alphas need. The limits of the swing are measured, not proven: pins beside a thin stroke can throw it further.
///
/// # Errors
/// As [`warp_until`].
pub(crate) fn destination_of_any_alpha(
    controls: &Controls,
    window: PixelRect,
    frame: FrameSize,
    stop: &Stop,
) -> Result<PixelRect, LiveError> {
    let free = Controls { moved: Moved::Masked, ..controls.clone() };
    // For an unbounded picture, only what lies within the frame gives the shape.
    let shape = if window.intersection(around(frame)) == window { window } else { frame.window() };
    let warp = warp_until(&free, &ShapeSource::Window(shape), frame, stop)?;
    if controls.is_at_rest() {
        return Ok(window);
    }
    let swung = Swing::of(controls).of_window(controls, window, frame).grown(SOFT_EDGE);
    Ok(window.union(warp.destination_of(window, frame)).union(swung))
}

/// Bounds on how pins may transform a part of the shape besides moving it.
struct Swing {
    /// Largest rotation in either direction, in radians.
    turn: f64,
    /// Largest scale factor.
    stretch: f64,
}

impl Swing {
    fn of(controls: &Controls) -> Self {
        let (mut turn, mut growth, mut scale) = (0.0_f64, 0.0_f64, 1.0_f64);
        for (k, pin) in controls.pins.iter().enumerate() {
            for other in &controls.pins[..k] {
                let line = (pin.rest - other.rest).0;
                let moved = (pin.target - pin.rest).0 - (other.target - other.rest).0;
                // For two pins at the same place the fractions are infinite, or NaN if they also move alike: `max` ignores NaN.
                let [across, along] =
                    [moved.perp_dot(line), moved.dot(line)].map(|part| part.abs() / line.length_squared());
                turn = turn.max(TURN[0] * across + TURN[1] * along);
                growth = growth.max(STRETCH * along);
            }
            scale = scale.max(pin.scale.map_or(1.0, |scale| scale.powf(controls.strength)));
        }
        let held = controls.pins.iter().filter_map(|pin| pin.rotation).map(f64::abs).fold(0.0, f64::max);
        let strength = controls.strength.abs();
        Self { turn: (strength * (turn + held)).min(PI), stretch: (1.0 + strength * growth).min(MAX_STRETCH) * scale }
    }

    /// Returns the bounding window of a window that is moved with each of the pins.
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

    /// Returns how far a rotated and stretched arm reaches in a direction.
    fn along(&self, arm: DVec2, direction: DVec2) -> f64 {
        let angle = (arm.angle_to(direction).abs() - self.turn).max(0.0);
        let along = arm.length() * angle.cos();
        along.max(along * self.stretch)
    }
}
