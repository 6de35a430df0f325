//! A block of a map, from its corners alone.
//!
//! In: offsets and slopes at four pixels. Out: offsets of all pixels between them. The sides are cubic Hermite curves,
//! the inside is blended between them (S. A. Coons, "Surfaces for Computer-Aided Design of Space Forms", 1967): the
//! error falls with the fourth power of the block's size.

use super::map_view::Node;
use glam::DVec2;

/// Pixels of the largest block.
pub(super) const LARGEST: usize = 32;
/// Floats of a register.
const LANES: usize = 8;

/// Four sides of a block: cubic polynomials of 0 to 1, c0 + c1 t + c2 t² + c3 t³.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    top: [DVec2; 4],
    bottom: [DVec2; 4],
    left: [DVec2; 4],
    right: [DVec2; 4],
}

impl Patch {
    /// Corners: upper left, upper right, lower left, lower right, `size` pixels apart.
    pub(super) fn new(corners: &[Node; 4], size: f64) -> Self {
        let [a, b, c, d] = corners;
        let along = |from: &Node, to: &Node| hermite(from.offset, to.offset, [from, to].map(|n| n.slope.x_axis * size));
        let down = |from: &Node, to: &Node| hermite(from.offset, to.offset, [from, to].map(|n| n.slope.y_axis * size));
        Self { top: along(a, b), bottom: along(c, d), left: down(a, c), right: down(b, d) }
    }

    /// The cubic of a row: `v` 0 is the upper side, 1 the lower.
    fn row(&self, v: f64) -> [DVec2; 4] {
        let mut row: [DVec2; 4] = std::array::from_fn(|k| self.top[k].lerp(self.bottom[k], v));
        // What the curved sides add to the straight ones.
        let left = value(&self.left, v) - row[0];
        let right = value(&self.right, v) - row.iter().sum::<DVec2>();
        row[0] += left;
        row[1] += right - left;
        row
    }

    /// The offset at a place of the block, 0 to 1 an axis.
    pub(super) fn at(&self, u: f64, v: f64) -> DVec2 {
        value(&self.row(v), u)
    }

    /// Offsets of the pixels of row `y` of a block of `size`: the first of `row` is the block's first.
    #[inline(always)]
    pub(super) fn fill(&self, size: usize, y: usize, row: &mut [[f32; 2]]) {
        let scale = 1.0 / size as f64;
        let mut power = 1.0;
        let cubic = self.row(y as f64 * scale).map(|c| {
            let c = c * power;
            power *= scale;
            std::array::from_fn::<f32, LANES, _>(|lane| c[lane % 2] as f32)
        });
        let mut place: [f32; LANES] = std::array::from_fn(|lane| (lane / 2) as f32);
        let mut chunks = row.as_flattened_mut().chunks_exact_mut(LANES);
        for chunk in &mut chunks {
            for lane in 0..LANES {
                let [c0, c1, c2, c3] = [0, 1, 2, 3].map(|k| cubic[k][lane]);
                chunk[lane] = ((c3 * place[lane] + c2) * place[lane] + c1) * place[lane] + c0;
                place[lane] += (LANES / 2) as f32;
            }
        }
        for (lane, slot) in chunks.into_remainder().iter_mut().enumerate() {
            let [c0, c1, c2, c3] = [0, 1, 2, 3].map(|k| cubic[k][lane]);
            *slot = ((c3 * place[lane] + c2) * place[lane] + c1) * place[lane] + c0;
        }
    }
}

/// The cubic between two values with slopes.
fn hermite(from: DVec2, to: DVec2, slopes: [DVec2; 2]) -> [DVec2; 4] {
    let rise = to - from;
    [from, slopes[0], rise * 3.0 - slopes[0] * 2.0 - slopes[1], slopes[0] + slopes[1] - rise * 2.0]
}

fn value(cubic: &[DVec2; 4], t: f64) -> DVec2 {
    ((cubic[3] * t + cubic[2]) * t + cubic[1]) * t + cubic[0]
}
