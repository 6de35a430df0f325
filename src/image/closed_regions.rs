//! The regions of a drawing that its lines close, as the paint bucket of a paint program finds them.
//!
//! In: the samples of a drawing. Out: [`ClosedRegions`]; the parts of a drawing that is divided by them. Gaps are closed by the trapped-ball method: a region is where a disc as wide as
//! the greatest gap can go without touching a line. S.-H. Zhang, T. Chen, Y.-F. Zhang, S.-M. Hu and R. R. Martin, "Vectorizing Cartoon
//! Animations", IEEE TVCG 15 (2009), 618–629, doi.org/10.1109/TVCG.2009.9, section 3.1.

use super::LabelMap;
use super::ink::Ink;
use super::label_map::{NO_LABEL, neighbours};
use super::line_owners::Lines;
use super::squared_distance::squared_distances;
use super::srgb::srgb_byte;
use crate::space::PixelRect;
use crate::space::with_neighbours;
use rayon::prelude::*;

/// Number of cells along the longer side of a drawing; larger drawings are read in cells of several pixels.
const MOST_CELLS: u32 = 2048;

/// A drawing as it is seen on white paper, in cells of one or more pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Drawing {
    /// Cells across and down; not 0.
    size: [u32; 2],
    /// #cells, rows from the top: least and greatest code of red, green, blue and alpha among the pixels of the cell.
    cells: Vec<[[u8; 4]; 2]>,
}

/// What counts as a line, and as a gap in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LineRule {
    /// Contrast with what lies beside it, 0 to 1.
    pub(crate) threshold: f64,
    /// Greatest gap that is closed, heights of the drawing.
    pub(crate) gap: f64,
    /// Greatest width of a line, heights of the drawing.
    pub(crate) line: f64,
}

/// The closed regions of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ClosedRegions {
    /// The region of every cell, without lines and without the surroundings of the drawing.
    pub(crate) inside: LabelMap,
    /// Number of cells of the regions, whose labels are 1, 2, ...
    pub(crate) areas: Vec<usize>,
    ink: Ink,
    /// #cells.
    light: Vec<u8>,
    /// Contrast of a line, 0 to 255.
    contrast: u8,
    /// Greatest width of a line, cells.
    widest: f32,
}

impl Drawing {
    /// Reads the display window of premultiplied red, green, blue and alpha over a window of pixels (#pixels each, relative to the
    /// display window); `None` if it is empty.
    pub(crate) fn of(planes: [&[f32]; 4], window: PixelRect, [width, height]: [u32; 2]) -> Option<Self> {
        let side = width.max(height).div_ceil(MOST_CELLS).max(1);
        let size = [width, height].map(|count| count.div_ceil(side));
        if width == 0 || height == 0 {
            return None;
        }
        let code = |x: i64, y: i64| {
            let (column, row) = (x - i64::from(window.x), y - i64::from(window.y));
            let is_inside =
                (0..i64::from(window.width)).contains(&column) && (0..i64::from(window.height)).contains(&row);
            if !is_inside {
                return [255, 255, 255, 0];
            }
            let pixel = (row * i64::from(window.width) + column) as usize;
            code_on_paper(planes.map(|plane| plane[pixel]))
        };
        let cell = |number: usize| {
            let (column, row) = (number as u32 % size[0], number as u32 / size[0]);
            let range = |at: u32, count: u32| i64::from(at * side)..i64::from((at * side + side).min(count));
            let pixels = range(row, height).flat_map(|y| range(column, width).map(move |x| (x, y)));
            pixels.fold([[255; 4], [0; 4]], |[low, high], (x, y)| {
                let code = code(x, y);
                [0, 1].map(|end| {
                    std::array::from_fn(|k| if end == 0 { code[k].min(low[k]) } else { code[k].max(high[k]) })
                })
            })
        };
        let count = size[0] as usize * size[1] as usize;
        Some(Self { size, cells: (0..count).into_par_iter().map(cell).collect() })
    }

    /// Returns the regions that lines close.
    pub(crate) fn regions(&self, rule: LineRule) -> ClosedRegions {
        let light = self.light();
        let contrast = (rule.threshold * 255.0) as u8;
        let widest = rule.line * f64::from(self.size[1]);
        let ink = Ink::find(&light, self.size[0] as usize, contrast, widest);
        let mut is_line = self.lines(rule.threshold);
        is_line.iter_mut().zip(&ink.is_ink).for_each(|(is_line, is_ink)| *is_line |= is_ink);
        let radius = 0.5 * rule.gap * f64::from(self.size[1]);
        let distances = squared_distances(&is_line, self.size[0] as usize);
        let is_core = |cell: usize| !is_line[cell] && f64::from(distances[cell]) > radius * radius;
        let (labels, kinds) = self.components(is_core);
        let mut inside = LabelMap { size: self.size, labels };
        inside.spread(|cell| !is_line[cell]);
        // A painted drawing is divided where it is painted; drawings of lines alone also where they are transparent.
        let is_painted = kinds.contains(&Kind::Painted);
        let wanted = if is_painted { Kind::Painted } else { Kind::Hole };
        let mut count = 0;
        let numbers: Vec<u32> = kinds
            .iter()
            .map(|kind| {
                count += usize::from(*kind == wanted);
                if *kind == wanted { count as u32 } else { NO_LABEL }
            })
            .collect();
        for label in inside.labels.iter_mut().filter(|label| **label != NO_LABEL) {
            *label = numbers[*label as usize - 1];
        }
        let mut areas = vec![0; count];
        inside.labels.iter().filter(|label| **label != NO_LABEL).for_each(|label| areas[*label as usize - 1] += 1);
        ClosedRegions { inside, areas, ink, light, contrast, widest: widest as f32 }
    }

    /// Returns the luma of every cell; that of its darkest pixel if it has several.
    fn light(&self) -> Vec<u8> {
        let luma = |[[r, g, b, _], _]: &[[u8; 4]; 2]| {
            ((54 * u32::from(*r) + 183 * u32::from(*g) + 19 * u32::from(*b)) / 256) as u8
        };
        self.cells.par_iter().map(luma).collect()
    }

    /// Returns the cells whose neighbourhood of 3 x 3 cells has more contrast than the threshold in some channel.
    fn lines(&self, threshold: f64) -> Vec<bool> {
        let (width, height) = (self.size[0] as usize, self.size[1] as usize);
        let limit = threshold * 255.0;
        let is_line = |cell: usize| {
            let (x, y) = (cell % width, cell / width);
            let (mut low, mut high) = ([255_u8; 4], [0_u8; 4]);
            for [least, greatest] in
                with_neighbours(y, height).flat_map(|y| &self.cells[y * width..][with_neighbours(x, width)])
            {
                low = std::array::from_fn(|k| low[k].min(least[k]));
                high = std::array::from_fn(|k| high[k].max(greatest[k]));
            }
            (0..4).any(|k| f64::from(high[k] - low[k]) > limit)
        };
        (0..self.cells.len()).into_par_iter().map(is_line).collect()
    }

    /// Labels the connected components of some cells 1, 2, ...; also returns their kinds.
    fn components(&self, is_in: impl Fn(usize) -> bool) -> (Vec<u32>, Vec<Kind>) {
        let mut labels = vec![NO_LABEL; self.cells.len()];
        let mut kinds = Vec::new();
        let mut open = Vec::new();
        for seed in 0..self.cells.len() {
            if labels[seed] != NO_LABEL || !is_in(seed) {
                continue;
            }
            let label = kinds.len() as u32 + 1;
            labels[seed] = label;
            open.push(seed);
            let (mut count, mut opaque, mut is_at_border) = (0_usize, 0_usize, false);
            while let Some(cell) = open.pop() {
                count += 1;
                opaque += usize::from(self.cells[cell][1][3] >= 128);
                let around = neighbours(self.size, cell);
                is_at_border |= around.contains(&None);
                for next in around.into_iter().flatten() {
                    if labels[next] == NO_LABEL && is_in(next) {
                        labels[next] = label;
                        open.push(next);
                    }
                }
            }
            kinds.push(match (2 * opaque >= count, is_at_border) {
                (true, _) => Kind::Painted,
                (false, true) => Kind::Surroundings,
                (false, false) => Kind::Hole,
            });
        }
        (labels, kinds)
    }
}

impl ClosedRegions {
    /// Returns the region of every cell. A line belongs in its whole width to one of the regions that it bounds: to the smallest of `first`,
    /// else to the smallest. What else is no region has the nearest.
    pub(crate) fn map(&self, first: &[u32]) -> LabelMap {
        let mut order: Vec<u32> = (1..=self.areas.len() as u32).collect();
        order.sort_by_key(|label| (!first.contains(label), self.areas[*label as usize - 1], *label));
        let lines = Lines { ink: &self.ink, light: &self.light, contrast: self.contrast / 2, widest: self.widest };
        let mut map = self.inside.clone();
        map.spread(|cell| !self.ink.is_ink[cell]);
        lines.complete_corners(&mut map);
        lines.give(&mut map, &order);
        map.spread(|_| true);
        map
    }

    /// Whether there is ink in a cell.
    pub(crate) fn is_ink(&self, cell: usize) -> bool {
        self.ink.is_ink[cell]
    }
}

/// What a connected area without lines is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Opaque.
    Painted,
    /// Transparent, with lines all around.
    Hole,
    /// Transparent, up to the border of the picture.
    Surroundings,
}

/// Returns the codes of a premultiplied colour over white, and that of its alpha.
fn code_on_paper([r, g, b, a]: [f32; 4]) -> [u8; 4] {
    let alpha = if a.is_finite() { a.clamp(0.0, 1.0) } else { 0.0 };
    let code = |light: f32| {
        let own = if alpha > 0.0 { f32::from(srgb_byte(light / alpha)) } else { 255.0 };
        (alpha * own + (1.0 - alpha) * 255.0).round() as u8
    };
    [code(r), code(g), code(b), (alpha * 255.0).round() as u8]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: u32 = 80;

    /// The regions of a drawing: ink where `ink` says so, on paper of this alpha.
    fn regions(paper: f32, gap: f64, ink: impl Fn(i32, i32) -> bool) -> ClosedRegions {
        let pixels = (0..SIDE * SIDE).map(|k| ink((k % SIDE) as i32, (k / SIDE) as i32));
        let (light, alpha): (Vec<f32>, Vec<f32>) =
            pixels.map(|is_ink| if is_ink { (0.0, 1.0) } else { (paper, paper) }).unzip();
        let window = PixelRect { x: 0, y: 0, width: SIDE, height: SIDE };
        let drawing = Drawing::of([&light, &light, &light, &alpha], window, [SIDE; 2]).expect("not empty");
        drawing.regions(LineRule { threshold: 0.25, gap, line: 0.025 })
    }

    /// A box from 10 to 70, divided at 40 by a line with a gap of this size.
    fn boxes(gap: i32) -> impl Fn(i32, i32) -> bool {
        move |x, y| {
            let is_within = |t: i32| (10..70).contains(&t);
            let is_rim = |t: i32| t == 10 || t == 69;
            let is_frame = is_within(x) && is_within(y) && (is_rim(x) || is_rim(y));
            is_frame || x == 40 && is_within(y) && !(30..30 + gap).contains(&y)
        }
    }

    fn label(regions: &ClosedRegions, x: u32, y: u32) -> u32 {
        regions.inside.labels[(y * SIDE + x) as usize]
    }

    #[test]
    fn lines_on_paper_close_regions_and_belong_to_the_nearest() {
        let found = regions(1.0, 0.0, boxes(0));
        assert_eq!(found.areas.len(), 3, "paper, left, right");
        let [paper, left, right, line] = [(3, 3), (25, 40), (55, 40), (40, 40)].map(|(x, y)| label(&found, x, y));
        assert!(paper != left && left != right && right != paper && line == NO_LABEL);
        assert!(found.map(&[]).labels.iter().all(|&label| label != NO_LABEL));
        assert_eq!(found.map(&[]).labels[40 * SIDE as usize + 38], left);
    }

    #[test]
    fn gaps_are_closed_up_to_their_greatest_size() {
        let count = |gap: f64| regions(1.0, gap, boxes(9)).areas.len();
        assert_eq!([0.0, 0.05, 0.15, 0.2].map(count), [2, 2, 3, 3]);
    }

    #[test]
    fn of_lines_without_paper_only_what_they_close_is_a_region() {
        let found = regions(0.0, 0.0, boxes(0));
        assert_eq!((found.areas.len(), label(&found, 3, 3)), (2, NO_LABEL));
        assert!(label(&found, 25, 40) != label(&found, 55, 40));
        assert!(
            found.map(&[]).labels.iter().all(|&label| label != NO_LABEL),
            "the outer half of a line belongs to the region within"
        );
    }

    /// Disc in a line of this width, with a black dot of some radius on the line.
    fn disc(wide: f64, dot: f64) -> ClosedRegions {
        let place = |k: u32| (f64::from(k % SIDE) - 39.5, f64::from(k / SIDE) - 39.5);
        let is_ink = |(x, y): (f64, f64)| (x.hypot(y) - 20.0).abs() < 0.5 * wide || (x - 20.0).hypot(y) < dot;
        let light: Vec<f32> = (0..SIDE * SIDE).map(|k| if is_ink(place(k)) { 0.0 } else { 1.0 }).collect();
        let window = PixelRect { x: 0, y: 0, width: SIDE, height: SIDE };
        let drawing =
            Drawing::of([&light, &light, &light, &vec![1.0; light.len()]], window, [SIDE; 2]).expect("not empty");
        drawing.regions(LineRule { threshold: 0.25, gap: 0.02, line: 0.12 })
    }

    #[test]
    fn a_line_belongs_as_a_whole_to_one_of_the_regions_that_it_bounds() {
        for wide in [1.5, 3.0, 4.0, 5.0, 6.0, 8.0] {
            let found = disc(wide, 0.0);
            assert_eq!(found.areas.len(), 2, "{wide}: paper and disc");
            let [paper, within] = [(2, 2), (40, 40)].map(|(x, y)| label(&found, x, y));
            // The smaller one, or the one that comes first.
            for (first, owner) in [(vec![], within), (vec![within], within), (vec![paper], paper)] {
                let map = found.map(&first);
                let wrong =
                    (0..map.labels.len()).filter(|&cell| found.is_ink(cell) && map.labels[cell] != owner).count();
                assert_eq!(wrong, 0, "{wide} {first:?}");
            }
        }
    }

    #[test]
    fn lines_that_meet_or_cross_an_outline_end_at_its_outer_edge() {
        // A bar with an outline, turned, over two lines: one crosses it, the other ends at it.
        let place = |k: u32| (f64::from(k % SIDE) - 39.5, f64::from(k / SIDE) - 39.5);
        for (turn, wide) in [0.0, 0.35, 0.785, 1.2].into_iter().flat_map(|turn| [3.0, 5.0].map(|wide| (turn, wide))) {
            let (sin, cos) = f64::sin_cos(turn);
            let box_distance = move |(x, y): (f64, f64)| {
                let (u, v) = ((cos * x + sin * y).abs() - 24.0, (cos * y - sin * x).abs() - 9.0);
                u.max(v).min(0.0) + u.max(0.0).hypot(v.max(0.0))
            };
            let is_ink = |at: (f64, f64)| {
                let line = |off: f64| (at.0 - off).abs() < 0.5 * wide;
                // Inside the outline is paper, and the outline has pointed corners.
                let (u, v) = ((cos * at.0 + sin * at.1).abs(), (cos * at.1 - sin * at.0).abs());
                let is_outline = u < 24.0 + wide && v < 9.0 + wide && box_distance(at) > 0.0;
                is_outline || box_distance(at) > 0.0 && (line(2.0) || line(-14.0) && at.1 < 0.0)
            };
            let light: Vec<f32> = (0..SIDE * SIDE).map(|k| if is_ink(place(k)) { 0.0 } else { 1.0 }).collect();
            let window = PixelRect { x: 0, y: 0, width: SIDE, height: SIDE };
            let drawing =
                Drawing::of([&light, &light, &light, &vec![1.0; light.len()]], window, [SIDE; 2]).expect("not empty");
            let found = drawing.regions(LineRule { threshold: 0.25, gap: 0.02, line: 0.12 });
            let bar = label(&found, 40, 40);
            let map = found.map(&[bar]);
            for (k, &owner) in map.labels.iter().enumerate() {
                let at = place(k as u32);
                let (u, v) = ((cos * at.0 + sin * at.1).abs() - 24.0, (cos * at.1 - sin * at.0).abs() - 9.0);
                let off = u.max(v);
                // The steps of cells make an outline up to a cell wider or narrower.
                let is_right = if off < wide - 1.0 { owner == bar } else { owner != bar || off < wide + 1.5 };
                assert!(is_right, "{turn}, {wide}: {at:?} is {off:.1} from the bar, of region {owner}, not {bar}");
            }
        }
    }

    #[test]
    fn a_dot_on_a_line_is_a_region_and_takes_no_more_of_the_line_than_is_beside_it() {
        let found = disc(4.0, 8.0);
        assert_eq!(found.areas.len(), 3);
        let [within, dot] = [(40, 40), (60, 40)].map(|(x, y)| label(&found, x, y));
        let map = found.map(&[within]);
        for cell in (0..map.labels.len()).filter(|&cell| found.is_ink(cell)) {
            let (x, y) = ((cell as u32 % SIDE) as f32 - 39.5, (cell as u32 / SIDE) as f32 - 39.5);
            let owner = map.labels[cell];
            assert!(owner == within || owner == dot && (x - 20.0).hypot(y) < 13.0, "{x} {y}");
        }
    }

    #[test]
    fn dark_areas_without_lines_are_regions_too() {
        let found = regions(1.0, 0.0, |x, y| x > 30 && y > 30);
        assert_eq!(found.areas.len(), 2);
        assert!(label(&found, 60, 60) != label(&found, 10, 10));
    }

    #[test]
    fn large_drawings_are_read_in_cells() {
        let (width, height) = (5000_u32, 100_u32);
        // A line one pixel wide, every 1000 pixels.
        let light: Vec<f32> = (0..width * height).map(|k| f32::from(u8::from(k % width % 1000 != 500))).collect();
        let alpha = vec![1.0; light.len()];
        let window = PixelRect { x: 0, y: 0, width, height };
        let drawing = Drawing::of([&light, &light, &light, &alpha], window, [width, height]).expect("not empty");
        assert_eq!(drawing.size, [1667, 34]);
        assert_eq!(drawing.regions(LineRule { threshold: 0.25, gap: 0.01, line: 0.025 }).areas.len(), 6);
    }
}
