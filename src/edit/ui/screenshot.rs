//! Renders the editor to a picture, without a window: for scripts, documentation and tests.

use super::editor::Editor;
use super::kept_view::KeptView;
use super::options::EditorOptions;
use super::software::SoftwarePainter;
use crate::edit::{EditError, Session};
use crate::image::{Preview, write_png};
use crate::shot::Layer;
use crate::spelling::hint;
use eframe::egui::{self, RawInput, Theme, ThemePreference};
use std::path::Path;
use std::time::Duration;

/// Timeout of a frame.
const LONGEST: Duration = Duration::from_secs(600);

/// Number of passes until the layout is settled.
const PASSES: usize = 4;

/// What a picture of the editor shows.
#[derive(Clone, Debug)]
pub(crate) struct Screenshot {
    /// The frame; `None`: the first one.
    pub(crate) frame: Option<i32>,
    /// Names of the selected pins.
    pub(crate) pins: Vec<String>,
    /// Whether the timeline shows curves.
    pub(crate) has_curves: bool,
    /// Width and height in pixels.
    pub(crate) size: [u32; 2],
    /// Light or dark.
    pub(crate) theme: Theme,
}

/// Draws a picture of the editor with a shot open, as the window would show it once the frame is rendered.
///
/// # Errors
/// [`EditError`] if the shot cannot be opened or rendered, it has no such frame or pins, or the picture cannot be written.
pub(crate) fn screenshot(
    path: &Path,
    shown: &Screenshot,
    output: &Path,
    options: EditorOptions,
) -> Result<(), EditError> {
    let ctx = egui::Context::default();
    ctx.set_theme(ThemePreference::from(shown.theme));
    let document = crate::edit::open(path, options.access)?;
    let mut editor = Editor::with_view(&ctx, options, KeptView::default());
    editor.begin_unjournaled(&ctx, document);
    if shown.has_curves {
        editor.timeline.toggle_curves();
    }
    if let Some(session) = editor.session_mut() {
        if let Some(frame) = shown.frame {
            session.go(frame);
        }
        shown.pins.iter().try_for_each(|name| select(session, name))?;
        if !session.settle(LONGEST) {
            let what = session.fault().unwrap_or("the frame took more than ten minutes").to_owned();
            return Err(EditError::Unusable { what, hint: "run `pinwarp check` on the shot".into() });
        }
        session.hold();
    }
    let picture = draw(&ctx, &mut editor, shown.size);
    Ok(write_png(output, &picture)?)
}

/// Selects a pin, too, by its name.
fn select(session: &mut Session, name: &str) -> Result<(), EditError> {
    let layers = || session.shot().layers.iter().enumerate();
    let place = |(layer, own): (usize, &Layer)| {
        Some([layer, own.pins.iter().position(|pin| pin.name == name && !pin.is_muted)?])
    };
    let Some(at) = layers().find_map(place) else {
        let names = layers().flat_map(|(_, layer)| &layer.pins).map(|pin| pin.name.as_str());
        let what = format!("no layer has a pin '{name}' that acts");
        return Err(EditError::Unusable { what, hint: hint(name, names) });
    };
    session.selection.layer = at[0];
    session.selection.pins.insert(at);
    Ok(())
}

/// Draws the editor.
fn draw(ctx: &egui::Context, editor: &mut Editor, size: [u32; 2]) -> Preview {
    let mut painter = SoftwarePainter::default();
    let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(size[0] as f32, size[1] as f32));
    let mut picture = Preview::transparent(size[0], size[1]);
    for pass in 0..PASSES {
        let input = RawInput { screen_rect: Some(screen), time: Some(pass as f64), ..RawInput::default() };
        let mut output = ctx.run_ui(input, |ui| editor.ui(ui));
        painter.take_textures(&mut output.textures_delta);
        if pass + 1 == PASSES {
            picture = painter.draw(ctx, &output, size);
        }
    }
    picture
}
