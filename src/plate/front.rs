//! What stands in front of a moved layer.
//!
//! In: coverage, drawn from the scene after the warp. Out: [`Front`], plain data for [`LayerJob`](super::LayerJob).

use super::Coverage;

/// What the scene shows in front of a layer. Pixels outside the windows show the layer as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Front {
    /// The fraction of the warped layer that nothing else covers, 0 to 1.
    pub visible: Coverage,
    /// How much of the pixel shows parts of the layer that something else hid before the warp. They are not in the plate:
    /// the pixel is a hole there.
    pub missing: Coverage,
}
