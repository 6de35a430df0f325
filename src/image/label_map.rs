//! A number for every pixel of a picture: the part of a drawing that it belongs to.
//!
//! In: labels of some pixels. Out: [`LabelMap`], whose pixels without a label take the nearest one.

use std::collections::VecDeque;

/// The label of pixels that belong to nothing.
pub(crate) const NO_LABEL: u32 = 0;

/// The label of the part that a mask, ids or points choose.
pub(crate) const CHOSEN: u32 = 1;

/// The label of everything else where there is a choice.
pub(crate) const OTHER: u32 = 2;

/// Labels over the unit square.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LabelMap {
    /// Width and height in pixels; not 0.
    pub(crate) size: [u32; 2],
    /// #pixels, rows from the top.
    pub(crate) labels: Vec<u32>,
}

impl LabelMap {
    /// Returns the label of the pixel at a position of the unit square, x right, y down from the upper left corner; that of the nearest
    /// pixel beyond it.
    #[must_use]
    pub(crate) fn at(&self, [u, v]: [f64; 2]) -> u32 {
        let along = |t: f64, count: u32| ((t * f64::from(count)).max(0.0) as usize).min(count as usize - 1);
        let [width, height] = self.size;
        self.labels[along(v, height) * width as usize + along(u, width)]
    }

    /// Gives pixels without a label that of the pixel from which the fewest steps lead to them; steps go to the four neighbours, through
    /// pixels of which `is_open` (#pixels) says so.
    pub(crate) fn spread(&mut self, is_open: impl Fn(usize) -> bool) {
        let mut rim: VecDeque<usize> = (0..self.labels.len()).filter(|&pixel| self.labels[pixel] != NO_LABEL).collect();
        while let Some(pixel) = rim.pop_front() {
            for next in neighbours(self.size, pixel).into_iter().flatten() {
                if self.labels[next] == NO_LABEL && is_open(next) {
                    self.labels[next] = self.labels[pixel];
                    rim.push_back(next);
                }
            }
        }
    }
}

/// Returns the pixels left, right, above and below a pixel, where the picture has them.
pub(crate) fn neighbours([width, height]: [u32; 2], pixel: usize) -> [Option<usize>; 4] {
    let (width, height) = (width as usize, height as usize);
    let (x, y) = (pixel % width, pixel / width);
    [
        (x > 0).then(|| pixel - 1),
        (x + 1 < width).then(|| pixel + 1),
        (y > 0).then(|| pixel - width),
        (y + 1 < height).then(|| pixel + width),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_spread_to_what_is_nearest_and_stop_at_what_is_closed() {
        let mut map = LabelMap { size: [7, 1], labels: vec![1, 0, 0, 0, 0, 0, 2] };
        map.spread(|pixel| pixel != 2);
        assert_eq!(map.labels, [1, 1, 0, 2, 2, 2, 2]);
        map.spread(|_| true);
        assert_eq!(map.labels, [1, 1, 1, 2, 2, 2, 2]);
    }

    #[test]
    fn positions_beyond_the_picture_have_the_label_of_its_border() {
        let map = LabelMap { size: [2, 2], labels: vec![1, 2, 3, 4] };
        assert_eq!([[0.4, 0.4], [0.6, 0.4], [0.4, 0.6], [1.0, 1.0]].map(|at| map.at(at)), [1, 2, 3, 4]);
        assert_eq!([[-1.0, 0.0], [2.0, 0.0], [f64::NAN, 7.0]].map(|at| map.at(at)), [1, 2, 3]);
    }
}
