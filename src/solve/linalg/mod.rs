//! Linear algebra of the solver: small matrices; banded, dense and sparse factorisations; symmetric products; SIMD registers.
//!
//! In: matrices and right-hand sides. Out: products, factors, solutions. Independent of lattices.

pub(super) mod band_storage;
pub(super) mod cholesky;
pub(super) mod factorization;
pub(super) mod gram_matrix;
pub(super) mod normal_matrix;
pub(super) mod pseudo_inverse;
pub(super) mod simd;
pub(super) mod small_matrix;
pub(super) mod sparse;
pub(super) mod syrk;
