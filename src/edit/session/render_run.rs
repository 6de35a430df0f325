//! Renders the sequence in the background, as `pinwarp render` does.
//!
//! In: a shot. Out: frames on disk, progress, a log.

use super::Session;
use crate::edit::reference::Reference;
use crate::image::Existing;
use crate::pipeline::{Event, PreparedShot, RenderOptions, Summary, render};
use crate::raster::DeviceChoice;
use crate::shot::Shot;
use std::panic::AssertUnwindSafe;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// A render that is running or has ended.
#[derive(Debug)]
pub(crate) struct RenderRun {
    /// The file of its shot.
    pub(crate) shot: PathBuf,
    events: Receiver<RenderMessage>,
    cancel: Arc<AtomicBool>,
    /// Number of requested frames.
    pub(crate) frames: usize,
    /// Number of frames processed.
    pub(crate) done: usize,
    /// Its log messages.
    pub(crate) log: Vec<String>,
    /// Its state.
    pub state: RunState,
    /// Whether it ended with all of its frames.
    is_complete: bool,
    /// Paths of finished frames, in order.
    pub(crate) files: Vec<PathBuf>,
}

/// The state of a render.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum RunState {
    /// Running.
    Running,
    /// Finished or cancelled, with a summary.
    Ended(String),
}

/// What the render's thread reports.
enum RenderMessage {
    Event(Box<Event>),
    Failed(String),
}

impl Session {
    /// Renders the playback range if there is one, else the whole shot; existing frames that are up to date are kept. A render
    /// that is running goes on instead.
    pub(crate) fn render(&mut self, device: DeviceChoice, wake: impl Fn() + Send + Sync + 'static) {
        if self.is_rendering() {
            return;
        }
        let frames: Vec<i32> = match self.playhead.has_range() {
            true => (self.playhead.range()[0]..=self.playhead.range()[1]).collect(),
            false => Vec::new(),
        };
        self.run = Some(RenderRun::start(self.document.shot().clone(), (frames, device), wake));
    }

    /// Returns the current or last render.
    #[must_use]
    pub(crate) const fn run(&self) -> Option<&RenderRun> {
        self.run.as_ref()
    }

    /// Returns whether a render is running.
    #[must_use]
    pub(crate) fn is_rendering(&self) -> bool {
        self.run.as_ref().is_some_and(RenderRun::is_running)
    }

    /// Hands over the running render, which goes on without the session.
    pub(crate) fn take_run(&mut self) -> Option<RenderRun> {
        self.run.take_if(|run| run.is_running())
    }

    /// Takes over a render of the same shot.
    pub(crate) fn resume_run(&mut self, run: RenderRun) {
        self.run = Some(run);
    }

    /// Cancels the render after the frames in flight.
    pub(crate) fn cancel_render(&self) {
        self.run.iter().for_each(RenderRun::cancel);
    }

    /// Lays the frames of the last render over the picture, as a reference.
    pub(crate) fn look_at_render(&mut self) {
        let frame = self.playhead.frame();
        let pattern = self.document.shot().output.path.clone();
        // This frame need not be among those that were rendered.
        let opened = Reference::open(&pattern, frame).or_else(|_| Reference::open(&pattern, self.playhead.range()[0]));
        match opened {
            Ok(mut reference) => {
                reference.opacity = 1.0;
                self.put_reference(&pattern, reference);
                self.say("The rendered frames lie over the picture; View, Reference pictures takes them away.");
            }
            Err(error) => self.say(error.to_string()),
        }
    }

    /// Closes the log of the last render.
    pub(crate) fn close_render(&mut self) {
        if !self.is_rendering() {
            self.run = None;
        }
    }
}

impl RenderRun {
    fn start(shot: Shot, (frames, device): (Vec<i32>, DeviceChoice), wake: impl Fn() + Send + Sync + 'static) -> Self {
        let (path, (sender, events)) = (shot.path.clone(), channel());
        let cancel = Arc::new(AtomicBool::new(false));
        let (count, own_cancel) =
            (if frames.is_empty() { shot.frames.count() } else { frames.len() }, Arc::clone(&cancel));
        let draw = move |send: &(dyn Fn(RenderMessage) + Sync)| {
            let options = RenderOptions {
                frames,
                device,
                existing: Existing::Resume,
                has_preview: true,
                ..RenderOptions::default()
            };
            let outcome = PreparedShot::new(shot).and_then(|prepared| {
                render(&prepared, &options, &own_cancel, &|event| send(RenderMessage::Event(Box::new(event))))
            });
            if let Err(error) = outcome {
                send(RenderMessage::Failed(error.to_string()));
            }
        };
        let work = move || {
            let send = |message: RenderMessage| {
                if sender.send(message).is_ok() {
                    wake();
                }
            };
            // The window learns of a panic, too, when nobody is left to send.
            let _ = std::panic::catch_unwind(AssertUnwindSafe(|| draw(&send)));
            drop(sender);
            wake();
        };
        let mut log = Vec::new();
        let mut state = RunState::Running;
        if let Err(error) = std::thread::Builder::new().name("edit: render".into()).spawn(work) {
            log.push(format!("no thread can be started: {error}"));
            state = RunState::Ended("Nothing was rendered.".into());
        }
        let (done, files, is_complete) = (0, Vec::new(), false);
        Self { shot: path, events, cancel, frames: count, done, log, state, is_complete, files }
    }

    /// Returns whether it is running.
    #[must_use]
    pub(crate) fn is_running(&self) -> bool {
        self.state == RunState::Running
    }

    /// Returns whether it ended without all of its frames.
    #[must_use]
    pub(crate) fn has_failed(&self) -> bool {
        !self.is_running() && !self.is_complete
    }

    /// Cancels it after the frames in flight.
    pub(crate) fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }

    /// Processes the render's events. Returns whether anything changed.
    pub(crate) fn pump(&mut self) -> bool {
        let mut is_any = false;
        loop {
            match self.events.try_recv() {
                Ok(RenderMessage::Event(event)) => self.take(*event),
                Ok(RenderMessage::Failed(text)) => {
                    self.log.push(text);
                    self.state = RunState::Ended("Nothing was rendered.".into());
                }
                Err(TryRecvError::Disconnected) if self.state == RunState::Running => {
                    self.state = RunState::Ended("Stopped by an internal error; render again to go on.".into());
                }
                Err(_) => return is_any,
            }
            is_any = true;
        }
    }

    fn take(&mut self, event: Event) {
        match event {
            Event::Started { device, frames, .. } => {
                self.frames = frames;
                self.log.push(format!("{device} draws {frames} frames"));
            }
            Event::Note { text } => self.log.push(text),
            Event::FrameRedone(_) => {}
            Event::FrameDone(report) => {
                self.done += 1;
                self.log.extend(report.warnings.iter().map(|text| format!("frame {}: {text}", report.frame)));
                self.log.push(format!("frame {}: {}", report.frame, report.path.display()));
                self.files.push(report.path);
            }
            Event::FrameFailed { frame, error } => {
                self.done += 1;
                self.log.push(format!("frame {frame}: {error}"));
            }
            Event::Finished(Summary { rendered, failed, is_cancelled, wall_secs, .. }) => {
                self.is_complete = failed == 0 && !is_cancelled;
                let end = if is_cancelled { "Cancelled" } else { "Done" };
                let failed = if failed == 0 { String::new() } else { format!(", {failed} failed") };
                self.state = RunState::Ended(format!("{end}: {rendered} frames in {wall_secs:.1} s{failed}"));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A render whose thread ended without a word.
    fn abandoned() -> RenderRun {
        let (_, events) = channel();
        let (cancel, state) = (Arc::default(), RunState::Running);
        RenderRun {
            shot: "a.toml".into(),
            events,
            cancel,
            frames: 77,
            done: 0,
            log: Vec::new(),
            state,
            is_complete: false,
            files: Vec::new(),
        }
    }

    #[test]
    fn a_render_that_died_has_ended() {
        let mut run = abandoned();
        assert!(run.pump());
        assert!(matches!(&run.state, RunState::Ended(words) if words.contains("internal error")), "{:?}", run.state);
        assert!(run.has_failed() && !run.pump(), "that is told once");
    }

    #[test]
    fn a_running_render_is_handed_over_and_one_that_ended_is_not() {
        let mut session = Session::of_text("scene = 'a.glb'\nframes = { first = 1, last = 24 }\n");
        session.run = Some(abandoned());
        let mut run = session.take_run().expect("it runs");
        assert!(!session.is_rendering() && session.run().is_none());
        run.pump();
        session.resume_run(run);
        assert!(!session.is_rendering() && session.take_run().is_none() && session.run().is_some());
    }

    #[test]
    fn a_running_render_is_not_replaced() {
        let mut session = Session::of_text("scene = 'a.glb'\nframes = { first = 1, last = 24 }\n");
        session.run = Some(abandoned());
        session.render(DeviceChoice::Cpu, || ());
        assert_eq!(session.run().map(|run| run.frames), Some(77));
    }
}
