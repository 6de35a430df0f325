//! The flag of the paper's image figure, and its pole: two pictures of equal size.
//!
//! Out: PNG files. The canvas is 3 : 2; the flag covers x from 0.25 to 1.25 and y from 0.22 to 0.84, in frame heights.

use super::drawing::{Shape, colour, drawn};
use glam::DVec2;
use image::ImageError;

/// Lower left and upper right corner of the flag, frame heights.
const FLAG: [DVec2; 2] = [DVec2::new(0.25, 0.22), DVec2::new(1.25, 0.84)];

const PIXELS: [u32; 2] = [720, 480];

/// The cloth: three stripes, a sun, a stitched border. Its straight lines make every kink visible.
pub(crate) fn cloth() -> Result<Vec<u8>, ImageError> {
    let [low, high] = FLAG;
    let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let cloth = move |at: DVec2| block(at, middle, half, 0.004);
    let stripes = [colour(0x1f6f78), colour(0xf6e7c8), colour(0xd1495b)];
    let striped = Shape::new(cloth, stripes[0]).painted(move |at| {
        let share = ((high.y - at.y) / (high.y - low.y) * 3.0).clamp(0.0, 2.999);
        let weave = 1.0 + 0.03 * (at.x * 300.0).sin() * (at.y * 300.0).sin();
        stripes[share as usize] * weave
    });
    let mut shapes = vec![striped.inked(0.007)];
    let ray = move |at: DVec2| {
        let turned = (at - middle).to_angle().rem_euclid(std::f64::consts::TAU / 16.0) - std::f64::consts::TAU / 32.0;
        let radius = (at - middle).length();
        ((turned.abs() - 0.075) * radius).max(radius - 0.2).max(0.125 - radius)
    };
    shapes.push(Shape::new(ray, colour(0xedae49)).inked(0.005));
    shapes.push(Shape::new(move |at| at.distance(middle) - 0.105, colour(0xedae49)).inked(0.006));
    let stitch = move |at: DVec2| {
        let rim = block(at, middle, half - 0.022, 0.004).abs() - 0.0022;
        let dash = (((at.x + at.y) * 60.0).fract() - 0.5).abs() - 0.3;
        rim.max(dash / 60.0)
    };
    shapes.push(Shape::new(stitch, colour(0xfffaf0)));
    drawn(PIXELS, DVec2::Y, DVec2::new(1.5, 1.0), &shapes)
}

/// The pole with its ball.
pub(crate) fn pole() -> Result<Vec<u8>, ImageError> {
    let x = FLAG[0].x - 0.012;
    let shade = move |at: DVec2| colour(0x8a5a3b) * (1.25 - 30.0 * (at.x - x).abs());
    let shapes = [
        Shape::new(move |at| block(at, DVec2::new(x, 0.44), DVec2::new(0.013, 0.48), 0.004), colour(0))
            .painted(shade)
            .inked(0.006),
        Shape::new(move |at| at.distance(DVec2::new(x, 0.93)) - 0.03, colour(0xedae49)).inked(0.006),
    ];
    drawn(PIXELS, DVec2::Y, DVec2::new(1.5, 1.0), &shapes)
}

/// A rectangle with rounded corners.
fn block(at: DVec2, center: DVec2, half: DVec2, round: f64) -> f64 {
    let out = (at - center).abs() - half + round;
    out.max(DVec2::ZERO).length() + out.max_element().min(0.0) - round
}
