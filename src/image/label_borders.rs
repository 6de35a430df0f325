//! Traces the borders between the labels of a picture.
//!
//! In: a [`LabelMap`]. Out: polylines through the middles of the sides that pixels of different labels share.

use super::LabelMap;

/// Directions of the sides that meet at a corner of pixels.
const DIRECTIONS: [[i64; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

impl LabelMap {
    /// Returns the borders between different labels as polylines over the unit square, y down. They end at the rim of the picture and where
    /// more than two of them meet; closed borders end at their first point.
    #[must_use]
    pub(crate) fn borders(&self) -> Vec<Vec<[f64; 2]>> {
        let mut sides = Sides::of(self);
        let corners: Vec<usize> = (0..sides.open.len()).filter(|&corner| sides.open[corner] != 0).collect();
        let degrees = sides.degrees(&corners);
        let is_end = |corner: usize| degrees[corner] != 2;
        let mut borders = Vec::new();
        // Borders between ends first, so that only closed ones are left for the second pass.
        for is_closed in [false, true] {
            for &corner in corners.iter().filter(|&&corner| is_closed || is_end(corner)) {
                while let Some(direction) = sides.first_open(corner) {
                    borders.push(sides.trace((corner, direction), &is_end));
                }
            }
        }
        let [width, height] = self.size.map(f64::from);
        borders.iter_mut().flatten().for_each(|point| *point = [point[0] / width, point[1] / height]);
        borders
    }
}

/// The sides between pixels of different labels that are still to be traced.
struct Sides {
    /// Corners in a row of the grid.
    columns: usize,
    /// #corners, rows from the top: a bit for every one of [`DIRECTIONS`] in which a side leads to the next corner.
    open: Vec<u8>,
}

impl Sides {
    fn of(map: &LabelMap) -> Self {
        let [width, height] = map.size.map(|side| side as usize);
        let columns = width + 1;
        let mut sides = Self { columns, open: vec![0; columns * (height + 1)] };
        for (y, row) in map.labels.chunks_exact(width).enumerate() {
            for x in (1..width).filter(|&x| row[x - 1] != row[x]) {
                sides.set([y * columns + x, (y + 1) * columns + x], 1);
            }
            let below = map.labels[(y + 1) * width..].iter().take(width);
            for (x, _) in below.enumerate().filter(|&(x, &label)| label != row[x]) {
                sides.set([(y + 1) * columns + x, (y + 1) * columns + x + 1], 0);
            }
        }
        sides
    }

    fn set(&mut self, [from, to]: [usize; 2], direction: usize) {
        self.open[from] |= 1 << direction;
        self.open[to] |= 1 << ((direction + 2) % 4);
    }

    /// #corners: number of sides that meet there. `used`: the corners with sides.
    fn degrees(&self, used: &[usize]) -> Vec<u8> {
        let mut degrees = vec![0; self.open.len()];
        used.iter().for_each(|&corner| degrees[corner] = self.open[corner].count_ones() as u8);
        degrees
    }

    fn first_open(&self, corner: usize) -> Option<usize> {
        (0..4).find(|direction| self.open[corner] >> direction & 1 == 1)
    }

    /// Follows a border to its end, or around to its start, and removes its sides. Returns its points in pixels.
    fn trace(&mut self, (start, direction): (usize, usize), is_end: &impl Fn(usize) -> bool) -> Vec<[f64; 2]> {
        let mut points = vec![self.place(start)];
        let (mut corner, mut next) = (start, Some(direction));
        while let Some(direction) = next {
            let [dx, dy] = DIRECTIONS[direction];
            let to = (corner as i64 + dy * self.columns as i64 + dx) as usize;
            self.open[corner] &= !(1 << direction);
            self.open[to] &= !(1 << ((direction + 2) % 4));
            let [a, b] = [corner, to].map(|corner| self.place(corner));
            points.push([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]);
            corner = to;
            next = if is_end(corner) { None } else { self.first_open(corner) };
        }
        if corner == start && !is_end(start) {
            // The corner at which a closed border was found is no point of interest.
            points[0] = points[points.len() - 1];
        } else {
            points.push(self.place(corner));
        }
        points
    }

    fn place(&self, corner: usize) -> [f64; 2] {
        [(corner % self.columns) as f64, (corner / self.columns) as f64]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn borders(size: [u32; 2], labels: &[u32]) -> Vec<Vec<[f64; 2]>> {
        let mut borders = LabelMap { size, labels: labels.to_vec() }.borders();
        let [width, height] = size.map(f64::from);
        borders.iter_mut().flatten().for_each(|point| *point = [point[0] * width, point[1] * height]);
        borders
    }

    #[test]
    fn a_border_runs_from_rim_to_rim_and_an_island_has_a_closed_one() {
        assert_eq!(borders([2, 1], &[1, 2]), [[[1.0, 0.0], [1.0, 0.5], [1.0, 1.0]]]);
        assert!(borders([2, 2], &[7; 4]).is_empty());
        let island = borders([4, 4], &[1, 1, 1, 1, 1, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]);
        assert_eq!(island.len(), 1);
        assert_eq!((island[0].len(), island[0].first()), (5, island[0].last()));
        assert!(island[0].contains(&[1.5, 1.0]) && island[0].contains(&[1.5, 2.0]));
    }

    #[test]
    fn borders_end_where_three_labels_meet() {
        let found = borders([2, 2], &[1, 1, 2, 3]);
        assert_eq!(found.len(), 3);
        assert!(found.iter().all(|border| [border[0], border[border.len() - 1]].contains(&[1.0, 1.0])));
    }
}
