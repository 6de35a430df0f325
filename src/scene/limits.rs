//! The range of numbers in a file that can be computed with.
//!
//! In: numbers of a file. Out: whether they are usable.

/// Largest coordinate, scale factor or time: squares and products of larger ones leave the range of single precision.
pub(super) const LARGEST: f32 = 1e15;

/// Whether a number is finite and small enough.
pub(super) fn is_usable(value: f32) -> bool {
    value.abs() <= LARGEST
}
