//! A drawn girl with parts close to each other: arms beside a skirt, two pigtails, legs.
//!
//! Out: a PNG file. The girl is 1 high; the canvas shows x from -0.36 to 0.36 and y from -0.04 to 1.04. No gap is wider
//! than 0.03.

use super::drawing::{Shape, colour, drawn};
use super::figures::draw::{Limb, chain, ellipse, melted};
use glam::DVec2;
use image::ImageError;

/// Width of the outlines.
const INK: f64 = 0.006;

/// Half widths of waist, hem and chest.
const WAIST: f64 = 0.066;
const HEM: f64 = 0.125;
const CHEST: f64 = 0.074;

const fn at(x: f64, y: f64) -> DVec2 {
    DVec2::new(x, y)
}

/// Distance to a body symmetric about x = 0, between the heights `low` and `high`; `width` is its half width at a
/// height.
fn symmetric(p: DVec2, [low, high]: [f64; 2], width: impl Fn(f64) -> f64) -> f64 {
    let y = p.y.clamp(low, high);
    (p.x.abs() - width(y)).max(p.y - high).max(low - p.y)
}

/// The skirt, with a rounded hem.
fn skirt(p: DVec2) -> f64 {
    let share = |y: f64| ((0.52 - y) / 0.2).clamp(0.0, 1.0);
    let round = 0.012;
    symmetric(p, [0.325 + round, 0.53], |y| WAIST + (HEM - WAIST) * share(y).powf(0.8) - round) - round
}

/// Blouse and collar.
fn blouse(p: DVec2) -> f64 {
    let round = 0.03;
    symmetric(p, [0.5 + round, 0.735 - round], |y| {
        let share = ((y - 0.53) / 0.17).clamp(0.0, 1.0);
        WAIST + (CHEST - WAIST) * share - round
    }) - round
}

/// A limb of constant width that bends at its joints.
fn limb(points: &[(DVec2, f64)]) -> impl Fn(DVec2) -> f64 + 'static {
    let parts: Vec<Limb> = chain(points).into_iter().map(|part| part.melting(0.012)).collect();
    move |p| melted(&parts, p)
}

/// The PNG file.
pub(crate) fn picture() -> Result<Vec<u8>, ImageError> {
    let (skin, hair, dark) = (colour(0xf7d9c0), colour(0x7a4a2e), colour(0x3a2a2e));
    let (white, red, blue) = (colour(0xfdfaf4), colour(0xd2504e), colour(0x3f5f9e));
    let mut shapes = Vec::new();
    for side in [-1.0, 1.0] {
        let tail = limb(&[
            (at(0.075 * side, 0.935), 0.02),
            (at(0.128 * side, 0.9), 0.028),
            (at(0.142 * side, 0.83), 0.03),
            (at(0.14 * side, 0.77), 0.02),
            (at(0.146 * side, 0.75), 0.008),
        ]);
        shapes.push(Shape::new(tail, hair).inked(INK));
        let leg =
            limb(&[(at(0.05 * side, 0.36), 0.036), (at(0.052 * side, 0.2), 0.031), (at(0.052 * side, 0.05), 0.024)]);
        shapes.push(Shape::new(leg, skin).inked(INK));
        let sock = Limb::new(at(0.052 * side, 0.1), at(0.052 * side, 0.04), [0.03, 0.028]);
        shapes.push(Shape::new(move |p| sock.field(p), white).inked(INK));
        let shoe = Limb::new(at(0.052 * side, 0.022), at(0.07 * side, 0.018), [0.028, 0.022]);
        shapes.push(Shape::new(move |p| shoe.field(p).max(-p.y), red).inked(INK));
        let arm =
            limb(&[(at(0.078 * side, 0.695), 0.027), (at(0.121 * side, 0.57), 0.024), (at(0.152 * side, 0.45), 0.02)]);
        shapes.push(Shape::new(arm, skin).inked(INK));
        let hand = Limb::new(at(0.154 * side, 0.44), at(0.163 * side, 0.405), [0.023, 0.019]);
        shapes.push(Shape::new(move |p| hand.field(p), skin).inked(INK));
        let sleeve = limb(&[(at(0.07 * side, 0.705), 0.03), (at(0.1 * side, 0.645), 0.035)]);
        shapes.push(Shape::new(sleeve, white).inked(INK));
    }
    let neck = Limb::new(at(0.0, 0.82), at(0.0, 0.72), [0.03, 0.03]);
    shapes.push(Shape::new(move |p| neck.field(p), skin).inked(INK));
    shapes.push(Shape::new(blouse, white).inked(INK));
    shapes.push(Shape::new(skirt, blue).inked(INK));
    // Pleats.
    for k in -2..=2 {
        let (top, hem) = (f64::from(k) * 0.026, f64::from(k) * 0.05);
        let pleat = Limb::new(at(top, 0.49), at(hem, 0.345), [0.0015, 0.0025]);
        shapes.push(Shape::new(move |p| pleat.field(p), dark).within(skirt));
    }
    let belt = Limb::new(at(-0.058, 0.522), at(0.058, 0.522), [0.013, 0.013]);
    shapes.push(Shape::new(move |p| belt.field(p), red).inked(INK));
    for side in [-1.0, 1.0] {
        let bow = Limb::new(at(0.006 * side, 0.7), at(0.032 * side, 0.7), [0.005, 0.017]);
        shapes.push(Shape::new(move |p| bow.field(p), red).inked(0.7 * INK));
    }
    shapes.extend(head(skin, hair));
    drawn([640, 960], at(-0.36, 1.04), DVec2::new(0.72, 1.08), &shapes)
}

/// Face, eyes and hair.
fn head(skin: glam::DVec3, hair: glam::DVec3) -> Vec<Shape> {
    let (dark, pink) = (colour(0x3a2a2e), colour(0xefa39b));
    let cap = |p: DVec2| ellipse(p, at(0.0, 0.895), at(0.098, 0.098));
    let mut shapes = vec![
        Shape::new(cap, hair).inked(INK),
        Shape::new(|p| ellipse(p, at(0.0, 0.875), at(0.078, 0.08)), skin).inked(INK),
        // A fringe of three locks.
        Shape::new(
            |p: DVec2| {
                let lock = |x: f64, radius: f64| p.distance(at(x, 0.975)) - radius;
                lock(-0.055, 0.07).min(lock(0.055, 0.07)).min(lock(0.0, 0.068))
            },
            hair,
        )
        .inked(0.8 * INK)
        .within(move |p| cap(p) + 0.002),
    ];
    for side in [-1.0, 1.0] {
        shapes.push(Shape::new(move |p| ellipse(p, at(0.034 * side, 0.868), at(0.012, 0.019)), dark));
        shapes.push(Shape::new(move |p| p.distance(at(0.034 * side + 0.004, 0.876)) - 0.0045, colour(0xffffff)));
        shapes.push(Shape::new(move |p| ellipse(p, at(0.05 * side, 0.836), at(0.014, 0.008)), pink));
        let smile = Limb::new(at(0.0, 0.823), at(0.012 * side, 0.827), [0.0026, 0.0022]);
        shapes.push(Shape::new(move |p| smile.field(p), dark));
        let band = Limb::new(at(0.088 * side, 0.93), at(0.1 * side, 0.945), [0.013, 0.013]);
        shapes.push(Shape::new(move |p| band.field(p), colour(0xd2504e)).inked(INK));
    }
    shapes
}
