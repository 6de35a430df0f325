//! What goes between the window and the thread of frames.

use crate::edit::picture::Picture;
use crate::pipeline::{FrameReport, LayerMarks, PickedPoint};
use crate::shot::Shot;
use crate::space::ScreenPoint;
use std::collections::VecDeque;
use std::sync::atomic::AtomicU64;
use std::sync::mpsc::Sender;
use std::sync::{Arc, Condvar, Mutex};

/// What is to be seen.
#[derive(Clone, Debug)]
pub(in crate::edit) struct Job {
    /// The shot, perhaps with keys that are not in the document yet.
    pub shot: Arc<Shot>,
    /// Change of the document that it is.
    pub revision: u64,
    /// Which frame.
    pub frame: i32,
    /// What for.
    pub purpose: Purpose,
    /// Frames that will be wanted after this one, in order.
    pub next: Vec<i32>,
    /// The frame without any warp is wanted, too.
    pub with_before: bool,
    /// The frame was told as it is rendered: a job that was interrupted goes on with the next frames.
    pub is_shown: bool,
}

/// What a frame is wanted for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::edit) enum Purpose {
    /// To be looked at: quickly first, then as it is rendered.
    Look,
    /// It is one of many: quickly.
    Play,
    /// Keys of these layers follow the pointer: marks at once, then a quick picture.
    Drag(Vec<usize>),
}

/// Something asked beside the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::edit) struct Question {
    /// Comes back with the answer.
    pub id: u64,
    /// A point of the model is wanted that is seen there, in the frame of the newest job.
    pub at: ScreenPoint,
}

/// What the thread has to say.
#[derive(Clone, Debug)]
pub(in crate::edit) enum Reply {
    /// The shot is loaded.
    Loaded(Arc<Loaded>),
    /// Marks over a frame, and what its solve says.
    Solved(Arc<SolvedFrame>),
    /// A frame was drawn.
    Drawn(Arc<Picture>),
    /// A frame was drawn without any warp.
    Before(Arc<Picture>),
    /// The answer to a question; `None`: there is no surface.
    Picked(u64, Option<PickedPoint>),
    /// How much of the solve over time is done, 0 to 1.
    Progress(f64),
    /// A frame or the shot failed, in words.
    Failed(String),
    /// Nothing is left to do.
    Idle,
    /// The shot file was written, perhaps by another program.
    ShotWritten,
    /// The scene or a picture was written by another program.
    SceneWritten,
}

/// What is known of a loaded shot.
#[derive(Clone, Debug, Default)]
pub struct Loaded {
    /// What was chosen or ignored, in the user's words.
    pub notes: Vec<String>,
    /// Names of nodes with meshes, and whether they are hidden.
    pub nodes: Vec<(String, bool)>,
    /// Names of clips, and how long they are, seconds.
    pub clips: Vec<(String, f64)>,
    /// Names of cameras of the scene.
    pub cameras: Vec<String>,
    /// What draws.
    pub device: String,
}

/// A solved frame.
#[derive(Clone, Debug)]
pub struct SolvedFrame {
    /// Number of the frame.
    pub frame: i32,
    /// Change of the document.
    pub revision: u64,
    /// What is drawn over it.
    pub marks: Vec<LayerMarks>,
    /// What the solve says.
    pub report: FrameReport,
    /// It is what is rendered.
    pub is_final: bool,
}

/// What the thread finds when it looks.
#[derive(Debug, Default)]
pub(super) struct Inbox {
    pub(super) state: Mutex<Mail>,
    pub(super) changed: Condvar,
    /// Goes up with all mail: what was begun before is no longer wanted, or waits.
    pub(super) newest: AtomicU64,
}

#[derive(Debug, Default)]
pub(super) struct Mail {
    pub(super) job: Option<Job>,
    pub(super) questions: VecDeque<Question>,
    /// The files of the shot hold something else now.
    pub(super) is_stale: bool,
    pub(super) is_over: bool,
}

/// The thread's end of the replies.
pub(super) struct Teller {
    pub(super) reply: Sender<Reply>,
    pub(super) wake: Box<dyn Fn() + Send + Sync>,
}

impl Teller {
    pub(super) fn tell(&self, reply: Reply) {
        if self.reply.send(reply).is_ok() {
            (self.wake)();
        }
    }
}
