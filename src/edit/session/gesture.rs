//! What the pen is doing.

use crate::shot::Shot;
use crate::space::ScreenPoint;
use std::sync::Arc;

/// What the pen does while it is down.
#[derive(Clone, Debug)]
pub(super) enum Gesture {
    Idle,
    /// It waits to hear what lies there.
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
    /// Around this point.
    Turn {
        center: ScreenPoint,
        from: ScreenPoint,
        base: Arc<Shot>,
    },
    /// From the pin's rest.
    Region {
        pin: [usize; 2],
        rest: ScreenPoint,
        base: Arc<Shot>,
    },
    /// Up is stiffer.
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
