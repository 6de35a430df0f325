//! The dinosaur: upright, a long tail, spikes along the back.

use super::draw::{Limb, Outline, chain, ellipse, melted};
use super::skeleton::{Joint, Pose};
use super::{Body, Detail, Figure, Region, p};

pub(crate) fn figure() -> Figure {
    let limbs = limbs();
    Figure {
        name: "dinosaur",
        vertices: 734,
        body: Body {
            field: Box::new(move |at| melted(&limbs, at)),
            start: p(0.3, -0.62),
            color: "#4fa58a",
            regions: vec![
                Region::new("spikes", "#f0a03c", |at| melted(&spikes(), at).max(-melted(&trunk(), at))),
                Region::new("belly", "#e8e3a4", |at| ellipse(at, p(0.36, -0.08), p(0.24, 0.46))),
            ],
        },
        details: details(),
        joints: joints(),
        poses: poses(),
    }
}

/// Body, neck, head and tail.
fn trunk() -> Vec<Limb> {
    let mut limbs = vec![Limb::new(p(0.02, -0.22), p(0.20, 0.26), [0.50, 0.38])];
    limbs.push(Limb::new(p(0.24, 0.40), p(0.36, 0.86), [0.30, 0.25]).melting(0.14));
    limbs.push(Limb::new(p(0.42, 1.06), p(0.84, 0.98), [0.34, 0.22]).melting(0.14));
    let tail = [
        (p(-0.20, -0.36), 0.38),
        (p(-0.72, -0.62), 0.26),
        (p(-1.22, -0.66), 0.17),
        (p(-1.62, -0.46), 0.10),
        (p(-1.86, -0.16), 0.04),
    ];
    limbs.extend(chain(&tail).into_iter().map(|limb| limb.melting(0.16)));
    limbs
}

fn spikes() -> Vec<Limb> {
    [
        (p(0.10, 1.14), p(-0.06, 1.36)),
        (p(0.08, 0.84), p(-0.14, 1.00)),
        (p(-0.02, 0.54), p(-0.26, 0.66)),
        (p(-0.18, 0.26), p(-0.44, 0.36)),
        (p(-0.36, -0.02), p(-0.60, 0.12)),
        (p(-0.60, -0.28), p(-0.80, -0.08)),
        (p(-0.92, -0.44), p(-1.08, -0.24)),
        (p(-1.22, -0.50), p(-1.34, -0.32)),
    ]
    .into_iter()
    .map(|(root, tip)| Limb::new(root, tip, [0.13, 0.03]).melting(0.03))
    .collect()
}

fn limbs() -> Vec<Limb> {
    let mut limbs = trunk();
    limbs.extend(spikes());
    for arm in chain(&[(p(0.46, 0.26), 0.11), (p(0.78, 0.10), 0.09), (p(0.96, 0.20), 0.085)]) {
        limbs.push(arm.melting(0.06));
    }
    for (hip, ankle) in [(p(-0.16, -0.56), p(-0.20, -1.14)), (p(0.30, -0.52), p(0.40, -1.14))] {
        limbs.push(Limb::new(hip, ankle, [0.25, 0.16]).melting(0.08));
        limbs.push(Limb::new(ankle + p(0.0, -0.06), ankle + p(0.24, -0.08), [0.14, 0.12]).melting(0.08));
    }
    limbs
}

fn details() -> Vec<Detail> {
    let mut details = vec![
        Detail::new("eye", "#ffffff", Outline::ellipse(p(0.50, 1.16), p(0.105, 0.115), 0.0), 14),
        Detail::new("pupil", "#1d2b2a", Outline::ellipse(p(0.53, 1.16), p(0.05, 0.065), 0.0), 10),
        Detail::new("nostril", "#2c6a58", Outline::ellipse(p(0.96, 1.06), p(0.03, 0.022), 20.0), 6),
        Detail::new("cheek", "#f0907e", Outline::ellipse(p(0.48, 0.92), p(0.08, 0.05), 0.0), 8),
        Detail::new("mouth", "#2c6a58", Outline::smile([p(0.58, 0.92), p(0.78, 0.83), p(1.0, 0.93)], 0.04), 16),
    ];
    for (at, radius) in [(p(-0.10, 0.02), 0.085), (p(-0.30, -0.30), 0.075), (p(-0.66, -0.58), 0.06)] {
        details.push(Detail::new("spot", "#3a8470", Outline::ellipse(at, p(radius, 0.8 * radius), 30.0), 10));
    }
    details
}

fn joints() -> Vec<Joint> {
    vec![
        Joint::root("belly", p(0.12, -0.12)),
        Joint::new("chest", "belly", p(0.22, 0.34)),
        Joint::new("nape", "chest", p(0.36, 0.86)),
        Joint::new("snout", "nape", p(0.92, 0.98)),
        Joint::new("crown", "nape", p(0.36, 1.30)),
        Joint::new("shoulder", "belly", p(0.46, 0.26)),
        Joint::new("hand", "shoulder", p(0.98, 0.20)),
        Joint::new("rump", "belly", p(-0.44, -0.48)),
        Joint::new("tail", "rump", p(-1.0, -0.66)),
        Joint::new("tail tip", "tail", p(-1.76, -0.30)),
        Joint::new("hind hip", "belly", p(-0.16, -0.58)),
        Joint::new("hind foot", "hind hip", p(-0.14, -1.20)),
        Joint::new("fore hip", "belly", p(0.30, -0.54)),
        Joint::new("fore foot", "fore hip", p(0.46, -1.20)),
    ]
}

fn poses() -> Vec<Pose> {
    let tips = ["belly", "crown", "snout", "hand", "tail tip", "hind foot", "fore foot"];
    vec![
        Pose::new("roar", &[("chest", 20.0), ("shoulder", 70.0), ("tail", -40.0), ("fore hip", 25.0)], &tips),
        Pose::new("stomp", &[("fore hip", 45.0), ("tail", 35.0), ("chest", -15.0), ("shoulder", 30.0)], &tips),
        Pose::new("dash", &[("hind hip", -45.0), ("fore hip", 30.0), ("chest", -25.0), ("rump", -20.0)], &tips),
    ]
}
