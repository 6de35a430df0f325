//! The scene that a lattice is laid over.

use crate::pipeline::PreparedShot;

/// A prepared scene, and the layer that the controls drive.
#[derive(Debug)]
pub(super) struct BaseScene {
    /// `None`: the picture is empty.
    pub(super) prepared: Option<PreparedShot>,
    /// Index of the layer.
    pub(super) layer: usize,
}
