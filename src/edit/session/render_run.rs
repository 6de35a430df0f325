//! Renders the sequence in the background, as `pinwarp render` does.
//!
//! In: a shot. Out: frames on disk, progress, a log.

use super::Session;
use crate::edit::render_hold::RenderHold;
use crate::edit::render_order::RenderOrder;
use crate::image::Existing;
use crate::pipeline::{Event, Pause, PreparedShot, RenderOptions, Summary, render};
use crate::raster::DeviceChoice;
use crate::shot::Shot;
use crate::spelling::pluralised;
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
    /// Holds it back while the view needs the processor.
    hold: RenderHold,
    /// Whether it writes previews.
    has_previews: bool,
    /// Number of requested frames.
    pub(crate) frames: usize,
    /// Number of frames processed.
    pub(crate) done: usize,
    /// Number of frames kept from an earlier render.
    kept: usize,
    /// How much of the solve over time is done, 0 to 1, while no frame is drawn yet.
    solved: Option<f64>,
    /// Where the frames go: a path with a place for the frame number.
    pub(crate) output: PathBuf,
    /// How the frames differ from what the window showed when it began.
    pub(crate) note: Option<String>,
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
    /// Progress of the solve over time, 0 to 1.
    Solved(f64),
    Failed(String),
}

impl Session {
    /// Renders what is ordered; existing frames that are up to date are kept. A render that is running goes on instead.
    pub(crate) fn render(
        &mut self,
        order: &RenderOrder,
        device: DeviceChoice,
        wake: impl Fn() + Send + Sync + 'static,
    ) {
        if self.is_rendering() {
            return;
        }
        let options = RenderOptions {
            frames: order.frames(&self.playhead),
            device,
            existing: Existing::Resume,
            has_preview: order.has_previews,
            ..RenderOptions::default()
        };
        let note = |solo: &str| {
            format!("Solo of '{solo}' is of the window alone: all layers that are not muted are rendered.")
        };
        let note = self.solo().map(note);
        self.run = Some(RenderRun { note, ..RenderRun::start(order.shot(self.document.shot()), options, wake) });
    }

    /// Returns whether the view needs the processor: while something is dragged, and until the frame is drawn.
    #[must_use]
    pub(crate) fn needs_processor(&self) -> bool {
        let is_seen = self.is_final() || self.playhead.is_playing() || self.fault.is_some();
        self.is_dragging() || !is_seen
    }

    /// Follows the render, and tells how it ended, whether its window is open or not. Returns whether anything changed.
    pub(super) fn pump_render(&mut self) -> bool {
        let needs_processor = self.needs_processor();
        let Some(run) = self.run.as_mut().filter(|run| run.is_running()) else { return false };
        run.yield_to_view(needs_processor);
        let is_any = run.pump();
        if let Some(told) = run.outcome() {
            self.say(told);
        }
        is_any
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

    /// Closes the log of the last render.
    pub(crate) fn close_render(&mut self) {
        if !self.is_rendering() {
            self.run = None;
        }
    }
}

impl RenderRun {
    fn start(shot: Shot, mut options: RenderOptions, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let (path, output, (sender, events)) = (shot.path.clone(), shot.output.path.clone(), channel());
        let cancel = Arc::new(AtomicBool::new(false));
        let count = if options.frames.is_empty() { shot.frames.count() } else { options.frames.len() };
        let (hold, has_previews, own_cancel) = (RenderHold::default(), options.has_preview, Arc::clone(&cancel));
        let is_held_back = {
            let (hold, cancel) = (hold.clone(), Arc::clone(&cancel));
            move || {
                let is_cancelled = || cancel.load(Ordering::Relaxed);
                hold.wait(is_cancelled);
                is_cancelled()
            }
        };
        let pause = is_held_back.clone();
        options.pause = Pause::new(move || _ = pause());
        let draw = move |send: &(dyn Fn(RenderMessage) + Sync)| {
            let outcome = PreparedShot::new(shot).and_then(|prepared| {
                render(&prepared, &options, &own_cancel, &|event| {
                    let is_begun = matches!(event, Event::Started { frames, .. } if frames > 0);
                    send(RenderMessage::Event(Box::new(event)));
                    if is_begun {
                        solve(&prepared, &is_held_back, send);
                    }
                })
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
        let (done, kept, files, is_complete) = (0, 0, Vec::new(), false);
        let (shot, frames, solved) = (path, count, None);
        Self {
            shot,
            events,
            cancel,
            hold,
            has_previews,
            frames,
            done,
            kept,
            solved,
            output,
            note: None,
            log,
            state,
            is_complete,
            files,
        }
    }

    /// Returns the part that is done, and what is being done: at first layers are solved over time.
    #[must_use]
    pub(crate) fn progress(&self) -> (f64, String) {
        match self.solved.filter(|_| self.done == 0) {
            Some(part) => (part, format!("solving over time, {:.0} %", 100.0 * part)),
            None => (self.done as f64 / self.frames.max(1) as f64, format!("frame {} / {}", self.done, self.frames)),
        }
    }

    /// Returns how it ended, and where its frames are; `None` while it is running.
    #[must_use]
    pub(crate) fn outcome(&self) -> Option<String> {
        let RunState::Ended(words) = &self.state else { return None };
        let folder = self.output.parent().unwrap_or(&self.output).display();
        Some(match self.is_complete {
            true => format!("Rendered: {} in {folder}", self.written()),
            false => format!("Render: {words}"),
        })
    }

    /// Returns what is on disk: frames that were written, of each kind, and frames that were kept.
    fn written(&self) -> String {
        let count = self.files.len();
        let frames = pluralised(count, "EXR frame", "EXR frames");
        let previews = self.has_previews.then(|| pluralised(count, "PNG preview", "PNG previews"));
        let kept = (self.kept > 0).then(|| format!("{} kept", pluralised(self.kept, "EXR frame", "EXR frames")));
        let written = previews.map_or(frames.clone(), |previews| format!("{frames} and {previews}"));
        match kept {
            Some(kept) if count == 0 => kept,
            Some(kept) => format!("{written}, {kept},"),
            None => written,
        }
    }

    /// Returns the name of its shot.
    #[must_use]
    pub(crate) fn name(&self) -> String {
        self.shot.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Holds it back while the view needs the processor.
    pub(crate) fn yield_to_view(&self, needs_processor: bool) {
        self.hold.set(needs_processor);
    }

    /// Returns whether it is running.
    #[must_use]
    pub(crate) fn is_running(&self) -> bool {
        self.state == RunState::Running
    }

    /// Returns whether frames of it are on disk.
    #[must_use]
    pub(crate) fn has_frames(&self) -> bool {
        self.kept > 0 || !self.files.is_empty()
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
                Ok(RenderMessage::Solved(part)) => self.solved = (part < 1.0).then_some(part),
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
            Event::Started { device, frames, kept } => {
                (self.frames, self.kept) = (frames, kept);
                let previews = if self.has_previews { ", each with a PNG preview" } else { "" };
                self.log.push(format!("{} to draw{previews}", pluralised(frames, "EXR frame", "EXR frames")));
                self.log.push(format!("Device: {device}"));
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

/// Solves the layers over time, which the frames then find solved. A fault is told with the first frame.
fn solve(prepared: &PreparedShot, is_cancelled: &(dyn Fn() -> bool + Sync), send: &(dyn Fn(RenderMessage) + Sync)) {
    if prepared.is_settled() {
        return;
    }
    send(RenderMessage::Solved(0.0));
    let progress = |part: f64| send(RenderMessage::Solved(part));
    if prepared.solve_trajectories(is_cancelled, &progress).is_err() {
        return;
    }
    send(RenderMessage::Solved(1.0));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::FrameReport;
    use crate::space::ScreenPoint;

    /// A render whose thread ended without a word.
    fn abandoned() -> RenderRun {
        let (_, events) = channel();
        let (cancel, state) = (Arc::default(), RunState::Running);
        RenderRun {
            shot: "a.toml".into(),
            events,
            cancel,
            hold: RenderHold::default(),
            has_previews: true,
            frames: 77,
            done: 0,
            kept: 0,
            solved: None,
            output: "out/a.####.exr".into(),
            note: None,
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
    fn the_stage_of_a_render_and_its_end_are_told() {
        let mut session = Session::of_text("scene = 'a.glb'\nframes = { first = 1, last = 24 }\n");
        let (sender, events) = channel();
        session.run = Some(RenderRun { events, ..abandoned() });
        let event = |event: Event| RenderMessage::Event(Box::new(event));
        let mut follow = |message: RenderMessage| {
            sender.send(message).expect("it listens");
            session.pump();
            (session.run().expect("it is kept").progress().1, session.message().map(str::to_owned))
        };
        let started = Event::Started { device: "CPU".into(), frames: 2, kept: 22 };
        assert_eq!(follow(event(started)).0, "frame 0 / 2");
        assert_eq!(follow(RenderMessage::Solved(0.684)).0, "solving over time, 68 %");
        assert_eq!(follow(RenderMessage::Solved(1.0)).0, "frame 0 / 2");
        for frame in [1, 2] {
            follow(event(Event::FrameDone(FrameReport { frame, ..FrameReport::default() })));
        }
        let (at, told) = follow(event(Event::Finished(Summary { rendered: 2, kept: 22, ..Summary::default() })));
        assert_eq!(
            (at.as_str(), told.as_deref()),
            ("frame 2 / 2", Some("Rendered: 2 EXR frames and 2 PNG previews, 22 EXR frames kept, in out"))
        );
        session.say("else");
        session.pump();
        assert_eq!(session.message(), Some("else"), "it is told once");
    }

    #[test]
    fn a_render_waits_while_the_view_needs_the_processor() {
        let mut session = Session::of_text("scene = 'a.glb'\nframes = { first = 1, last = 24 }\n");
        let (_sender, events) = channel();
        session.run = Some(RenderRun { events, ..abandoned() });
        let is_held = |session: &mut Session| {
            session.pump_render();
            session.run().is_some_and(|run| run.hold.is_on())
        };
        session.fault = None;
        assert!(is_held(&mut session), "the frame is not drawn yet");
        session.fault = Some("no scene".into());
        assert!(!is_held(&mut session), "there is nothing to wait for");
        session.drag_placed(ScreenPoint::new(0.5, 0.5));
        assert!(is_held(&mut session), "something is dragged");
        let hold = session.run().expect("it runs").hold.clone();
        let waits = std::thread::spawn(move || hold.wait(|| false));
        session.release();
        assert!(!is_held(&mut session));
        waits.join().expect("it goes on");
        let run = session.take_run().expect("it runs");
        run.yield_to_view(true);
        run.hold.wait(|| true);
    }

    #[test]
    fn a_running_render_is_not_replaced() {
        let mut session = Session::of_text("scene = 'a.glb'\nframes = { first = 1, last = 24 }\n");
        session.run = Some(abandoned());
        session.render(&RenderOrder::default(), DeviceChoice::Cpu, || ());
        assert_eq!(session.run().map(|run| run.frames), Some(77));
    }
}
