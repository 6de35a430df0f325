//! Problem files in a compact, readable layout: lists with one entry per line, or several short ones.
//!
//! In: a figure. Out: JSON text.

use super::Figure;
use super::mesh::{Mesh, mesh};
use super::skeleton::pins;
use std::fmt::Display;

const NOTE: &str = "A layered figure drawn by scenes/make/figures; CC0. Pins of `poses` follow a bent skeleton.";

/// The text of a figure's file.
pub(crate) fn json(figure: &Figure) -> String {
    let mesh = mesh(figure);
    let vertices: Vec<String> = mesh.vertices.iter().map(|at| format!("[{},{}]", at.x, at.y)).collect();
    let triangles: Vec<String> =
        mesh.parts.iter().flat_map(|part| part.triangles.iter().map(|[a, b, c]| format!("[{a},{b},{c}]"))).collect();
    format!(
        "{{\n\"name\": \"{}\",\n\"note\": \"{NOTE}\",\n\"dims\": [10, 10],\n\"bbox\": {},\n\"parts\": {},\n\"poses\": {},\n\
         \"vertices\": {},\n\"triangles\": {}\n}}\n",
        figure.name,
        bounds(&mesh),
        rows(&parts(&mesh), 1),
        rows(&poses(figure, &mesh), 1),
        rows(&vertices, 8),
        rows(&triangles, 12)
    )
}

/// The box of the lattice: the bounding box of the model, as in the paper.
fn bounds(mesh: &Mesh) -> String {
    let first = mesh.vertices[0];
    let (low, high) = mesh.vertices.iter().fold((first, first), |(low, high), at| (low.min(*at), high.max(*at)));
    format!("[[{}, {}], [{}, {}]]", low.x, low.y, high.x, high.y)
}

/// Colours of consecutive triangles.
fn parts(mesh: &Mesh) -> Vec<String> {
    let part = |part: &super::mesh::MeshPart| {
        format!(
            "{{\"name\": \"{}\", \"color\": \"{}\", \"triangles\": {}}}",
            part.name,
            part.color,
            part.triangles.len()
        )
    };
    mesh.parts.iter().map(part).collect()
}

fn poses(figure: &Figure, mesh: &Mesh) -> Vec<String> {
    let pose = |pose: &super::Pose| {
        let pins = pins(figure, mesh, pose);
        let pins: Vec<String> = pins
            .iter()
            .map(|(vertex, to)| format!("{{\"vertex\": {vertex}, \"target\": [{}, {}]}}", to.x, to.y))
            .collect();
        format!("{{\"name\": \"{}\", \"pins\": {}}}", pose.name, rows(&pins, 3))
    };
    figure.poses.iter().map(pose).collect()
}

/// A list with this number of entries per line.
fn rows<T: Display>(entries: &[T], per_line: usize) -> String {
    let line = |line: &[T]| line.iter().map(T::to_string).collect::<Vec<_>>().join(", ");
    let lines: Vec<String> = entries.chunks(per_line).map(line).collect();
    format!("[\n{}]", lines.join(",\n"))
}
