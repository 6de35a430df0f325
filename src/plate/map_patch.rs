//! Interpolates a block of a map from its corners.
//!
//! In: offsets and slopes at four pixels. Out: offsets of all pixels between them. The sides are cubic Hermite curves,
//! and the interior is a Coons patch (S. A. Coons, "Surfaces for Computer-Aided Design of Space Forms", 1967): the
//! error falls with the fourth power of the block size.

use super::pixel_field::Node;
use glam::DVec2;

/// Size of the largest block, in pixels.
pub(super) const LARGEST: usize = 32;
/// Floats per SIMD register.
const LANES: usize = 8;

/// The four sides of a block as cubic polynomials on 0..1: c0 + c1 t + c2 t² + c3 t³.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    top: [DVec2; 4],
    bottom: [DVec2; 4],
    left: [DVec2; 4],
    right: [DVec2; 4],
}

impl Patch {
    /// Creates a patch from its corners (upper left, upper right, lower left, lower right), `size` pixels apart.
    pub(super) fn new(corners: &[Node; 4], size: f64) -> Self {
        let [a, b, c, d] = corners;
        let along = |from: &Node, to: &Node| hermite(from.offset, to.offset, [from, to].map(|n| n.slope.x_axis * size));
        let down = |from: &Node, to: &Node| hermite(from.offset, to.offset, [from, to].map(|n| n.slope.y_axis * size));
        Self { top: along(a, b), bottom: along(c, d), left: down(a, c), right: down(b, d) }
    }

    /// Returns the cubic of a row: `v` is 0 at the upper side and 1 at the lower.
    fn row(&self, v: f64) -> [DVec2; 4] {
        let mut row: [DVec2; 4] = std::array::from_fn(|k| self.top[k].lerp(self.bottom[k], v));
        // Deviation of the curved sides from straight ones.
        let left = value(&self.left, v) - row[0];
        let right = value(&self.right, v) - row.iter().sum::<DVec2>();
        row[0] += left;
        row[1] += right - left;
        row
    }

    /// Returns the offset at a position of the block, 0 to 1 per axis.
    pub(super) fn at(&self, u: f64, v: f64) -> DVec2 {
        value(&self.row(v), u)
    }

    /// Writes the offsets of row `y` of a block of `size` pixels to `row`, starting at the block's first column.
    pub(super) fn fill(&self, size: usize, y: usize, row: &mut [[f32; 2]]) {
        let scale = 1.0 / size as f64;
        let [c0, c1, c2, c3] = self.row(y as f64 * scale);
        let cubic = [spread(c0), spread(c1 * scale), spread(c2 * scale.powi(2)), spread(c3 * scale.powi(3))];
        let mut place: [f32; LANES] = std::array::from_fn(|lane| (lane / 2) as f32);
        let (chunks, rest) = row.as_flattened_mut().as_chunks_mut::<LANES>();
        for chunk in chunks {
            *chunk = values(&cubic, &place);
            place.iter_mut().for_each(|place| *place += (LANES / 2) as f32);
        }
        rest.copy_from_slice(&values(&cubic, &place)[..rest.len()]);
    }
}

/// Repeats x and y alternately.
fn spread(c: DVec2) -> [f32; LANES] {
    let (x, y) = (c.x as f32, c.y as f32);
    [x, y, x, y, x, y, x, y]
}

/// Evaluates a cubic at four positions, x and y interleaved.
#[inline(always)]
fn values([c0, c1, c2, c3]: &[[f32; LANES]; 4], t: &[f32; LANES]) -> [f32; LANES] {
    let mut sums = *c3;
    for lane in 0..LANES {
        sums[lane] = ((sums[lane] * t[lane] + c2[lane]) * t[lane] + c1[lane]) * t[lane] + c0[lane];
    }
    sums
}

/// Returns the cubic between two values with the given slopes.
fn hermite(from: DVec2, to: DVec2, slopes: [DVec2; 2]) -> [DVec2; 4] {
    let rise = to - from;
    [from, slopes[0], rise * 3.0 - slopes[0] * 2.0 - slopes[1], slopes[0] + slopes[1] - rise * 2.0]
}

fn value(cubic: &[DVec2; 4], t: f64) -> DVec2 {
    ((cubic[3] * t + cubic[2]) * t + cubic[1]) * t + cubic[0]
}
