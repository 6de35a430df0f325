//! The current pen gesture.

use crate::shot::Shot;
use crate::space::ScreenPoint;
use std::sync::Arc;

/// The gesture in progress while the pen is down.
#[derive(Clone, Debug)]
pub(super) enum Gesture {
    Idle,
    /// Waits for the worker's answer about the surface under the pen.
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
    /// The centre of the turn.
    Turn {
        center: ScreenPoint,
        from: ScreenPoint,
        base: Arc<Shot>,
    },
    /// The pin's rest position.
    Region {
        pin: [usize; 2],
        rest: ScreenPoint,
        base: Arc<Shot>,
    },
    /// Dragging up makes it stiffer.
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
