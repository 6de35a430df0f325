//! The worker thread's processing of jobs.
//!
//! In: an [`Inbox`]. Out: replies through a [`ReplySender`]. Long operations poll for a newer job.

use super::draft_size::DraftSize;
use super::drag_solve::DragSolve;
use super::file_watch::{Changed, FileWatch};
use super::keyed_poses::{held_places, turns};
use super::mail::{
    FoundPoint, Inbox, Interrupts, Job, Loaded, Purpose, Question, Queue, Reply, ReplySender, SolvedFrame,
};
use crate::edit::frame_runs::pop_frame;
use crate::edit::picture::{Picture, Quality};
use crate::pipeline::{
    Draft, FrameReport, JerkMeter, LayerMarks, OpenShot, PickedPoint, PipelineError, Rework, TimeSample, layer_marks,
    report, resting_marks,
};
use crate::raster::geometry::KeptParts;
use crate::raster::{self, DeviceChoice, Raster};
use crate::scene::{self, Scene};
use crate::shot::{LayerSpace, Shot, Source};
use crate::space::FrameSize;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

/// Time budget of a frame during a drag, solve included, in milliseconds.
const DRAG_MS: f64 = 22.0;

/// Time budget of a frame during playback, in milliseconds.
const PLAY_MS: f64 = 30.0;

/// Time budget of the first draft of a displayed frame, in milliseconds.
const LOOK_MS: f64 = 80.0;

/// Time of the smallest draft above which pictures of the layers are warped in place of drawing the scene, in milliseconds.
const SLOW_MS: f64 = 150.0;

/// Idle time before the files are checked for changes.
const WATCH: Duration = Duration::from_secs(1);

/// Loads, solves and draws.
pub(super) struct FrameWorker {
    choice: DeviceChoice,
    /// The scene of the first job, if it is loaded already.
    loaded: Option<Scene>,
    open: Option<OpenShot>,
    device: Option<Box<dyn Raster + Send>>,
    drag: Option<DragSolve>,
    drafts: DraftSize,
    /// Milliseconds that warping pictures of the layers took last, 0 before.
    still_ms: f64,
    jerk: JerkMeter,
    /// The frame solved last, for questions; `None` if the shot changed since.
    seen: Option<(i32, Arc<TimeSample>)>,
    watch: FileWatch,
}

/// The next task from the inbox.
enum Task {
    Job(Job, u64),
    Answer(Question),
    /// Nothing arrived for a while.
    Watch,
    Over,
}

/// A solved time of a frame, at a revision of the document.
#[derive(Clone, Copy)]
struct SolvedTime<'a> {
    frame: i32,
    revision: u64,
    sample: &'a TimeSample,
    /// Whether it is what a render would show.
    is_final: bool,
}

impl<'a> SolvedTime<'a> {
    /// Returns the frame of a job while it is dragged.
    fn of_drag(job: &Job, drag: &'a DragSolve) -> Self {
        Self { frame: job.frame, revision: job.revision, sample: drag.sample(), is_final: false }
    }
}

/// A draft to draw.
#[derive(Clone, Copy)]
struct DraftOrder<'a> {
    solved: SolvedTime<'a>,
    /// Parts that have been built for this time before.
    kept: &'a KeptParts,
    /// Time budget in milliseconds.
    longest_ms: f64,
}

impl FrameWorker {
    pub(super) fn new(choice: DeviceChoice, loaded: Option<Scene>) -> Self {
        let (open, device, drag, seen) = (None, None, None, None);
        Self {
            choice,
            loaded,
            open,
            device,
            drag,
            drafts: DraftSize::default(),
            still_ms: 0.0,
            jerk: JerkMeter::default(),
            seen,
            watch: FileWatch::default(),
        }
    }

    /// Processes the inbox until the window closes.
    pub(super) fn run(mut self, inbox: &Inbox, sender: &ReplySender) {
        loop {
            match next(inbox, &mut self.open) {
                Task::Over => return,
                Task::Watch => self.look_at_files(sender),
                Task::Answer(question) => sender.send(self.answer(question)),
                Task::Job(mut job, serial) => {
                    let interrupts = Interrupts { inbox, serial };
                    if let Err(error) = self.work(&mut job, &interrupts, sender)
                        && !interrupts.is_stale()
                    {
                        sender.send(Reply::Failed(error.to_string()));
                    }
                    if interrupts.is_stale() {
                        put_back(inbox, job);
                    } else {
                        sender.send(Reply::Idle);
                    }
                }
            }
        }
    }

    fn look_at_files(&mut self, sender: &ReplySender) {
        let Changed { shot, scene, plates } = self.watch.look();
        shot.then(|| sender.send(Reply::ShotWritten));
        scene.then(|| sender.send(Reply::SceneWritten));
        (!plates.is_empty()).then(|| sender.send(Reply::PlatesWritten(plates)));
    }

    fn work(&mut self, job: &mut Job, interrupts: &Interrupts, sender: &ReplySender) -> Result<(), PipelineError> {
        self.load(job, sender)?;
        match job.purpose.clone() {
            Purpose::Drag(layers) => return self.drag(job, &layers, sender),
            Purpose::Paint => return self.paint(job, sender),
            Purpose::Play => self.play_frame(job.frame, job, sender)?,
            Purpose::Look if job.is_shown => {}
            Purpose::Look => job.is_shown = self.look(job, interrupts, sender)?,
        }
        // Each frame leaves the list before it is drawn, in case a question interrupts.
        while !interrupts.is_stale()
            && let Some(next) = job.next.pop_front()
        {
            self.play_frame(next, job, sender)?;
        }
        // Before the range is solved over time, reports would not match the rendered frames.
        let is_settled = self.open.as_ref().is_some_and(|open| open.prepared().is_settled());
        let mut looked = Instant::now();
        while is_settled
            && !interrupts.is_stale()
            && let Some(frame) = pop_frame(&mut job.reports)
        {
            self.report_frame(frame, job.revision, sender);
            if looked.elapsed() >= WATCH {
                self.look_at_files(sender);
                looked = Instant::now();
            }
        }
        Ok(())
    }

    /// Updates the loaded shot to the job's.
    fn load(&mut self, job: &Job, sender: &ReplySender) -> Result<(), PipelineError> {
        let shot = wanted_shot(job);
        // What cannot be loaded is watched, too: it may be mended on disk.
        let is_other = self.watch.add(&shot, &self.files_beside(&shot));
        self.watch.follow_plate(&shot);
        let rework = match &mut self.open {
            Some(open) => open.edit(shot)?,
            None => {
                self.open = Some(match self.loaded.take() {
                    Some(scene) => OpenShot::with_scene(shot, scene)?,
                    None => OpenShot::new(shot)?,
                });
                Rework::Scene
            }
        };
        if rework >= Rework::Stiffness {
            self.drag = None;
        }
        // A drag changes the keys of its own layers alone.
        if rework > Rework::Nothing && !matches!(job.purpose, Purpose::Drag(_) | Purpose::Paint) {
            self.set_drag_aside(job.frame);
        }
        // The brush goes on over the frame that is seen.
        if rework > Rework::Nothing && job.purpose != Purpose::Paint {
            self.seen = None;
        }
        if rework > Rework::Nothing {
            // The frames that it remembers are those of the old shot.
            self.jerk = JerkMeter::default();
        }
        let Some(open) = &self.open else { return Ok(()) };
        if rework == Rework::Scene {
            self.device = None;
            if open.prepared().needs_raster() {
                self.device = Some(raster::open(&self.choice, &open.prepared().scene)?.0);
            }
            (self.drafts, self.still_ms) = (DraftSize::default(), 0.0);
        }
        if rework == Rework::Scene || is_other {
            self.watch.keep(open.given(), &open.prepared().scene.files_beside);
        }
        if rework >= Rework::Pins {
            sender.send(Reply::Loaded(Arc::new(self.facts(open))));
        }
        Ok(())
    }

    /// Returns the files beside the scene of a shot that is about to be loaded; none if they are watched already, or the scene cannot be
    /// read.
    fn files_beside(&self, shot: &Shot) -> Vec<PathBuf> {
        match (&self.open, &self.loaded, &shot.source) {
            (Some(open), _, source) if open.given().source == *source && self.watch.is_of(shot) => Vec::new(),
            // Saved elsewhere: what is watched begins anew, even if this edit cannot be loaded.
            (Some(open), _, source) if open.given().source == *source => open.prepared().scene.files_beside.clone(),
            (None, Some(scene), _) => scene.files_beside.clone(),
            (_, _, Source::Scene(scene)) => scene::files_beside(scene).unwrap_or_default(),
            (_, _, Source::Images(_) | Source::Frame) => Vec::new(),
        }
    }

    fn facts(&self, open: &OpenShot) -> Loaded {
        let (scene, shot) = (&open.prepared().scene, &open.prepared().shot);
        let cameras = scene.nodes.iter().filter(|node| node.camera.is_some());
        Loaded {
            nodes: open.drawn_nodes().map(|(name, is_hidden)| (name.to_owned(), is_hidden)).collect(),
            offers: open.layer_offers(),
            dims: shot.layers.iter().map(|layer| (layer.name.clone(), layer.space.dims())).collect(),
            can_branch: open.can_branch(),
            clips: scene.clips.iter().map(|clip| (clip.name.clone(), f64::from(clip.end_secs))).collect(),
            cameras: cameras.map(|node| node.name.clone()).collect(),
            device: self.device.as_ref().map_or_else(|| "CPU".into(), |device| device.name()),
        }
    }

    /// Keeps what the next drag of a frame needs, while other layers may change.
    fn set_drag_aside(&mut self, frame: i32) {
        let prepared = self.open.as_ref().map(OpenShot::prepared);
        self.drag = self.drag.take().zip(prepared).and_then(|(drag, prepared)| drag.set_aside(prepared, frame));
    }

    /// Returns a frame solved for itself. What it took is kept for drags.
    fn provisional(&mut self, frame: i32) -> Result<Option<Arc<TimeSample>>, PipelineError> {
        let Some(open) = &self.open else { return Ok(None) };
        let prepared = open.prepared();
        let kept = self.drag.take();
        let solved = kept.and_then(|mut drag| drag.solve_all(prepared).is_ok().then_some(drag));
        let drag = match solved {
            Some(drag) => drag,
            None => DragSolve::look(prepared, frame)?,
        };
        Ok(Some(Arc::clone(self.drag.insert(drag).sample())))
    }

    /// Draws a draft, then the rendered frame. Returns false if a newer message interrupted it.
    fn look(&mut self, job: &Job, interrupts: &Interrupts, sender: &ReplySender) -> Result<bool, PipelineError> {
        self.seen = None;
        self.set_drag_aside(job.frame);
        let Some(open) = &self.open else { return Ok(false) };
        let was_settled = open.prepared().is_settled();
        let settled = if was_settled { Some(open.prepared().mid_exposure(job.frame)?) } else { None };
        let Some(sample) = settled.map_or_else(|| self.provisional(job.frame), |sample| Ok(Some(sample)))? else {
            return Ok(false);
        };
        self.seen = Some((job.frame, Arc::clone(&sample)));
        let (frame, revision) = (job.frame, job.revision);
        let solved = SolvedTime { frame, revision, sample: &sample, is_final: was_settled };
        self.send_solved(solved, sender);
        let is_unwanted = || interrupts.is_pen_waiting();
        self.draw(DraftOrder { solved, kept: &KeptParts::default(), longest_ms: LOOK_MS }, &is_unwanted, sender)?;
        let is_stale = || interrupts.is_stale();
        if is_stale() {
            return Ok(false);
        }
        let Some(open) = &self.open else { return Ok(false) };
        let prepared = open.prepared();
        if !was_settled {
            let progress = |part: f64| sender.send(Reply::Progress(job.revision, part));
            if !prepared.solve_trajectories(&is_stale, &progress)? {
                return Ok(false);
            }
            progress(1.0);
            let shown = sample;
            let sample = prepared.mid_exposure(job.frame)?;
            let shifts = prepared.layer_shifts([&shown, &sample]);
            sender.send(Reply::Shifted(job.revision, job.frame, shifts));
            self.seen = Some((job.frame, Arc::clone(&sample)));
            self.send_solved(SolvedTime { frame, revision, sample: &sample, is_final: true }, sender);
            self.set_drag_aside(job.frame);
        }
        let Some(open) = &self.open else { return Ok(false) };
        let drawn = open.prepared().finished(self.device.as_deref_mut(), job.frame, &is_stale)?;
        let Some(frame) = drawn else { return Ok(false) };
        if job.with_before {
            self.send_before(job, sender)?;
        }
        sender.send(Reply::Drawn(Arc::new(Picture::of(&frame, (job.frame, job.revision), Quality::Final))));
        Ok(true)
    }

    fn send_before(&mut self, job: &Job, sender: &ReplySender) -> Result<(), PipelineError> {
        let Some(open) = &self.open else { return Ok(()) };
        let prepared = open.prepared();
        let sample = prepared.unsolved_at(prepared.mid_exposure_time(f64::from(job.frame)))?;
        let draft = Draft { sample: &sample, kept: &KeptParts::default(), size: prepared.shot.size };
        let drawn = prepared.draft(self.device.as_deref_mut(), draft, &|| false)?;
        let picture = drawn.map(|drawn| Picture::of(&drawn, (job.frame, job.revision), Quality::Draft));
        picture.into_iter().for_each(|picture| sender.send(Reply::Before(Arc::new(picture))));
        Ok(())
    }

    fn play_frame(&mut self, frame: i32, job: &Job, sender: &ReplySender) -> Result<(), PipelineError> {
        let Some(open) = &self.open else { return Ok(()) };
        let prepared = open.prepared();
        let is_settled = prepared.is_settled();
        let sample = if is_settled { prepared.mid_exposure(frame)? } else { Arc::new(prepared.provisional(frame)?) };
        let solved = SolvedTime { frame, revision: job.revision, sample: &sample, is_final: is_settled };
        self.send_solved(solved, sender);
        self.draw(DraftOrder { solved, kept: &KeptParts::default(), longest_ms: PLAY_MS }, &|| false, sender)
    }

    /// Reports a frame without drawing it. The report of one that cannot be solved has no figures; who goes there is told why.
    fn report_frame(&mut self, frame: i32, revision: u64, sender: &ReplySender) {
        let Some(open) = &self.open else { return };
        let mut told = FrameReport { frame, ..FrameReport::default() };
        if let Ok(sample) = open.prepared().mid_exposure(frame) {
            told = report(open.prepared(), frame, &sample);
            self.jerk.watch(open.prepared(), &sample, &mut told);
        }
        sender.send(Reply::Reported(revision, frame, Box::new(told)));
    }

    fn drag(&mut self, job: &Job, layers: &[usize], sender: &ReplySender) -> Result<(), PipelineError> {
        let Some(open) = &self.open else { return Ok(()) };
        let prepared = open.prepared();
        let begun = Instant::now();
        let known = self.drag.take().filter(|drag| drag.fits(prepared, job.frame, layers));
        // Nothing else holds the sample, so that it is changed in place.
        self.seen = None;
        // A rotation that was not constrained before adds constraint rows, so the drag is prepared anew.
        let solved = known.and_then(|mut drag| drag.solve(prepared, layers).is_ok().then_some(drag));
        let mut drag = match solved {
            Some(drag) => drag,
            None => DragSolve::begin(prepared, job.frame, layers)?,
        };
        drag.take_up(prepared, layers);
        let marks = [&layer_marks(prepared, drag.sample())[..], drag.resting()].concat();
        sender.send(Reply::Solved(Arc::new(self.solved(SolvedTime::of_drag(job, &drag), marks))));
        let solved_ms = begun.elapsed().as_secs_f64() * 1e3;
        let left_ms = (DRAG_MS - solved_ms).max(5.0);
        let is_slow = self.drafts.least_ms().is_some_and(|least| least > SLOW_MS && least > self.still_ms);
        if !(is_slow && self.warp_still(job, &mut drag, sender)?) {
            let order =
                DraftOrder { solved: SolvedTime::of_drag(job, &drag), kept: drag.at_rest(), longest_ms: left_ms };
            self.draw(order, &|| false, sender)?;
        }
        self.drag = Some(drag);
        Ok(())
    }

    /// Warps a picture of the frame in place of drawing the scene. Returns false if that is not possible.
    fn warp_still(&mut self, job: &Job, drag: &mut DragSolve, sender: &ReplySender) -> Result<bool, PipelineError> {
        let Some((open, device)) = self.open.as_ref().zip(self.device.as_deref_mut()) else { return Ok(false) };
        let prepared = open.prepared();
        let size = DraftSize::least(prepared.shot.size);
        let is_drawn = drag.has_still();
        let begun = Instant::now();
        let Some(frame) = drag.warped(prepared, device, size)? else { return Ok(false) };
        if is_drawn {
            self.still_ms = begun.elapsed().as_secs_f64() * 1e3;
        }
        let picture = Picture::of(&frame, (job.frame, job.revision), Quality::Provisional);
        sender.send(Reply::Drawn(Arc::new(picture)));
        Ok(true)
    }

    fn send_solved(&mut self, solved: SolvedTime, sender: &ReplySender) {
        let Some(open) = &self.open else { return };
        let sample = solved.sample;
        let marks = [layer_marks(open.prepared(), sample), resting_marks(open.prepared(), sample)].concat();
        let mut reply = self.solved(solved, marks);
        // A provisional sample would be remembered as the frame.
        if let Some(open) = self.open.as_ref().filter(|_| solved.is_final) {
            self.jerk.watch(open.prepared(), sample, &mut reply.report);
        }
        sender.send(Reply::Solved(Arc::new(reply)));
    }

    fn solved(&self, solved: SolvedTime, marks: Vec<LayerMarks>) -> SolvedFrame {
        let SolvedTime { frame, revision, sample, is_final } = solved;
        let of = |open: &OpenShot| match is_final {
            true => report(open.prepared(), frame, sample),
            false => Default::default(),
        };
        let report = self.open.as_ref().map(of).unwrap_or_default();
        SolvedFrame { frame, revision, marks, report, is_final }
    }

    /// Draws a draft, unless it becomes unwanted.
    fn draw(
        &mut self,
        DraftOrder { solved, kept, longest_ms }: DraftOrder,
        is_unwanted: &(dyn Fn() -> bool + Sync),
        sender: &ReplySender,
    ) -> Result<(), PipelineError> {
        let Some(open) = &self.open else { return Ok(()) };
        let full: FrameSize = open.prepared().shot.size;
        let size = self.drafts.within(full, longest_ms);
        let begun = Instant::now();
        let draft = Draft { sample: solved.sample, kept, size };
        let drawn = open.prepared().draft(self.device.as_deref_mut(), draft, is_unwanted)?;
        let Some(drawn) = drawn else { return Ok(()) };
        let quality = if solved.is_final { Quality::Draft } else { Quality::Provisional };
        let picture = Picture::of(&drawn, (solved.frame, solved.revision), quality);
        self.drafts.learn(full, size, begun.elapsed().as_secs_f64() * 1e3);
        sender.send(Reply::Drawn(Arc::new(picture)));
        Ok(())
    }

    /// Shows what is painted, over the frame as it was solved last.
    fn paint(&mut self, job: &Job, sender: &ReplySender) -> Result<(), PipelineError> {
        let Some(sample) = self.seen_at(job.frame)? else { return Ok(()) };
        let Some(open) = &self.open else { return Ok(()) };
        let triangles = open.prepared().stiff_triangles(&sample);
        sender.send(Reply::Painted { revision: job.revision, frame: job.frame, triangles });
        Ok(())
    }

    /// Returns a frame as it is seen: as solved last, during a drag or before. Solves it if another frame was solved since.
    fn seen_at(&mut self, frame: i32) -> Result<Option<Arc<TimeSample>>, PipelineError> {
        let Some(open) = &self.open else { return Ok(None) };
        if let Some((_, sample)) = self.seen.as_ref().filter(|(known, _)| *known == frame) {
            return Ok(Some(Arc::clone(sample)));
        }
        if let Some(sample) = self.drag.as_ref().and_then(|drag| drag.sample_of(frame)) {
            return Ok(Some(Arc::clone(sample)));
        }
        let prepared = open.prepared();
        let sample =
            if prepared.is_settled() { prepared.mid_exposure(frame)? } else { Arc::new(prepared.provisional(frame)?) };
        self.seen = Some((frame, Arc::clone(&sample)));
        Ok(Some(sample))
    }

    fn answer(&mut self, question: Question) -> Reply {
        let sample = self.seen_at(question.frame()).ok().flatten();
        let seen = self.open.as_ref().map(OpenShot::prepared).zip(sample.as_deref());
        match question {
            Question::Point { id, frame, at } => {
                let point = seen.and_then(|(prepared, sample)| prepared.pick_warped(sample, at));
                let held = |point: &PickedPoint| seen.map_or_else(Vec::new, |(own, _)| held_places(own, frame, point));
                Reply::Picked(id, point.map(|point| FoundPoint { held: held(&point), point }))
            }
            Question::Brush { id, at, mirrors, .. } => {
                let point = seen.and_then(|(prepared, sample)| prepared.brush_point(sample, at));
                let mirrored = point.as_ref().zip(seen.filter(|_| mirrors));
                let mirrored =
                    mirrored.and_then(|(point, (prepared, _))| prepared.mirrored_place(point.layer, &point.place));
                Reply::Brushed { id, point, mirrored }
            }
            Question::Painted { revision, frame } => {
                let triangles = seen.map_or_else(Vec::new, |(prepared, sample)| prepared.stiff_triangles(sample));
                Reply::Painted { revision, frame, triangles }
            }
            Question::KeyedTurns { id, frame, layer } => {
                let turns = seen.map_or_else(Vec::new, |(prepared, sample)| turns(prepared, (frame, layer), sample));
                Reply::KeyedTurns { id, layer, turns }
            }
        }
    }
}

/// Returns the shot of a job; world-space layers being dragged are solved per frame, because the whole range takes too
/// long.
fn wanted_shot(job: &Job) -> Shot {
    let mut shot = Shot::clone(&job.shot);
    if let Purpose::Drag(layers) = &job.purpose {
        for &index in layers {
            let Some(layer) = shot.layers.get_mut(index) else { continue };
            if matches!(layer.space, LayerSpace::World { .. }) {
                layer.settings.temporal = 0.0;
            }
        }
    }
    shot
}

/// Puts back a job that a question interrupted, unless there is a newer one.
fn put_back(inbox: &Inbox, job: Job) {
    let mut queue = inbox.state.lock().unwrap_or_else(PoisonError::into_inner);
    if queue.job.is_none() {
        queue.job = Some(job);
    }
}

/// Waits for a task. Questions come first, because the user is waiting with the pointer pressed.
fn next(inbox: &Inbox, open: &mut Option<OpenShot>) -> Task {
    let mut queue = inbox.state.lock().unwrap_or_else(PoisonError::into_inner);
    loop {
        if queue.is_over {
            return Task::Over;
        }
        if std::mem::take(&mut queue.is_stale) {
            *open = None;
        }
        if open.is_some()
            && let Some(question) = queue.questions.pop_front()
        {
            return Task::Answer(question);
        }
        let Queue { job, .. } = &mut *queue;
        if let Some(job) = job.take() {
            return Task::Job(job, inbox.newest.load(Ordering::Acquire));
        }
        let (next, waited) = inbox.changed.wait_timeout(queue, WATCH).unwrap_or_else(PoisonError::into_inner);
        if waited.timed_out() {
            return Task::Watch;
        }
        queue = next;
    }
}
