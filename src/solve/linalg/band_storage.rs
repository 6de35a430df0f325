//! Storage of the lower half of a banded matrix: by columns, each from its diagonal on, padded to whole registers.

use super::simd::LANES;

/// Columns per panel.
pub(super) const PANEL: usize = 4;

/// Numbers per column. Entries beyond the band are zero, so that the four columns of a panel can be read over the same rows, in
/// whole registers.
pub(crate) fn stride(band: usize) -> usize {
    (band + 2 * PANEL - 1).next_multiple_of(LANES)
}

/// Numbers per factor; the last panel is padded.
pub(crate) fn padded_length(size: usize, band: usize) -> usize {
    size.next_multiple_of(PANEL) * stride(band)
}
