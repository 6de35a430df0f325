//! A drawn cat in approximately the pose of the gingerman, to which the gingerman's lattices are transferred.
//!
//! Out: a PNG file. The canvas shows x from -1.5 to 1.5 and y from -1.6 to 1.4, nearly like the gingerman's camera.

use super::drawing::{Shape, colour, drawn};
use super::figures::draw::{Limb, both, chain, ellipse, melted};
use glam::DVec2;
use image::ImageError;

const fn at(x: f64, y: f64) -> DVec2 {
    DVec2::new(x, y)
}

/// The fur: head, ears, body and limbs in one shape.
fn fur() -> Vec<Limb> {
    let mut limbs = vec![
        Limb::new(at(-0.12, 0.66), at(0.12, 0.66), [0.42, 0.42]),
        Limb::new(at(0.0, -0.1), at(0.0, -0.5), [0.27, 0.36]).melting(0.1),
    ];
    limbs.extend(both(Limb::new(at(0.32, 0.88), at(0.43, 1.2), [0.18, 0.03]).melting(0.06)));
    limbs.extend(both(Limb::new(at(0.22, 0.02), at(0.98, -0.14), [0.15, 0.15]).melting(0.16)));
    limbs.extend(both(Limb::new(at(0.2, -0.6), at(0.44, -1.22), [0.2, 0.19]).melting(0.12)));
    limbs
}

/// The PNG file.
pub(crate) fn picture() -> Result<Vec<u8>, ImageError> {
    let (ginger, cream, pink, dark) = (colour(0xe8923c), colour(0xfbe9d0), colour(0xe98a8a), colour(0x3a2a2e));
    let limbs = fur();
    let body = move |p: DVec2| melted(&limbs, p);
    let limbs = fur();
    let whole = move |p: DVec2| melted(&limbs, p) + 0.012;
    let tail = chain(&[(at(0.25, -0.75), 0.1), (at(0.72, -0.98), 0.1), (at(1.08, -0.9), 0.1), (at(1.22, -0.62), 0.09)]);
    let tail_field = move |p: DVec2| melted(&tail, p);
    let banded = move |p: DVec2| if (p.x * 16.0 + p.y * 6.0).sin() > 0.6 { colour(0xc4681f) } else { ginger };
    let mut shapes = vec![
        Shape::new(tail_field, ginger).painted(banded).inked(0.03),
        Shape::new(body, ginger).inked(0.034),
        Shape::new(|p| ellipse(p, at(0.0, -0.42), at(0.2, 0.33)), cream).within(whole),
    ];
    for side in [-1.0, 1.0] {
        let inner = Limb::new(at(0.335 * side, 0.92), at(0.41 * side, 1.11), [0.09, 0.02]);
        shapes.push(Shape::new(move |p| inner.field(p), pink));
        for k in 0..2 {
            let (x, y) = (0.56 + 0.17 * f64::from(k), -0.055 - 0.035 * f64::from(k));
            let band = Limb::new(at(x * side, y + 0.2), at((x - 0.05) * side, y - 0.2), [0.03, 0.03]);
            let limbs = fur();
            shapes
                .push(Shape::new(move |p| band.field(p), colour(0xc4681f)).within(move |p| melted(&limbs, p) + 0.012));
        }
        shapes.push(Shape::new(move |p| ellipse(p, at(1.03 * side, -0.15), at(0.13, 0.14)).min(1e3), cream).within({
            let limbs = fur();
            move |p| melted(&limbs, p) + 0.012
        }));
        shapes.push(Shape::new(move |p| ellipse(p, at(0.45 * side, -1.3), at(0.18, 0.12)), cream).within({
            let limbs = fur();
            move |p| melted(&limbs, p) + 0.012
        }));
        shapes.push(Shape::new(move |p| ellipse(p, at(0.36 * side, 0.44), at(0.11, 0.07)), pink));
        shapes.push(Shape::new(move |p| ellipse(p, at(0.22 * side, 0.66), at(0.085, 0.12)), dark));
        shapes.push(Shape::new(move |p| p.distance(at(0.22 * side + 0.03, 0.71)) - 0.03, colour(0xffffff)));
        for (y, end) in [(0.5, 0.56), (0.43, 0.4)] {
            let whisker = Limb::new(at(0.46 * side, y), at(0.74 * side, end), [0.012, 0.006]);
            shapes.push(Shape::new(move |p| whisker.field(p), dark));
        }
        for (from, to) in [(at(0.0, 0.44), at(0.06 * side, 0.385)), (at(0.06 * side, 0.385), at(0.14 * side, 0.41))] {
            let smile = Limb::new(from, to, [0.014, 0.013]);
            shapes.push(Shape::new(move |p| smile.field(p), dark));
        }
    }
    for (x, tip) in [(-0.16, 0.82), (0.0, 0.78), (0.16, 0.82)] {
        let stripe = Limb::new(at(x, 1.06 - x.abs() * 0.2), at(x * 0.8, tip), [0.035, 0.012]);
        shapes.push(Shape::new(move |p| stripe.field(p), colour(0xc4681f)));
    }
    shapes.push(Shape::new(|p| ellipse(p, at(0.0, 0.5), at(0.06, 0.042)), pink).inked(0.014));
    let scarf = Limb::new(at(-0.27, 0.11), at(0.27, 0.11), [0.085, 0.085]);
    shapes.push(Shape::new(move |p| scarf.field(p), colour(0x2f7f9d)).inked(0.024));
    let end = Limb::new(at(0.16, 0.06), at(0.23, -0.24), [0.07, 0.09]);
    shapes.push(Shape::new(move |p| end.field(p), colour(0x2f7f9d)).inked(0.024));
    drawn([640, 640], at(-1.5, 1.4), DVec2::splat(3.0), &shapes)
}
