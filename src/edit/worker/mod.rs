//! The thread that loads, solves and draws, so that the window never waits.
//!
//! In: [`Job`]s, of which only the newest counts, and [`Question`]s. Out: [`Reply`]s, in the order in which they are known: marks,
//! a quick picture, the rendered one.

mod drag_solve;
mod draft_size;
mod studio;

use super::picture::Picture;
use crate::pipeline::{FrameReport, LayerMarks, PickedPoint};
use crate::raster::DeviceChoice;
use crate::shot::Shot;
use crate::space::ScreenPoint;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use studio::Studio;

/// What is to be seen.
#[derive(Clone, Debug)]
pub struct Job {
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
}

/// What a frame is wanted for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// To be looked at: quickly first, then as it is rendered.
    Look,
    /// It is one of many: quickly.
    Play,
    /// Keys of these layers follow the pointer: marks at once, then a quick picture.
    Drag(Vec<usize>),
}

/// Something asked beside the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Question {
    /// Comes back with the answer.
    pub id: u64,
    /// A point of the model is wanted that is seen there, in the frame of the newest job.
    pub at: ScreenPoint,
}

/// What the thread has to say.
#[derive(Clone, Debug)]
pub enum Reply {
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
}

/// What is known of a loaded shot.
#[derive(Clone, Debug, Default)]
pub struct Loaded {
    /// What was chosen or ignored, in the user's words.
    pub notes: Vec<String>,
    /// Names of nodes with meshes.
    pub nodes: Vec<String>,
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

/// The window's end of the thread.
#[derive(Debug)]
pub struct Worker {
    inbox: Arc<Inbox>,
    replies: Receiver<Reply>,
    thread: Option<std::thread::JoinHandle<()>>,
}

/// What the thread finds when it looks.
#[derive(Debug, Default)]
struct Inbox {
    state: Mutex<Mail>,
    changed: Condvar,
    /// Goes up with all mail: what was begun before is no longer wanted, or waits.
    newest: AtomicU64,
}

#[derive(Debug, Default)]
struct Mail {
    job: Option<Job>,
    questions: VecDeque<Question>,
    /// The files of the shot hold something else now.
    is_stale: bool,
    is_over: bool,
}

impl Worker {
    /// Starts the thread; `wake` is called whenever there is a reply.
    #[must_use]
    pub fn start(device: DeviceChoice, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let (inbox, (reply, replies)) = (Arc::new(Inbox::default()), channel());
        let own = Arc::clone(&inbox);
        let work = move || Studio::new(device).run(&own, &Teller { reply, wake: Box::new(wake) });
        let thread = std::thread::Builder::new().name("edit: frames".into()).spawn(work);
        if let Err(error) = &thread {
            tracing::error!("no thread can be started: {error}");
        }
        Self { inbox, replies, thread: thread.ok() }
    }

    /// Wants a frame, and no other any more.
    pub fn want(&self, job: Job) {
        self.interrupt(|mail| mail.job = Some(job));
    }

    /// Asks something. What is being drawn waits for the answer.
    pub fn ask(&self, question: Question) {
        self.interrupt(|mail| mail.questions.push_back(question));
    }

    /// The files of the shot are read again with the next job.
    pub fn forget(&self) {
        self.interrupt(|mail| mail.is_stale = true);
    }

    /// What came since the last call.
    pub fn replies(&self) -> impl Iterator<Item = Reply> {
        self.replies.try_iter()
    }

    /// Waits for the next reply, so long at most.
    #[must_use]
    pub fn wait(&self, longest: std::time::Duration) -> Option<Reply> {
        self.replies.recv_timeout(longest).ok()
    }

    /// Changes the mail, and ends what was begun before.
    fn interrupt(&self, change: impl FnOnce(&mut Mail)) {
        let mut mail = self.inbox.state.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut mail);
        self.inbox.newest.fetch_add(1, Ordering::Release);
        self.inbox.changed.notify_one();
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.interrupt(|mail| mail.is_over = true);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// The thread's end of the replies.
struct Teller {
    reply: Sender<Reply>,
    wake: Box<dyn Fn() + Send + Sync>,
}

impl Teller {
    fn tell(&self, reply: Reply) {
        if self.reply.send(reply).is_ok() {
            (self.wake)();
        }
    }
}
