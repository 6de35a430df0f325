//! Separable weights of a basis of global support (Bernstein): a weight is a function of x times a function of the other axes, so
//! a point needs 30 numbers where a 15 × 15 lattice has 225 weights.
//!
//! In: points and a grid. Out: products with the handles, and products of the transpose with values at the points.

use super::linalg::simd::{LANES, Lanes, add_multiple, load, store};
use super::separable_rows::SeparableRows;
use crate::lattice::{Grid, bernstein_values};
use crate::simd::dispatch;
use pulp::{Simd, WithSimd};

/// Number of packets of four points that are processed together.
const GROUP: usize = 4;

/// Factors of all weights at some points.
#[derive(Clone, Debug)]
pub(crate) struct SeparableWeights {
    /// Number of handles in a row of handles along x, and number of these rows.
    pub(crate) counts: [usize; 2],
    points: usize,
    /// For each packet of four points the basis functions of x, then those of the rows; padded to whole groups of packets.
    factors: Vec<Lanes>,
}

impl SeparableWeights {
    /// Evaluates the factors at some points; `None` if the basis is local.
    pub(crate) fn new<const D: usize>(grid: &Grid<D>, points: &[[f64; D]]) -> Option<Self> {
        if grid.basis.is_local() {
            return None;
        }
        let counts = [grid.dims[0], grid.handle_count() / grid.dims[0]];
        let packets = points.len().div_ceil(LANES).next_multiple_of(GROUP);
        let mut factors = vec![[0.0; LANES]; packets * (counts[0] + counts[1])];
        dispatch(Evaluate { grid, points, factors: &mut factors });
        Some(Self { counts, points: points.len(), factors })
    }

    /// Number of handles.
    pub(crate) fn handle_count(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// Returns Σ_h w_h P_h at every point.
    pub(crate) fn moved<const D: usize>(&self, handles: &[[f64; D]]) -> Vec<[f64; D]> {
        dispatch(Moved { separable: self, handles })
    }

    /// Adds scale · Σ w_h · value to every handle; `values` has one entry per point.
    pub(crate) fn add_transposed<const D: usize>(&self, values: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]]) {
        dispatch(Transposed { separable: self, values, scale, right_side });
    }

    /// Factors, a group of packets at a time.
    #[inline(always)]
    fn groups(&self) -> impl Iterator<Item = Group<'_>> {
        let [inner, outer] = self.counts;
        self.factors.chunks_exact(GROUP * (inner + outer)).map(move |packets| {
            let (first, rest) = packets.split_at(inner + outer);
            let (second, rest) = rest.split_at(inner + outer);
            let (third, fourth) = rest.split_at(inner + outer);
            Group {
                xs: [&first[..inner], &second[..inner], &third[..inner], &fourth[..inner]],
                rows: [&first[inner..], &second[inner..], &third[inner..], &fourth[inner..]],
            }
        })
    }

    /// Returns the same weights, stored point after point.
    pub(crate) fn by_point(&self) -> SeparableRows {
        let [inner, outer] = self.counts;
        let strides = self.counts.map(|count| count.next_multiple_of(LANES));
        let mut factors = vec![0.0; self.points * (strides[0] + strides[1])];
        let packets = factors.chunks_mut(LANES * (strides[0] + strides[1]));
        for (packet, slots) in self.factors.chunks_exact(inner + outer).zip(packets) {
            for (lane, slots) in slots.chunks_exact_mut(strides[0] + strides[1]).enumerate() {
                let (xs, rows) = slots.split_at_mut(strides[0]);
                xs.iter_mut().zip(&packet[..inner]).for_each(|(slot, lanes)| *slot = lanes[lane]);
                rows.iter_mut().zip(&packet[inner..]).for_each(|(slot, lanes)| *slot = lanes[lane]);
            }
        }
        SeparableRows::new(self.counts, self.points, factors)
    }
}

/// Factors of a group of packets.
struct Group<'a> {
    /// Basis functions of x.
    xs: [&'a [Lanes]; GROUP],
    /// Basis functions of the rows.
    rows: [&'a [Lanes]; GROUP],
}

/// Kernel that evaluates the basis.
struct Evaluate<'a, const D: usize> {
    grid: &'a Grid<D>,
    points: &'a [[f64; D]],
    factors: &'a mut [Lanes],
}

impl<const D: usize> WithSimd for Evaluate<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { grid, points, factors } = self;
        let (inner, count) = (grid.dims[0], grid.handle_count());
        let mut axis_values = vec![[0.0; LANES]; grid.dims.iter().copied().max().unwrap_or(0)];
        for (points, slots) in points.chunks(LANES).zip(factors.chunks_exact_mut(inner + count / inner)) {
            let mut units = [[0.0; LANES]; D];
            for (lane, &point) in points.iter().enumerate() {
                let unit = grid.unit_from_point(point);
                (0..D).for_each(|axis| units[axis][lane] = unit[axis]);
            }
            let (xs, rows) = slots.split_at_mut(inner);
            bernstein_values(&units[0], xs);
            rows[0] = [1.0; LANES];
            let mut known = 1;
            for axis in 1..D {
                let values = &mut axis_values[..grid.dims[axis]];
                bernstein_values(&units[axis], values);
                multiply_rows(&mut rows[..known * values.len()], values);
                known *= values.len();
            }
        }
        // Lanes without a point have weight 0.
        let used = points.len() % LANES;
        if used > 0 {
            let packet = points.len() / LANES * (inner + count / inner);
            factors[packet..][..inner + count / inner].iter_mut().for_each(|lanes| lanes[used..].fill(0.0));
        }
    }
}

/// Multiplies the known rows at the start of `rows` by each of the values, which gives one copy per value.
#[inline(always)]
fn multiply_rows(rows: &mut [Lanes], values: &[Lanes]) {
    let known = rows.len() / values.len();
    // From the last value on, so that the known rows are overwritten last.
    for (number, value) in values.iter().enumerate().rev() {
        for row in 0..known {
            let before = rows[row];
            (0..LANES).for_each(|lane| rows[number * known + row][lane] = before[lane] * value[lane]);
        }
    }
}

/// Kernel of [`SeparableWeights::moved`].
struct Moved<'a, const D: usize> {
    separable: &'a SeparableWeights,
    handles: &'a [[f64; D]],
}

impl<const D: usize> WithSimd for Moved<'_, D> {
    type Output = Vec<[f64; D]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<[f64; D]> {
        let Self { separable, handles } = self;
        let (points, inner) = (separable.points, separable.counts[0]);
        let mut moved = vec![[0.0; D]; points.next_multiple_of(LANES * GROUP)];
        for (group, slots) in separable.groups().zip(moved.chunks_exact_mut(GROUP * LANES)) {
            let mut sums = [[simd.splat_f64s(0.0); D]; GROUP];
            for (row, handles) in handles.chunks_exact(inner).enumerate() {
                let mut along = [[simd.splat_f64s(0.0); D]; GROUP];
                for (k, handle) in handles.iter().enumerate() {
                    let mut coordinates = [simd.splat_f64s(0.0); D];
                    for (register, x) in coordinates.iter_mut().zip(handle) {
                        *register = simd.splat_f64s(*x);
                    }
                    for (along, xs) in along.iter_mut().zip(group.xs) {
                        add_multiple(simd, load::<S>(&xs[k]), &coordinates, along);
                    }
                }
                for ((sums, along), rows) in sums.iter_mut().zip(&along).zip(group.rows) {
                    add_multiple(simd, load::<S>(&rows[row]), along, sums);
                }
            }
            for (sums, slots) in sums.iter().zip(slots.chunks_exact_mut(LANES)) {
                for d in 0..D {
                    let lanes = store::<S>(sums[d]);
                    slots.iter_mut().zip(lanes).for_each(|(slot, x)| slot[d] = x);
                }
            }
        }
        moved.truncate(points);
        moved
    }
}

/// Kernel of [`SeparableWeights::add_transposed`].
struct Transposed<'a, const D: usize> {
    separable: &'a SeparableWeights,
    values: &'a [[f64; D]],
    scale: f64,
    right_side: &'a mut [[f64; D]],
}

impl<const D: usize> WithSimd for Transposed<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { separable, values, scale, right_side } = self;
        let inner = separable.counts[0];
        let mut sums = vec![[[0.0; LANES]; D]; separable.handle_count()];
        for (group, values) in separable.groups().zip(values.chunks(GROUP * LANES)) {
            let mut lanes = [[[0.0; LANES]; D]; GROUP];
            for (k, value) in values.iter().enumerate() {
                (0..D).for_each(|d| lanes[k / LANES][d][k % LANES] = value[d]);
            }
            for (row, sums) in sums.chunks_exact_mut(inner).enumerate() {
                let mut weighted = [[simd.splat_f64s(0.0); D]; GROUP];
                for n in 0..GROUP {
                    let value = load::<S>(&group.rows[n][row]);
                    for d in 0..D {
                        weighted[n][d] = simd.mul_f64s(value, load::<S>(&lanes[n][d]));
                    }
                }
                for (k, sums) in sums.iter_mut().enumerate() {
                    let mut registers = [simd.splat_f64s(0.0); D];
                    for (register, sum) in registers.iter_mut().zip(&*sums) {
                        *register = load::<S>(sum);
                    }
                    for (weighted, xs) in weighted.iter().zip(group.xs) {
                        add_multiple(simd, load::<S>(&xs[k]), weighted, &mut registers);
                    }
                    for (sum, register) in sums.iter_mut().zip(registers) {
                        *sum = store::<S>(register);
                    }
                }
            }
        }
        for (slot, sums) in right_side.iter_mut().zip(&sums) {
            (0..D).for_each(|d| slot[d] += scale * sums[d].iter().sum::<f64>());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;

    fn check<const D: usize>(dims: [usize; D], count: usize) {
        let grid = Grid { dims, basis: Basis::Bernstein, lo: [-0.5; D], hi: [1.5; D], angle: 0.0 };
        let points: Vec<[f64; D]> =
            (0..count).map(|k| std::array::from_fn(|d| ((k * (3 + 2 * d)) as f64).sin())).collect();
        let separable = SeparableWeights::new(&grid, &points).expect("every handle acts everywhere");
        let handles: Vec<[f64; D]> =
            (0..grid.handle_count()).map(|k| std::array::from_fn(|d| ((k + 5 * d) as f64).cos())).collect();
        let mut wanted_sums = vec![[0.0; D]; handles.len()];
        for (point, moved) in points.iter().zip(separable.moved(&handles)) {
            for d in 0..D {
                let wanted: f64 = grid.weights(*point).iter().map(|&(handle, w)| w * handles[handle][d]).sum();
                assert!((moved[d] - wanted).abs() < 1e-12, "{dims:?} {count}: {} {wanted}", moved[d]);
            }
            for (handle, w) in grid.weights(*point) {
                (0..D).for_each(|d| wanted_sums[handle][d] += 2.0 * w * point[d]);
            }
        }
        let mut sums = vec![[0.0; D]; handles.len()];
        separable.add_transposed(&points, 2.0, &mut sums);
        for (found, wanted) in sums.as_flattened().iter().zip(wanted_sums.as_flattened()) {
            assert!((found - wanted).abs() < 1e-12 * count as f64, "{dims:?} {count}");
        }
    }

    #[test]
    fn products_are_those_with_the_weights() {
        for count in [1, 4, 15, 16, 17, 40] {
            check([2, 2], count);
            check([5, 7], count);
            check([15, 15], count);
            check([3, 4, 5], count);
        }
    }
}
