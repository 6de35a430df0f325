//! Executes actions, triggered by keys or menus.

use super::browser::Purpose;
use super::editor::{Deferred, Editor};
use super::keys;
use crate::edit::{Action, Session, Wipe};
use eframe::egui;

impl Editor {
    /// Executes an action.
    pub(super) fn act(&mut self, ctx: &egui::Context, action: Action, now: f64) {
        match action {
            Action::Open => self.browse(Purpose::Open),
            Action::SaveAs if self.session.is_some() => self.browse(Purpose::SaveAs),
            Action::Reference if self.session.is_some() => self.browse(Purpose::Reference),
            Action::Plate if self.session.is_some() => self.browse(Purpose::Plate),
            Action::Save => self.save(),
            Action::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
            Action::Keys => (self.shows_keys, self.rebound) = (!self.shows_keys, None),
            Action::Tour => self.tour(ctx),
            Action::Render => self.render(ctx),
            Action::RenderOptions => self.shows_render = self.session.is_some(),
            Action::Start if self.session.is_some() => self.leave(ctx, Deferred::Start),
            Action::Curves => self.timeline.toggle_curves(),
            // Whoever deletes key after key in the timeline means no pin.
            Action::Delete if self.timeline.has_focus() => {
                if let Some(session) = &mut self.session {
                    session.delete_keys();
                }
            }
            _ => {
                if let Some(session) = &mut self.session {
                    on_session(ctx, session, action, now);
                }
            }
        }
    }

    /// Handles the keys that widgets with keyboard focus use first: arrow keys, and Escape, which cancels the gesture.
    pub(super) fn late_keys(&mut self, ctx: &egui::Context, now: f64) {
        let Some(session) = self.session.as_mut().filter(|_| !keys::are_taken(ctx)) else { return };
        // Escape closes an open window, or leaves a field, first.
        let is_behind = self.shows_keys || self.browser.is_some() || self.were_keys_taken;
        if !is_behind && ctx.input(|input| input.key_pressed(egui::Key::Escape)) {
            session.cancel();
        }
        let can_nudge = !session.selection.tracks(session.document().shot()).is_empty();
        for action in keys::pressed_arrows(ctx, &self.shortcuts, can_nudge) {
            self.act(ctx, action, now);
        }
    }

    fn save(&mut self) {
        let Some(session) = &mut self.session else { return };
        let Err(error) = session.save() else { return };
        if session.conflict.is_some() {
            session.say(error.to_string());
        } else {
            session.say(format!("{error}; choose another place"));
            self.browse(Purpose::SaveAs);
        }
    }

    pub(super) fn render(&mut self, ctx: &egui::Context) {
        let Some(session) = &mut self.session else { return };
        let wake = ctx.clone();
        session.render(&self.render_order, self.options.device.clone(), move || wake.request_repaint());
        self.shows_render = true;
    }
}

fn on_session(ctx: &egui::Context, session: &mut Session, action: Action, now: f64) {
    let frame = session.playhead.frame();
    let [first, last] = session.playhead.range();
    let flip = |value: &mut bool| *value = !*value;
    if let Some(by) = action.nudge().filter(|_| !session.selection.tracks(session.document().shot()).is_empty()) {
        let pixel = 1.0 / f64::from(session.shot().size.height.max(1));
        return session.nudge(pixel * glam::DVec2::from(by));
    }
    let shown = &mut session.shown;
    match action {
        Action::Undo => {
            // A look at rendered frames is what was done last.
            let has_left = session.leave_rendered();
            if !has_left {
                session.undo();
            }
        }
        Action::Redo => session.redo(),
        Action::Copy => {
            session.copy_keys();
            // Platforms send a paste event only if the clipboard is not empty.
            ctx.copy_text("keys of pinwarp".to_owned());
        }
        Action::Paste => session.paste_keys(),
        Action::Delete if session.selection.keys.is_empty() => session.delete_pins(),
        Action::Delete => session.delete_keys(),
        Action::Mute => session.mute_chosen(),
        Action::Hard => session.toggle_hard(),
        Action::Mirror => flip(&mut session.mirrors),
        Action::MirrorPins => session.mirror_pins(),
        Action::All => session.choose_all(),
        Action::Play => session.toggle_play(now),
        Action::Back => session.step(-1),
        Action::Forward => session.step(1),
        Action::KeyBack => session.go_to_key(false),
        Action::KeyForward => session.go_to_key(true),
        Action::First => session.go(first),
        Action::Last => session.go(last),
        Action::Key => session.insert_keys(),
        Action::RangeIn => session.set_range(Some([frame, last.max(frame)])),
        Action::RangeOut => session.set_range(Some([first.min(frame), frame])),
        Action::RangeAll => session.set_range(None),
        Action::Fit => session.zoom = crate::edit::Zoom::Fit,
        Action::OneToOne => zoom(session, 1.0 / f64::from(ctx.pixels_per_point()), None),
        Action::ZoomIn => zoom(session, 1.25, Some(())),
        Action::ZoomOut => zoom(session, 0.8, Some(())),
        Action::Lattice => flip(&mut shown.lattice),
        Action::Handles => flip(&mut shown.handles),
        Action::Pins => flip(&mut shown.pins),
        Action::Distortion => flip(&mut shown.distortion),
        Action::Trails => flip(&mut shown.trails),
        Action::SafeAreas => flip(&mut shown.safe_areas),
        Action::Onion => shown.onion.count = u32::from(shown.onion.count == 0) * 2,
        Action::Painted => flip(&mut shown.painted),
        Action::Wipe if matches!(shown.wipe, Wipe::At(_)) => session.set_wipe(Wipe::Off),
        Action::Wipe => session.set_wipe(Wipe::At(0.5)),
        Action::Ghost if matches!(shown.wipe, Wipe::Ghost(_)) => session.set_wipe(Wipe::Off),
        Action::Ghost => session.set_wipe(Wipe::Ghost(0.4)),
        _ => {}
    }
}

/// Zooms to a scale, or by a factor.
fn zoom(session: &mut Session, value: f64, by: Option<()>) {
    // The scale of a fitted picture depends on the viewport; from here on the centre stays fixed.
    let lens = session.zoom.lens(session.shot().size, session.viewport);
    let scale = if by.is_some() { lens.scale() * value } else { value };
    session.zoom = session.zoom.at_scale(&lens, scale);
}
