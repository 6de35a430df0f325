//! Chooses the instruction set of kernels. Crate pulp.
//!
//! In: a kernel whose whole body is inlined. Out: its result, compiled for the current processor.

use pulp::{Simd, WithSimd};

/// Runs a kernel with AVX2 if the processor has it, else with scalar emulation of the same registers: eight `f32` or four `f64`. Both
/// fuse multiply-adds, so results have the same bits.
pub(crate) fn dispatch<Op: WithSimd>(kernel: Op) -> Op::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return Simd::vectorize(simd, kernel);
    }
    Simd::vectorize(pulp::Scalar256b, kernel)
}
