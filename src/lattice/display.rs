//! Forward deformation of many points in single precision, for display.
//!
//! In: a screen lattice and points. Out: warped points, within 1e-6 of the box of those of [`Lattice::warp`]. Handles
//! are stored as displacements, which preserves precision.

use super::axis::MAX_HANDLES;
use super::basis::Basis;
use super::grid::Lattice;
use crate::simd::dispatch;
use crate::space::ScreenPoint;
use pulp::{Simd, WithSimd};
use rayon::prelude::*;

/// Points per task.
const CHUNK: usize = 1 << 13;
/// Floats per vector register; rows of handles are padded to multiples of it.
const LANES: usize = 8;

/// A lattice prepared to warp many points.
///
/// ```
/// use pinwarp::lattice::{Basis, DisplayWarp, Grid};
/// let mut lattice = Grid { dims: [4, 4], basis: Basis::Bernstein, lo: [0.0, 0.0], hi: [1.0, 1.0], angle: 0.0 }.at_rest();
/// lattice.handles.iter_mut().for_each(|handle| handle[1] += 0.25);
/// let mut points = [[0.5_f32, 0.5], [3.0, -1.0]];
/// DisplayWarp::new(&lattice).warp(&mut points);
/// assert_eq!(points, [[0.5, 0.75], [3.0, -0.75]]);
/// ```
#[derive(Clone, Debug)]
pub struct DisplayWarp {
    lattice: Lattice<2>,
    center: [f32; 2],
    /// Change of a coordinate of the box per unit of x and y, for each axis of the box.
    per_unit: [[f32; 2]; 2],
    /// Displacements x0 y0 x1 y1 ... per row of handles, padded with zeros; rows from the bottom.
    rows: Vec<f32>,
    /// Floats per row.
    stride: usize,
    /// C(n − 1, i) for both axes.
    binomials: [Vec<f32>; 2],
}

/// The non-zero functions of an axis: the first handle and the values.
struct Values<const N: usize> {
    first: usize,
    values: [f32; N],
}

impl DisplayWarp {
    /// Prepares a lattice.
    #[must_use]
    pub fn new(lattice: &Lattice<2>) -> Self {
        let grid = &lattice.grid;
        // Four handles are loaded at once from any position of a row.
        let stride = (2 * grid.dims[0]).next_multiple_of(LANES) + LANES;
        let mut rows = vec![0.0; stride * grid.dims[1]];
        let pairs = lattice.handles.iter().zip(grid.rest_handles());
        for (index, (moved, rest)) in pairs.enumerate() {
            let [column, row] = grid.handle_coords(index);
            (0..2).for_each(|d| rows[row * stride + 2 * column + d] = (moved[d] - rest[d]) as f32);
        }
        Self {
            center: [0, 1].map(|axis| (0.5 * (grid.lo[axis] + grid.hi[axis])) as f32),
            per_unit: [0, 1].map(|axis| {
                let along = grid.rotated(std::array::from_fn(|d| f64::from(u8::from(d == axis)) / grid.size(axis)));
                along.map(|x| x as f32)
            }),
            rows,
            stride,
            binomials: grid.dims.map(binomials),
            lattice: lattice.clone(),
        }
    }

    /// Warps points in place, on all threads.
    pub fn warp(&self, points: &mut [[f32; 2]]) {
        points.par_chunks_mut(CHUNK).for_each(|chunk| dispatch(Kernel { warp: self, points: chunk }));
    }

    #[inline(always)]
    fn warp_chunk(&self, points: &mut [[f32; 2]]) {
        match self.lattice.grid.basis {
            Basis::Bspline => points.iter_mut().for_each(|point| self.warp_local(point, cubic)),
            Basis::Bilinear => points.iter_mut().for_each(|point| self.warp_local(point, hat)),
            Basis::Bernstein => self.warp_dense(points),
            Basis::Barytri => points.iter_mut().for_each(|point| {
                let warped = self.lattice.warp(ScreenPoint::new(point[0].into(), point[1].into()));
                *point = warped.0.as_vec2().to_array();
            }),
        }
    }

    /// Returns the coordinate of a point in the box, 0 to 1.
    #[inline(always)]
    fn unit(&self, point: [f32; 2], axis: usize) -> f32 {
        let [x, y] = self.per_unit[axis];
        (0.5 + x * (point[0] - self.center[0]) + y * (point[1] - self.center[1])).clamp(0.0, 1.0)
    }

    /// Warps a point with four handles per axis.
    #[inline(always)]
    fn warp_local(&self, point: &mut [f32; 2], values: impl Fn(usize, f32) -> Values<4>) {
        let [nx, ny] = self.lattice.grid.dims;
        let (x, y) = (values(nx, self.unit(*point, 0)), values(ny, self.unit(*point, 1)));
        let mut sums = [0.0; LANES];
        for (row, weight) in y.values.iter().enumerate() {
            // Hat functions have two values; the others are zero and may lie beyond the last row.
            let start = (y.first + row).min(ny - 1) * self.stride + 2 * x.first;
            let handles = &self.rows[start..start + LANES];
            (0..LANES).for_each(|k| sums[k] += weight * handles[k]);
        }
        for (column, weight) in x.values.iter().enumerate() {
            point[0] += weight * sums[2 * column];
            point[1] += weight * sums[2 * column + 1];
        }
    }

    /// Warps points with all handles: one point per lane, one handle at a time.
    #[inline(always)]
    fn warp_dense(&self, points: &mut [[f32; 2]]) {
        let [nx, ny] = self.lattice.grid.dims;
        let mut values = [[[0.0; LANES]; MAX_HANDLES]; 2];
        for packet in points.chunks_mut(LANES) {
            for (axis, values) in values.iter_mut().enumerate() {
                let unit = std::array::from_fn(|lane| packet.get(lane).map_or(0.0, |point| self.unit(*point, axis)));
                bernstein(&self.binomials[axis], &unit, values);
            }
            let [x, y] = &values;
            let mut moved = [[0.0; LANES]; 2];
            for (handles, weights) in self.rows.chunks_exact(self.stride).zip(&y[..ny]) {
                let mut sums = [[0.0; LANES]; 2];
                for (handle, weights) in handles.as_chunks::<2>().0[..nx].iter().zip(x) {
                    for lane in 0..LANES {
                        sums[0][lane] += handle[0] * weights[lane];
                        sums[1][lane] += handle[1] * weights[lane];
                    }
                }
                for lane in 0..LANES {
                    moved[0][lane] += sums[0][lane] * weights[lane];
                    moved[1][lane] += sums[1][lane] * weights[lane];
                }
            }
            for (lane, point) in packet.iter_mut().enumerate() {
                *point = [point[0] + moved[0][lane], point[1] + moved[1][lane]];
            }
        }
    }
}

/// Kernel of [`DisplayWarp::warp`].
struct Kernel<'a> {
    warp: &'a DisplayWarp,
    points: &'a mut [[f32; 2]],
}

impl WithSimd for Kernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.warp.warp_chunk(self.points);
    }
}

/// Returns the cell and the local coordinate.
#[inline(always)]
fn cell(spans: usize, t: f32) -> (usize, f32) {
    let x = t * spans as f32;
    let cell = (x as usize).min(spans - 1);
    (cell, x - cell as f32)
}

/// Evaluates the uniform cubic B-spline.
#[inline(always)]
fn cubic(count: usize, t: f32) -> Values<4> {
    let (first, u) = cell(count - 3, t);
    let v = 1.0 - u;
    let values = [
        v * v * v / 6.0,
        (u * u * (3.0 * u - 6.0) + 4.0) / 6.0,
        (v * v * (3.0 * v - 6.0) + 4.0) / 6.0,
        u * u * u / 6.0,
    ];
    Values { first, values }
}

/// Evaluates the hat functions.
#[inline(always)]
fn hat(count: usize, t: f32) -> Values<4> {
    let (first, u) = cell(count - 1, t);
    Values { first, values: [1.0 - u, u, 0.0, 0.0] }
}

fn binomials(count: usize) -> Vec<f32> {
    let mut row = vec![1.0_f64];
    for _ in 1..count {
        row = (0..=row.len()).map(|i| row.get(i).unwrap_or(&0.0) + if i > 0 { row[i - 1] } else { 0.0 }).collect();
    }
    row.into_iter().map(|x| x as f32).collect()
}

/// Evaluates Bernstein polynomials at eight coordinates: ascending powers of t times descending powers of 1 − t.
#[inline(always)]
fn bernstein(binomials: &[f32], t: &[f32; LANES], values: &mut [[f32; LANES]; MAX_HANDLES]) {
    let mut power = [1.0; LANES];
    for (value, binomial) in values.iter_mut().zip(binomials) {
        for lane in 0..LANES {
            value[lane] = binomial * power[lane];
            power[lane] *= t[lane];
        }
    }
    power = [1.0; LANES];
    for value in values[..binomials.len()].iter_mut().rev() {
        for lane in 0..LANES {
            value[lane] *= power[lane];
            power[lane] *= 1.0 - t[lane];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Grid;

    #[test]
    fn display_is_the_warp_in_single_precision() {
        let bases = [Basis::Bernstein, Basis::Bspline, Basis::Bilinear, Basis::Barytri];
        for (basis, dims) in bases.into_iter().flat_map(|basis| [[4, 5], [15, 15], [64, 9]].map(|dims| (basis, dims))) {
            let angle = if dims[0] == 15 { 0.7 } else { 0.0 };
            let mut lattice = Grid { dims, basis, lo: [-0.4, 0.1], hi: [1.3, 0.9], angle }.at_rest();
            for (k, handle) in lattice.handles.iter_mut().enumerate() {
                *handle = [handle[0] + 0.1 * (k as f64).sin(), handle[1] + 0.1 * (1.3 * k as f64).cos()];
            }
            let place = |k: usize| [-0.6 + 0.041 * (k % 50) as f32, -0.1 + 0.031 * (k / 50) as f32];
            let mut points: Vec<[f32; 2]> = (0..2000).map(place).collect();
            DisplayWarp::new(&lattice).warp(&mut points);
            for (k, found) in points.iter().enumerate() {
                let [x, y] = place(k).map(f64::from);
                let wanted = lattice.warp(ScreenPoint::new(x, y)).0;
                let gap = (wanted.as_vec2() - glam::Vec2::from(*found)).length();
                assert!(gap < 2e-6, "{basis:?} {dims:?} at {x}, {y}: {gap:e}");
            }
        }
    }
}
