//! The unicorn: from the side, with horn, mane and tail.

use super::draw::{Limb, Outline, chain, melted};
use super::skeleton::{Joint, Pose};
use super::{Body, Detail, Figure, Region, p};
use glam::DVec2;

pub(crate) fn figure() -> Figure {
    let limbs = limbs();
    Figure {
        name: "unicorn",
        vertices: 549,
        body: Body {
            field: Box::new(move |at| melted(&limbs, at)),
            start: p(-0.1, 0.5),
            color: "#f7f0fb",
            regions: vec![
                Region::new("horn", "#f5c542", |at| melted(&horn(), at) - 0.01),
                Region::new("mane", "#e58ac0", |at| melted(&mane(), at) - 0.01),
                Region::new("tail", "#e58ac0", |at| (melted(&tail(), at) - 0.01).max(at.x + 0.93)),
                Region::new("hooves", "#8f6fb8", |at| at.y + 1.16),
            ],
        },
        details: details(),
        joints: joints(),
        poses: poses(),
    }
}

const LEGS: [[DVec2; 2]; 4] = [
    [p(-0.74, -0.22), p(-0.86, -1.22)],
    [p(-0.44, -0.26), p(-0.42, -1.22)],
    [p(0.26, -0.26), p(0.24, -1.22)],
    [p(0.56, -0.20), p(0.68, -1.22)],
];

fn limbs() -> Vec<Limb> {
    let mut limbs = vec![Limb::new(p(-0.56, 0.04), p(0.36, 0.06), [0.37, 0.36])];
    limbs.extend(LEGS.map(|[hip, hoof]| Limb::new(hip, hoof, [0.17, 0.115]).melting(0.08)));
    limbs.push(Limb::new(p(0.46, 0.22), p(0.86, 0.82), [0.29, 0.21]).melting(0.16));
    limbs.push(Limb::new(p(0.92, 0.98), p(1.32, 0.76), [0.25, 0.165]));
    limbs.push(Limb::new(p(0.80, 1.14), p(0.78, 1.36), [0.09, 0.03]).melting(0.06));
    limbs.extend(mane());
    limbs.extend(horn());
    limbs.extend(tail());
    limbs
}

fn horn() -> Vec<Limb> {
    vec![Limb::new(p(1.06, 1.18), p(1.30, 1.70), [0.075, 0.022]).melting(0.04)]
}

/// Curls along the neck.
fn mane() -> Vec<Limb> {
    let curls = [(p(0.66, 1.10), 0.15), (p(0.55, 0.88), 0.15), (p(0.42, 0.66), 0.15), (p(0.26, 0.48), 0.13)];
    curls.into_iter().map(|(at, radius)| Limb::ball(at, radius).melting(0.05)).collect()
}

fn tail() -> Vec<Limb> {
    chain(&[
        (p(-0.86, 0.16), 0.10),
        (p(-1.12, 0.24), 0.13),
        (p(-1.36, 0.02), 0.17),
        (p(-1.42, -0.34), 0.14),
        (p(-1.62, -0.56), 0.04),
    ])
}

fn details() -> Vec<Detail> {
    vec![
        Detail::new("eye", "#3b2a4a", Outline::ellipse(p(1.02, 0.98), p(0.06, 0.085), 0.0), 12),
        Detail::new("glint", "#ffffff", Outline::ellipse(p(1.035, 1.015), p(0.022, 0.026), 0.0), 6),
        Detail::new("cheek", "#f5b5c8", Outline::ellipse(p(1.04, 0.80), p(0.085, 0.055), -25.0), 8),
        Detail::new("nostril", "#8f6fb8", Outline::ellipse(p(1.40, 0.78), p(0.025, 0.035), 0.0), 6),
        Detail::new("mouth", "#8f6fb8", Outline::smile([p(1.22, 0.70), p(1.32, 0.65), p(1.41, 0.68)], 0.03), 10),
        Detail::new("star", "#f5c542", Outline::star(p(-0.58, 0.10), 0.17, 5), 10),
    ]
}

fn joints() -> Vec<Joint> {
    vec![
        Joint::root("belly", p(-0.1, 0.02)),
        Joint::new("withers", "belly", p(0.36, 0.22)),
        Joint::new("poll", "withers", p(0.88, 0.90)),
        Joint::new("nose", "poll", p(1.34, 0.76)),
        Joint::new("horn", "poll", p(1.28, 1.64)),
        Joint::new("rump", "belly", p(-0.80, 0.10)),
        Joint::new("tail", "rump", p(-1.44, -0.36)),
        Joint::new("hind hip", "belly", p(-0.72, -0.20)),
        Joint::new("hind hoof", "hind hip", p(-0.86, -1.24)),
        Joint::new("inner hind hip", "belly", p(-0.44, -0.24)),
        Joint::new("inner hind hoof", "inner hind hip", p(-0.42, -1.24)),
        Joint::new("inner shoulder", "belly", p(0.26, -0.24)),
        Joint::new("inner fore hoof", "inner shoulder", p(0.24, -1.24)),
        Joint::new("shoulder", "belly", p(0.54, -0.18)),
        Joint::new("fore hoof", "shoulder", p(0.68, -1.24)),
    ]
}

fn poses() -> Vec<Pose> {
    let tips = ["belly", "nose", "horn", "tail", "hind hoof", "inner hind hoof", "inner fore hoof", "fore hoof"];
    vec![
        Pose::new(
            "prance",
            &[("shoulder", 65.0), ("inner shoulder", 15.0), ("rump", -30.0), ("hind hip", -15.0)],
            &tips,
        ),
        Pose::new("graze", &[("withers", -55.0), ("poll", -15.0), ("rump", 20.0), ("inner shoulder", -10.0)], &tips),
        Pose::new("kick", &[("hind hip", -70.0), ("inner hind hip", -20.0), ("withers", 12.0), ("rump", -35.0)], &tips),
    ]
}
