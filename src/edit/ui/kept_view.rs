//! Remembers the view between sessions: reads it at the start, and writes it when it changes.
//!
//! In: the state of a pass. Out: a file; a fault of it is a message, never an obstacle.

use crate::edit::{Brightness, PanelSizes, Shown, ViewSettings};
use eframe::egui::{Context, ThemePreference};
use std::path::PathBuf;

/// The remembered view.
#[derive(Default)]
pub(super) struct KeptView {
    /// `None`: nothing is read or written.
    path: Option<PathBuf>,
    pub(super) settings: ViewSettings,
    written: ViewSettings,
    /// Sizes of the panels in the last pass.
    seen: PanelSizes,
}

impl KeptView {
    /// Reads a file and installs its theme; returns a message if the file is broken.
    pub(super) fn read(ctx: &Context, path: PathBuf) -> (Self, Option<String>) {
        let (settings, fault) = ViewSettings::read(&path);
        ctx.set_theme(match settings.theme {
            Brightness::Dark => ThemePreference::Dark,
            Brightness::Light => ThemePreference::Light,
            Brightness::System => ThemePreference::System,
        });
        (Self { path: Some(path), settings, written: settings, seen: PanelSizes::default() }, fault)
    }

    /// Takes the sizes of the panels in this pass. Only what the user resizes is remembered; all else follows the
    /// window.
    pub(super) fn see_panels(&mut self, now: PanelSizes, is_resized: bool) {
        let seen = std::mem::replace(&mut self.seen, now);
        let kept = &mut self.settings.panels;
        let sizes = [
            (&mut kept.timeline, seen.timeline, now.timeline),
            (&mut kept.layers, seen.layers, now.layers),
            (&mut kept.inspector, seen.inspector, now.inspector),
        ];
        for (kept, seen, now) in sizes {
            if is_resized && seen.is_some() && seen != now {
                *kept = now;
            }
        }
    }

    /// Writes the view if it is another than the one written last; not during a drag, which changes it many times.
    pub(super) fn keep(&mut self, ctx: &Context, shown: Option<Shown>) {
        if ctx.input(|input| input.pointer.any_down()) {
            return;
        }
        let theme = match ctx.options(|options| options.theme_preference) {
            ThemePreference::Dark => Brightness::Dark,
            ThemePreference::Light => Brightness::Light,
            ThemePreference::System => Brightness::System,
        };
        let shown = shown.map_or(self.settings.shown, Shown::lasting);
        self.settings = ViewSettings { theme, shown, ..self.settings };
        if self.settings == self.written {
            return;
        }
        self.written = self.settings;
        if let Some(path) = &self.path
            && let Err(error) = self.settings.write(path)
        {
            tracing::warn!("the view cannot be remembered: {error}");
            self.path = None;
        }
    }
}
