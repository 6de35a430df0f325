//! The ginger man: the cookie of `scenes/gingerman`, with eyes, mouth and buttons in front.

use super::draw::Outline;
use super::skeleton::{Joint, Pose};
use super::{Body, Detail, Figure, p};
use crate::make::gingerman::silhouette;

const ICING: &str = "#fff4e4";

pub(crate) fn figure() -> Figure {
    Figure {
        name: "ginger",
        vertices: 225,
        body: Body { field: Box::new(silhouette), start: p(0.0, 1.45), color: "#c98a4b", regions: Vec::new() },
        details: details(),
        joints: joints(),
        poses: poses(),
    }
}

fn details() -> Vec<Detail> {
    let mut details = Vec::new();
    for side in [-1.0, 1.0] {
        details.push(Detail::new("eye", "#4a2412", Outline::ellipse(p(0.19 * side, 0.96), p(0.08, 0.11), 0.0), 12));
    }
    let smile = Outline::smile([p(-0.26, 0.76), p(0.0, 0.61), p(0.26, 0.76)], 0.07);
    details.push(Detail::new("mouth", ICING, smile, 14));
    for (y, color) in [(0.20, "#d8433c"), (-0.10, "#f2c230"), (-0.40, "#4f9a4a")] {
        details.push(Detail::new("button", color, Outline::ellipse(p(0.0, y), p(0.085, 0.085), 0.0), 8));
    }
    details
}

fn joints() -> Vec<Joint> {
    vec![
        Joint::root("hip", p(0.0, -0.45)),
        Joint::new("chest", "hip", p(0.0, 0.12)),
        Joint::new("neck", "chest", p(0.0, 0.42)),
        Joint::new("head", "neck", p(0.0, 1.30)),
        Joint::new("left shoulder", "chest", p(0.34, 0.14)),
        Joint::new("left hand", "left shoulder", p(1.16, -0.12)),
        Joint::new("right shoulder", "chest", p(-0.34, 0.14)),
        Joint::new("right hand", "right shoulder", p(-1.16, -0.12)),
        Joint::new("left thigh", "hip", p(0.24, -0.62)),
        Joint::new("left foot", "left thigh", p(0.48, -1.36)),
        Joint::new("right thigh", "hip", p(-0.24, -0.62)),
        Joint::new("right foot", "right thigh", p(-0.48, -1.36)),
    ]
}

fn poses() -> Vec<Pose> {
    let tips = ["head", "chest", "left hand", "right hand", "left foot", "right foot"];
    vec![
        Pose::new("wave", &[("left shoulder", 70.0), ("right thigh", -45.0)], &tips),
        Pose::new("stride", &[("left thigh", 45.0), ("right thigh", -25.0), ("right shoulder", 40.0)], &tips),
        Pose::new("cheer", &[("left shoulder", 70.0), ("right shoulder", -70.0), ("neck", 12.0)], &tips),
        Pose::new(
            "lean",
            &[("hip", -12.0), ("left shoulder", -50.0), ("left thigh", 57.0), ("right thigh", 12.0)],
            &tips,
        ),
    ]
}
