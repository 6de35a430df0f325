//! Renders the editor to a picture, without a window: for scripts, documentation and tests.

use super::editor::Editor;
use super::kept_view::KeptView;
use super::options::EditorOptions;
use super::software::SoftwarePainter;
use crate::edit::EditError;
use crate::image::{Preview, write_png};
use eframe::egui::{self, RawInput, Theme, ThemePreference};
use std::path::Path;
use std::time::Duration;

/// Timeout of a frame.
const LONGEST: Duration = Duration::from_secs(600);

/// Number of passes until the layout is settled.
const PASSES: usize = 4;

/// Returns a picture of the editor with a shot open at a frame, as the window would show it once the frame is rendered.
///
/// # Errors
/// [`EditError`] if the shot cannot be opened or rendered, or the picture cannot be written.
pub(crate) fn screenshot(
    path: &Path,
    frame: Option<i32>,
    (size, theme, output): ([u32; 2], Theme, &Path),
    options: EditorOptions,
) -> Result<(), EditError> {
    let ctx = egui::Context::default();
    ctx.set_theme(ThemePreference::from(theme));
    let document = crate::edit::open(path, options.access)?;
    let mut editor = Editor::with_view(&ctx, options, KeptView::default());
    editor.begin_unjournaled(&ctx, document);
    if let Some(session) = editor.session_mut() {
        if let Some(frame) = frame {
            session.go(frame);
        }
        if !session.settle(LONGEST) {
            let what = session.fault().unwrap_or("the frame took more than ten minutes").to_owned();
            return Err(EditError::Unusable { what, hint: "run `pinwarp check` on the shot".into() });
        }
        session.hold();
    }
    let picture = draw(&ctx, &mut editor, size);
    Ok(write_png(output, &picture)?)
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
