//! The narrow gaps of a picture, which a dilation would close.
//!
//! In: alpha of pixels. Out: the pixels in gaps up to a width.

use crate::space::around;
use rayon::prelude::*;

/// Returns the pixels below a threshold that lie in a gap: along a row, a column or a diagonal they are among at most `widest` such pixels
/// between two others. With them come the pixels beside those found along rows and columns: before the mouth of a gap a dilation would
/// connect its sides. `alpha`: #pixels, rows of `width`.
pub(super) fn slits(alpha: &[f32], width: usize, edge: f32, widest: usize) -> Vec<usize> {
    let height = alpha.len() / width.max(1);
    // Returns the number of steps to the first covered pixel.
    let steps = |[x, y]: [usize; 2], [dx, dy]: [isize; 2]| {
        (1..=widest as isize).find(|step| {
            let place = x.checked_add_signed(step * dx).zip(y.checked_add_signed(step * dy));
            place.is_some_and(|(x, y)| x < width && y < height && alpha[y * width + x] >= edge)
        })
    };
    let is_between = |pixel: usize, [dx, dy]: [isize; 2]| {
        let at = [pixel % width, pixel / width];
        let ends = steps(at, [dx, dy]).zip(steps(at, [-dx, -dy]));
        ends.is_some_and(|(before, after)| before + after <= widest as isize + 1)
    };
    let is_straight = |pixel: usize| [[1, 0], [0, 1]].into_iter().any(|step| is_between(pixel, step));
    let is_diagonal = |pixel: usize| [[1, 1], [1, -1]].into_iter().any(|step| is_between(pixel, step));
    let found = |pixel: usize| -> Vec<usize> {
        if alpha[pixel] >= edge {
            Vec::new()
        } else if is_straight(pixel) {
            around(width, height, pixel).filter(|near| alpha[*near] < edge).collect()
        } else if is_diagonal(pixel) {
            vec![pixel]
        } else {
            Vec::new()
        }
    };
    (0..alpha.len()).into_par_iter().flat_map_iter(found).collect()
}
