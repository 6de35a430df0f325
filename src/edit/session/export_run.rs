//! Runs `pinwarp export` from the window, as a child process on the saved shot.
//!
//! In: an order. Out: files, progress, and the program's output; a question if there are such files.

use super::Session;
use crate::edit::export_order::{ExportFormat, ExportOrder, REPLACE};
use crate::image::remove_unfinished;
use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

/// The export that is ordered, that runs, and that waits for an answer.
#[derive(Debug, Default)]
pub(crate) struct ExportRun {
    /// The order in the window; `None`: the window is closed.
    pub(crate) order: Option<ExportOrder>,
    running: Option<Running>,
    /// The order whose files are there already.
    clash: Option<ExportOrder>,
    /// Number of frames that were written so far.
    pub(crate) written: usize,
    /// What the last export said.
    pub(crate) told: String,
    /// Whether the last export ended without all of its files.
    has_failed: bool,
}

/// An export in progress; dropping it ends the program.
#[derive(Debug)]
struct Running {
    order: ExportOrder,
    messages: Receiver<ExportMessage>,
    program: Arc<Program>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Running {
    /// Waits until the program has ended and its unfinished files are gone.
    fn drop(&mut self) {
        self.program.end();
        if let Some(thread) = self.thread.take() {
            // The export is over, even if its thread panicked.
            let _ = thread.join();
        }
    }
}

/// The child process.
#[derive(Debug, Default)]
struct Program {
    child: Mutex<Option<Child>>,
    is_cancelled: AtomicBool,
}

impl Program {
    /// Ends the child process, or keeps it from being started.
    fn end(&self) {
        self.is_cancelled.store(true, Ordering::SeqCst);
        if let Some(child) = self.child.lock().unwrap_or_else(PoisonError::into_inner).as_mut() {
            // A process that has ended is not an error.
            let _ = child.kill();
        }
    }

    /// Runs the program to its end. Returns its status, its output and its messages; `on_frame` is called for every frame written.
    fn run(&self, mut command: Command, on_frame: &dyn Fn()) -> std::io::Result<(ExitStatus, [String; 2])> {
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
        let (out, err) = (child.stdout.take(), child.stderr.take());
        let mut lock = self.child.lock().unwrap_or_else(PoisonError::into_inner);
        if self.is_cancelled.load(Ordering::SeqCst) {
            let _ = child.kill();
        }
        *lock = Some(child);
        drop(lock);
        let (mut words, mut told) = (Vec::new(), String::new());
        std::thread::scope(|scope| {
            scope.spawn(|| out.map(|mut out| out.read_to_end(&mut words)));
            for line in err.into_iter().flat_map(|err| BufReader::new(err).split(b'\n')).map_while(Result::ok) {
                take_line(&String::from_utf8_lossy(&line), &mut told, on_frame);
            }
        });
        let child = self.child.lock().unwrap_or_else(PoisonError::into_inner).take();
        let status = child.ok_or(std::io::ErrorKind::NotFound)?.wait()?;
        Ok((status, [String::from_utf8_lossy(&words).trim().to_owned(), told.trim().to_owned()]))
    }
}

/// Takes a line of the program's messages: of the log, frames that were written are counted, and only warnings are told.
fn take_line(line: &str, told: &mut String, on_frame: &dyn Fn()) {
    let is_log = |level: &str| line.trim_start().starts_with(level);
    if is_log("INFO ") || is_log("DEBUG ") {
        if line.trim_end().ends_with(" written") {
            on_frame();
        }
    } else {
        told.push_str(line);
        told.push('\n');
    }
}

/// What the export's thread reports.
#[derive(Debug, PartialEq, Eq)]
enum ExportMessage {
    Frame,
    End(ExportEnd),
}

/// How an export ended.
#[derive(Debug, PartialEq, Eq)]
struct ExportEnd {
    words: String,
    /// Whether all files are written.
    is_success: bool,
    /// Whether there are such files already.
    is_clash: bool,
}

impl ExportEnd {
    fn of(is_success: bool, [out, err]: [String; 2]) -> Self {
        let is_clash = !is_success && err.contains(REPLACE);
        // Warnings come with success, too.
        let words = [err, out].into_iter().filter(|text| !text.is_empty()).collect::<Vec<_>>().join("\n");
        Self { words, is_success, is_clash }
    }
}

/// Runs the program, and removes what it leaves unfinished.
fn export(
    program: &Program,
    (arguments, folder, target): (&[OsString], &Path, &Path),
    on_frame: &dyn Fn(),
) -> ExportEnd {
    let run = std::env::current_exe().and_then(|path| {
        let mut command = Command::new(path);
        command.args(arguments).arg("-v").current_dir(folder);
        program.run(command, on_frame)
    });
    if program.is_cancelled.load(Ordering::SeqCst) {
        remove_unfinished(target);
        let words = "The export was cancelled; the files that it had finished stay.".into();
        return ExportEnd { words, is_success: false, is_clash: false };
    }
    match run {
        Ok((status, texts)) => ExportEnd::of(status.success(), texts),
        Err(error) => {
            let words = format!("the program cannot be started again: {error}");
            ExportEnd { words, is_success: false, is_clash: false }
        }
    }
}

impl Session {
    /// Opens the window of an export; one that is running stays in it.
    pub(crate) fn order_export(&mut self, format: &'static ExportFormat) {
        if !self.is_exporting() {
            self.export = ExportRun { order: Some(ExportOrder::of(format)), ..ExportRun::default() };
        } else if let Some(running) = &self.export.running {
            self.export.order = Some(running.order.clone());
        }
    }

    /// Returns the state of the export, with the order in its window.
    pub(crate) const fn export_run(&mut self) -> &mut ExportRun {
        &mut self.export
    }

    /// Returns whether an export is running.
    #[must_use]
    pub(crate) const fn is_exporting(&self) -> bool {
        self.export.running.is_some()
    }

    /// Returns whether the last export ended without all of its files.
    #[must_use]
    pub(crate) const fn has_export_failed(&self) -> bool {
        self.export.has_failed
    }

    /// Exports the shot, saving unsaved changes first.
    pub(crate) fn export(&mut self, order: &ExportOrder, wake: impl Fn() + Send + 'static) {
        if self.is_exporting() {
            return;
        }
        if self.document().is_dirty()
            && let Err(error) = self.save()
        {
            self.export.told = error.to_string();
            return self.say(error.to_string());
        }
        let names = self.document().shot().layers.iter().map(|layer| &layer.name);
        if let Some(name) = order.unlisted(names) {
            let told =
                format!("Layer '{name}' cannot be chosen: its name has a comma. Rename it, or export all layers.");
            self.export.told.clone_from(&told);
            return self.say(told);
        }
        let shot = self.document().path().to_owned();
        let layers = self.document().shot().layers.iter().map(|layer| layer.name.as_str());
        let (mut arguments, target) = (order.arguments(&shot, layers), order.target(&shot));
        arguments.extend(self.document().shot().allow_outside.then(|| OsString::from("--allow-outside")));
        let (sender, messages) = channel();
        let program = Arc::new(Program::default());
        let own = Arc::clone(&program);
        let work = move || {
            let folder = shot.parent().map_or_else(PathBuf::new, Path::to_owned);
            let send = |sender: &Sender<ExportMessage>, message| {
                if sender.send(message).is_ok() {
                    wake();
                }
            };
            let end = export(&own, (&arguments, &folder, &target), &|| send(&sender, ExportMessage::Frame));
            send(&sender, ExportMessage::End(end));
        };
        self.say("Exporting \u{2026}");
        (self.export.clash, self.export.written, self.export.told) = (None, 0, String::new());
        self.export.has_failed = false;
        match std::thread::Builder::new().name("edit: export".into()).spawn(work) {
            Ok(thread) => {
                self.export.running = Some(Running { order: order.clone(), messages, program, thread: Some(thread) });
            }
            Err(error) => self.say(format!("no thread can be started: {error}")),
        }
    }

    /// Begins an export that nothing carries out. It ends once what is returned is called, with whether it succeeds.
    #[cfg(test)]
    pub(crate) fn pretend_export(&mut self, format: &'static ExportFormat) -> impl FnOnce(bool) + use<> {
        let (sender, messages) = channel();
        let (order, program) = (ExportOrder::of(format), Arc::new(Program::default()));
        self.export.running = Some(Running { order, messages, program, thread: None });
        move |is_success| {
            let end = ExportEnd { words: "Ended.".into(), is_success, is_clash: false };
            let _ = sender.send(ExportMessage::End(end));
        }
    }

    /// Ends the running export, which leaves no unfinished file.
    pub(crate) fn cancel_export(&self) {
        self.export.running.iter().for_each(|running| running.program.end());
    }

    /// Collects the messages of the export. Returns whether there were any.
    pub(super) fn pump_export(&mut self) -> bool {
        let messages: Vec<_> = self.export.running.iter().flat_map(|running| running.messages.try_iter()).collect();
        let is_any = !messages.is_empty();
        for message in messages {
            match message {
                ExportMessage::Frame => self.export.written += 1,
                ExportMessage::End(ExportEnd { words, is_success, is_clash }) => {
                    let order = self.export.running.take().map(|running| running.order.clone());
                    self.export.clash = order.filter(|_| is_clash);
                    self.export.has_failed = !is_success;
                    self.export.told.clone_from(&words);
                    self.say(words);
                }
            }
        }
        is_any
    }

    /// Returns the order of an export whose files are there already.
    #[must_use]
    pub(crate) const fn export_clash(&self) -> Option<&ExportOrder> {
        self.export.clash.as_ref()
    }

    /// Leaves existing files as they are.
    pub(crate) fn keep_exported(&mut self) {
        self.export.clash = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_are_told_and_existing_files_are_asked_about() {
        let end = |is_success: bool, texts: [&str; 2]| ExportEnd::of(is_success, texts.map(str::to_owned));
        let told = end(true, ["shot.nk", "warning: folded"]);
        let words = "warning: folded\nshot.nk".into();
        assert_eq!(told, ExportEnd { words, is_success: true, is_clash: false });
        let error = "error: shot.nk: exists already; use --overwrite to replace it";
        assert_eq!(end(false, ["", error]), ExportEnd { words: error.into(), is_success: false, is_clash: true });
        assert!(!end(false, ["", "error: no scene"]).is_clash);
    }

    #[test]
    fn frames_are_counted_in_the_log_and_warnings_are_kept() {
        let (mut told, written) = (String::new(), std::cell::Cell::new(0));
        for line in [
            " INFO pinwarp::cli::export::maps: m.0001.exr written",
            " INFO pinwarp::solve: 3 iterations",
            "warning: frame 1: the warp folds",
            " WARN pinwarp::scene: a light is ignored",
            " INFO pinwarp::cli::export::maps: m.0002.exr written",
        ] {
            take_line(line, &mut told, &|| written.set(written.get() + 1));
        }
        assert_eq!((written.get(), told.lines().count()), (2, 2));
        assert!(told.contains("folds") && told.contains("a light"), "{told}");
    }

    #[cfg(unix)]
    #[test]
    fn a_cancelled_program_ends_at_once_and_one_that_is_left_alone_says_all() {
        let of = |script: &str| {
            let mut command = Command::new("sh");
            command.args(["-c", script]);
            command
        };
        let program = Program::default();
        let (status, texts) = program.run(of("echo out; echo err >&2"), &|| ()).expect("it runs");
        assert_eq!((status.success(), texts), (true, ["out".to_owned(), "err".to_owned()]));
        let begun = std::time::Instant::now();
        let program = Program::default();
        // It is cancelled as soon as it speaks.
        let (status, _) =
            program.run(of("echo ' INFO a written' >&2; exec sleep 600"), &|| program.end()).expect("it runs");
        assert!(!status.success() && begun.elapsed().as_secs() < 300);
        let (status, _) = program.run(of("exec sleep 600"), &|| ()).expect("it runs");
        assert!(!status.success() && begun.elapsed().as_secs() < 300, "it is not even begun");
    }
}
