//! SIMD registers of eight floats: loads and stores. Crate pulp.

use pulp::Simd;

/// Floats per register. Both instruction sets of [`dispatch`](crate::simd::dispatch) have exactly eight.
pub(super) const LANES: usize = 8;

/// Loads eight floats into a register.
#[inline(always)]
pub(super) fn load<S: Simd>(lanes: &[f32; LANES]) -> S::f32s {
    S::as_simd_f32s(lanes).0[0]
}

/// Stores a register as eight floats.
#[inline(always)]
pub(super) fn store<S: Simd>(register: S::f32s) -> [f32; LANES] {
    let mut lanes = [0.0; LANES];
    S::as_mut_simd_f32s(&mut lanes).0[0] = register;
    lanes
}
