//! The window's end of the thread of frames.

use super::mail::{Inbox, Job, Mail, Question, Reply, Teller};
use super::studio::Studio;
use crate::raster::DeviceChoice;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, PoisonError};

/// The window's end of the thread.
#[derive(Debug)]
pub(in crate::edit) struct Worker {
    inbox: Arc<Inbox>,
    replies: Receiver<Reply>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread; `wake` is called whenever there is a reply.
    #[must_use]
    pub(in crate::edit) fn start(device: DeviceChoice, wake: impl Fn() + Send + Sync + 'static) -> Self {
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
    pub(in crate::edit) fn want(&self, job: Job) {
        self.interrupt(|mail| mail.job = Some(job));
    }

    /// Asks something. What is being drawn waits for the answer.
    pub(in crate::edit) fn ask(&self, question: Question) {
        self.interrupt(|mail| mail.questions.push_back(question));
    }

    /// The files of the shot are read again with the next job.
    pub(in crate::edit) fn forget(&self) {
        self.interrupt(|mail| mail.is_stale = true);
    }

    /// What came since the last call.
    pub(in crate::edit) fn replies(&self) -> impl Iterator<Item = Reply> {
        self.replies.try_iter()
    }

    /// Waits for the next reply, so long at most.
    #[must_use]
    pub(in crate::edit) fn wait(&self, longest: std::time::Duration) -> Option<Reply> {
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
