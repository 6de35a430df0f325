//! The editor: the open document, the open windows, and the layout of one pass.

use super::browser::{Browser, Choice, Purpose};
use super::kept_view::KeptView;
use super::options::EditorOptions;
use super::pan::Pan;
use super::start::StartAction;
use super::timeline::Timeline;
use super::viewport::Textures;
use super::{bundled, dialogs, export_window, key_window, keys, menus, panels, start, theme, tour_window, viewport};
use crate::edit::{Action, Document, Dropped, EditError, RenderOrder, RenderRun, Session, Shortcuts, Tour, Unfinished};
use crate::edit::{recent_shots, remember_shot, unfinished};
use crate::files::is_same_file;
use eframe::egui::{self, CentralPanel, Frame, Panel, Ui};
use std::path::{Path, PathBuf};

/// The operation deferred until the user has decided about unsaved work.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Deferred {
    Open(Dropped),
    Tour,
    /// Goes back to the start page.
    Start,
    Quit,
}

/// What is asked about files and renders.
#[derive(Debug, Default)]
pub(super) struct Questions {
    /// Whether to save unsaved work before this.
    pub(super) unsaved: Option<Deferred>,
    /// Whether to keep what is running before this.
    pub(super) running: Option<Deferred>,
    /// Whether to overwrite this file by the shot.
    pub(super) overwritten: Option<PathBuf>,
    /// Whether to recover work on the open shot from this journal.
    pub(super) recovered: Option<PathBuf>,
}

/// The editor.
pub(crate) struct Editor {
    pub(super) options: EditorOptions,
    pub(super) shortcuts: Shortcuts,
    view: KeptView,
    pub(super) session: Option<Session>,
    /// Renders of shots that are not open any more.
    pub(super) background: Vec<RenderRun>,
    /// Whether one of these failed since the user was asked about what runs.
    pub(super) has_background_failed: bool,
    /// Work of killed editors.
    pub(super) left: Vec<Unfinished>,
    /// Shots that were open last, as the start page lists them.
    recent: Vec<PathBuf>,
    fault: Option<String>,
    pub(super) browser: Option<Browser>,
    pub(super) timeline: Timeline,
    textures: Textures,
    pan: Pan,
    pub(super) shows_keys: bool,
    /// The action that is waiting for its new key.
    pub(super) rebound: Option<Action>,
    /// Whether keys were meant for a text field, a question or a menu in the last pass: Escape leaves these before they are shown.
    pub(super) were_keys_taken: bool,
    tour: Option<Tour>,
    pub(super) shows_render: bool,
    pub(super) render_order: RenderOrder,
    pub(super) questions: Questions,
    pub(super) may_close: bool,
}

impl Editor {
    /// Starts without an open document.
    #[must_use]
    pub(crate) fn new(ctx: &egui::Context, options: EditorOptions) -> Self {
        let (view, fault) = KeptView::read(ctx, options.view());
        let mut editor = Self::with_view(ctx, options, view);
        editor.fault = editor.fault.or(fault);
        editor
    }

    /// Starts without an open document, with a view.
    pub(super) fn with_view(ctx: &egui::Context, options: EditorOptions, view: KeptView) -> Self {
        theme::install(ctx);
        let (shortcuts, fault) = match Shortcuts::read(&options.keys(), keys::known) {
            Ok(shortcuts) => (shortcuts, None),
            Err(error) => (Shortcuts::default(), Some(error.to_string())),
        };
        let (left, recent) = (unfinished(&options.journals()), recent_shots(&options.recent()));
        Self {
            options,
            shortcuts,
            view,
            session: None,
            background: Vec::new(),
            has_background_failed: false,
            left,
            recent,
            fault,
            browser: None,
            timeline: Timeline::default(),
            textures: Textures::default(),
            pan: Pan::default(),
            shows_keys: false,
            rebound: None,
            were_keys_taken: false,
            tour: None,
            shows_render: false,
            render_order: RenderOrder::default(),
            questions: Questions::default(),
            may_close: false,
        }
    }

    /// Returns the open session.
    #[cfg(test)]
    #[must_use]
    pub(crate) const fn session(&self) -> Option<&Session> {
        self.session.as_ref()
    }

    /// Returns the open session mutably.
    pub(crate) const fn session_mut(&mut self) -> Option<&mut Session> {
        self.session.as_mut()
    }

    /// Opens a file.
    ///
    /// # Errors
    /// [`EditError`] if it cannot be opened; the current document then stays open.
    pub(crate) fn open(&mut self, ctx: &egui::Context, path: &Path) -> Result<(), EditError> {
        let document = crate::edit::open(path, self.options.access)?;
        let shot = document.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_beside = document.on_disk().is_some() && *name != *shot;
        self.begin(ctx, document);
        if let Some(session) = self.session.as_mut().filter(|session| is_beside && session.message().is_none()) {
            session.say(format!("{shot} opened, the shot of {name}"));
        }
        Ok(())
    }

    /// Starts editing a document.
    pub(super) fn begin(&mut self, ctx: &egui::Context, mut document: Document) {
        self.questions = Questions::default();
        // Bundled scenes are on the start page anyway.
        if !document.path().starts_with(&self.options.folder)
            && let Err(error) = remember_shot(&self.options.recent(), document.path())
        {
            tracing::warn!("the shot cannot be listed on the start page: {error}");
        }
        self.recent = recent_shots(&self.options.recent());
        if !document.has_journal() {
            self.look_for_work(document.path());
            document.keep_journal(&self.options.journals());
        }
        self.begin_unjournaled(ctx, document);
        (self.textures, self.timeline, self.tour) = (Textures::default(), Timeline::default(), None);
        if let (Some(session), Some(fault)) = (&mut self.session, self.fault.take()) {
            // What was wrong at the start is told once.
            session.say(fault);
        }
    }

    /// Closes the open shot, and shows the start page.
    pub(super) fn show_start(&mut self) {
        self.background.extend(self.session.as_mut().and_then(Session::take_run));
        (self.session, self.tour, self.shows_render) = (None, None, false);
        self.left = unfinished(&self.options.journals());
    }

    /// Starts editing a document without a journal, leaving nothing on disk.
    pub(super) fn begin_unjournaled(&mut self, ctx: &egui::Context, document: Document) {
        let wake = ctx.clone();
        let mut session = Session::new(document, self.options.device.clone(), move || wake.request_repaint());
        session.shown = self.view.settings.shown;
        self.background.extend(self.session.as_mut().and_then(Session::take_run));
        let path = session.document().path().to_owned();
        if let Some(run) = self.background.extract_if(.., |run| is_same_file(&run.shot, &path)).next() {
            session.resume_run(run);
        }
        self.shows_render &= session.run().is_some();
        self.render_order = RenderOrder::default();
        self.session = Some(session);
    }

    pub(super) fn show_error(&mut self, error: &EditError) {
        match &mut self.session {
            Some(session) => session.say(error.to_string()),
            None => self.fault = Some(error.to_string()),
        }
    }

    /// Runs one pass of the user interface.
    pub(crate) fn ui(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        let now = ctx.input(|input| input.time);
        self.drops(&ctx);
        if let Some(session) = &mut self.session {
            session.pump();
            session.tick(now);
            if let Some(secs) = session.playhead.due_in(now) {
                ctx.request_repaint_after(std::time::Duration::from_secs_f64(secs));
            }
        }
        self.follow_background();
        self.look_at_disk();
        self.tell_journal();
        if let Some(session) = self.session.as_mut().filter(|_| ctx.input(|input| input.pointer.any_pressed())) {
            // Each drag of a number is undone separately.
            session.document_mut().end_series();
        }
        let is_free = self.session.as_ref().is_some_and(|session| !session.is_dragging());
        if self.rebound.is_none() && self.pan.is_tapped(&ctx, &self.shortcuts, is_free) {
            self.act(&ctx, Action::Play, now);
        }
        let pressed = if self.rebound.is_none() { keys::pressed(&ctx, &self.shortcuts) } else { Vec::new() };
        for action in pressed {
            self.act(&ctx, action, now);
        }
        self.bar(ui, &ctx, now);
        match &mut self.session {
            None => {
                let known = (&self.left[..], &self.recent[..]);
                let shown = CentralPanel::no_frame().show(ui, |ui| start::show(ui, known, self.fault.as_deref()));
                self.start(&ctx, shown.inner);
            }
            Some(session) => {
                let kept = self.view.settings.panels;
                let (sizes, is_resized) = panels::show(ui, session, (&mut self.timeline, now), kept);
                self.view.see_panels(sizes, is_resized);
                let central = CentralPanel::no_frame().frame(Frame::NONE);
                central
                    .show(ui, |ui| viewport::show(ui, session, &self.shortcuts, (&mut self.textures, &mut self.pan)));
            }
        }
        // A key that is being bound triggers nothing.
        if self.rebound.is_none() {
            self.late_keys(&ctx, now);
        }
        self.windows(&ctx);
        self.were_keys_taken = keys::are_taken(&ctx) || egui::Popup::is_any_open(&ctx);
        self.view.keep(&ctx, self.session.as_ref().map(|session| session.shown));
        self.close(&ctx);
    }

    fn bar(&mut self, ui: &mut Ui, ctx: &egui::Context, now: f64) {
        let chosen = Panel::top("bar").show(ui, |ui| {
            ui.horizontal(|ui| {
                let (mut chosen, opened) = menus::show(ui, self.session.as_mut(), &self.shortcuts, &self.recent);
                if let Some(session) = &self.session {
                    let keys = (&self.shortcuts, !self.shows_render);
                    match menus::state(ui, session, &self.background, keys) {
                        Some(menus::BarClick::Render) => chosen.push(Action::Render),
                        Some(menus::BarClick::ShowRender) => self.shows_render = true,
                        None => {}
                    }
                }
                (chosen, opened)
            })
            .inner
        });
        let (actions, opened) = chosen.inner;
        for action in actions {
            self.act(ctx, action, now);
        }
        if let Some(shot) = opened {
            self.try_open(ctx, Dropped::of([shot]));
        }
    }

    fn start(&mut self, ctx: &egui::Context, action: Option<StartAction>) {
        let Some(action) = action else { return };
        let done = match action {
            StartAction::Open => {
                self.browse(Purpose::Open);
                Ok(())
            }
            StartAction::Recent(shot) => self.open(ctx, &shot),
            StartAction::Bundled(index) => self.open_bundled(ctx, index),
            StartAction::Tour => {
                self.tour(ctx);
                Ok(())
            }
            StartAction::Recover(journal) => self.recover(ctx, &journal),
            StartAction::Forget(journal) => {
                self.forget(&journal);
                Ok(())
            }
        };
        if let Err(error) = done {
            self.show_error(&error);
        }
    }

    fn open_bundled(&mut self, ctx: &egui::Context, index: usize) -> Result<(), EditError> {
        let shot = bundled::BUNDLED[index].unpack(&self.options.folder.join("scenes"))?;
        self.open(ctx, &shot)
    }

    /// Begins the tour on the first bundled scene, after questions if there is unsaved work or a render of another shot.
    pub(super) fn tour(&mut self, ctx: &egui::Context) {
        if self.has_tour_scene() {
            self.begin_tour(ctx);
        } else {
            self.leave(ctx, Deferred::Tour);
        }
    }

    fn has_tour_scene(&self) -> bool {
        let shot = bundled::BUNDLED[0].shot(&self.options.folder.join("scenes"));
        self.session.as_ref().is_some_and(|session| is_same_file(session.document().path(), &shot))
    }

    /// Begins the tour. Returns whether its scene is open.
    pub(super) fn begin_tour(&mut self, ctx: &egui::Context) -> bool {
        if !self.has_tour_scene()
            && let Err(error) = self.open_bundled(ctx, 0)
        {
            self.show_error(&error);
            return false;
        }
        self.tour = self.session.as_ref().map(Tour::begin);
        true
    }

    pub(super) fn browse(&mut self, purpose: Purpose) {
        let near =
            self.session.as_ref().map_or_else(|| PathBuf::from("."), |session| session.document().path().to_owned());
        self.browser = Some(Browser::new(purpose, &near));
    }

    fn windows(&mut self, ctx: &egui::Context) {
        if self.shows_keys {
            let chords = key_window::Chords { shortcuts: &mut self.shortcuts, rebound: &mut self.rebound };
            self.shows_keys = key_window::show(ctx, chords, &self.options.keys());
        }
        if let (Some(tour), Some(session)) = (&mut self.tour, &mut self.session) {
            tour.follow(session);
            let is_open = tour_window::show(ctx, tour, session);
            session.shown.pointed = tour.pin(session).filter(|_| is_open);
            if !is_open {
                self.tour = None;
            }
        }
        self.render_window(ctx);
        if let Some(session) = &mut self.session {
            export_window::show(ctx, session);
            dialogs::replace_exported(ctx, session);
        }
        if let Some(browser) = &mut self.browser {
            let (purpose, choice) = (browser.purpose, browser.show(ctx));
            match choice {
                Choice::None => {}
                Choice::Cancelled => self.browser = None,
                Choice::File(path) => {
                    self.browser = None;
                    self.chosen(ctx, purpose, &path);
                }
            }
        }
        self.ask(ctx);
    }

    fn chosen(&mut self, ctx: &egui::Context, purpose: Purpose, path: &Path) {
        match (purpose, &mut self.session) {
            (Purpose::Open, _) => self.try_open(ctx, Dropped::of([path.to_owned()])),
            (Purpose::SaveAs, _) => self.try_save_as(path),
            (Purpose::Plate, Some(session)) => session.choose_plate(path),
            (Purpose::Reference, Some(session)) => {
                if let Err(error) = session.add_reference(path) {
                    session.say(error.to_string());
                }
            }
            (_, None) => {}
        }
    }

    /// Asks about unsaved work and what is running before the window closes.
    fn close(&mut self, ctx: &egui::Context) {
        let is_wanted = ctx.input(|input| input.viewport().close_requested());
        let is_dirty = self.session.as_ref().is_some_and(|session| session.document().has_unsaved_work());
        let is_running = self.is_running() || !self.background.is_empty();
        if is_wanted && (is_dirty || is_running) && !self.may_close {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.leave(ctx, Deferred::Quit);
        }
    }
}
