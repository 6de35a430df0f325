//! Runs `pinwarp export` from the window, as a child process on the saved shot.
//!
//! In: a format. Out: files next to the shot, and the program's output; a question if there are such files.

use super::Session;
use std::process::{Command, Output};
use std::sync::mpsc::{Receiver, channel};

/// The formats of `pinwarp export --to`, with display names.
pub(crate) const EXPORTS: [(&str, &str); 6] = [
    ("lattice-json", "Lattices (JSON)"),
    ("stmap", "STMaps (EXR)"),
    ("nuke", "Nuke script"),
    ("blender", "Blender script"),
    ("gltf", "glTF with shape keys"),
    ("after-effects", "After Effects script"),
];

/// The flag that replaces files, which the program names where they are in the way.
const REPLACE: &str = "--overwrite";

/// The running export, and the one that waits for an answer.
#[derive(Debug, Default)]
pub(super) struct ExportRun {
    running: Option<Receiver<ExportEnd>>,
    /// The format whose files are there already.
    clash: Option<&'static str>,
}

/// How an export ended.
#[derive(Debug, PartialEq, Eq)]
struct ExportEnd {
    words: String,
    clash: Option<&'static str>,
}

impl ExportEnd {
    fn of(output: &Output, format: &'static str) -> Self {
        let [out, err] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).trim().to_owned());
        let is_clash = !output.status.success() && err.contains(REPLACE);
        // Warnings come with success, too.
        let words = [err, out].into_iter().filter(|text| !text.is_empty()).collect::<Vec<_>>().join("\n");
        Self { words, clash: is_clash.then_some(format) }
    }
}

impl Session {
    /// Exports the shot, saving unsaved changes first. `replaces`: whether existing files are replaced; else they are asked about.
    pub(crate) fn export(&mut self, format: &'static str, replaces: bool, wake: impl Fn() + Send + 'static) {
        if self.document().is_dirty()
            && let Err(error) = self.save()
        {
            return self.say(error.to_string());
        }
        let (sender, receiver) = channel();
        let shot = self.document().path().to_owned();
        let work = move || {
            let program = std::env::current_exe();
            let run = program.and_then(|program| {
                let mut command = Command::new(program);
                command.arg("export").arg(&shot).args(["--to", format]);
                command.args(replaces.then_some(REPLACE)).output()
            });
            let end = match run {
                Ok(output) => ExportEnd::of(&output, format),
                Err(error) => ExportEnd { words: format!("the program cannot be started again: {error}"), clash: None },
            };
            if sender.send(end).is_ok() {
                wake();
            }
        };
        self.say("Exporting \u{2026}");
        match std::thread::Builder::new().name("edit: export".into()).spawn(work) {
            Ok(_) => self.export = ExportRun { running: Some(receiver), clash: None },
            Err(error) => self.say(format!("no thread can be started: {error}")),
        }
    }

    /// Collects the output of a finished export.
    pub(super) fn pump_export(&mut self) -> bool {
        let Some(end) = self.export.running.as_ref().and_then(|running| running.try_recv().ok()) else { return false };
        self.export = ExportRun { running: None, clash: end.clash };
        self.say(end.words);
        true
    }

    /// Returns the format of an export whose files are there already.
    #[must_use]
    pub(crate) const fn export_clash(&self) -> Option<&'static str> {
        self.export.clash
    }

    /// Leaves existing files as they are.
    pub(crate) fn keep_exported(&mut self) {
        self.export.clash = None;
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::process::ExitStatusExt;
    use std::process::ExitStatus;

    #[test]
    fn warnings_are_told_and_existing_files_are_asked_about() {
        let output = |status: i32, out: &str, err: &str| {
            let status = ExitStatus::from_raw(status << 8);
            Output { status, stdout: out.as_bytes().to_vec(), stderr: err.as_bytes().to_vec() }
        };
        let end = |output: &Output| ExportEnd::of(output, "nuke");
        let told = end(&output(0, "shot.nk\n", "warning: folded\n"));
        assert_eq!(told, ExportEnd { words: "warning: folded\nshot.nk".into(), clash: None });
        let error = "error: shot.nk: exists already; use --overwrite to replace it";
        assert_eq!(end(&output(2, "", error)), ExportEnd { words: error.into(), clash: Some("nuke") });
        assert_eq!(end(&output(2, "", "error: no scene")).clash, None);
    }
}
