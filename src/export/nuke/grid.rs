//! Writes a lattice as the grids of Nuke's GridWarp3.
//!
//! In: screen lattices by frame. Out: the two grid knobs: points and Bézier handles, keyed over the frames. The syntax was
//! inferred from scripts that Nuke and trackers wrote; the result has not been opened in Nuke.

use crate::lattice::{Grid, Lattice};
use crate::space::{FrameSize, ScreenPoint, ScreenVector};
use std::collections::BTreeMap;
use std::fmt::Write;

/// A point of a grid: its position and its four handles, in pixels, y up.
type Knot = [[f64; 2]; 5];

/// The two grids of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// The undeformed grid.
    Source,
    /// The deformed grid.
    Destination,
}

/// Returns the value of a grid knob: "1 columns rows 4 1 0", then one line per point from the bottom: its position, then handles up,
/// down, right, left relative to it; `{2 x y}` is constant, `{1 {curve ..} ..}` is keyed.
///
/// The grid lines lie at the boundaries of the lattice's spans, and the border of a
/// span is a cubic with the ends and slopes of the lattice: along lines of B-splines both agree exactly. Between the
/// lines Nuke interpolates in its own way.
pub(super) fn grid_knob(lattices: &BTreeMap<i32, Lattice<2>>, frame: FrameSize, side: Side) -> String {
    let Some(first) = lattices.values().next() else { return String::new() };
    let [columns, rows] = [0, 1].map(|axis| first.grid.basis.spans(first.grid.dims[axis]) + 1);
    let mut text = format!("{{\n  1 {columns} {rows} 4 1 0\n  {{default }}\n  {{\n");
    for row in 0..rows {
        for column in 0..columns {
            let knots: Vec<(i32, Knot)> = lattices
                .iter()
                .map(|(&number, lattice)| (number, knot(lattice, frame, ([column, row], side))))
                .collect();
            text.push_str("    { ");
            text.push_str(&vector(&knots, 0));
            text.push_str(" {");
            (1..5).for_each(|handle| {
                text.push(' ');
                text.push_str(&vector(&knots, handle));
            });
            text.push_str(" } }\n");
        }
    }
    text + "  }\n }"
}

fn knot(lattice: &Lattice<2>, frame: FrameSize, (place, side): ([usize; 2], Side)) -> Knot {
    let grid = &lattice.grid;
    let spans = [0, 1].map(|axis| grid.basis.spans(grid.dims[axis]));
    let step: [f64; 2] = [0, 1].map(|axis| grid.size(axis) / spans[axis] as f64);
    let at = rest(grid, place, spans);
    let (image, right, up) = match side {
        Side::Source => {
            (grid.point_from_upright(at), grid.rotated([step[0] / 3.0, 0.0]), grid.rotated([0.0, step[1] / 3.0]))
        }
        Side::Destination => moved(lattice, at, step),
    };
    let pixels = |[x, y]: [f64; 2]| frame.pixels_from_screen(ScreenVector::new(x, y)).to_array();
    let place = frame.pixels_from_screen(ScreenPoint::new(image[0], image[1]) - ScreenPoint::default()).to_array();
    let back = |[x, y]: [f64; 2]| [-x, -y];
    [place, pixels(up), pixels(back(up)), pixels(right), pixels(back(right))]
}

/// Returns a crossing of lines of the box before its rotation.
fn rest(grid: &Grid<2>, place: [usize; 2], spans: [usize; 2]) -> [f64; 2] {
    [0, 1].map(|axis| grid.lo[axis] + grid.size(axis) * place[axis] as f64 / spans[axis] as f64)
}

/// Returns the image of a point of the box, and a third of its slope over a span to the right and upwards: the handles of a cubic with
/// the ends and slopes of the lattice. Piecewise linear cells have corners there; their handles are the mean of both sides.
fn moved(lattice: &Lattice<2>, at: [f64; 2], step: [f64; 2]) -> ([f64; 2], [f64; 2], [f64; 2]) {
    let upright = lattice.grid.upright();
    let is_cell = lattice.grid.basis.is_piecewise_linear();
    let slope = |axis: usize| -> [f64; 2] {
        let reach = if is_cell { step[axis] * 0.5 } else { step[axis] * 1e-3 };
        let side = |sign: f64| {
            let mut point = at;
            point[axis] += sign * reach;
            let inside = upright.clamp_to_box(point);
            (inside[axis], lattice.evaluate(lattice.grid.point_from_upright(inside)))
        };
        let ((low, from), (high, to)) = (side(-1.0), side(1.0));
        [0, 1].map(|d| (to[d] - from[d]) / (high - low) * step[axis] / 3.0)
    };
    (lattice.evaluate(lattice.grid.point_from_upright(at)), slope(0), slope(1))
}

/// Formats a position or handle: constant, or a curve with a key per frame.
fn vector(knots: &[(i32, Knot)], part: usize) -> String {
    // Rounded first, without negative zeros, so that constant values are written identically in all frames.
    let written = |knot: &Knot| knot[part].map(|value| format!("{:.4}", (value * 1e4).round() / 1e4 + 0.0));
    let first = knots.first().map(|(_, knot)| written(knot)).unwrap_or_default();
    if knots.iter().all(|(_, knot)| written(knot) == first) {
        return format!("{{2 {} {}}}", first[0], first[1]);
    }
    let mut curves = [String::from("{curve L"), String::from("{curve L")];
    for (number, knot) in knots {
        for (curve, value) in curves.iter_mut().zip(written(knot)) {
            write!(curve, " x{number} {value}").expect("strings take all text");
        }
    }
    format!("{{1 {}}} {}}}}}", curves[0], curves[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;

    fn knob(shift: f64, side: Side) -> String {
        let rest = Grid { dims: [5, 4], basis: Basis::Bspline, lo: [0.25, 0.5], hi: [0.75, 1.0], angle: 0.0 }.at_rest();
        let mut moved = rest.clone();
        moved.handles.iter_mut().for_each(|handle| handle[0] += shift);
        grid_knob(&BTreeMap::from([(1, rest), (2, moved)]), FrameSize::new(200, 100), side)
    }

    #[test]
    fn lines_of_the_grid_lie_where_spans_meet() {
        let source = knob(0.1, Side::Source);
        assert!(source.starts_with("{\n  1 3 2 4 1 0\n  {default }\n"), "{source}");
        let first =
            "{ {2 25.0000 50.0000} { {2 0.0000 16.6667} {2 0.0000 -16.6667} {2 8.3333 0.0000} {2 -8.3333 0.0000} } }";
        assert!(source.contains(first), "{source}");
        assert!(!source.contains("curve"), "the box stands still: {source}");
    }

    #[test]
    fn destinations_are_keyed_where_they_move() {
        let destination = knob(0.1, Side::Destination);
        assert!(destination.contains("{ {1 {curve L x1 25.0000 x2 35.0000} {curve L x1 50.0000 x2 50.0000}} { {2 "));
        assert_eq!(destination.matches("{curve L").count(), 12, "two for each of six points: {destination}");
        assert_eq!(destination.matches('{').count(), destination.matches('}').count());
    }
}
