//! Six flat, layered characters with the vertex counts of the paper's table, and their poses.
//!
//! Out: problem files of `scenes/figures/`. Each has one connected body, with face and buttons as isolated parts in
//! front.

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
    /// Number of vertices of all parts, as in the paper.
    vertices: usize,
    body: Body,
    /// Isolated parts, from back to front.
    details: Vec<Detail>,
    joints: Vec<Joint>,
    poses: Vec<Pose>,
}

/// The connected body. It gets the vertices that the details leave.
struct Body {
    /// Negative inside.
    field: Box<dyn Fn(DVec2) -> f64>,
    /// A point near the border.
    start: DVec2,
    color: &'static str,
    /// Parts with their own colours. A triangle belongs to the first that contains its centroid.
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
    /// Number of vertices of its border; the interior has none.
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

/// Names below `scenes/` and texts of the files.
pub(crate) fn files() -> Vec<(String, String)> {
    let figures =
        [ginger::figure(), frog::figure(), panda::figure(), unicorn::figure(), girl::figure(), dinosaur::figure()];
    figures.iter().map(|figure| (format!("figures/{}.json", figure.name), write::json(figure))).collect()
}

/// A point.
const fn p(x: f64, y: f64) -> DVec2 {
    DVec2::new(x, y)
}
