//! The pointer gesture in progress.

use crate::edit::AxisRing;
use crate::shot::{BrushStroke, Layer, Shot};
use crate::space::ScreenPoint;
use glam::DVec2;
use std::sync::Arc;

/// A press whose surface the worker looks for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Click {
    /// Returned with the answer.
    pub(super) id: u64,
    pub(super) frame: i32,
    pub(super) from: ScreenPoint,
    /// Whether the pin moves the part as a whole.
    pub(super) is_whole: bool,
    /// Whether what is selected stays so if there is no surface.
    pub(super) keeps_selection: bool,
}

/// The pins that a drag carries.
#[derive(Clone, Debug)]
pub(super) struct Carried {
    pub(super) frame: i32,
    /// Layer and pin of each, and where its target was when the drag began.
    pub(super) pins: Vec<([usize; 2], ScreenPoint)>,
    /// How far the pen has moved since then, frame heights.
    pub(super) by: DVec2,
}

/// The gesture in progress while the pointer is pressed.
#[derive(Clone, Debug)]
pub(super) enum Gesture {
    Idle,
    /// Waits for the worker's answer about the surface under the pointer.
    Placing {
        click: Click,
        at: ScreenPoint,
        is_up: bool,
    },
    Drag {
        from: ScreenPoint,
        base: Arc<Shot>,
        has_moved: bool,
        carried: Carried,
    },
    /// A press on a ring: a click, until it has moved by more than `slack` frame heights and becomes a turn.
    OnRing {
        from: ScreenPoint,
        slack: f64,
        /// The pin that a click places, by whether it moves the part as a whole; `None`: no pin.
        placed: Option<bool>,
        turn: Box<Self>,
    },
    /// Centre of the rotation.
    Turn {
        center: ScreenPoint,
        from: ScreenPoint,
        /// The angle so far, radians.
        turned: f64,
        base: Arc<Shot>,
    },
    /// Turns a pin about an axis of the scene.
    TurnAbout {
        /// The centre of the rings, and their radius in frame heights.
        center: ScreenPoint,
        radius: f64,
        /// The axis, by its place and as it was when the drag began.
        axis: usize,
        ring: AxisRing,
        from: ScreenPoint,
        /// The angle so far, radians.
        turned: f64,
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
    Paint(Painting),
    /// Sizes the brush around a centre.
    BrushSize {
        center: ScreenPoint,
    },
    /// Moves the line between the frames with and without the warp.
    Wipe,
}

impl Gesture {
    /// Goes on with a changed document; ends if that has other layers or pins, as an index may mean another one then.
    pub(super) fn follow(&mut self, shot: &Shot) {
        let base = match self {
            Self::OnRing { turn, .. } => {
                turn.follow(shot);
                if turn.is_idle() {
                    *self = Self::Idle;
                }
                return;
            }
            Self::Idle | Self::Placing { .. } | Self::Box { .. } | Self::BrushSize { .. } | Self::Wipe => return,
            Self::Drag { base, .. }
            | Self::Turn { base, .. }
            | Self::TurnAbout { base, .. }
            | Self::Region { base, .. }
            | Self::Stiffness { base, .. } => base,
            Self::Paint(painting) => &mut painting.base,
        };
        if has_same_pins(base, shot) {
            *base = Arc::new(shot.clone());
        } else {
            *self = Self::Idle;
        }
    }

    pub(super) const fn is_idle(&self) -> bool {
        matches!(self, Self::Idle)
    }
}

/// Returns whether two shots have the same layers and pins, in order, under whatever names.
fn has_same_pins(a: &Shot, b: &Shot) -> bool {
    let is_same = |a: &Layer, b: &Layer| {
        let anchors = |layer: &Layer| layer.pins.iter().map(|pin| pin.anchor.clone()).collect::<Vec<_>>();
        a.space.dims() == b.space.dims() && anchors(a) == anchors(b)
    };
    a.layers.len() == b.layers.len() && a.layers.iter().zip(&b.layers).all(|(a, b)| is_same(a, b))
}

/// A line that the brush paints, in one stroke or several: a new one begins where it leaves the surface or jumps.
#[derive(Clone, Debug, Default)]
pub(super) struct PaintedLine {
    pub(super) strokes: Vec<BrushStroke>,
    /// Whether the last point belongs to the last stroke.
    pub(super) goes_on: bool,
}

/// Painting in progress.
#[derive(Clone, Debug)]
pub(super) struct Painting {
    /// Returned with the answers to its questions.
    pub(super) id: u64,
    /// What is painted so far.
    pub(super) line: PaintedLine,
    /// The same on the other side of the model, if edits are mirrored.
    pub(super) mirrored: PaintedLine,
    /// The painted layer, that of the first point.
    pub(super) layer: Option<usize>,
    /// The stiffness that is painted; 1 erases.
    pub(super) value: f64,
    /// Where the pen was when the last point was asked for.
    pub(super) asked_at: ScreenPoint,
    /// Number of questions without an answer.
    pub(super) waiting: usize,
    /// The pen's way, on the screen.
    pub(super) way: Vec<ScreenPoint>,
    pub(super) is_up: bool,
    pub(super) base: Arc<Shot>,
}
