//! The window's handle to the worker thread.

use super::frame_worker::FrameWorker;
use super::mail::{Inbox, Job, Question, Queue, Reply, ReplySender};
use crate::raster::DeviceChoice;
use crate::scene::Scene;
use std::panic::AssertUnwindSafe;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, PoisonError};
use std::thread::JoinHandle;

/// The window's handle to the worker thread.
#[derive(Debug)]
pub(in crate::edit) struct Worker {
    inbox: Arc<Inbox>,
    replies: Receiver<Reply>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread; `wake` is called for every reply. `scene`: that of the first job, if it is loaded already.
    #[must_use]
    pub(in crate::edit) fn start(
        (device, scene): (DeviceChoice, Option<Scene>),
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let (inbox, (reply, replies)) = (Arc::new(Inbox::default()), channel());
        let own = Arc::clone(&inbox);
        let work = move || {
            let (sender, mut scene) = (ReplySender { reply, wake: Box::new(wake) }, scene);
            // After a panic the next job begins anew.
            while std::panic::catch_unwind(AssertUnwindSafe(|| {
                FrameWorker::new(device.clone(), scene.take()).run(&own, &sender);
            }))
            .is_err()
            {
                sender.send(Reply::Failed("The frame cannot be drawn: internal error. Undo may help.".into()));
            }
        };
        let thread = std::thread::Builder::new().name("edit: frames".into()).spawn(work);
        if let Err(error) = &thread {
            tracing::error!("no thread can be started: {error}");
        }
        Self { inbox, replies, thread: thread.ok() }
    }

    /// Requests a frame, replacing any earlier request.
    pub(in crate::edit) fn want(&self, job: Job) {
        self.interrupt(|queue| queue.job = Some(job));
    }

    /// Asks a question, which interrupts drawing until it is answered.
    pub(in crate::edit) fn ask(&self, question: Question) {
        self.interrupt(|queue| queue.questions.push_back(question));
    }

    /// Makes the next job read the shot's files again.
    pub(in crate::edit) fn forget(&self) {
        self.interrupt(|queue| queue.is_stale = true);
    }

    /// Returns the replies since the last call.
    pub(in crate::edit) fn replies(&self) -> impl Iterator<Item = Reply> {
        self.replies.try_iter()
    }

    /// Waits for the next reply until a timeout.
    #[must_use]
    pub(in crate::edit) fn wait(&self, longest: std::time::Duration) -> Option<Reply> {
        self.replies.recv_timeout(longest).ok()
    }

    /// Returns whether the thread has ended, or was never started.
    #[must_use]
    pub(in crate::edit) fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Ends the thread.
    #[cfg(test)]
    pub(in crate::edit) fn end(&self) {
        self.interrupt(|queue| queue.is_over = true);
    }

    /// Modifies the queue, and interrupts work in progress.
    fn interrupt(&self, change: impl FnOnce(&mut Queue)) {
        let mut queue = self.inbox.state.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut queue);
        self.inbox.newest.fetch_add(1, Ordering::Release);
        self.inbox.changed.notify_one();
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.interrupt(|queue| queue.is_over = true);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
