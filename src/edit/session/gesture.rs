//! The pointer gesture in progress.

use crate::shot::Shot;
use crate::space::ScreenPoint;
use std::sync::Arc;

/// The gesture in progress while the pointer is pressed.
#[derive(Clone, Debug)]
pub(super) enum Gesture {
    Idle,
    /// Waits for the worker's answer about the surface under the pointer.
    Placing {
        id: u64,
        from: ScreenPoint,
        at: ScreenPoint,
        is_up: bool,
        is_whole: bool,
    },
    Drag {
        from: ScreenPoint,
        base: Arc<Shot>,
        has_moved: bool,
    },
    /// Centre of the rotation.
    Turn {
        center: ScreenPoint,
        from: ScreenPoint,
        base: Arc<Shot>,
    },
    /// Rest position of the pin.
    Region {
        pin: [usize; 2],
        rest: ScreenPoint,
        base: Arc<Shot>,
    },
    /// Dragging up increases the stiffness.
    Stiffness {
        pin: [usize; 2],
        from: ScreenPoint,
        base: Arc<Shot>,
    },
    Box {
        from: ScreenPoint,
        to: ScreenPoint,
    },
}
