//! SIMD registers of four numbers: loads, stores, fused multiply-adds. Crate pulp.
//!
//! All code paths use fused multiply-add, so results have the same bits on every processor.

use pulp::Simd;

/// Number of rows that are computed together.
pub(crate) const LANES: usize = 4;

/// One number for each of four rows.
pub(crate) type Lanes = [f64; LANES];

/// The matrix in one of four lanes.
pub(crate) fn lane_of<const D: usize>(lanes: &[[Lanes; D]; D], lane: usize) -> [[f64; D]; D] {
    lanes.map(|row| row.map(|x| x[lane]))
}

/// Loads four numbers. Both instruction sets of [`dispatch`](crate::simd::dispatch) have exactly four lanes.
#[inline(always)]
pub(crate) fn load<S: Simd>(lanes: &Lanes) -> S::f64s {
    S::as_simd_f64s(lanes).0[0]
}

/// Stores a register as four numbers.
#[inline(always)]
pub(crate) fn store<S: Simd>(register: S::f64s) -> Lanes {
    let mut lanes = [0.0; LANES];
    S::as_mut_simd_f64s(&mut lanes).0[0] = register;
    lanes
}

/// a·b + c, rounded once.
#[inline(always)]
pub(crate) fn multiply_add<S: Simd>(simd: S, a: S::f64s, b: S::f64s, c: S::f64s) -> S::f64s {
    simd.mul_add_f64s(a, b, c)
}

/// Adds value · factor to every sum.
#[inline(always)]
pub(crate) fn add_multiple<S: Simd, const D: usize>(
    simd: S,
    value: S::f64s,
    factors: &[S::f64s; D],
    sums: &mut [S::f64s; D],
) {
    for (sum, factor) in sums.iter_mut().zip(factors) {
        *sum = multiply_add(simd, value, *factor, *sum);
    }
}
