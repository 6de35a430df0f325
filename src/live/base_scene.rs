//! The scene that lattices are laid over.

use crate::pipeline::PreparedShot;

/// A scene, and the layer of it that is driven.
#[derive(Debug)]
pub(super) struct BaseScene {
    /// `None`: nothing of the picture is there.
    pub(super) prepared: Option<PreparedShot>,
    /// Index of the layer.
    pub(super) layer: usize,
}
