//! The native window.

use super::editor::Editor;
use super::options::EditorOptions;
use crate::edit::EditError;
use eframe::egui::{self, ViewportBuilder};
use std::path::Path;

impl eframe::App for Editor {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        Self::ui(self, ui);
    }
}

/// Opens the window, and a file in it; returns when it is closed.
///
/// # Errors
/// [`EditError::NoDisplay`] if there is no display; others if the file cannot be opened.
pub(crate) fn run(path: Option<&Path>, options: EditorOptions) -> Result<(), EditError> {
    // A file that cannot be opened is reported on the command line, before the window opens.
    let document = path.map(|path| crate::edit::open(path, options.access)).transpose()?;
    let is_told = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if cfg!(all(unix, not(target_os = "macos"))) && !is_told("DISPLAY") && !is_told("WAYLAND_DISPLAY") {
        return Err(EditError::NoDisplay { what: "neither DISPLAY nor WAYLAND_DISPLAY is set".into() });
    }
    let viewport = ViewportBuilder::default()
        .with_title("pinwarp")
        .with_app_id("pinwarp")
        .with_inner_size([1440.0, 900.0])
        .with_min_inner_size([900.0, 560.0])
        .with_drag_and_drop(true);
    let native =
        eframe::NativeOptions { viewport, renderer: eframe::Renderer::Glow, ..eframe::NativeOptions::default() };
    let create: eframe::AppCreator = Box::new(move |context| {
        let mut editor = Editor::new(&context.egui_ctx, options);
        if let Some(document) = document {
            editor.begin(&context.egui_ctx, document);
        }
        Ok(Box::new(editor))
    });
    eframe::run_native("pinwarp", native, create).map_err(|error| EditError::NoDisplay { what: error.to_string() })
}
