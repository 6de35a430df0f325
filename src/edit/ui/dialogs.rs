//! Modal windows: render progress, questions.

use crate::edit::{ExportOrder, RunState, Session};
use eframe::egui::{self, Align2, Modal, RichText, ScrollArea, vec2};

/// The answer to a three-way question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    First,
    Second,
    Cancel,
}

/// Shows the current or last render. Returns false once closed.
pub(super) fn render(ctx: &egui::Context, session: &mut Session) -> bool {
    let mut is_wanted = false;
    let is_open = run_window(ctx, session, &mut is_wanted);
    if is_wanted {
        session.look_at_render();
    }
    is_open && !is_wanted
}

fn run_window(ctx: &egui::Context, session: &Session, is_wanted: &mut bool) -> bool {
    let Some(run) = session.run() else { return false };
    let (mut is_open, mut is_closed) = (true, false);
    let window = egui::Window::new("Render").open(&mut is_open).collapsible(true).default_size(vec2(520.0, 320.0));
    window.anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0)).show(ctx, |ui| {
        let (part, stage) = run.progress();
        ui.weak(format!("Frames go to {}", run.output.display()));
        if let Some(note) = &run.note {
            ui.colored_label(ui.visuals().warn_fg_color, note);
        }
        ui.horizontal(|ui| {
            ui.add(egui::ProgressBar::new(part as f32).desired_width(380.0).text(stage));
            match &run.state {
                RunState::Running if ui.button("Cancel").clicked() => session.cancel_render(),
                RunState::Running => {}
                RunState::Ended(_) => is_closed = ui.button("Close").clicked(),
            }
        });
        if let RunState::Ended(words) = &run.state {
            ui.strong(words);
            let hint = "Lays the rendered frames over the picture, frame by frame, as the reference";
            let look = ui.add_enabled(!run.files.is_empty(), egui::Button::new("Look at the frames"));
            *is_wanted = look.on_hover_text(hint).clicked();
        }
        ui.separator();
        ScrollArea::vertical().auto_shrink(false).stick_to_bottom(true).max_height(240.0).show(ui, |ui| {
            for line in &run.log {
                ui.label(RichText::new(line).small().monospace());
            }
        });
    });
    is_open && !is_closed
}

/// Asks whether an export may replace files that are there already.
pub(super) fn replace_exported(ctx: &egui::Context, session: &mut Session) {
    let Some(order) = session.export_clash().cloned() else { return };
    let words = session.message().unwrap_or_default().to_owned();
    let Some(answer) = ask(ctx, ("Replace the exported files?", &words), ["Replace", "Keep", ""]) else { return };
    session.keep_exported();
    if answer == Answer::First {
        let wake = ctx.clone();
        session.export(&ExportOrder { replaces: true, ..order }, move || wake.request_repaint());
    }
}

/// Asks a three-way question. Without a first answer the second one, which ends something, stands apart: it must not appear under a
/// pointer that has just answered another question.
pub(super) fn ask(ctx: &egui::Context, (title, words): (&str, &str), answers: [&str; 3]) -> Option<Answer> {
    let mut answer = None;
    let modal = Modal::new(egui::Id::unique(title)).show(ctx, |ui| {
        ui.set_width(400.0);
        ui.heading(title);
        ui.add_space(6.0);
        ui.label(words);
        ui.add_space(12.0);
        let [first, second, cancel] = answers;
        let mut button = |ui: &mut egui::Ui, text: &str, own: Answer| {
            if !text.is_empty() && ui.button(text).clicked() {
                answer = Some(own);
            }
        };
        ui.horizontal(|ui| {
            if first.is_empty() {
                button(ui, cancel, Answer::Cancel);
                let layout = egui::Layout::right_to_left(egui::Align::Center);
                ui.with_layout(layout, |ui| button(ui, second, Answer::Second));
                return;
            }
            button(ui, first, Answer::First);
            button(ui, second, Answer::Second);
            button(ui, cancel, Answer::Cancel);
        });
    });
    if modal.should_close() { Some(Answer::Cancel) } else { answer }
}
