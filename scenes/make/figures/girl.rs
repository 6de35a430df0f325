//! The girl: a round head with pigtails, a dress, boots.

use super::draw::{Limb, Outline, both, chain, ellipse, melted};
use super::skeleton::{Joint, Pose};
use super::{Body, Detail, Figure, Region, p};
use glam::DVec2;

const HAIR: &str = "#7a4a2b";
const DRESS: &str = "#e0525e";

pub(crate) fn figure() -> Figure {
    let limbs = limbs();
    Figure {
        name: "girl",
        vertices: 637,
        body: Body {
            field: Box::new(move |at| melted(&limbs, at)),
            start: p(0.0, 1.6),
            color: "#fbd9bd",
            regions: vec![
                Region::new("hair", HAIR, hair),
                Region::new("dress", DRESS, dress),
                Region::new("boots", "#5a4fa0", |at| at.y + 1.22),
            ],
        },
        details: details(),
        joints: joints(),
        poses: poses(),
    }
}

/// Pigtails, and the head above the fringe.
fn hair(at: DVec2) -> f64 {
    let face = ellipse(at, p(0.0, 0.84), p(0.43, 0.36));
    let fringe = 0.98 + 0.10 * (at.x * 9.0).cos().abs() - at.y;
    let cap = (-face.max(-fringe)).max(0.62 - at.y);
    cap.min(melted(&pigtails(), at) - 0.02)
}

fn pigtails() -> Vec<Limb> {
    let tails = chain(&[(p(0.52, 1.16), 0.10), (p(0.78, 1.06), 0.17), (p(0.92, 0.74), 0.16), (p(1.0, 0.46), 0.05)]);
    tails.into_iter().flat_map(|tail| both(tail.melting(0.06))).collect()
}

fn gown() -> [Limb; 2] {
    [Limb::new(p(0.0, 0.24), p(0.0, -0.10), [0.22, 0.25]), Limb::new(p(-0.30, -0.62), p(0.30, -0.62), [0.16, 0.16])]
}

fn dress(at: DVec2) -> f64 {
    let skirt = {
        // A trapezoid: the half-width grows downwards.
        let half = 0.28 + 0.46 * ((0.05 - at.y) / 0.75).clamp(0.0, 1.0);
        (at.x.abs() - half).max(at.y - 0.25).max(-0.82 - at.y)
    };
    let top = (at.x.abs() - 0.25).max(at.y - 0.36).max(-0.2 - at.y);
    let sleeves = Limb::new(p(0.24, 0.26), p(0.42, 0.12), [0.13, 0.14]).field(p(at.x.abs(), at.y));
    skirt.min(top).min(sleeves)
}

fn limbs() -> Vec<Limb> {
    let mut limbs = gown().to_vec();
    for share in [0.25, 0.5, 0.75, 1.0] {
        let (half, y) = (0.05 + 0.40 * share, -0.08 - 0.50 * share);
        limbs.push(Limb::new(p(-half, y), p(half, y), [0.20, 0.20]).melting(0.02));
    }
    limbs.push(Limb::new(p(0.0, 0.3), p(0.0, 0.5), [0.11, 0.11]));
    limbs.push(Limb::new(p(-0.04, 0.95), p(0.04, 0.95), [0.50, 0.50]).melting(0.06));
    limbs.extend(pigtails());
    for arm in chain(&[(p(0.22, 0.24), 0.11), (p(0.60, 0.02), 0.095), (p(0.92, -0.22), 0.085), (p(1.0, -0.28), 0.11)]) {
        limbs.extend(both(arm.melting(0.06)));
    }
    for leg in chain(&[(p(0.20, -0.66), 0.13), (p(0.22, -1.36), 0.115)]) {
        limbs.extend(both(leg.melting(0.05)));
    }
    limbs.extend(both(Limb::new(p(0.22, -1.40), p(0.36, -1.42), [0.13, 0.11]).melting(0.05)));
    limbs
}

fn details() -> Vec<Detail> {
    let mut details = Vec::new();
    for side in [-1.0, 1.0] {
        let eye = p(0.19 * side, 0.84);
        details.push(Detail::new("eye", "#33241c", Outline::ellipse(eye, p(0.058, 0.09), 0.0), 12));
        details.push(Detail::new("glint", "#ffffff", Outline::ellipse(eye + p(0.018, 0.035), p(0.02, 0.025), 0.0), 6));
        details.push(Detail::new("cheek", "#f59b94", Outline::ellipse(p(0.30 * side, 0.70), p(0.075, 0.045), 0.0), 8));
        let bow = Outline::ellipse(p(0.10 * side, 0.32), p(0.10, 0.06), 20.0 * side);
        details.push(Detail::new("bow", "#fff1c9", bow, 10));
    }
    let smile = Outline::smile([p(-0.13, 0.66), p(0.0, 0.58), p(0.13, 0.66)], 0.045);
    details.push(Detail::new("mouth", "#b8433f", smile, 14));
    for y in [0.06, -0.16] {
        details.push(Detail::new("button", "#fff1c9", Outline::ellipse(p(0.0, y), p(0.045, 0.045), 0.0), 8));
    }
    details
}

fn joints() -> Vec<Joint> {
    vec![
        Joint::root("waist", p(0.0, -0.2)),
        Joint::new("neck", "waist", p(0.0, 0.42)),
        Joint::new("head", "neck", p(0.0, 1.25)),
        Joint::new("left pigtail", "neck", p(0.94, 0.70)),
        Joint::new("right pigtail", "neck", p(-0.94, 0.70)),
        Joint::new("left shoulder", "waist", p(0.26, 0.22)),
        Joint::new("left elbow", "left shoulder", p(0.60, 0.02)),
        Joint::new("left hand", "left elbow", p(0.98, -0.27)),
        Joint::new("right shoulder", "waist", p(-0.26, 0.22)),
        Joint::new("right elbow", "right shoulder", p(-0.60, 0.02)),
        Joint::new("right hand", "right elbow", p(-0.98, -0.27)),
        Joint::new("left hip", "waist", p(0.20, -0.60)),
        Joint::new("left foot", "left hip", p(0.26, -1.40)),
        Joint::new("right hip", "waist", p(-0.20, -0.60)),
        Joint::new("right foot", "right hip", p(-0.26, -1.40)),
    ]
}

fn poses() -> Vec<Pose> {
    let tips = ["head", "waist", "left hand", "right hand", "left foot", "right foot"];
    vec![
        Pose::new("wave", &[("left shoulder", 70.0), ("right hip", -45.0)], &tips),
        Pose::new(
            "dance",
            &[("left shoulder", 60.0), ("right shoulder", 30.0), ("left hip", 40.0), ("neck", 10.0)],
            &tips,
        ),
        Pose::new(
            "hop",
            &[("left shoulder", 50.0), ("right shoulder", -50.0), ("left hip", 25.0), ("right hip", -25.0)],
            &tips,
        ),
    ]
}
