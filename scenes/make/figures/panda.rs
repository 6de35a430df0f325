//! The panda: upright, dark ears, arms and legs.

use super::draw::{Limb, Outline, both, ellipse, melted};
use super::skeleton::{Joint, Pose};
use super::{Body, Detail, Figure, Region, p};
use glam::DVec2;

const INK: &str = "#2b2b30";

pub(crate) fn figure() -> Figure {
    let limbs = limbs();
    Figure {
        name: "panda",
        vertices: 444,
        body: Body {
            field: Box::new(move |at| melted(&limbs, at)),
            start: p(0.0, 1.5),
            color: "#fbfaf5",
            regions: vec![
                Region::new("ears", INK, |at| Limb::ball(p(at.x.signum() * 0.50, 1.33), 0.23).field(at)),
                Region::new("arms", INK, arms),
                Region::new("legs", INK, |at| ellipse(folded(at), p(0.44, -1.12), p(0.50, 0.48))),
            ],
        },
        details: details(),
        joints: joints(),
        poses: poses(),
    }
}

fn folded(at: DVec2) -> DVec2 {
    p(at.x.abs(), at.y)
}

/// Arms and the band across the shoulders.
fn arms(at: DVec2) -> f64 {
    let band = (at.y - (0.20 - 0.10 * at.x * at.x)).abs() - 0.15;
    band.min(Limb::new(p(0.40, 0.15), p(1.0, -0.32), [0.22, 0.26]).field(folded(at)))
}

fn limbs() -> Vec<Limb> {
    let mut limbs = vec![Limb::new(p(0.0, 0.10), p(0.0, -0.52), [0.46, 0.56])];
    limbs.push(Limb::new(p(-0.14, 0.88), p(0.14, 0.88), [0.54, 0.54]).melting(0.12));
    limbs.extend(both(Limb::ball(p(0.50, 1.33), 0.19).melting(0.06)));
    limbs.extend(both(Limb::new(p(0.38, 0.18), p(1.0, -0.32), [0.19, 0.20])));
    limbs.extend(both(Limb::new(p(0.32, -0.75), p(0.44, -1.28), [0.25, 0.23])));
    limbs.extend(both(Limb::new(p(0.44, -1.34), p(0.60, -1.38), [0.17, 0.15])));
    limbs
}

fn details() -> Vec<Detail> {
    let mut details = Vec::new();
    for side in [-1.0, 1.0] {
        let patch = Outline::ellipse(p(0.26 * side, 0.92), p(0.13, 0.17), 28.0 * side);
        details.push(Detail::new("patch", INK, patch, 14));
        details.push(Detail::new("eye", "#ffffff", Outline::ellipse(p(0.245 * side, 0.95), p(0.055, 0.06), 0.0), 8));
        details.push(Detail::new("cheek", "#f4b8b2", Outline::ellipse(p(0.46 * side, 0.70), p(0.085, 0.055), 0.0), 8));
    }
    details.push(Detail::new("nose", INK, Outline::ellipse(p(0.0, 0.76), p(0.085, 0.055), 0.0), 8));
    let smile = Outline::smile([p(-0.16, 0.63), p(0.0, 0.56), p(0.16, 0.63)], 0.04);
    details.push(Detail::new("mouth", INK, smile, 12));
    details
}

fn joints() -> Vec<Joint> {
    vec![
        Joint::root("belly", p(0.0, -0.45)),
        Joint::new("neck", "belly", p(0.0, 0.35)),
        Joint::new("head", "neck", p(0.0, 1.30)),
        Joint::new("left shoulder", "belly", p(0.42, 0.14)),
        Joint::new("left hand", "left shoulder", p(1.06, -0.36)),
        Joint::new("right shoulder", "belly", p(-0.42, 0.14)),
        Joint::new("right hand", "right shoulder", p(-1.06, -0.36)),
        Joint::new("left hip", "belly", p(0.32, -0.78)),
        Joint::new("left foot", "left hip", p(0.48, -1.36)),
        Joint::new("right hip", "belly", p(-0.32, -0.78)),
        Joint::new("right foot", "right hip", p(-0.48, -1.36)),
    ]
}

fn poses() -> Vec<Pose> {
    let tips = ["head", "belly", "left hand", "right hand", "left foot", "right foot"];
    vec![
        Pose::new("wave", &[("left shoulder", 70.0), ("right hip", -45.0)], &tips),
        Pose::new("bow", &[("neck", -20.0), ("right shoulder", -55.0), ("left shoulder", 25.0)], &tips),
        Pose::new("march", &[("left hip", 45.0), ("right shoulder", -70.0), ("left shoulder", -20.0)], &tips),
    ]
}
