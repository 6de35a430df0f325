//! Tells a render's events: a progress bar on a terminal, plain lines elsewhere, JSON lines on request.

use crate::pipeline::{Event, Summary, WarpEvent, WarpSummary};
use crate::plate::Holes;
use crate::spelling::counted;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Warnings that every frame repeats are told this often, then counted.
const REPEATS_TOLD: usize = 3;

/// Tells events as the user wants them.
pub(super) struct Teller {
    is_json: bool,
    bar: ProgressBar,
    begun: Instant,
    /// Of a warp: what fills holes.
    holes: Holes,
    told: Mutex<BTreeMap<String, usize>>,
}

impl Teller {
    pub(super) fn new(is_json: bool) -> Self {
        let bar = if is_json || !io::stderr().is_terminal() { ProgressBar::hidden() } else { ProgressBar::new(0) };
        let style = ProgressStyle::with_template("{bar:32} {pos}/{len} frames  {msg}  {eta} left");
        if let Ok(style) = style {
            bar.set_style(style);
        }
        Self { is_json, bar, begun: Instant::now(), holes: Holes::Leave, told: Mutex::default() }
    }

    /// The same for a warp whose holes something fills.
    pub(super) fn of_holes(self, holes: &Holes) -> Self {
        Self { holes: holes.clone(), ..self }
    }

    /// Tells one event of a render.
    pub(super) fn tell(&self, event: &Event) {
        if self.is_json {
            return print_json(event);
        }
        match event {
            Event::Note { text } => self.line(&format!("note: {text}")),
            Event::Started { device, frames, kept } => self.started(*frames, &format!(" on {device}"), *kept),
            Event::FrameDone(report) => self.frame_done(report.frame, &report.path, &report.warnings),
            Event::FrameFailed { frame, error } => self.frame_failed(*frame, error),
            Event::Finished(summary) => self.finished(&Totals::of_render(summary)),
        }
    }

    /// Tells one event of a warp.
    pub(super) fn tell_warp(&self, event: &WarpEvent) {
        if self.is_json {
            return print_json(event);
        }
        match event {
            WarpEvent::Note { text } => self.line(&format!("note: {text}")),
            WarpEvent::Started { frames, kept } => self.started(*frames, "", *kept),
            WarpEvent::FrameDone(report) => {
                let found = findings(&self.holes, report.hole_pixels, report.contained_samples);
                let warnings: Vec<String> = report.warnings.iter().cloned().chain(found).collect();
                self.frame_done(report.frame, &report.path, &warnings);
                for channel in &report.channels {
                    tracing::info!("channel {}: {:?} ({:?})", channel.channel, channel.meaning, channel.reason);
                }
            }
            WarpEvent::FrameFailed { frame, error } => self.frame_failed(*frame, error),
            WarpEvent::Finished(summary) => self.finished(&Totals::of_warp(summary)),
        }
    }

    fn started(&self, frames: usize, place: &str, kept: usize) {
        self.bar.set_length(frames as u64);
        self.bar.enable_steady_tick(Duration::from_millis(500));
        let kept = if kept > 0 { format!(", {kept} kept") } else { String::new() };
        self.line(&format!("{}{place}{kept}", counted(frames, "frame", "frames")));
    }

    fn frame_failed(&self, frame: i32, error: &str) {
        self.bar.inc(1);
        self.line(&format!("error: frame {frame}: {error}"));
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
    }

    /// Frames often repeat a warning with other numbers: the kind is the text without them.
    fn warn(&self, frame: i32, warning: &str) {
        let kind = kind_of(warning);
        let count = {
            let mut told = self.told.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            let count = told.entry(kind).or_default();
            *count += 1;
            *count
        };
        if count <= REPEATS_TOLD {
            self.line(&format!("warning: frame {frame}: {warning}"));
        }
    }

    fn finished(&self, totals: &Totals) {
        self.bar.finish_and_clear();
        let told = self.told.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        for (kind, count) in told.iter().filter(|(_, count)| **count > REPEATS_TOLD) {
            self.line(&format!("warning: {}: {kind}", counted(count - REPEATS_TOLD, "more time", "more times")));
        }
        let Totals { done, failed, is_cancelled, wall_secs, busy } = totals;
        let fps = *done as f64 / wall_secs;
        let failed = if *failed > 0 { format!(", {failed} FAILED") } else { String::new() };
        let stopped = if *is_cancelled { "; stopped: go on with --resume" } else { "" };
        let done = counted(*done, "frame", "frames");
        self.line(&format!("{done} in {wall_secs:.1} s ({fps:.2} fps){failed}{stopped}"));
        let busy: Vec<String> = busy.iter().map(|(stage, ms)| format!("{stage} {ms:.0} ms")).collect();
        tracing::info!("busy: {}", busy.join(", "));
    }

    fn line(&self, text: &str) {
        self.bar.suspend(|| {
            let _ = writeln!(io::stderr(), "{text}");
        });
    }
}

fn print_json(event: &impl Serialize) {
    if let Ok(line) = serde_json::to_string(event) {
        // A reader that has gone away is no reason to stop.
        let _ = writeln!(io::stdout().lock(), "{line}");
    }
}

/// What is told of a render or a warp when it ends.
struct Totals {
    done: usize,
    failed: usize,
    is_cancelled: bool,
    wall_secs: f64,
    /// Stages, and for how long each was busy, milliseconds.
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

/// Counts of a warped frame that are worth a word.
fn findings(fill: &Holes, hole_pixels: usize, contained_samples: usize) -> impl Iterator<Item = String> {
    let hole_pixels = if *fill == Holes::Leave { hole_pixels } else { 0 };
    let empty =
        counted(hole_pixels, "pixel that a layer uncovered is empty", "pixels that a layer uncovered are empty");
    let holes = format!("{empty}; fill holes by --clean or `holes`");
    let contained = counted(
        contained_samples,
        "sample is no finite number and was contained",
        "samples are no finite numbers and were contained",
    );
    [(hole_pixels, holes), (contained_samples, contained)]
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|found| found.1)
}

/// A warning with every number outside quotes replaced: names may hold digits and tell warnings apart.
fn kind_of(warning: &str) -> String {
    let unquoted = |(index, piece): (usize, &str)| {
        let is_number = |letter: char| letter.is_ascii_digit() || letter == '.';
        if index % 2 == 1 {
            piece.to_owned()
        } else {
            piece.split(is_number).filter(|s| !s.is_empty()).collect::<Vec<_>>().join("…")
        }
    };
    warning.split('\'').enumerate().map(unquoted).collect::<Vec<_>>().join("'")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_that_are_filled_are_not_told() {
        let told = |fill: &Holes| findings(fill, 7, 0).collect::<Vec<_>>();
        assert!(told(&Holes::Leave)[0].starts_with("7 pixels"), "{:?}", told(&Holes::Leave));
        assert_eq!((told(&Holes::Geometry), findings(&Holes::Geometry, 7, 2).count()), (Vec::new(), 1));
    }

    #[test]
    fn warnings_that_differ_in_numbers_are_of_one_kind() {
        let one = kind_of("layer 'layer1': pin 'a' is 0.12 px off its target");
        assert_eq!(one, kind_of("layer 'layer1': pin 'a' is 7.5 px off its target"));
        assert_ne!(one, kind_of("layer 'layer2': pin 'a' is 0.12 px off its target"));
    }
}
