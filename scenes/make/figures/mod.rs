//! Six flat, layered characters with the vertex counts of the paper's table, and poses for them.
//!
//! Out: problem files of `scenes/figures/`: one connected body each, with face and buttons as isolated parts in front.

mod dinosaur;
pub(crate) mod draw;
mod frog;
mod ginger;
mod girl;
mod mesh;
mod panda;
mod skeleton;
mod unicorn;
mod write;

use draw::Outline;
use glam::DVec2;
use skeleton::{Joint, Pose};

/// A character.
pub(crate) struct Figure {
    /// File name and title.
    name: &'static str,
    /// Vertices of all parts together, as in the paper.
    vertices: usize,
    body: Body,
    /// Isolated parts, later ones in front.
    details: Vec<Detail>,
    joints: Vec<Joint>,
    poses: Vec<Pose>,
}

/// The connected body; it takes the vertices that the details leave.
struct Body {
    /// Negative inside.
    field: Box<dyn Fn(DVec2) -> f64>,
    /// Near the border.
    start: DVec2,
    color: &'static str,
    /// Parts of it in colours of their own; the first that holds a triangle's middle takes it.
    regions: Vec<Region>,
}

/// A coloured part of the body.
struct Region {
    name: &'static str,
    color: &'static str,
    /// Negative inside.
    field: Box<dyn Fn(DVec2) -> f64>,
}

/// An isolated part.
struct Detail {
    name: &'static str,
    color: &'static str,
    outline: Outline,
    /// Vertices of its border; there are none inside.
    border: usize,
}

impl Detail {
    fn new(name: &'static str, color: &'static str, outline: Outline, border: usize) -> Self {
        Self { name, color, outline, border }
    }
}

impl Region {
    fn new(name: &'static str, color: &'static str, field: impl Fn(DVec2) -> f64 + 'static) -> Self {
        Self { name, color, field: Box::new(field) }
    }
}

/// File names below `scenes/` and their text.
pub(crate) fn files() -> Vec<(String, String)> {
    let figures =
        [ginger::figure(), frog::figure(), panda::figure(), unicorn::figure(), girl::figure(), dinosaur::figure()];
    figures.iter().map(|figure| (format!("figures/{}.json", figure.name), write::json(figure))).collect()
}

/// A point.
const fn p(x: f64, y: f64) -> DVec2 {
    DVec2::new(x, y)
}
