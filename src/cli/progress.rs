//! Prints the events of a render or a warp: a progress bar on a terminal, plain lines elsewhere, JSON lines on request.
//!
//! In: events, from several threads. Out: lines on standard error; with `--json` on standard output.

use super::layer_notes::LayerNotes;
use super::outcome::OutputCutOff;
use super::warnings::kind_of;
use crate::pipeline::{BakeEvent, BakeSummary, BakedLayer, Event, LayerNote, Summary, WarpEvent, WarpSummary};
use crate::solve::Spread;
use crate::spelling::pluralised;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How often a warning that recurs in many frames is printed; later ones are only counted.
const MAX_REPEATS: usize = 1;

/// The output format of progress events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ProgressForm {
    /// Text and a progress bar.
    Words,
    /// One JSON event per line, on standard output.
    Json,
    /// Text, and on standard output the messages that an Open Job Description scheduler parses (its wiki, "How Jobs Are
    /// Run").
    OpenJd,
}

/// Prints events in the selected format.
pub(super) struct EventPrinter {
    form: ProgressForm,
    bar: ProgressBar,
    begun: Instant,
    printed: Mutex<BTreeMap<String, usize>>,
    notes: Mutex<LayerNotes>,
    /// The first error of printing JSON.
    failed: Mutex<Option<io::Error>>,
}

impl EventPrinter {
    pub(super) fn new(form: ProgressForm) -> Self {
        let bar = if form == ProgressForm::Json || !io::stderr().is_terminal() {
            ProgressBar::hidden()
        } else {
            ProgressBar::new(0)
        };
        let style = ProgressStyle::with_template("{bar:32} {pos}/{len} frames  {msg}  {eta} left");
        if let Ok(style) = style {
            bar.set_style(style);
        }
        Self {
            form,
            bar,
            begun: Instant::now(),
            printed: Mutex::default(),
            notes: Mutex::default(),
            failed: Mutex::default(),
        }
    }

    /// Prints one event of a render.
    pub(super) fn print_render(&self, event: &Event) {
        if self.form == ProgressForm::Json {
            return self.print_json(event);
        }
        match event {
            Event::Note { text } => self.line(&format!("note: {text}")),
            Event::FrameRedone(_) => {}
            Event::Started { device, frames, kept } => self.started(*frames, &format!(" on {device}"), *kept),
            Event::FrameDone(report) => {
                self.notes(&report.notes);
                self.frame_done(report.frame, &report.path, &report.warnings);
            }
            Event::FrameFailed { frame, error } => self.frame_failed(*frame, error),
            Event::Finished(summary) => self.finished(&Totals::of_render(summary)),
        }
    }

    /// Prints one event of a warp.
    pub(super) fn print_warp(&self, event: &WarpEvent) {
        if self.form == ProgressForm::Json {
            return self.print_json(event);
        }
        match event {
            WarpEvent::Note { text } => self.line(&format!("note: {text}")),
            WarpEvent::FrameRedone(_) => {}
            WarpEvent::Started { frames, kept } => self.started(*frames, "", *kept),
            WarpEvent::FrameDone(report) => {
                let found = findings(report.hole_pixels, report.contained_samples);
                let warnings: Vec<String> = report.warnings.iter().cloned().chain(found).collect();
                self.notes(&report.notes);
                self.frame_done(report.frame, &report.path, &warnings);
                if !report.mattes.is_empty() {
                    let from = &report.mattes;
                    let remedy = "`matte` chooses other parts, matte = \"none\" the whole picture";
                    self.line(&format!("note: layers without a matte move their own nodes, as in {from}; {remedy}"));
                }
                for channel in &report.channels {
                    tracing::info!("channel {}: {:?} ({:?})", channel.channel, channel.semantic, channel.reason);
                }
            }
            WarpEvent::FrameFailed { frame, error } => self.frame_failed(*frame, error),
            WarpEvent::Finished(summary) => self.finished(&Totals::of_warp(summary)),
        }
    }

    /// Prints one event of a bake.
    pub(super) fn print_bake(&self, event: &BakeEvent) {
        if self.form == ProgressForm::Json {
            return self.print_json(event);
        }
        match event {
            BakeEvent::Note { text } => self.line(&format!("note: {text}")),
            BakeEvent::Started { layers: 0, .. } => {
                self.line(
                    "no layer is solved over time: there is nothing to bake (see `temporal` in the manual of shots)",
                );
            }
            BakeEvent::Started { layers, solve_range: [first, last] } => {
                self.bar.set_length(0);
                self.bar.enable_steady_tick(Duration::from_millis(500));
                self.line(&format!("{} over frames {first} to {last}", pluralised(*layers, "layer", "layers")));
            }
            BakeEvent::Progress { layer, done, of } => self.baking(layer, *done, *of),
            BakeEvent::LayerDone(baked) => self.line(&baked_in_words(baked)),
            BakeEvent::LayerFailed { layer, error } => self.line(&format!("error: layer '{layer}': {error}")),
            BakeEvent::Finished(summary) => {
                self.bar.finish_and_clear();
                let BakeSummary { solved, kept, failed, is_cancelled, wall_secs } = summary;
                let solved = pluralised(*solved, "layer", "layers");
                let kept = if *kept > 0 { format!(", {kept} kept") } else { String::new() };
                let failed = if *failed > 0 { format!(", {failed} FAILED") } else { String::new() };
                let stopped = if *is_cancelled { "; stopped: go on with the same command" } else { "" };
                self.line(&format!("{solved} solved in {wall_secs:.1} s{kept}{failed}{stopped}"));
            }
        }
    }

    /// Advances the bar of a bake. Layers are solved in parallel, so the bar shows their sum.
    fn baking(&self, layer: &str, done: usize, of: usize) {
        let mut printed = self.printed.lock().unwrap_or_else(PoisonError::into_inner);
        if !printed.contains_key(layer) {
            self.bar.inc_length(of as u64);
        }
        let before = printed.insert(layer.to_owned(), done).unwrap_or_default();
        self.bar.inc(done.saturating_sub(before) as u64);
        drop(printed);
        self.print_scheduler_status(&format!("layer '{layer}': {done} of {of}"));
    }

    fn started(&self, frames: usize, place: &str, kept: usize) {
        self.bar.set_length(frames as u64);
        self.bar.enable_steady_tick(Duration::from_millis(500));
        let kept = if kept > 0 { format!(", {kept} kept") } else { String::new() };
        self.line(&format!("{}{place}{kept}", pluralised(frames, "frame", "frames")));
        self.print_scheduler_status(&format!("{} to make", pluralised(frames, "frame", "frames")));
    }

    /// Prints the first note of each layer.
    fn notes(&self, notes: &[LayerNote]) {
        let lines = self.notes.lock().unwrap_or_else(PoisonError::into_inner).new_lines(notes);
        lines.iter().for_each(|line| self.line(line));
    }

    fn frame_failed(&self, frame: i32, error: &str) {
        self.bar.inc(1);
        self.line(&format!("error: frame {frame}: {error}"));
        self.print_scheduler_status(&format!("frame {frame} failed"));
    }

    fn frame_done(&self, frame: i32, path: &Path, warnings: &[String]) {
        self.bar.inc(1);
        let fps = self.bar.position() as f64 / self.begun.elapsed().as_secs_f64();
        self.bar.set_message(format!("{fps:.2} fps"));
        for warning in warnings {
            self.warn(frame, warning);
        }
        if self.bar.is_hidden() {
            self.line(&format!("frame {frame} -> {}", path.display()));
        }
        self.print_scheduler_status(&format!("frame {frame} is done"));
    }

    /// Counts repeated warnings by their text without numbers, as these often vary from frame to frame.
    fn warn(&self, frame: i32, warning: &str) {
        let kind = kind_of(warning);
        let count = {
            let mut printed = self.printed.lock().unwrap_or_else(PoisonError::into_inner);
            let count = printed.entry(kind).or_default();
            *count += 1;
            *count
        };
        if count <= MAX_REPEATS {
            self.line(&format!("warning: frame {frame}: {warning}"));
        }
    }

    fn finished(&self, totals: &Totals) {
        self.bar.finish_and_clear();
        let printed = self.printed.lock().unwrap_or_else(PoisonError::into_inner);
        for (kind, count) in printed.iter().filter(|(_, count)| **count > MAX_REPEATS) {
            self.line(&format!("warning: {}: {kind}", pluralised(count - MAX_REPEATS, "more time", "more times")));
        }
        let Totals { done, failed, is_cancelled, wall_secs, busy } = totals;
        let fps = *done as f64 / wall_secs;
        let failed = if *failed > 0 { format!(", {failed} FAILED") } else { String::new() };
        let stopped = if *is_cancelled { "; stopped: go on with --resume" } else { "" };
        let done = pluralised(*done, "frame", "frames");
        self.line(&format!("{done} in {wall_secs:.1} s ({fps:.2} fps){failed}{stopped}"));
        let busy: Vec<String> = busy.iter().map(|(stage, ms)| format!("{stage} {ms:.0} ms")).collect();
        tracing::info!("busy: {}", busy.join(", "));
    }

    fn print_json(&self, event: &impl Serialize) {
        match serde_json::to_string(event) {
            Ok(line) => self.print(&(line + "\n")),
            Err(error) => self.store_failure(error.into()),
        }
    }

    /// Prints whole lines. Errors are stored for the end, as a closed pipe or a full disk is no reason to stop
    /// rendering.
    fn print(&self, lines: &str) {
        let mut out = io::stdout().lock();
        if let Err(error) = out.write_all(lines.as_bytes()).and_then(|()| out.flush()) {
            self.store_failure(error);
        }
    }

    /// Stores the first error until the end.
    fn store_failure(&self, error: io::Error) {
        self.failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }

    /// Prints the progress in percent, and the last status.
    fn print_scheduler_status(&self, status: &str) {
        if self.form == ProgressForm::OpenJd {
            let all = self.bar.length().unwrap_or_default();
            let part = if all == 0 { 1.0 } else { self.bar.position() as f64 / all as f64 };
            self.print(&format!("openjd_progress: {:.1}\nopenjd_status: {status}\n", 100.0 * part));
        }
    }

    /// Checks that all events were printed.
    ///
    /// # Errors
    /// [`OutputCutOff`] if one could not be, for a reason other than a closed pipe.
    pub(super) fn end(self) -> Result<(), OutputCutOff> {
        match self.failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(OutputCutOff(error)),
            _ => Ok(()),
        }
    }

    fn line(&self, text: &str) {
        self.bar.suspend(|| {
            let _ = writeln!(io::stderr(), "{text}");
        });
    }
}

/// Describes the result of a baked layer.
fn baked_in_words(baked: &BakedLayer) -> String {
    let BakedLayer { layer, path, is_kept, knots, spreads, wall_secs } = baked;
    let times = pluralised(*knots, "time", "times");
    let done = if *is_kept { "kept".to_owned() } else { format!("solved at {times} in {wall_secs:.1} s") };
    let spread = |spread: &Spread| format!("{} to {}", spread.frames[0], spread.frames[1]);
    let spreads: Vec<String> = spreads.iter().map(spread).collect();
    let printed =
        if spreads.is_empty() { String::new() } else { format!("; snaps spread over frames {}", spreads.join(", ")) };
    let path = path.as_ref().map(|path| format!(" -> {}", path.display())).unwrap_or_default();
    format!("layer '{layer}' {done}{path}{printed}")
}

/// The summary line of a render or a warp.
struct Totals {
    done: usize,
    failed: usize,
    is_cancelled: bool,
    wall_secs: f64,
    /// Stages with their busy time in milliseconds.
    busy: [(&'static str, f64); 3],
}

impl Totals {
    fn of_render(summary: &Summary) -> Self {
        let &Summary { rendered: done, failed, is_cancelled, wall_secs, .. } = summary;
        let busy = [("geometry", summary.geometry_ms), ("raster", summary.raster_ms), ("write", summary.write_ms)];
        Self { done, failed, is_cancelled, wall_secs, busy }
    }

    fn of_warp(summary: &WarpSummary) -> Self {
        let &WarpSummary { warped: done, failed, is_cancelled, wall_secs, .. } = summary;
        let busy = [("read", summary.read_ms), ("warp", summary.warp_ms), ("write", summary.write_ms)];
        Self { done, failed, is_cancelled, wall_secs, busy }
    }
}

/// Returns the noteworthy counts of a warped frame.
fn findings(hole_pixels: usize, contained_samples: usize) -> impl Iterator<Item = String> {
    let empty =
        pluralised(hole_pixels, "pixel that a layer uncovered is empty", "pixels that a layer uncovered are empty");
    let holes = format!("{empty}; fill holes by --clean or `holes`");
    let contained = pluralised(
        contained_samples,
        "sample was not finite and was replaced",
        "samples were not finite and were replaced",
    );
    [(hole_pixels, holes), (contained_samples, contained)]
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|found| found.1)
}
