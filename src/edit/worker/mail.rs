//! Messages between the window and the worker thread.

use crate::edit::picture::Picture;
use crate::pipeline::{
    BrushPoint, FrameReport, LayerMarks, LayerOffer, LayerShift, PaintedPlace, PickedPoint, PinTurn, StiffTriangle,
};
use crate::shot::{Ease, Shot};
use crate::space::{ScreenPoint, ScreenVector};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// A requested frame.
#[derive(Clone, Debug)]
pub(in crate::edit) struct Job {
    /// The shot, possibly with keys that are not in the document yet.
    pub shot: Arc<Shot>,
    /// Revision of the document.
    pub revision: u64,
    /// Frame number.
    pub frame: i32,
    /// The purpose of the request.
    pub purpose: Purpose,
    /// Frames to draw afterwards, in order.
    pub next: VecDeque<i32>,
    /// Runs of frames to report after those, in order, without a picture: first and last.
    pub reports: VecDeque<[i32; 2]>,
    /// Whether the unwarped frame is requested, too.
    pub with_before: bool,
    /// Whether the rendered frame was already sent: an interrupted job then continues with the next frames.
    pub is_shown: bool,
}

/// The purpose of a requested frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::edit) enum Purpose {
    /// Display: a draft first, then the rendered frame.
    Look,
    /// Playback: a draft only.
    Play,
    /// Drag of these layers: marks at once, then a draft.
    Drag(Vec<usize>),
    /// Painting of stiffness: the painted triangles only.
    Paint,
}

/// A question asked alongside the picture, about the frame that is shown. Numbers are returned with the answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::edit) enum Question {
    /// What point of the model is seen at a point of the screen?
    Point { id: u64, frame: i32, at: ScreenPoint },
    /// What point of the model at rest lies under the brush, and on its other side?
    Brush { id: u64, frame: i32, at: ScreenPoint, mirrors: bool },
    /// What triangles are painted?
    Painted { revision: u64, frame: i32 },
    /// How are the pins of a layer turned in this frame, and in all keyed ones?
    KeyedTurns { id: u64, frame: i32, layer: usize },
}

impl Question {
    /// Returns the frame that it is about.
    pub(super) const fn frame(self) -> i32 {
        match self {
            Self::Point { frame, .. }
            | Self::Brush { frame, .. }
            | Self::Painted { frame, .. }
            | Self::KeyedTurns { frame, .. } => frame,
        }
    }
}

/// A reply of the worker thread.
#[derive(Clone, Debug)]
pub(in crate::edit) enum Reply {
    /// The shot is loaded.
    Loaded(Arc<Loaded>),
    /// Overlay marks and the solve report of a frame.
    Solved(Arc<SolvedFrame>),
    /// The report of a frame that is not drawn, with the revision of the document and the frame number.
    Reported(u64, i32, Box<FrameReport>),
    /// A frame was drawn.
    Drawn(Arc<Picture>),
    /// The unwarped frame was drawn.
    Before(Arc<Picture>),
    /// The answer to a question; `None` if there is no surface.
    Picked(u64, Option<FoundPoint>),
    /// The answer about the brush; `None` if no layer's surface is there.
    Brushed { id: u64, point: Option<BrushPoint>, mirrored: Option<PaintedPlace> },
    /// The painted triangles of a frame.
    Painted { revision: u64, frame: i32, triangles: Vec<StiffTriangle> },
    /// How the pins of a layer are turned, by the times of its keys.
    KeyedTurns { id: u64, layer: usize, turns: Vec<(f64, Vec<PinTurn>)> },
    /// By how much a frame that is solved over time differs from what was shown before, with the revision of the document.
    Shifted(u64, i32, Vec<LayerShift>),
    /// Progress of the solve over time, 0 to 1, with the revision of the document.
    Progress(u64, f64),
    /// A frame or the shot failed, with a message.
    Failed(String),
    /// There is no work left.
    Idle,
    /// The shot file was written, possibly by another program.
    ShotWritten,
    /// The scene or a picture was written by another program.
    SceneWritten,
    /// The plates of these frames, from first to last, were written by another program.
    PlatesWritten(Vec<[i32; 2]>),
}

/// A point of the model under the pointer.
#[derive(Clone, Debug)]
pub(in crate::edit) struct FoundPoint {
    /// The point.
    pub(in crate::edit) point: PickedPoint,
    /// Where its layer shows it in other keyed frames.
    pub(in crate::edit) held: Vec<HeldPlace>,
}

/// Where a keyed frame shows a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::edit) struct HeldPlace {
    /// The time of the keys.
    pub(in crate::edit) time: f64,
    /// The ease that leaves them.
    pub(in crate::edit) ease: Ease,
    /// The displacement by the warp.
    pub(in crate::edit) offset: ScreenVector,
}

/// Information about a loaded shot.
#[derive(Clone, Debug, Default)]
pub(crate) struct Loaded {
    /// Names of nodes with meshes, and whether they are hidden.
    pub(crate) nodes: Vec<(String, bool)>,
    /// The layers that can be added: everything, then one for each of these nodes.
    pub(crate) offers: Vec<LayerOffer>,
    /// Names of layers, and the numbers of handles along the axes of their lattices, also where they are automatic.
    pub(crate) dims: Vec<(String, [usize; 3])>,
    /// Whether the lattices of new layers branch, as in a new shot of the scene.
    pub(crate) can_branch: bool,
    /// Names of clips, and their durations in seconds.
    pub(crate) clips: Vec<(String, f64)>,
    /// Names of the scene's cameras.
    pub(crate) cameras: Vec<String>,
    /// Name of the rendering device.
    pub(crate) device: String,
}

/// A solved frame.
#[derive(Clone, Debug)]
pub(crate) struct SolvedFrame {
    /// Frame number.
    pub(crate) frame: i32,
    /// Revision of the document.
    pub(crate) revision: u64,
    /// Its overlay marks.
    pub(crate) marks: Vec<LayerMarks>,
    /// The solve report.
    pub report: FrameReport,
    /// Whether it is the solve used for rendering.
    pub(crate) is_final: bool,
}

/// The worker thread's inbox.
#[derive(Debug, Default)]
pub(super) struct Inbox {
    pub(super) state: Mutex<Queue>,
    pub(super) changed: Condvar,
    /// Incremented by every message: work begun before is cancelled or suspended.
    pub(super) newest: AtomicU64,
}

/// The pending work.
#[derive(Debug, Default)]
pub(super) struct Queue {
    pub(super) job: Option<Job>,
    pub(super) questions: VecDeque<Question>,
    /// Whether the shot's files changed.
    pub(super) is_stale: bool,
    pub(super) is_over: bool,
}

/// What long work asks for while it goes on.
pub(super) struct Interrupts<'a> {
    pub(super) inbox: &'a Inbox,
    /// The number of the message that began the work.
    pub(super) serial: u64,
}

impl Interrupts<'_> {
    /// Returns whether there is a newer message.
    pub(super) fn is_stale(&self) -> bool {
        self.inbox.newest.load(Ordering::Acquire) != self.serial
    }

    /// Returns whether the pen waits for an answer or for the first marks of a drag: drafts are then given up, too.
    pub(super) fn is_pen_waiting(&self) -> bool {
        if !self.is_stale() {
            return false;
        }
        let queue = self.inbox.state.lock().unwrap_or_else(PoisonError::into_inner);
        let is_pen = |job: &Job| matches!(job.purpose, Purpose::Drag(_) | Purpose::Paint);
        queue.is_over || !queue.questions.is_empty() || queue.job.as_ref().is_some_and(is_pen)
    }
}

/// The worker thread's end of the replies.
pub(super) struct ReplySender {
    pub(super) reply: Sender<Reply>,
    pub(super) wake: Box<dyn Fn() + Send + Sync>,
}

impl ReplySender {
    pub(super) fn send(&self, reply: Reply) {
        if self.reply.send(reply).is_ok() {
            (self.wake)();
        }
    }
}
