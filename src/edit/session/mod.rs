//! The editor without its window: the open shot, what is chosen and seen, and everything a person can do to it.
//!
//! In: what the person does, what the thread of frames answers. Out: state that widgets draw. Nothing here knows of widgets.

mod arrange;
mod clipboard;
mod curves;
mod export_run;
mod gesture;
mod keying;
mod placing;
mod pointer;
mod render_run;
mod selection;
mod shown;

pub use arrange::MatteChoice;
pub use export_run::EXPORTS;
pub use keying::EasePreset;
pub use pointer::{Held, PinPart, Ring};
pub use render_run::{RenderRun, RunState};
pub use selection::Selection;
pub use shown::{Onion, Shown, Wipe};

use super::picture::{Picture, Quality};
use super::playhead::Playhead;
use super::reference::Reference;
use super::track::AutoKey;
use super::worker::{Job, Loaded, Purpose, Reply, SolvedFrame, Worker};
use super::zoom::Zoom;
use super::{Document, EditError};
use crate::raster::DeviceChoice;
use crate::shot::{PinKey, Shot, ShotError};
use gesture::Gesture;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Bytes of pictures that are kept for playing.
const PICTURE_BYTES: usize = 768 << 20;

/// Frames that are drawn ahead of the one that is seen.
const AHEAD: i32 = 240;

/// An open shot in an editor.
#[derive(Debug)]
pub struct Session {
    document: Document,
    worker: Worker,
    /// Which frame is seen.
    pub playhead: Playhead,
    /// How the picture lies in the viewport.
    pub zoom: Zoom,
    /// Size of the viewport, as it was drawn last.
    pub viewport: glam::DVec2,
    /// What is chosen.
    pub selection: Selection,
    /// What is drawn over the picture.
    pub shown: Shown,
    /// What a drag does to keys.
    pub auto_key: AutoKey,
    /// What is done to a pin is done to its counterpart on the other side, mirrored.
    pub mirrors: bool,
    /// Layers that rest while they are edited, by name.
    muted: BTreeSet<String>,
    /// The layer that alone is not muted.
    solo: Option<String>,
    /// Goes up whenever frames change.
    revision: u64,
    gesture: Gesture,
    /// The shot with keys under the hand.
    dragged: Option<Arc<Shot>>,
    pictures: BTreeMap<i32, Arc<Picture>>,
    before: Option<Arc<Picture>>,
    /// What is seen, until something newer is there.
    current: Option<Arc<Picture>>,
    solves: BTreeMap<i32, Arc<SolvedFrame>>,
    current_solve: Option<Arc<SolvedFrame>>,
    loaded: Arc<Loaded>,
    progress: Option<f64>,
    is_idle: bool,
    /// The shot file was written, perhaps by another program.
    is_written: bool,
    fault: Option<String>,
    message: Option<String>,
    /// Copied keys, by the names of their pins.
    copied: Vec<(String, Vec<PinKey>)>,
    run: Option<RenderRun>,
    /// What an export that runs will say.
    export: Option<std::sync::mpsc::Receiver<String>>,
    /// A picture to match by eye.
    pub reference: Option<Reference>,
    next_question: u64,
}

impl Session {
    /// Edits a document; `wake` is called whenever there is something new to see.
    #[must_use]
    pub fn new(document: Document, device: DeviceChoice, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let playhead = Playhead::new(&document.shot().frames);
        let mut session = Self {
            document,
            worker: Worker::start(device, wake),
            playhead,
            zoom: Zoom::default(),
            viewport: glam::DVec2::new(960.0, 540.0),
            selection: Selection::default(),
            shown: Shown::default(),
            auto_key: AutoKey::default(),
            mirrors: false,
            muted: BTreeSet::new(),
            solo: None,
            revision: 1,
            gesture: Gesture::Idle,
            dragged: None,
            pictures: BTreeMap::new(),
            before: None,
            current: None,
            solves: BTreeMap::new(),
            current_solve: None,
            loaded: Arc::default(),
            progress: None,
            is_idle: false,
            is_written: false,
            fault: None,
            message: None,
            copied: Vec::new(),
            run: None,
            export: None,
            reference: None,
            next_question: 0,
        };
        session.refresh(Purpose::Look);
        session
    }

    /// The open file.
    #[must_use]
    pub const fn document(&self) -> &Document {
        &self.document
    }

    /// What the document says, with keys under the hand.
    #[must_use]
    pub fn shot(&self) -> &Shot {
        self.dragged.as_deref().unwrap_or(self.document.shot())
    }

    /// The picture of the frame that is seen; while it is made, the last one.
    #[must_use]
    pub const fn picture(&self) -> Option<&Arc<Picture>> {
        self.current.as_ref()
    }

    /// The picture of another frame, where it is kept.
    #[must_use]
    pub fn picture_of(&self, frame: i32) -> Option<&Arc<Picture>> {
        self.pictures.get(&frame)
    }

    /// The frame that is seen, without any warp.
    #[must_use]
    pub fn before(&self) -> Option<&Arc<Picture>> {
        self.before.as_ref().filter(|picture| picture.frame == self.playhead.frame())
    }

    /// The solve of the frame that is seen; while it is made, the last one.
    #[must_use]
    pub const fn solve(&self) -> Option<&Arc<SolvedFrame>> {
        self.current_solve.as_ref()
    }

    /// Solves of all frames that were seen or drawn ahead since the last change.
    pub fn solves(&self) -> impl Iterator<Item = &Arc<SolvedFrame>> {
        self.solves.values()
    }

    /// What is known of the loaded shot.
    #[must_use]
    pub fn loaded(&self) -> &Loaded {
        &self.loaded
    }

    /// How much of the solve over time is done; `None`: there is nothing to do.
    #[must_use]
    pub const fn progress(&self) -> Option<f64> {
        self.progress
    }

    /// The thread of frames has nothing left to do.
    #[must_use]
    pub const fn is_idle(&self) -> bool {
        self.is_idle
    }

    /// Whether the shot file was written since the last call.
    pub const fn take_written(&mut self) -> bool {
        std::mem::replace(&mut self.is_written, false)
    }

    /// Why there is no picture of what the document says.
    #[must_use]
    pub fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    /// What the last action has to say.
    #[must_use]
    pub fn message(&self) -> Option<&str> {
        self.message.as_deref()
    }

    /// Says something to the person.
    pub fn say(&mut self, text: impl Into<String>) {
        self.message = Some(text.into());
    }

    /// The message was read.
    pub fn forget_message(&mut self) {
        self.message = None;
    }

    /// Takes what the thread of frames has to say. Gives whether anything changed.
    pub fn pump(&mut self) -> bool {
        let replies: Vec<Reply> = self.worker.replies().collect();
        let is_any = !replies.is_empty();
        replies.into_iter().for_each(|reply| self.take(reply));
        let has_run_on = self.run.as_mut().is_some_and(RenderRun::pump);
        self.pump_export() || is_any || has_run_on
    }

    /// Waits until the frame that is seen is there as it is rendered. False: it is not, after so long.
    pub fn settle(&mut self, longest: std::time::Duration) -> bool {
        let begun = std::time::Instant::now();
        while !self.is_final() && self.fault.is_none() {
            let Some(left) = longest.checked_sub(begun.elapsed()) else { return false };
            if let Some(reply) = self.worker.wait(left) {
                self.take(reply);
            }
        }
        self.fault.is_none()
    }

    /// What is seen is the rendered frame.
    #[must_use]
    pub fn is_final(&self) -> bool {
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
            Reply::Drawn(picture) => self.take_picture(picture),
            Reply::Before(picture) => self.before = Some(picture),
            Reply::Picked(id, point) => self.picked(id, point),
            Reply::Progress(part) => self.progress = (part < 1.0).then_some(part),
            Reply::Failed(text) => {
                self.fault = Some(text);
                self.progress = None;
            }
            Reply::Idle => self.is_idle = true,
            Reply::ShotWritten => self.is_written = true,
            Reply::SceneWritten => {
                self.reload();
                self.say("The scene changed on disk: it was read again.");
            }
        }
    }

    fn take_solve(&mut self, solved: Arc<SolvedFrame>) {
        if solved.revision != self.revision {
            return;
        }
        self.fault = None;
        if solved.frame == self.playhead.frame() {
            self.current_solve = Some(Arc::clone(&solved));
        }
        if solved.is_final {
            self.solves.insert(solved.frame, solved);
        }
    }

    fn take_picture(&mut self, picture: Arc<Picture>) {
        if picture.revision != self.revision {
            return;
        }
        // What was looked at already is not drawn coarsely again.
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

    /// Memory stays the same however long the shot is.
    fn forget_far_pictures(&mut self) {
        let here = self.playhead.frame();
        let mut bytes: usize = self.pictures.values().map(|picture| picture.rgba.len()).sum();
        while bytes > PICTURE_BYTES {
            let Some(far) = self.pictures.keys().copied().max_by_key(|frame| (frame - here).abs()) else { return };
            bytes -= self.pictures.remove(&far).map_or(0, |picture| picture.rgba.len());
        }
    }

    /// Frames hold something else from now on.
    fn frames_changed(&mut self) {
        self.revision += 1;
        self.pictures.clear();
        self.solves.clear();
        (self.before, self.fault) = (None, None);
    }

    /// Changes the document. What cannot be is told, and nothing changes.
    fn change(&mut self, label: &str, text: Result<String, ShotError>, series: Option<&str>) -> bool {
        match text.and_then(|text| self.document.change(label, text, series)) {
            Ok(()) => {
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
        self.playhead.follow(&shot.frames);
        self.selection.retain(shot);
        self.frames_changed();
        self.refresh(Purpose::Look);
    }

    /// Wants the frame that is seen.
    fn refresh(&mut self, purpose: Purpose) {
        self.is_idle = false;
        let mut shot = self.dragged.clone().unwrap_or_else(|| Arc::new(self.document.shot().clone()));
        if self.solo.is_some() || !self.muted.is_empty() {
            let shot = Arc::make_mut(&mut shot);
            for layer in &mut shot.layers {
                let is_heard = self.solo.as_ref().map_or(!self.muted.contains(&layer.name), |solo| *solo == layer.name);
                layer.strength *= f64::from(u8::from(is_heard));
            }
        }
        let next = match purpose {
            Purpose::Drag(_) => Vec::new(),
            Purpose::Look | Purpose::Play => self.frames_ahead(),
        };
        let with_before = self.shown.wipe != Wipe::Off && purpose == Purpose::Look;
        let (revision, frame) = (self.revision, self.playhead.frame());
        self.worker.want(Job { shot, revision, frame, purpose, next, with_before, is_shown: false });
    }

    /// Frames without a picture, in the order in which they would be played.
    fn frames_ahead(&self) -> Vec<i32> {
        let [first, last] = self.playhead.range();
        let count = last - first + 1;
        let here = self.playhead.frame() - first;
        let frames = (1..count.min(AHEAD)).map(|ahead| first + (here + ahead).rem_euclid(count));
        frames.filter(|frame| !self.pictures.contains_key(frame)).collect()
    }

    /// Goes to a frame.
    pub fn go(&mut self, frame: i32) {
        self.playhead.go(frame);
        self.frame_changed(Purpose::Look);
    }

    /// Goes so many frames on.
    pub fn step(&mut self, by: i32) {
        self.playhead.step(by);
        self.frame_changed(Purpose::Look);
    }

    /// Begins to play, or ends.
    pub fn toggle_play(&mut self, now_secs: f64) {
        self.playhead.toggle(now_secs);
        self.refresh(if self.playhead.is_playing() { Purpose::Play } else { Purpose::Look });
    }

    /// The clock goes on.
    pub fn tick(&mut self, now_secs: f64) {
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
        // While it plays, frames that are there need not be drawn again.
        if purpose == Purpose::Look || !self.pictures.contains_key(&frame) {
            self.refresh(purpose);
        }
    }

    /// Takes the last change back.
    pub fn undo(&mut self) {
        match self.document.undo() {
            Some(label) => self.went("Undone", &label),
            None => self.say("There is nothing to undo."),
        }
    }

    /// Does again what was undone.
    pub fn redo(&mut self) {
        match self.document.redo() {
            Some(label) => self.went("Done again", &label),
            None => self.say("There is nothing to do again."),
        }
    }

    fn went(&mut self, what: &str, label: &str) {
        self.gesture = Gesture::Idle;
        self.document_changed();
        self.say(format!("{what}: {label}"));
    }

    /// Writes the file.
    ///
    /// # Errors
    /// [`EditError`] where it cannot be written.
    pub fn save(&mut self) -> Result<(), EditError> {
        self.document.save()?;
        self.say(format!("Saved {}", self.document.path().display()));
        Ok(())
    }

    /// Writes another file, and goes on with that.
    ///
    /// # Errors
    /// As [`Self::save`].
    pub fn save_as(&mut self, path: &std::path::Path) -> Result<(), EditError> {
        self.document.save_as(path)?;
        self.document_changed();
        self.say(format!("Saved {}", path.display()));
        Ok(())
    }

    /// The document, for what only concerns its file.
    pub const fn document_mut(&mut self) -> &mut Document {
        &mut self.document
    }

    /// The document was read from disk again, or its scene.
    pub fn reload(&mut self) {
        self.worker.forget();
        self.document_changed();
    }
}
