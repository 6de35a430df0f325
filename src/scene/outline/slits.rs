//! The narrow gaps of a picture, which a dilation would close.
//!
//! In: alpha of pixels. Out: the pixels in gaps up to a width.

use rayon::prelude::*;

/// Returns the pixels below a threshold that lie in a gap: along a row, a column or a diagonal they are among at most `widest` such pixels
/// between two others. `alpha`: #pixels, rows of `width`.
pub(super) fn slits(alpha: &[f32], width: usize, edge: f32, widest: usize) -> Vec<usize> {
    let height = alpha.len() / width.max(1);
    // Returns the number of steps to the first covered pixel.
    let steps = |[x, y]: [usize; 2], [dx, dy]: [isize; 2]| {
        (1..=widest as isize).find(|step| {
            let place = x.checked_add_signed(step * dx).zip(y.checked_add_signed(step * dy));
            place.is_some_and(|(x, y)| x < width && y < height && alpha[y * width + x] >= edge)
        })
    };
    let is_slit = |pixel: &usize| {
        let at = [pixel % width, pixel / width];
        let is_between = |[dx, dy]: [isize; 2]| {
            steps(at, [dx, dy])
                .zip(steps(at, [-dx, -dy]))
                .is_some_and(|(before, after)| before + after <= widest as isize + 1)
        };
        alpha[*pixel] < edge && [[1, 0], [0, 1], [1, 1], [1, -1]].into_iter().any(is_between)
    };
    (0..alpha.len()).into_par_iter().filter(is_slit).collect()
}
