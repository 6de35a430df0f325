//! Questions before something is lost: unsaved work, renders that run, files that would be overwritten, work of a killed editor.
//!
//! In: what is to be decided. Out: the user's decision, carried out.

use super::dialogs::{Answer, ask};
use super::editor::{Deferred, Editor};
use crate::edit::{DiskChange, Document, EditError, RenderRun, Session, forget, unfinished};
use crate::files::is_same_file;
use crate::spelling::pluralised;
use eframe::egui;
use std::path::Path;

impl Editor {
    /// Shows the open questions.
    pub(super) fn ask(&mut self, ctx: &egui::Context) {
        self.ask_recovery(ctx);
        self.ask_overwrite(ctx);
        self.ask_conflict(ctx);
        self.ask_unsaved(ctx);
        self.ask_running(ctx);
    }

    /// Does what leaves the open shot, after questions about unsaved work and what is running.
    pub(super) fn leave(&mut self, ctx: &egui::Context, deferred: Deferred) {
        if self.session.as_ref().is_some_and(|session| session.document().has_unsaved_work()) {
            self.questions.unsaved = Some(deferred);
        } else {
            self.leave_running(ctx, deferred);
        }
    }

    /// Does what leaves the open shot, after a question if something is running.
    fn leave_running(&mut self, ctx: &egui::Context, deferred: Deferred) {
        if self.asks_about_running(&deferred) {
            self.has_background_failed = false;
            self.questions.running = Some(deferred);
        } else {
            self.carry_out(ctx, deferred);
        }
    }

    /// Returns whether something runs that leaving the open shot would end or hide.
    fn asks_about_running(&self, deferred: &Deferred) -> bool {
        self.is_running() || *deferred == Deferred::Quit && !self.background.is_empty()
    }

    /// Returns whether what ran last ended without all of its files.
    fn has_failed(&self) -> bool {
        let is_failed =
            |session: &Session| session.has_export_failed() || session.run().is_some_and(RenderRun::has_failed);
        self.has_background_failed || self.session.as_ref().is_some_and(is_failed)
    }

    /// Returns whether the open shot is rendered or exported.
    pub(super) fn is_running(&self) -> bool {
        self.session.as_ref().is_some_and(|session| session.is_rendering() || session.is_exporting())
    }

    /// Does what leaves the open shot. Returns whether it was left: files that cannot be opened leave it as it is.
    fn carry_out(&mut self, ctx: &egui::Context, deferred: Deferred) -> bool {
        match deferred {
            Deferred::Open(files) => self.open_files(ctx, files),
            Deferred::Tour => self.begin_tour(ctx),
            Deferred::Start => {
                self.show_start();
                true
            }
            Deferred::Quit => {
                self.session.iter().for_each(|session| {
                    session.cancel_export();
                    session.cancel_render();
                });
                self.background.iter().for_each(RenderRun::cancel);
                self.may_close = true;
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
                true
            }
        }
    }

    fn ask_running(&mut self, ctx: &egui::Context) {
        let Some(deferred) = self.questions.running.clone() else { return };
        if !self.asks_about_running(&deferred) {
            // It ended by itself meanwhile.
            self.questions.running = None;
            // A window that closes now would hide why something failed.
            if deferred == Deferred::Quit && self.has_failed() {
                self.shows_render |= self.session.as_ref().is_some_and(|session| session.run().is_some());
            } else {
                self.carry_out(ctx, deferred);
            }
            return;
        }
        let is_exporting = self.session.as_ref().is_some_and(Session::is_exporting);
        let (title, words) = match (&deferred, is_exporting) {
            (Deferred::Quit, _) => {
                let words = "Renders and exports end with the editor; what is finished stays. Left open, this waits for \
                             them and quits then.";
                ("Stop what is running?", words)
            }
            (_, true) => ("Cancel the export?", "It cannot go on without its shot. Files that are finished stay."),
            (_, false) => (
                "Keep rendering?",
                "The shot is being rendered. It can go on in the background; the bar shows its progress.",
            ),
        };
        let answers = match (&deferred, is_exporting) {
            (Deferred::Quit, _) => ["", "Stop and quit", "Cancel"],
            (_, true) => ["", "Cancel the export", "Stay here"],
            (_, false) => ["Keep rendering", "Cancel the render", "Stay here"],
        };
        let Some(answer) = ask(ctx, (title, words), answers) else { return };
        self.questions.running = None;
        if answer == Answer::Cancel {
            return;
        }
        // An export ends with its session, and a render beside it goes on in the background.
        let is_render_ended = answer == Answer::Second && !is_exporting;
        let run = self.session.as_ref().and_then(Session::run).filter(|_| is_render_ended);
        let shot = run.map(|run| run.shot.clone());
        if self.carry_out(ctx, deferred)
            && let Some(shot) = shot
        {
            self.cancel_renders(&shot);
        }
    }

    /// Cancels the renders of a shot, whether it is open or not.
    fn cancel_renders(&self, shot: &Path) {
        let runs = self.background.iter().chain(self.session.as_ref().and_then(Session::run));
        runs.filter(|run| is_same_file(&run.shot, shot)).for_each(RenderRun::cancel);
    }

    /// Follows the renders of shots that are not open any more, and tells how they ended.
    pub(super) fn follow_background(&mut self) {
        let needs_processor = self.session.as_ref().is_some_and(Session::needs_processor);
        self.background.iter_mut().for_each(|run| {
            run.yield_to_view(needs_processor);
            run.pump();
        });
        for run in self.background.extract_if(.., |run| !run.is_running()) {
            self.has_background_failed |= run.has_failed();
            let (Some(told), Some(session)) = (run.outcome(), &mut self.session) else { continue };
            session.say(format!("{}: {told}", run.shot.display()));
        }
    }

    /// Looks for work of killed editors, and asks about that on a shot.
    pub(super) fn look_for_work(&mut self, shot: &Path) {
        self.left = unfinished(&self.options.journals());
        let left = self.left.iter().find(|left| is_same_file(&left.path, shot));
        self.questions.recovered = left.map(|left| left.journal.clone());
    }

    /// Opens the work that a killed editor left in a journal.
    pub(super) fn recover(&mut self, ctx: &egui::Context, journal: &Path) -> Result<(), EditError> {
        let document = Document::recovered(journal)?.allowing(self.options.access);
        self.left.retain(|left| left.journal != journal);
        self.begin(ctx, document);
        Ok(())
    }

    /// Deletes the work that a killed editor left in a journal.
    pub(super) fn forget(&mut self, journal: &Path) {
        forget(journal);
        self.left.retain(|left| left.journal != journal);
    }

    fn ask_recovery(&mut self, ctx: &egui::Context) {
        let Some(journal) = self.questions.recovered.clone() else { return };
        let count =
            self.left.iter().find(|left| left.journal == journal).map_or(0, |left| left.history.labels().count());
        let words =
            format!("The editor ended before {} of this shot were saved.", pluralised(count, "change", "changes"));
        let asked = ask(ctx, ("Recover the changes?", &words), ["Recover", "Forget", "Later"]);
        let Some(answer) = asked else { return };
        self.questions.recovered = None;
        match answer {
            Answer::First => {
                if let Err(error) = self.recover(ctx, &journal) {
                    self.show_error(&error);
                }
            }
            Answer::Second => self.forget(&journal),
            Answer::Cancel => {}
        }
    }

    /// Saves to another path, after a question if there is a file.
    pub(super) fn try_save_as(&mut self, path: &Path) {
        let Some(session) = &mut self.session else { return };
        let saved = if is_same_file(path, session.document().path()) {
            session.save()
        } else if path.exists() {
            self.questions.overwritten = Some(path.to_owned());
            return;
        } else {
            session.save_as(path)
        };
        if let Err(error) = saved {
            self.show_error(&error);
        }
    }

    fn ask_overwrite(&mut self, ctx: &egui::Context) {
        let Some(path) = self.questions.overwritten.clone() else { return };
        let words = format!("{} is there already. What is in it is lost otherwise.", path.display());
        let asked = ask(ctx, ("Overwrite the file?", &words), ["Overwrite", "", "Cancel"]);
        let (Some(answer), Some(session)) = (asked, &mut self.session) else { return };
        self.questions.overwritten = None;
        if answer == Answer::First
            && let Err(error) = session.save_as(&path)
        {
            session.say(error.to_string());
        }
    }

    /// Looks whether another program wrote the shot file.
    pub(super) fn look_at_disk(&mut self) {
        let Some(session) = self.session.as_mut().filter(|session| session.conflict.is_none()) else { return };
        if !session.take_written() {
            return;
        }
        let was_there = session.document().on_disk().is_some();
        match session.document_mut().check_disk() {
            Ok(DiskChange::None) if was_there && session.document().on_disk().is_none() => {
                session.say("The shot file was removed. Saving writes it again.");
            }
            Ok(DiskChange::None) => {}
            Ok(DiskChange::Reloaded) => {
                session.reload();
                session.say("The file changed on disk: it was read again. Undo brings back what was here.");
            }
            Ok(DiskChange::Merged) => {
                session.reload();
                session.say(
                    "The file changed on disk elsewhere: both changes are here now. Undo takes those of the file back.",
                );
            }
            Ok(DiskChange::Conflict(text)) => session.conflict = Some(text),
            Err(error) => session.say(format!("The file changed on disk and is no shot any more: {error}")),
        }
    }

    fn ask_conflict(&mut self, ctx: &egui::Context) {
        let Some(session) = self.session.as_mut().filter(|session| session.conflict.is_some()) else { return };
        let words = "Another program wrote the shot file, and there are changes here that are not saved.";
        let answers = ["Take the file", "Keep mine", "Later"];
        let Some(answer) = ask(ctx, ("The file changed on disk", words), answers) else { return };
        let Some(text) = session.conflict.take() else { return };
        match answer {
            Answer::First => match session.document_mut().take_from_disk(text) {
                Ok(()) => session.reload(),
                Err(error) => session.say(error.to_string()),
            },
            Answer::Second => {
                session.document_mut().keep_own(text);
                session.say("Saving overwrites what the other program wrote.");
            }
            Answer::Cancel => session.say("The file on disk is another one. Saving asks again."),
        }
    }

    fn ask_unsaved(&mut self, ctx: &egui::Context) {
        let Some(deferred) = self.questions.unsaved.clone() else { return };
        let name = self.session.as_ref().map(|session| session.document().path().display().to_string());
        let words = format!("The changes of {} are lost otherwise.", name.unwrap_or_default());
        let asked = ask(ctx, ("Save the changes?", &words), ["Save", "Discard", "Cancel"]);
        let (Some(answer), Some(session)) = (asked, &mut self.session) else { return };
        self.questions.unsaved = None;
        if answer == Answer::First
            && let Err(error) = session.save()
        {
            session.say(error.to_string());
            return;
        }
        if answer == Answer::Cancel {
            return;
        }
        self.leave_running(ctx, deferred);
    }

    /// Tells what is wrong with the journal.
    pub(super) fn tell_journal(&mut self) {
        let fault = self.session.as_mut().and_then(|session| session.document_mut().take_journal_fault());
        if let (Some(session), Some(fault)) = (&mut self.session, fault) {
            session.say(fault);
        }
    }
}
