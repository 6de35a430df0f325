//! The editor without its window: the open shot, selection and view state, and all user operations.
//!
//! In: user input and replies of the worker thread. Out: state that widgets draw. Independent of the widget toolkit.

mod arrange;
mod carried;
mod channels;
mod clipboard;
mod corner;
mod curves;
mod export_run;
mod figures;
mod first_turns;
mod gesture;
mod handles;
mod key_steps;
mod keying;
mod lattice_space;
mod new_layer;
mod overtaken;
mod painting;
mod placing;
mod plates;
mod pointer;
mod references;
mod regions;
mod render_run;
mod rings;
mod saving;
mod selection;
mod shot_settings;
mod shown;
mod weights;
mod wording;

pub(crate) use arrange::MatteChoice;
pub(crate) use figures::Figure;
pub(crate) use key_steps::CurveUnit;
pub(crate) use key_steps::KeyStep;
pub(crate) use keying::EasePreset;
pub(crate) use painting::Brush;
pub(crate) use painting::{BRUSH_RADII, BRUSH_STIFFNESSES};
pub(crate) use pointer::{Held, PinPart, Ring};
pub(crate) use render_run::{RenderRun, RunState};
pub(crate) use selection::Selection;
pub(crate) use shown::Shown;
pub(crate) use shown::{Onion, Wipe};

use super::Document;
use super::picture::{Picture, Quality};
use super::playhead::Playhead;
use super::reference::Reference;
use super::track::AutoKey;
use super::worker::{Job, Loaded, Purpose, Reply, SolvedFrame, Worker};
use super::zoom::Zoom;
use crate::pipeline::LayerShift;
use crate::raster::DeviceChoice;
use crate::shot::{Shot, ShotError};
use gesture::Gesture;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

/// Maximum bytes of pictures cached for playback.
const PICTURE_BYTES: usize = 768 << 20;

/// Number of frames drawn ahead of the current one.
const AHEAD: i32 = 240;

/// An open shot in an editor.
#[derive(Debug)]
pub(crate) struct Session {
    document: Document,
    worker: Worker,
    /// The current frame.
    pub playhead: Playhead,
    /// Zoom and pan of the picture in the viewport.
    pub zoom: Zoom,
    /// Size of the viewport when last drawn.
    pub(crate) viewport: glam::DVec2,
    /// The selection.
    pub selection: Selection,
    /// What is drawn over the picture.
    pub shown: Shown,
    /// How a drag affects keys.
    pub(crate) auto_key: AutoKey,
    /// Whether edits of a pin are mirrored to its counterpart on the other side.
    pub mirrors: bool,
    /// The brush for stiffness.
    pub brush: Brush,
    /// The painted triangles that are known.
    painted: Option<painting::PaintedFrame>,
    /// Revision and frame for which they were requested last.
    painted_asked: Option<(u64, i32)>,
    /// The soloed layer.
    solo: Option<String>,
    /// Incremented whenever frames change.
    revision: u64,
    gesture: Gesture,
    overtaken: overtaken::Overtaken,
    /// The shot with the keys of the drag in progress.
    dragged: Option<Arc<Shot>>,
    pictures: BTreeMap<i32, Arc<Picture>>,
    before: Option<Arc<Picture>>,
    /// The displayed picture, until a newer one arrives.
    current: Option<Arc<Picture>>,
    solves: BTreeMap<i32, Arc<SolvedFrame>>,
    current_solve: Option<Arc<SolvedFrame>>,
    figures: figures::Figures,
    turns: first_turns::KeyedTurns,
    /// By how much a frame differs since it is solved over time.
    shifts: Option<(i32, Vec<LayerShift>)>,
    loaded: Arc<Loaded>,
    progress: Option<(u64, f64)>,
    is_idle: bool,
    /// Whether replies are left unread, for a picture of the window that does not depend on when it is taken.
    is_held: bool,
    /// Whether the shot file was written, possibly by another program.
    is_written: bool,
    /// The text on disk, if another program wrote it where there are unsaved changes: the user has to decide.
    pub(crate) conflict: Option<String>,
    fault: Option<String>,
    message: Option<String>,
    /// The weights that pins had when they were soft last, by the names of layer and pin.
    soft: BTreeMap<(String, String), f64>,
    /// Copied keys.
    copied: Vec<clipboard::Copied>,
    run: Option<RenderRun>,
    export: export_run::ExportRun,
    /// The reference pictures, the first one at the bottom.
    pub(crate) references: Vec<Reference>,
    next_question: u64,
}

impl Session {
    /// Edits a document; `wake` is called whenever there is something new to display.
    #[must_use]
    pub(crate) fn new(mut document: Document, device: DeviceChoice, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let playhead = Playhead::new(&document.shot().frames);
        let scene = document.take_scene();
        let mut session = Self {
            document,
            worker: Worker::start((device, scene), wake),
            playhead,
            zoom: Zoom::default(),
            viewport: glam::DVec2::new(960.0, 540.0),
            selection: Selection::default(),
            shown: Shown::default(),
            auto_key: AutoKey::default(),
            mirrors: false,
            brush: Brush::default(),
            painted: None,
            painted_asked: None,
            solo: None,
            revision: 1,
            gesture: Gesture::Idle,
            overtaken: overtaken::Overtaken::default(),
            dragged: None,
            pictures: BTreeMap::new(),
            before: None,
            current: None,
            solves: BTreeMap::new(),
            current_solve: None,
            figures: figures::Figures::default(),
            turns: first_turns::KeyedTurns::default(),
            shifts: None,
            loaded: Arc::default(),
            progress: None,
            is_idle: false,
            is_held: false,
            is_written: false,
            conflict: None,
            fault: None,
            message: None,
            soft: BTreeMap::new(),
            copied: Vec::new(),
            run: None,
            export: export_run::ExportRun::default(),
            references: Vec::new(),
            next_question: 0,
        };
        session.refresh(Purpose::Look);
        session
    }

    /// Edits a text without a file, whose scene is missing.
    #[cfg(test)]
    pub(in crate::edit) fn of_text(text: &str) -> Self {
        let document = Document::new(std::path::Path::new("shot.toml"), text.to_owned()).expect("a shot");
        Self::new(document, DeviceChoice::Cpu, || ())
    }

    /// Returns the open document.
    #[must_use]
    pub(crate) const fn document(&self) -> &Document {
        &self.document
    }

    /// Returns the shot, including the drag in progress.
    #[must_use]
    pub(crate) fn shot(&self) -> &Shot {
        self.dragged.as_deref().unwrap_or(self.document.shot())
    }

    /// Returns the picture of the current frame; until it is drawn, the previous one.
    #[must_use]
    pub(crate) const fn picture(&self) -> Option<&Arc<Picture>> {
        self.current.as_ref()
    }

    /// Returns the cached picture of another frame.
    #[must_use]
    pub(crate) fn picture_of(&self, frame: i32) -> Option<&Arc<Picture>> {
        self.pictures.get(&frame)
    }

    /// Returns the frames with a cached picture, in order.
    pub(crate) fn drawn_frames(&self) -> impl Iterator<Item = i32> {
        self.pictures.keys().copied()
    }

    /// Returns the unwarped picture of the current frame.
    #[must_use]
    pub(crate) fn before(&self) -> Option<&Arc<Picture>> {
        self.before.as_ref().filter(|picture| picture.frame == self.playhead.frame())
    }

    /// Returns the solve of the current frame; until it is done, the previous one.
    #[must_use]
    pub(crate) const fn solve(&self) -> Option<&Arc<SolvedFrame>> {
        self.current_solve.as_ref()
    }

    /// Returns the solves of all frames since the last change.
    pub(crate) fn solves(&self) -> impl Iterator<Item = &Arc<SolvedFrame>> {
        self.solves.values()
    }

    /// Returns information about the loaded shot.
    #[must_use]
    pub(crate) fn loaded(&self) -> &Loaded {
        &self.loaded
    }

    /// Returns the progress of the solve over time, 0 to 1; `None` if there is none to do.
    #[must_use]
    pub(crate) fn progress(&self) -> Option<f64> {
        self.progress.filter(|(revision, _)| *revision == self.revision).map(|(_, part)| part)
    }

    /// Returns whether the worker thread is idle.
    #[cfg(test)]
    #[must_use]
    pub(crate) const fn is_idle(&self) -> bool {
        self.is_idle
    }

    /// Returns whether the shot file was written since the last call.
    pub(crate) const fn take_written(&mut self) -> bool {
        std::mem::replace(&mut self.is_written, false)
    }

    /// Returns the error that prevents drawing the document.
    #[must_use]
    pub(crate) fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    /// Returns the message of the last action.
    #[must_use]
    pub(crate) fn message(&self) -> Option<&str> {
        self.message.as_deref()
    }

    /// Sets a message for the user.
    pub(crate) fn say(&mut self, text: impl Into<String>) {
        self.message = Some(text.into());
    }

    /// Processes the replies of the worker thread. Returns whether anything changed.
    pub(crate) fn pump(&mut self) -> bool {
        if self.is_held {
            return false;
        }
        let replies: Vec<Reply> = self.worker.replies().collect();
        let is_any = !replies.is_empty();
        replies.into_iter().for_each(|reply| self.take(reply));
        self.notice_ended_worker();
        let has_run_on = self.pump_render();
        self.pump_export() || is_any || has_run_on
    }

    /// Waits until the current frame is displayed as rendered. Returns false on a timeout or an error.
    pub(crate) fn settle(&mut self, longest: std::time::Duration) -> bool {
        let begun = std::time::Instant::now();
        while !self.is_final() && self.fault.is_none() {
            let Some(left) = longest.checked_sub(begun.elapsed()) else { return false };
            if let Some(reply) = self.worker.wait(left) {
                self.take(reply);
            }
            self.notice_ended_worker();
        }
        self.fault.is_none()
    }

    /// Leaves everything as it is shown now: later replies are not read.
    pub(crate) const fn hold(&mut self) {
        self.is_held = true;
    }

    /// Turns the end of the worker thread into a fault.
    fn notice_ended_worker(&mut self) {
        if self.fault.is_none() && self.worker.has_ended() {
            self.fault = Some("Nothing can be drawn any more; save the shot and open it again.".into());
            self.progress = None;
        }
    }

    /// Returns whether the displayed picture is the rendered frame.
    #[must_use]
    pub(crate) fn is_final(&self) -> bool {
        let is_current = |picture: &Arc<Picture>| {
            picture.quality == Quality::Final
                && picture.revision == self.revision
                && picture.frame == self.playhead.frame()
        };
        self.current.as_ref().is_some_and(is_current)
    }

    fn take(&mut self, reply: Reply) {
        match reply {
            Reply::Loaded(loaded) => self.loaded = loaded,
            Reply::Solved(solved) => self.take_solve(solved),
            Reply::Reported(revision, frame, report) if revision == self.revision => {
                self.take_figures(frame, &report);
            }
            Reply::Reported(..) => {}
            Reply::Drawn(picture) => self.take_picture(picture),
            Reply::Before(picture) => self.before = Some(picture),
            Reply::Picked(id, point) => self.picked(id, point),
            Reply::KeyedTurns { id, layer, turns } => self.take_turns(id, layer, turns),
            Reply::Brushed { id, point, mirrored } => self.brushed(id, point.map(|point| (point, mirrored))),
            Reply::Painted { revision, frame, triangles } => self.take_painted((revision, frame), triangles),
            Reply::Progress(revision, part) => self.progress = (part < 1.0).then_some((revision, part)),
            Reply::Failed(text) => {
                self.fault = Some(text);
                self.progress = None;
            }
            Reply::Shifted(revision, frame, shifts) if revision == self.revision => self.shifts = Some((frame, shifts)),
            Reply::Shifted(..) => {}
            Reply::Idle => self.is_idle = true,
            Reply::ShotWritten => self.is_written = true,
            Reply::SceneWritten => {
                self.reload();
                self.say("The scene changed on disk and was reloaded.");
            }
            Reply::PlatesWritten(changed) => self.plates_changed(&changed),
        }
    }

    fn take_solve(&mut self, solved: Arc<SolvedFrame>) {
        if solved.revision != self.revision {
            return;
        }
        self.fault = None;
        if solved.frame == self.playhead.frame() {
            self.current_solve = Some(Arc::clone(&solved));
            self.carry_pins();
        }
        if solved.is_final {
            self.take_figures(solved.frame, &solved.report);
            self.solves.insert(solved.frame, solved);
        }
    }

    fn take_picture(&mut self, picture: Arc<Picture>) {
        if picture.revision != self.revision {
            return;
        }
        // A frame that was already displayed at a higher quality is not replaced by a coarse one.
        let is_seen_better = self.current.as_ref().is_some_and(|seen| {
            seen.frame == picture.frame && seen.revision == picture.revision && seen.quality > picture.quality
        });
        if picture.frame == self.playhead.frame() && !is_seen_better {
            self.current = Some(Arc::clone(&picture));
        }
        let is_better = |known: &Arc<Picture>| known.quality <= picture.quality;
        if self.dragged.is_none() && self.pictures.get(&picture.frame).is_none_or(is_better) {
            self.pictures.insert(picture.frame, picture);
            self.forget_far_pictures();
        }
    }

    /// Bounds the memory used, however long the shot is.
    fn forget_far_pictures(&mut self) {
        let here = self.playhead.frame();
        let mut bytes: usize = self.pictures.values().map(|picture| picture.rgba.len()).sum();
        while bytes > PICTURE_BYTES {
            let Some(far) = self.pictures.keys().copied().max_by_key(|frame| (frame - here).abs()) else { return };
            bytes -= self.pictures.remove(&far).map_or(0, |picture| picture.rgba.len());
        }
    }

    /// Invalidates all frames.
    fn frames_changed(&mut self) {
        self.revision += 1;
        self.pictures.clear();
        self.solves.clear();
        self.figures.clear();
        self.turns.clear();
        self.leave_rendered();
        (self.before, self.fault, self.shifts) = (None, None, None);
    }

    /// Changes the document. An invalid change is reported and has no effect.
    fn change(&mut self, label: &str, text: Result<String, ShotError>, series: Option<&str>) -> bool {
        match text.and_then(|text| self.document.change(label, text, series)) {
            Ok(()) => {
                // What was said about an earlier action holds no longer.
                self.message = None;
                self.document_changed();
                true
            }
            Err(error) => {
                self.say(error.to_string());
                self.dragged = None;
                self.refresh(Purpose::Look);
                false
            }
        }
    }

    fn document_changed(&mut self) {
        self.dragged = None;
        let shot = self.document.shot();
        self.gesture.follow(shot);
        self.playhead.follow(&shot.frames);
        self.selection.retain(shot);
        self.forget_missing_layers();
        self.frames_changed();
        self.refresh(Purpose::Look);
    }

    /// Requests the current frame.
    fn refresh(&mut self, purpose: Purpose) {
        self.is_idle = false;
        let mut shot = self.dragged.clone().unwrap_or_else(|| Arc::new(self.document.shot().clone()));
        if let Some(solo) = &self.solo {
            for layer in Arc::make_mut(&mut shot).layers.iter_mut().filter(|layer| layer.name != *solo) {
                layer.strength = 0.0;
            }
        }
        let (next, reports) = match purpose {
            Purpose::Drag(_) | Purpose::Paint => (VecDeque::new(), VecDeque::new()),
            Purpose::Look | Purpose::Play => (self.frames_ahead(), self.frames_without_report()),
        };
        let with_before = self.wants_before() && purpose == Purpose::Look;
        let (revision, frame) = (self.revision, self.playhead.frame());
        self.worker.want(Job { shot, revision, frame, purpose, next, reports, with_before, is_shown: false });
    }

    /// Returns the frames without a picture, in playback order.
    fn frames_ahead(&self) -> VecDeque<i32> {
        let [first, last] = self.playhead.range();
        let count = last - first + 1;
        let here = self.playhead.frame() - first;
        let frames = (1..count.min(AHEAD)).map(|ahead| first + (here + ahead).rem_euclid(count));
        frames.filter(|frame| !self.pictures.contains_key(frame)).collect()
    }

    /// Goes to a frame.
    pub(crate) fn go(&mut self, frame: i32) {
        self.playhead.go(frame);
        self.frame_changed(Purpose::Look);
    }

    /// Moves by a number of frames.
    pub(crate) fn step(&mut self, by: i32) {
        self.playhead.step(by);
        self.frame_changed(Purpose::Look);
    }

    /// Starts or stops playback.
    pub(crate) fn toggle_play(&mut self, now_secs: f64) {
        self.playhead.toggle(now_secs);
        self.refresh(if self.playhead.is_playing() { Purpose::Play } else { Purpose::Look });
    }

    /// Advances playback to the time `now_secs`.
    pub(crate) fn tick(&mut self, now_secs: f64) {
        let is_ready = self.current.as_ref().is_some_and(|picture| picture.frame == self.playhead.frame());
        if self.playhead.tick(now_secs, is_ready) {
            self.frame_changed(Purpose::Play);
        }
    }

    fn frame_changed(&mut self, purpose: Purpose) {
        self.document.end_series();
        let frame = self.playhead.frame();
        if let Some(picture) = self.pictures.get(&frame) {
            self.current = Some(Arc::clone(picture));
        }
        if let Some(solve) = self.solves.get(&frame) {
            self.current_solve = Some(Arc::clone(solve));
        }
        // During playback, frames that are cached need not be drawn again.
        if purpose == Purpose::Look || !self.pictures.contains_key(&frame) {
            self.refresh(purpose);
        }
    }

    /// Undoes the last change; during a drag, that drag alone.
    pub(crate) fn undo(&mut self) {
        if self.dragged.is_some() && !self.gesture.is_idle() {
            self.cancel();
            return self.say("Undone: the drag");
        }
        if self.take_back_click() {
            return self.say("Undone: the click");
        }
        match self.document.undo() {
            Some(label) => self.went("Undone", &label),
            None => self.say("Nothing to undo."),
        }
    }

    /// Redoes the change undone last.
    pub(crate) fn redo(&mut self) {
        match self.document.redo() {
            Some(label) => self.went("Redone", &label),
            None => self.say("Nothing to redo."),
        }
    }

    fn went(&mut self, what: &str, label: &str) {
        self.gesture = Gesture::Idle;
        self.document_changed();
        self.say(format!("{what}: {label}"));
    }

    /// Returns the document, for operations on its file only.
    pub(crate) const fn document_mut(&mut self) -> &mut Document {
        &mut self.document
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, Instant};

    #[test]
    fn a_worker_that_ended_is_a_fault() {
        let mut session = Session::of_text("scene = 'a.glb'\nframes = { first = 1, last = 24 }\n");
        session.worker.end();
        let begun = Instant::now();
        while !session.worker.has_ended() {
            assert!(begun.elapsed() < Duration::from_secs(60));
            std::thread::yield_now();
        }
        // Replies that it sent before are gone.
        session.pump();
        session.frames_changed();
        assert!(session.fault().is_none() && !session.settle(Duration::from_secs(60)));
        assert!(session.fault().is_some_and(|fault| fault.contains("open it again")), "{:?}", session.fault());
    }
}
