//! Runs `pinwarp export` from the window, as a child process on the saved shot.
//!
//! In: a format. Out: files next to the shot, and the program's output.

use super::Session;
use std::process::Command;
use std::sync::mpsc::channel;

/// The formats of `pinwarp export --to`, with display names.
pub(crate) const EXPORTS: [(&str, &str); 6] = [
    ("lattice-json", "Lattices (JSON)"),
    ("stmap", "STMaps (EXR)"),
    ("nuke", "Nuke script"),
    ("blender", "Blender script"),
    ("gltf", "glTF with shape keys"),
    ("after-effects", "After Effects script"),
];

impl Session {
    /// Exports the shot, saving unsaved changes first.
    pub(crate) fn export(&mut self, format: &'static str, wake: impl Fn() + Send + 'static) {
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
                Command::new(program).arg("export").arg(&shot).args(["--to", format, "--overwrite"]).output()
            });
            let words = match run {
                Ok(output) => {
                    let words = if output.status.success() { output.stdout } else { output.stderr };
                    String::from_utf8_lossy(&words).trim().to_owned()
                }
                Err(error) => format!("the program cannot be started again: {error}"),
            };
            if sender.send(words).is_ok() {
                wake();
            }
        };
        self.say("Exporting \u{2026}");
        match std::thread::Builder::new().name("edit: export".into()).spawn(work) {
            Ok(_) => self.export = Some(receiver),
            Err(error) => self.say(format!("no thread can be started: {error}")),
        }
    }

    /// Collects the output of a finished export.
    pub(super) fn pump_export(&mut self) -> bool {
        let Some(words) = self.export.as_ref().and_then(|receiver| receiver.try_recv().ok()) else { return false };
        self.export = None;
        self.say(words);
        true
    }
}
