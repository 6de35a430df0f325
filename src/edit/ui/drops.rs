//! Files dropped on the window.
//!
//! In: the files of a pass. Out: an open document, reference pictures, a message about what was not used.

use super::editor::{Deferred, Editor};
use crate::edit::{Dropped, EditError};
use crate::shot::Source;
use eframe::egui;
use std::path::{Path, PathBuf};

impl Editor {
    /// Handles files dropped on the window.
    pub(super) fn drops(&mut self, ctx: &egui::Context) {
        let dropped = ctx.input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect());
        let dropped: Vec<PathBuf> = dropped;
        if !dropped.is_empty() {
            self.try_open(ctx, Dropped::of(dropped));
        }
    }

    /// Opens files, after questions if there is unsaved work or something is running.
    pub(super) fn try_open(&mut self, ctx: &egui::Context, files: Dropped) {
        self.leave(ctx, Deferred::Open(files));
    }

    /// Opens the first file that can be opened, and lays the pictures beside it over the frame. Returns whether there was one.
    pub(super) fn open_files(&mut self, ctx: &egui::Context, files: Dropped) -> bool {
        let Dropped { candidates, pictures, others } = files;
        let mut fault: Option<EditError> = None;
        let mut rest = candidates.into_iter();
        let mut unused: Vec<PathBuf> = Vec::new();
        let opened = rest.by_ref().find(|path| match self.open(ctx, path) {
            Ok(()) => true,
            Err(error) => {
                unused.push(path.clone());
                fault.get_or_insert(error);
                false
            }
        });
        unused.extend(rest);
        let (Some(_), Some(session)) = (opened, &mut self.session) else {
            if let Some(error) = fault {
                self.show_error(&error);
            }
            return false;
        };
        let (mut told, mut laid) = (Vec::new(), Vec::new());
        for picture in pictures {
            match session.add_reference(&picture) {
                Ok(()) => laid.push(name(&picture)),
                Err(error) => {
                    told.push(error.to_string());
                    unused.push(picture);
                }
            }
        }
        if !laid.is_empty() {
            let verb = if laid.len() == 1 { "lies" } else { "lie" };
            told.insert(0, format!("{} {verb} over the picture (View: opacity, place).", laid.join(", ")));
        }
        unused.extend(others);
        // The scene of a shot that was dropped with it is used.
        if let Source::Scene(scene) = &session.document().shot().source {
            unused.retain(|path| path.file_name() != scene.file_name());
        }
        if !unused.is_empty() {
            told.push(format!("Not used: {}", unused.iter().map(|path| name(path)).collect::<Vec<_>>().join(", ")));
        }
        if !told.is_empty() {
            session.say(told.join(" "));
        }
        true
    }
}

fn name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}
