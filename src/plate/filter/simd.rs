//! Runs inner loops with SIMD instructions.
//!
//! In: a kernel whose whole body is inlined. Out: its result, compiled for the current processor.

use pulp::{Simd, WithSimd};

/// Floats per register. Both instruction sets of [`dispatch`] have exactly eight.
pub(super) const LANES: usize = 8;

/// Runs a kernel with the widest registers of up to eight floats that the processor supports.
pub(super) fn dispatch<Op: WithSimd>(kernel: Op) -> Op::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return Simd::vectorize(simd, kernel);
    }
    Simd::vectorize(pulp::Scalar256b, kernel)
}

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
