//! Modal windows: questions.

use crate::edit::{ExportOrder, Session};
use eframe::egui::{self, Modal};

/// The answer to a three-way question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    First,
    Second,
    Cancel,
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
