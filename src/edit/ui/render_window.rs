//! The window of a render: what to render, how and where to; progress, log, and a look at the frames.
//!
//! In: a [`Session`], a [`RenderOrder`]. Out: the order as changed; a render, started or cancelled.

use super::accessible::Accessible;
use super::editor::Editor;
use super::number_field::whole;
use crate::edit::{RenderOrder, RenderRange, RunState, Session};
use eframe::egui::{self, Align2, Button, ComboBox, Grid, RichText, ScrollArea, TextEdit, Ui, vec2};

/// Smallest and largest size in per cent of the shot's.
const PERCENT: [u32; 2] = [1, 400];

/// What the user wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wish {
    Start,
    Close,
    /// To look at the frames.
    Look,
}

impl Editor {
    /// Shows the window of the render, if it is open.
    pub(super) fn render_window(&mut self, ctx: &egui::Context) {
        let Some(session) = self.session.as_mut().filter(|_| self.shows_render) else { return };
        let mut is_open = true;
        let mut wish = None;
        let window = egui::Window::new("Render").open(&mut is_open).collapsible(true).default_size(vec2(520.0, 320.0));
        window.anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0)).show(ctx, |ui| {
            let order = &mut self.render_order;
            ui.add_enabled_ui(!session.is_rendering(), |ui| {
                Grid::new("render").num_columns(2).spacing([10.0, 6.0]).show(ui, |ui| options(ui, session, order));
            });
            ui.separator();
            wish = run(ui, session, order);
        });
        match wish {
            Some(Wish::Start) => self.render(ctx),
            Some(Wish::Look) => {
                session.look_at_render();
                is_open = false;
            }
            Some(Wish::Close) => is_open = false,
            None => {}
        }
        self.shows_render = is_open;
        if let Some(session) = self.session.as_mut().filter(|_| !is_open) {
            session.close_render();
        }
    }
}

fn options(ui: &mut Ui, session: &Session, order: &mut RenderOrder) {
    ui.label("Frames");
    range(ui, session, &mut order.range);
    ui.end_row();
    ui.label("Files");
    ui.horizontal(|ui| {
        ui.label("EXR");
        let hint = "A picture to look at beside each EXR frame, in sRGB with 8 bits";
        ui.checkbox(&mut order.has_previews, "and PNG previews").on_hover_text(hint);
    });
    ui.end_row();
    ui.label("Size");
    ui.horizontal(|ui| {
        ui.add(whole(&mut order.percent, PERCENT[0]..=PERCENT[1]).suffix(" %")).accessible("Size in per cent");
        let size = order.shot(session.document().shot()).size;
        ui.weak(format!("{} x {} pixels", size.width, size.height));
    });
    ui.end_row();
    ui.label("Motion blur");
    ui.horizontal(|ui| {
        let shot = session.document().shot();
        let mut is_blurred = order.is_blurred.unwrap_or(shot.shutter.angle > 0.0);
        if ui.checkbox(&mut is_blurred, "").accessible("Motion blur of the render").changed() {
            order.is_blurred = Some(is_blurred);
        }
        let mut samples = order.samples.unwrap_or(shot.samples);
        let field = whole(&mut samples, 1..=4096).suffix(" samples");
        if ui.add(field).accessible("Samples of the render").changed() {
            order.samples = (samples != shot.samples).then_some(samples);
        }
    });
    ui.end_row();
    ui.label("Folder");
    let usual = session.document().shot().output.path.parent().map(|folder| folder.display().to_string());
    let field = TextEdit::singleline(&mut order.folder).hint_text(usual.unwrap_or_default()).desired_width(360.0);
    ui.add(field)
        .explained("Folder of the render", "Relative to the folder of the shot; empty: that of the shot's output");
    ui.end_row();
}

/// Chooses the frames.
fn range(ui: &mut Ui, session: &Session, chosen: &mut RenderRange) {
    let words = |range: RenderRange| {
        let ([first, last], [from, to]) = (session.playhead.shot_range(), session.playhead.range());
        match range {
            RenderRange::Played => format!("those played: {from} to {to}"),
            RenderRange::All => format!("all: {first} to {last}"),
            RenderRange::Shown => format!("the one shown: {}", session.playhead.frame()),
        }
    };
    let list = ComboBox::from_id_salt("range").selected_text(words(*chosen)).width(200.0).show_ui(ui, |ui| {
        for range in [RenderRange::Played, RenderRange::All, RenderRange::Shown] {
            ui.selectable_value(chosen, range, words(range));
        }
    });
    list.response.explained("Frames to render", "I and O set the frames that are played");
}

/// Shows the progress of the current or last render, its buttons and its log.
fn run(ui: &mut Ui, session: &Session, order: &RenderOrder) -> Option<Wish> {
    let mut wish = None;
    let Some(run) = session.run() else {
        ui.weak(format!("Frames go to {}", order.shot(session.document().shot()).output.path.display()));
        return ui.button("Start render").clicked().then_some(Wish::Start);
    };
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
            RunState::Ended(_) => wish = ui.button("Close").clicked().then_some(Wish::Close),
        }
    });
    if let RunState::Ended(words) = &run.state {
        ui.strong(words);
        ui.horizontal(|ui| {
            let hint = "Shows the rendered frames in place of the frame, until the next edit";
            let look = ui.add_enabled(run.has_frames(), Button::new("Look at the frames"));
            if look.on_hover_text(hint).clicked() {
                wish = Some(Wish::Look);
            }
            if ui.button("Start render").clicked() {
                wish = Some(Wish::Start);
            }
        });
    }
    ui.separator();
    ScrollArea::vertical().auto_shrink(false).stick_to_bottom(true).max_height(240.0).show(ui, |ui| {
        for line in &run.log {
            ui.label(RichText::new(line).small().monospace());
        }
    });
    wish
}
