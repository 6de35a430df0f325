//! The frog: standing, eyes on top, long toes.

use super::draw::{Limb, Outline, both, chain, ellipse, melted};
use super::skeleton::{Joint, Pose};
use super::{Body, Detail, Figure, Region, p};

pub(crate) fn figure() -> Figure {
    let limbs = limbs();
    Figure {
        name: "frog",
        vertices: 315,
        body: Body {
            field: Box::new(move |at| melted(&limbs, at)),
            start: p(0.0, 1.2),
            color: "#6fb63a",
            regions: vec![Region::new("belly", "#d6e8a0", |at| ellipse(at, p(0.0, -0.08), p(0.36, 0.40)))],
        },
        details: details(),
        joints: joints(),
        poses: poses(),
    }
}

fn limbs() -> Vec<Limb> {
    let mut limbs = vec![Limb::new(p(0.0, 0.15), p(0.0, -0.15), [0.46, 0.52])];
    limbs.push(Limb::new(p(-0.30, 0.78), p(0.30, 0.78), [0.38, 0.38]).melting(0.2));
    limbs.extend(both(Limb::ball(p(0.40, 1.18), 0.21)));
    for arm in chain(&[(p(0.40, 0.25), 0.15), (p(0.85, 0.0), 0.12), (p(1.05, -0.28), 0.10)]) {
        limbs.extend(both(arm));
    }
    for tip in [p(1.32, -0.24), p(1.25, -0.48), p(1.02, -0.56)] {
        limbs.extend(both(Limb::new(p(1.06, -0.30), tip, [0.075, 0.085]).melting(0.05)));
    }
    for leg in chain(&[(p(0.32, -0.42), 0.22), (p(0.66, -0.75), 0.18), (p(0.58, -1.18), 0.12)]) {
        limbs.extend(both(leg));
    }
    for tip in [p(1.05, -1.26), p(0.92, -1.42), p(0.66, -1.46)] {
        limbs.extend(both(Limb::new(p(0.60, -1.22), tip, [0.085, 0.095]).melting(0.05)));
    }
    limbs
}

fn details() -> Vec<Detail> {
    let mut details = Vec::new();
    for side in [-1.0, 1.0] {
        let eye = p(0.40 * side, 1.20);
        details.push(Detail::new("eye", "#ffffff", Outline::ellipse(eye, p(0.145, 0.15), 0.0), 12));
        details.push(Detail::new(
            "pupil",
            "#20241a",
            Outline::ellipse(eye + p(-0.02 * side, 0.01), p(0.065, 0.085), 0.0),
            8,
        ));
        details.push(Detail::new("cheek", "#f2a27e", Outline::ellipse(p(0.50 * side, 0.72), p(0.095, 0.06), 0.0), 8));
    }
    let smile = Outline::smile([p(-0.42, 0.82), p(0.0, 0.60), p(0.42, 0.82)], 0.05);
    details.push(Detail::new("mouth", "#2f5a1c", smile, 18));
    details
}

fn joints() -> Vec<Joint> {
    vec![
        Joint::root("belly", p(0.0, -0.2)),
        Joint::new("neck", "belly", p(0.0, 0.45)),
        Joint::new("head", "neck", p(0.0, 1.02)),
        Joint::new("left shoulder", "belly", p(0.42, 0.22)),
        Joint::new("left hand", "left shoulder", p(1.08, -0.32)),
        Joint::new("right shoulder", "belly", p(-0.42, 0.22)),
        Joint::new("right hand", "right shoulder", p(-1.08, -0.32)),
        Joint::new("left hip", "belly", p(0.34, -0.45)),
        Joint::new("left knee", "left hip", p(0.66, -0.75)),
        Joint::new("left foot", "left knee", p(0.62, -1.26)),
        Joint::new("right hip", "belly", p(-0.34, -0.45)),
        Joint::new("right knee", "right hip", p(-0.66, -0.75)),
        Joint::new("right foot", "right knee", p(-0.62, -1.26)),
    ]
}

fn poses() -> Vec<Pose> {
    let tips = ["head", "belly", "left hand", "right hand", "left foot", "right foot"];
    vec![
        Pose::new("hello", &[("left shoulder", 70.0), ("right hip", -45.0)], &tips),
        Pose::new("kick", &[("left hip", 45.0), ("right shoulder", -60.0), ("neck", -10.0)], &tips),
        Pose::new(
            "dance",
            &[("left shoulder", 65.0), ("right shoulder", 35.0), ("left hip", 30.0), ("right hip", 30.0)],
            &tips,
        ),
    ]
}
