//! Finds regions in which the samples of all planes are bit-identical, which make up most of an id picture.
//!
//! In: planes over one window. Out: for rectangles of samples, whether one represents all.

use crate::space::PixelRect;
use rayon::prelude::*;

/// A flag per sample: whether it equals its neighbours to the right, below, and diagonally below right.
pub(super) struct UniformRegions {
    width: usize,
    height: usize,
    /// #samples; false in the last column and row.
    flags: Vec<bool>,
}

impl UniformRegions {
    /// Compares planes with `window.area()` samples each.
    pub(super) fn of(window: PixelRect, planes: &[&[f32]]) -> Self {
        let (width, height) = (window.width as usize, window.height as usize);
        let mut flags = vec![false; width * height];
        let rows = flags.par_chunks_mut(width.max(1)).take(height.saturating_sub(1)).enumerate();
        rows.for_each(|(row, flags)| {
            flags[..width - 1].fill(true);
            for plane in planes {
                let (upper, lower) = plane[row * width..(row + 2) * width].split_at(width);
                compare(upper, lower, &mut flags[..width - 1]);
            }
        });
        Self { width, height, flags }
    }

    /// Returns the index of a sample that equals all from the first to the last (column and row, inclusive); `None` if
    /// they differ or lie outside the window.
    pub(super) fn representative(&self, [first, last]: [[i32; 2]; 2]) -> Option<usize> {
        let is_within = first[0] >= 0 && first[1] >= 0 && last[0] < self.width as i32 && last[1] < self.height as i32;
        if !is_within {
            return None;
        }
        // A rectangle one sample wide also compares the next column: it may miss a match, but never reports a false one.
        let [columns, rows] =
            [0, 1].map(|axis| first[axis] as usize..(last[axis] as usize).max(first[axis] as usize + 1));
        let is_uniform =
            rows.clone().all(|row| self.flags[row * self.width..][columns.clone()].iter().all(|flag| *flag));
        is_uniform.then_some(rows.start * self.width + columns.start)
    }
}

fn compare(upper: &[f32], lower: &[f32], flags: &mut [bool]) {
    let pairs = upper.windows(2).zip(lower.windows(2));
    for (flag, (upper, lower)) in flags.iter_mut().zip(pairs) {
        let [a, b, c, d] = [upper[0], upper[1], lower[0], lower[1]].map(f32::to_bits);
        *flag &= ((a ^ b) | (a ^ c) | (a ^ d)) == 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_are_uniform_where_no_sample_differs() {
        let window = PixelRect { x: -3, y: 7, width: 5, height: 4 };
        let (mut ids, shares) = (vec![0.25; 20], vec![1.0; 20]);
        ids[2 * 5 + 3] = -0.25;
        let uniform = UniformRegions::of(window, &[&shares, &ids]);
        assert_eq!(uniform.representative([[0, 0], [2, 2]]), Some(0));
        assert_eq!(uniform.representative([[1, 1], [1, 2]]), Some(6));
        for other in [[[2, 1], [3, 2]], [[0, 0], [4, 3]], [[-1, 0], [1, 1]], [[0, 3], [1, 4]]] {
            assert_eq!(uniform.representative(other), None, "{other:?}");
        }
    }
}
