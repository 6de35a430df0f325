//! The crossings of limbs that are known of whole frames. Plain data, found by [`super::crossing_times`].

use crate::solve::Crossing;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock};

/// The crossings of layers in whole frames, by layer and frame.
pub(in crate::pipeline) type CrossingCache = Mutex<HashMap<(usize, i32), Arc<FrameCrossings>>>;

/// The crossings of a layer in one frame.
#[derive(Debug, Default)]
pub(in crate::pipeline) struct FrameCrossings {
    /// Digest of the pieces to which the crossings refer.
    pub(super) pieces: u64,
    pub(super) list: Vec<Crossing>,
    /// #list: the same over all frames, once known.
    pub(super) over_time: Vec<OnceLock<Crossing>>,
}
