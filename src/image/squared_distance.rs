//! The distance of every pixel from the nearest of some pixels.
//!
//! In: a picture of booleans. Out: squared distances in pixels. P. F. Felzenszwalb and D. P. Huttenlocher, "Distance Transforms of Sampled
//! Functions", Theory of Computing 8 (2012), 415–428, doi.org/10.4086/toc.2012.v008a019.

/// Returns the squared distances from the nearest pixel of `is_there` (#pixels, rows of `width`); infinite if there is none.
pub(super) fn squared_distances(is_there: &[bool], width: usize) -> Vec<f32> {
    let mut field: Vec<f32> = is_there.iter().map(|is_there| if *is_there { 0.0 } else { f32::INFINITY }).collect();
    let height = field.len() / width.max(1);
    let mut line = Line::default();
    for x in 0..width {
        line.transform(&mut field, (x, width, height));
    }
    for y in 0..height {
        line.transform(&mut field, (y * width, 1, width));
    }
    field
}

/// The lower envelope of parabolas over a line of pixels.
#[derive(Default)]
struct Line {
    values: Vec<f32>,
    /// Pixels at which the parabolas of the envelope have their lowest point.
    lowest: Vec<usize>,
    /// Where each of them begins to be the lowest.
    begin: Vec<f64>,
}

impl Line {
    /// Replaces the values at first, first + step, .. by the lowest parabola over each.
    fn transform(&mut self, field: &mut [f32], (first, step, count): (usize, usize, usize)) {
        self.values.clear();
        self.values.extend((0..count).map(|k| field[first + k * step]));
        self.lowest.clear();
        self.begin.clear();
        for q in (0..count).filter(|&q| self.values[q].is_finite()) {
            let mut begin = f64::NEG_INFINITY;
            while let (Some(&p), Some(&from)) = (self.lowest.last(), self.begin.last()) {
                begin = self.meet(p, q);
                if begin > from {
                    break;
                }
                self.lowest.pop();
                self.begin.pop();
                begin = f64::NEG_INFINITY;
            }
            self.lowest.push(q);
            self.begin.push(begin);
        }
        let mut k = 0;
        for x in (0..count).filter(|_| !self.lowest.is_empty()) {
            while self.begin.get(k + 1).is_some_and(|begin| *begin < x as f64) {
                k += 1;
            }
            let p = self.lowest[k];
            field[first + x * step] = self.values[p] + (x.abs_diff(p) as f32).powi(2);
        }
    }

    /// Where the parabolas of two pixels, p < q, meet.
    fn meet(&self, p: usize, q: usize) -> f64 {
        let [height_p, height_q] = [p, q].map(|k| f64::from(self.values[k]) + (k as f64).powi(2));
        (height_q - height_p) / (2.0 * (q as f64 - p as f64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_a_search() {
        let (width, height) = (13, 9);
        let mut state = 7_u32;
        for share in [2, 9, 40] {
            let is_there: Vec<bool> = (0..width * height)
                .map(|_| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (state >> 16).is_multiple_of(share)
                })
                .collect();
            let found = squared_distances(&is_there, width);
            for (pixel, found) in found.into_iter().enumerate() {
                let square = |other: usize| {
                    let apart = |a: usize, b: usize| a.abs_diff(b).pow(2);
                    (apart(pixel % width, other % width) + apart(pixel / width, other / width)) as f32
                };
                let wanted =
                    (0..is_there.len()).filter(|&other| is_there[other]).map(square).fold(f32::INFINITY, f32::min);
                assert_eq!(found, wanted, "pixel {pixel}");
            }
        }
        assert!(squared_distances(&[false; 6], 3).iter().all(|square| square.is_infinite()));
    }
}
