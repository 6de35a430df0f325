//! A trajectory and the points of the model that it watches.

use super::PinAnchor;
use crate::solve::Trajectory;

/// The trajectory of a layer on the screen.
#[derive(Debug)]
pub(super) struct WatchedTrajectory {
    pub(super) trajectory: Trajectory<2>,
    pub(super) points: Vec<PinAnchor>,
}
