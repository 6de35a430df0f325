//! A picture's alpha to triangles: its outline, holes and islands included, and a mesh inside it.
//!
//! In: coverage of pixels. Out: points in pixels, y down, and triangles, counter-clockwise as seen; the same on every
//! run. Nothing of the picture is cut off: the outline lies about a pixel outside.

mod contour;
mod coverage;
mod mesh;
mod simplify;

pub(super) use mesh::Triangulated;

use crate::space::PixelRect;
use coverage::Coverage;

/// Vertices that a mesh should have.
const WANTED_VERTICES: f64 = 400.0;

/// A mesh with more is made anew with longer edges.
const MOST_VERTICES: usize = 700;

/// Longer edges are tried so often; outlines of foam stay finer.
const TRIES: usize = 8;

/// By so much edges grow at each try.
const GROWTH: f64 = 1.2;

/// Edges are at least this long, cells of the coverage.
const LEAST_SPACING: f64 = 1.0;

/// An outline may leave the contour by this share of an edge, and by this many cells: the steps of pixels are not shape.
const TOLERANCE: [f64; 2] = [0.04, 0.4];

/// Holes that are smaller, in squares of an edge, are closed, and islands left out where larger ones are there.
const LEAST_AREA: f64 = 0.1;

/// How a picture fills its pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filling {
    /// Nothing of it is there.
    Nothing,
    /// All of it is.
    Everything,
    /// Something between.
    Some,
}

/// What can be seen of a picture of `size` pixels.
pub(super) fn filling(alpha: &[f32]) -> Filling {
    let is_there = |alpha: &&f32| **alpha > 0.0;
    match alpha.iter().filter(is_there).count() {
        0 => Filling::Nothing,
        _ if alpha.iter().all(|&alpha| alpha >= 1.0) => Filling::Everything,
        _ => Filling::Some,
    }
}

/// A mesh of what can be seen of a picture; `alpha`: #pixels of the window, rows from the top, not 0 everywhere.
pub(super) fn triangulated(window: PixelRect, alpha: &[f32]) -> Triangulated {
    let coverage = Coverage::of(window, alpha);
    let loops = contour::loops(&coverage);
    let area = loops.iter().map(|points| contour::area(points)).sum::<f64>().abs();
    let length: f64 = loops.iter().map(|points| contour::length(points)).sum();
    let mut spacing = spacing(area, length).max(LEAST_SPACING);
    let mut made = meshed(&loops, spacing);
    for _ in 0..TRIES {
        if made.points.len() <= MOST_VERTICES {
            break;
        }
        spacing *= GROWTH;
        made = meshed(&loops, spacing);
    }
    made.points.iter_mut().for_each(|point| *point = coverage.pixel(*point));
    made
}

/// The edge length at which triangles of an area, and an outline of a length, have the wanted number of vertices:
/// a / (√3/2 · s²) + l / 2s = n.
fn spacing(area: f64, length: f64) -> f64 {
    let half = length / (4.0 * WANTED_VERTICES);
    half + (half * half + area / (0.75_f64.sqrt() * WANTED_VERTICES)).sqrt()
}

/// The mesh at an edge length.
fn meshed(loops: &[Vec<[f64; 2]>], spacing: f64) -> Triangulated {
    let least = LEAST_AREA * spacing * spacing;
    let largest = loops.iter().map(|points| contour::area(points)).fold(0.0, f64::max);
    let is_kept = |points: &&Vec<[f64; 2]>| {
        let area = contour::area(points);
        area.abs() >= least || area == largest
    };
    let kept: Vec<&Vec<[f64; 2]>> = loops.iter().filter(is_kept).collect();
    let mut tolerance = (TOLERANCE[0] * spacing).max(TOLERANCE[1]);
    // Outlines that run close together may cross when they are simplified; the contour itself never does.
    while tolerance > 0.05 {
        let simple: Vec<_> = kept.iter().map(|points| simplify::simplified(points, tolerance)).collect();
        if let Some(made) = mesh::triangulate(&simple, spacing) {
            return made;
        }
        tolerance *= 0.5;
    }
    let plain: Vec<_> = kept.into_iter().cloned().collect();
    mesh::triangulate(&plain, spacing).unwrap_or_default()
}
