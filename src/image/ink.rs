//! The ink of a drawing: dark lines up to a width, and how wide they are.
//!
//! In: the light of every cell. Out: [`Ink`]. Ink is what a closing by an octagon fills with light, the black top-hat transform of F. Meyer
//! (J. Serra, "Image Analysis and Mathematical Morphology", 1982, chapter XII); what is wider, such as black hair, is none. Nor is what has
//! darker ink beside it, such as a dark sleeve within its outline.

use super::squared_distance::squared_distances;
use crate::space::around;
use rayon::prelude::*;

/// Contrast of the paler rim of a line, which belongs to it, 0 to 255: less is not seen beside the line.
const RIM: u8 = 10;

/// The ink of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ink {
    /// #cells: whether there is ink.
    pub(super) is_ink: Vec<bool>,
    /// #cells: width of the line, cells; 0 where there is none.
    pub(super) widths: Vec<f32>,
}

impl Ink {
    /// Finds the lines that are darker than what is on both sides of them by more than `contrast`, and at most `widest` cells wide.
    /// `light`: #cells, rows of `width`.
    pub(super) fn find(light: &[u8], width: usize, contrast: u8, widest: f64) -> Self {
        let mut closed = light.to_vec();
        let reaches = octagon(widest as usize + 1);
        reaches.iter().for_each(|&(step, count)| extend(&mut closed, width, step, count, u8::max));
        reaches.iter().for_each(|&([x, y], count)| extend(&mut closed, width, [-x, -y], count, u8::min));
        let depth: Vec<u8> = closed.iter().zip(light).map(|(closed, light)| closed.saturating_sub(*light)).collect();
        let darkest = darkest_around(light, width, widest as usize / 2);
        let is_deep = |cell: usize| depth[cell] > contrast && light[cell] - darkest[cell] <= contrast;
        let is_deep: Vec<bool> = (0..light.len()).into_par_iter().map(is_deep).collect();
        let height = light.len() / width.max(1);
        let is_ink =
            |cell: usize| is_deep[cell] || depth[cell] > RIM && around(width, height, cell).any(|near| is_deep[near]);
        let is_ink: Vec<bool> = (0..light.len()).into_par_iter().map(is_ink).collect();
        let widths = widths(&is_ink, width);
        Self { is_ink, widths }
    }
}

/// Returns the lines, as steps and numbers of cells, whose Minkowski sum is a regular octagon of a width in cells.
fn octagon(width: usize) -> [([isize; 2], usize); 4] {
    // Half of what the diagonal sides take of the width: 1 - 1/√2 of it.
    let diagonal = (0.293 * width as f64).round() as usize;
    let straight = width - (2 * diagonal).min(width - 1);
    [([1, 0], straight), ([0, 1], straight), ([1, 1], diagonal + 1), ([-1, 1], diagonal + 1)]
}

/// Replaces every value by the greatest or least of `count` values that begin there and lie a step apart.
fn extend(values: &mut Vec<u8>, width: usize, step: [isize; 2], count: usize, better: fn(u8, u8) -> u8) {
    let mut done = 1;
    while done < count {
        let by = done.min(count - done);
        *values = combined(values, width, step.map(|step| step * by as isize), better);
        done += by;
    }
}

/// Combines every value with the one at an offset; beyond the picture everything is light.
fn combined(values: &[u8], width: usize, [dx, dy]: [isize; 2], better: fn(u8, u8) -> u8) -> Vec<u8> {
    let mut result = values.to_vec();
    let height = values.len() / width.max(1);
    let shift = dx.unsigned_abs().min(width);
    result.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
        let Some(other) = y.checked_add_signed(dy).filter(|&y| y < height) else {
            return row.iter_mut().for_each(|value| *value = better(*value, u8::MAX));
        };
        let other = &values[other * width..][..width];
        let (beyond, within, other) = match dx < 0 {
            true => (0..shift, shift..width, &other[..width - shift]),
            false => (width - shift..width, 0..width - shift, &other[shift..]),
        };
        row[within].iter_mut().zip(other).for_each(|(value, other)| *value = better(*value, *other));
        row[beyond].iter_mut().for_each(|value| *value = better(*value, u8::MAX));
    });
    result
}

/// Returns the least value within a square around every cell.
fn darkest_around(light: &[u8], width: usize, reach: usize) -> Vec<u8> {
    let mut darkest = light.to_vec();
    for step in [[1, 0], [-1, 0], [0, 1], [0, -1]] {
        extend(&mut darkest, width, step, reach + 1, u8::min);
    }
    darkest
}

/// Returns the local thickness of what is there: the diameter of the largest disc inside it that covers a cell (T. Hildebrand and
/// P. Rüegsegger, "A new method for the model-independent assessment of thickness in three-dimensional images", 1997).
fn widths(is_there: &[bool], width: usize) -> Vec<f32> {
    let height = is_there.len() / width.max(1);
    let is_free: Vec<bool> = is_there.iter().map(|is_there| !is_there).collect();
    let squares = squared_distances(&is_free, width);
    let mut widths: Vec<f32> =
        squares.iter().map(|square| if square.is_finite() { 2.0 * square.sqrt() } else { 0.0 }).collect();
    for cell in (0..is_there.len()).filter(|&cell| is_there[cell] && squares[cell].is_finite()) {
        if around(width, height, cell).any(|near| squares[near] > squares[cell]) {
            continue;
        }
        let (x, y) = (cell % width, cell / width);
        let (square, radius) = (squares[cell], squares[cell].sqrt());
        let reach = radius as usize;
        for row in y.saturating_sub(reach)..(y + reach + 1).min(height) {
            for column in x.saturating_sub(reach)..(x + reach + 1).min(width) {
                let (dx, dy) = (column.abs_diff(x) as f32, row.abs_diff(y) as f32);
                let near = row * width + column;
                if is_there[near] && dx * dx + dy * dy <= square {
                    widths[near] = widths[near].max(2.0 * radius);
                }
            }
        }
    }
    widths
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 80;

    /// The ink of a drawing with this light, for lines of at most 9 cells.
    fn ink(light: impl Fn(f64, f64) -> u8) -> Vec<bool> {
        let light: Vec<u8> =
            (0..SIDE * SIDE).map(|k| light((k % SIDE) as f64 - 39.5, (k / SIDE) as f64 - 39.5)).collect();
        Ink::find(&light, SIDE, 64, 9.0).is_ink
    }

    #[test]
    fn lines_are_ink_whatever_their_direction_and_solid_areas_are_not() {
        for turn in [0.0, 0.4, 0.785] {
            let (sin, cos) = f64::sin_cos(turn);
            let off = move |x: f64, y: f64| (cos * x + sin * y).abs();
            for wide in [1.5, 8.0] {
                let found = ink(|x, y| if off(x, y) < 0.5 * wide { 0 } else { 255 });
                let is_right = |k: usize| {
                    let off = off((k % SIDE) as f64 - 39.5, (k / SIDE) as f64 - 39.5);
                    found[k] == (off < 0.5 * wide)
                };
                assert!((0..found.len()).all(is_right), "{turn} {wide}");
            }
            // Where a solid area ends at the border of the picture its corners are not filled.
            let found = ink(|x, y| if off(x, y) < 7.0 { 0 } else { 255 });
            let inner = (0..found.len()).filter(|k| (12..68).contains(&(k % SIDE)) && (12..68).contains(&(k / SIDE)));
            assert!(!inner.into_iter().any(|k| found[k]), "{turn}");
        }
        // A dot on a line: the line is ink up to it.
        let found = ink(|x, y| if x.hypot(y) < 9.0 || y.abs() < 2.0 { 0 } else { 255 });
        assert!(!found[40 * SIDE + 40] && !found[40 * SIDE + 45] && found[40 * SIDE + 60]);
    }

    #[test]
    fn a_dark_area_within_its_outline_is_none() {
        let found = ink(|x, _| {
            if x.abs() < 2.5 {
                90
            } else if x.abs() < 4.4 {
                0
            } else {
                255
            }
        });
        assert!(
            !found[40 * SIDE + 40] && found[40 * SIDE + 36] && found[40 * SIDE + 43],
            "{:?}",
            &found[40 * SIDE + 30..][..20]
        );
    }

    #[test]
    fn the_width_of_a_line_is_known_all_over_it() {
        let is_there: Vec<bool> = (0..SIDE * SIDE).map(|k| (30..38).contains(&(k / SIDE))).collect();
        let widths = widths(&is_there, SIDE);
        assert!(is_there.iter().zip(&widths).all(|(is_there, width)| *width == if *is_there { 8.0 } else { 0.0 }));
    }
}
