//! Converts a picture's alpha to triangles: its outline, holes and islands included, and a mesh inside it.
//!
//! In: coverage of pixels. Out: points in pixels, y down, and triangles, counter-clockwise as seen; deterministic.
//! Nothing of the picture is cut off: the outline lies about a pixel outside.

mod contour;
mod coverage;
mod cut_lines;
mod mesh;
mod simplify;
mod slits;

pub(super) use cut_lines::cut_along;
pub(super) use mesh::Triangulated;

use crate::space::PixelRect;
use coverage::AlphaGrid;

/// Target number of vertices of a mesh.
const WANTED_VERTICES: f64 = 400.0;

/// A mesh with more vertices is rebuilt with longer edges.
const MAX_VERTICES: usize = 700;

/// Maximum number of rebuilds; intricate outlines may stay finer.
const TRIES: usize = 8;

/// Growth of the edge length per rebuild.
const GROWTH: f64 = 1.2;

/// Minimum edge length in cells of the coverage.
const MIN_SPACING: f64 = 1.0;

/// Tolerance of an outline's simplification as a fraction of the edge length, and in cells: the staircase of pixels is
/// not shape.
const TOLERANCE: [f64; 2] = [0.04, 0.4];

/// The same in cells beside narrow gaps: what lies on their other side belongs to another part.
const BESIDE_SLITS: f64 = 1.0;

/// Smaller holes, in squared edge lengths, are closed, and smaller islands dropped if there are larger ones. Islands are measured in the
/// first edge length: in a picture of many islands longer edges would drop them all.
const MIN_AREA: f64 = 0.1;

/// Number of islands from which on only the largest are kept; the others move with what is nearest.
const MAX_ISLANDS: usize = 1000;

/// How a picture fills its pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filling {
    /// It is completely transparent.
    Nothing,
    /// It is completely opaque.
    Everything,
    /// Anything in between.
    Some,
}

/// Classifies the alpha of a picture.
pub(super) fn filling(alpha: &[f32]) -> Filling {
    let is_there = |alpha: &&f32| **alpha > 0.0;
    match alpha.iter().filter(is_there).count() {
        0 => Filling::Nothing,
        _ if alpha.iter().all(|&alpha| alpha >= 1.0) => Filling::Everything,
        _ => Filling::Some,
    }
}

/// Returns a mesh of the visible part of a picture; `alpha`: #pixels of the window, rows from the top, not 0
/// everywhere.
pub(super) fn triangulated(window: PixelRect, alpha: &[f32]) -> Triangulated {
    let coverage = AlphaGrid::of(window, alpha);
    let loops = contour::loops(&coverage);
    let area = loops.iter().map(|points| contour::area(points)).sum::<f64>().abs();
    let length: f64 = loops.iter().map(|points| contour::length(points)).sum();
    let mut spacing = spacing(area, length).max(MIN_SPACING);
    let least_island = least_island(&loops, MIN_AREA * spacing * spacing);
    let mut made = meshed(&coverage, &loops, spacing, least_island);
    for _ in 0..TRIES {
        if made.points.len() <= MAX_VERTICES {
            break;
        }
        spacing *= GROWTH;
        let coarser = meshed(&coverage, &loops, spacing, least_island);
        if coarser.triangles.is_empty() {
            break;
        }
        made = coarser;
    }
    made.points.iter_mut().for_each(|point| *point = coverage.pixel(*point));
    made
}

/// Returns the least area of an island that is kept: a given one, or more if there are too many islands.
fn least_island(loops: &[Vec<[f64; 2]>], least: f64) -> f64 {
    let mut areas: Vec<f64> = loops.iter().map(|points| contour::area(points)).filter(|&area| area >= least).collect();
    areas.sort_by(|a, b| b.total_cmp(a));
    areas.get(MAX_ISLANDS).copied().unwrap_or(least)
}

/// Returns the edge length at which the triangles of an area, and an outline of a length, have the target number of
/// vertices: a / (√3/2 · s²) + l / 2s = n.
fn spacing(area: f64, length: f64) -> f64 {
    let half = length / (4.0 * WANTED_VERTICES);
    half + (half * half + area / (0.75_f64.sqrt() * WANTED_VERTICES)).sqrt()
}

/// Builds the mesh at an edge length, without islands of a smaller area than `least_island`.
fn meshed(coverage: &AlphaGrid, loops: &[Vec<[f64; 2]>], spacing: f64, least_island: f64) -> Triangulated {
    let least_hole = MIN_AREA * spacing * spacing;
    let largest = loops.iter().map(|points| contour::area(points)).fold(0.0, f64::max);
    let is_kept = |points: &&Vec<[f64; 2]>| {
        let area = contour::area(points);
        area >= least_island || area <= -least_hole || area == largest
    };
    let kept: Vec<&Vec<[f64; 2]>> = loops.iter().filter(is_kept).collect();
    let tolerance = (TOLERANCE[0] * spacing).max(TOLERANCE[1]);
    let tolerance = |point| if coverage.is_beside_slit(point) { tolerance.min(BESIDE_SLITS) } else { tolerance };
    let simple = simplify::simplified_apart(&kept, tolerance);
    if let Some(made) = mesh::triangulate(&simple, spacing) {
        return made;
    }
    let plain: Vec<_> = kept.into_iter().cloned().collect();
    mesh::triangulate(&plain, spacing).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square picture, open to the left by a slit of some pixels that ends before its right side.
    fn slit(side: u32, wide: u32, slope: f64) -> (PixelRect, Vec<f32>, impl Fn(u32) -> f64) {
        let window = PixelRect { x: 0, y: 0, width: side, height: side };
        let top = move |x: u32| (0.4 * f64::from(side) + slope * f64::from(x)).floor();
        let is_clear = move |x: u32, y: u32| {
            let into = f64::from(y) - top(x);
            x < side * 3 / 4 && (0.0..f64::from(wide)).contains(&into)
        };
        let alpha = (0..side * side).map(|k| f32::from(u8::from(!is_clear(k % side, k / side)))).collect();
        (window, alpha, move |x| top(x) + 0.5 * f64::from(wide))
    }

    fn contains(corners: [[f64; 2]; 3], [x, y]: [f64; 2]) -> bool {
        let side = |k: usize| {
            let ([ax, ay], [bx, by]) = (corners[k], corners[(k + 1) % 3]);
            (bx - ax) * (y - ay) - (by - ay) * (x - ax)
        };
        let sides = [side(0), side(1), side(2)];
        sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0)
    }

    /// How many triangles reach from one bar to the other where two hang down from a beam, `wide` pixels apart, with ends rounded by a radius
    /// and a slope.
    fn bridges(wide: f64, radius: f64, slope: f64) -> usize {
        let window = PixelRect { x: 0, y: 0, width: 240, height: 240 };
        // Distances to the middle of the gap, and to the lower ends.
        let place = |x: f64, y: f64| (x - 120.5 - slope * (y - 40.0), 200.0 - y);
        let covered = |x: f64, y: f64| {
            let (across, up) = place(x, y);
            let (from_gap, from_side) = (across.abs() - 0.5 * wide, 40.0 - across.abs());
            let (to_side, corner) = (from_gap.min(from_side), radius - up.min(radius));
            let is_rounded_off = to_side < radius && corner > 0.0 && (radius - to_side).hypot(corner) > radius;
            up > 0.0 && y > 20.0 && from_side > 0.0 && !is_rounded_off && (from_gap > 0.0 || y < 60.0)
        };
        // Four by four samples a pixel, as an antialiased drawing has.
        let alpha = (0..240 * 240).map(|k| {
            let within = (0..16).filter(|sample| {
                let at = |k: u32, sample: u32| f64::from(k) + 0.25 * f64::from(sample) + 0.125;
                covered(at(k % 240, sample % 4), at(k / 240, sample / 4))
            });
            within.count() as f32 / 16.0
        });
        let made = triangulated(window, &alpha.collect::<Vec<f32>>());
        let is_bridge = |corners: &&[u32; 3]| {
            let places = corners.map(|corner| made.points[corner as usize]).map(|[x, y]| place(x, y));
            let is_below = places.iter().all(|(_, up)| *up < 100.0);
            is_below
                && places.iter().any(|(across, _)| *across < -3.0)
                && places.iter().any(|(across, _)| *across > 3.0)
        };
        made.triangles.iter().filter(is_bridge).count()
    }

    #[test]
    fn a_narrow_gap_is_open_at_its_mouth() {
        for wide in [1.0, 1.5, 2.0, 2.5, 3.0] {
            for (radius, slope) in [(0.0, 0.0), (2.0, 0.0), (8.0, 0.0), (20.0, 0.0), (0.0, 0.1), (4.0, 0.1)] {
                // Thinner gaps that slope are clear in no pixel here and there.
                if slope == 0.0 || wide >= 2.0 {
                    assert_eq!(bridges(wide, radius, slope), 0, "{wide} {radius} {slope}");
                }
            }
        }
    }

    #[test]
    fn a_gap_of_one_pixel_is_open_in_the_mesh_at_any_size() {
        for (side, wide, slope) in [
            (360, 1, 0.0),
            (360, 2, 0.0),
            (360, 3, 0.0),
            (360, 2, 0.37),
            (1200, 1, 0.21),
            (2500, 1, 0.0),
            (2500, 2, 0.3),
        ] {
            let (window, alpha, middle) = slit(side, wide, slope);
            let made = triangulated(window, &alpha);
            assert!(
                (100..=MAX_VERTICES + 100).contains(&made.points.len()),
                "{side} {wide} {slope}: {}",
                made.points.len()
            );
            let corners = made.triangles.iter().map(|corners| corners.map(|corner| made.points[corner as usize]));
            let corners: Vec<_> = corners.collect();
            for x in (3..side * 3 / 4 - 3).step_by(7) {
                // Outlines are simplified, so the gap may lie a little beside its place.
                let mut places = (-30..=30).map(|k| [f64::from(x) + 0.5, middle(x) + 0.1 * f64::from(k)]);
                let is_open = places.any(|at| !corners.iter().any(|corners| contains(*corners, at)));
                assert!(is_open, "{side} {wide} {slope}: closed at {x}");
            }
        }
    }
}
