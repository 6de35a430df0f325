//! The pixels of a convex polygon, row by row.
//!
//! In: corners, in pixels from the centre of the first pixel. Out: for each row the columns whose centres lie inside or on a side.

use std::ops::Range;

/// Returns the rows that a polygon meets in a picture of the given width and height, each with its columns. Of a corner's numbers the
/// first two are x, to the right, and y, down.
pub(crate) fn convex_spans<const N: usize>(
    corners: &[[f64; N]],
    [width, height]: [usize; 2],
) -> impl Iterator<Item = (usize, Range<usize>)> {
    within(corners.iter().map(|corner| corner[1]), height).map(move |row| {
        let sides = (0..corners.len()).map(|k| [corners[k], corners[(k + 1) % corners.len()]]);
        (row, within(sides.flat_map(|side| crossings(side, row as f64)), width))
    })
}

/// Returns the integers in 0..`count` between the minimum and the maximum of some values.
fn within(values: impl Iterator<Item = f64>, count: usize) -> Range<usize> {
    let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
    let start = low.ceil().clamp(0.0, count as f64) as usize;
    start..((high.floor() + 1.0).clamp(0.0, count as f64) as usize).max(start)
}

/// Returns the x at which a side meets the line at height `y`: none, one, or both ends if the side lies on the line.
fn crossings<const N: usize>([a, b]: [[f64; N]; 2], y: f64) -> impl Iterator<Item = f64> {
    let ([ax, ay], [bx, by]) = ([a[0], a[1]], [b[0], b[1]]);
    let both = if y < ay.min(by) || y > ay.max(by) {
        [None; 2]
    } else if ay == by {
        [Some(ax), Some(bx)]
    } else {
        [Some(ax + (y - ay) / (by - ay) * (bx - ax)), None]
    };
    both.into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_and_corners_count_as_inside_and_the_picture_bounds_all() {
        let spans = |corners: &[[f64; 2]]| convex_spans(corners, [5, 4]).collect::<Vec<_>>();
        let diamond = [[2.0, 0.0], [4.0, 2.0], [2.0, 4.0], [0.0, 2.0]];
        assert_eq!(spans(&diamond), [(0, 2..3), (1, 1..4), (2, 0..5), (3, 1..4)]);
        let wide = [[-3.0, 0.5], [9.0, 0.5], [9.0, 1.0], [-3.0, 1.0]];
        assert_eq!(spans(&wide), [(1, 0..5)]);
        assert_eq!(spans(&[[1.2, -1.0], [1.8, -1.0], [1.5, 9.0]]), [0, 1, 2, 3].map(|row| (row, 2..2)));
    }
}
