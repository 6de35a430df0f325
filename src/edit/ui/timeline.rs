//! The timeline: transport, ruler, and a row of keys for each pin of the chosen layer.

use super::icons::{self, Icon};
use super::theme::ACCENT;
use crate::edit::{AutoKey, EasePreset, Pace, Session};
use crate::shot::Ease;
use eframe::egui::{
    Align2, Color32, ComboBox, DragValue, FontId, Painter, Pos2, Rect, Response, Role, ScrollArea, Sense, Shape,
    Stroke, Ui, WidgetInfo, pos2, vec2,
};

/// Width of the names left of the rows.
const NAMES: f32 = 150.0;

/// Height of a row of keys.
const ROW: f32 = 20.0;

/// Height of the ruler.
const RULER: f32 = 24.0;

/// What the timeline remembers between frames of the window.
#[derive(Default)]
pub(super) struct Timeline {
    /// The pen scrubs.
    scrubs: bool,
    /// Frame at which a drag of keys began, and how far it is.
    moved: Option<(f32, i32)>,
}

/// Frames along a line of the window.
#[derive(Clone, Copy)]
struct Scale {
    first: f32,
    left: f32,
    per_frame: f32,
}

impl Scale {
    fn x(self, frame: f64) -> f32 {
        self.left + (frame as f32 - self.first + 0.5) * self.per_frame
    }

    fn frame(self, x: f32) -> f32 {
        (x - self.left) / self.per_frame - 0.5 + self.first
    }
}

impl Timeline {
    pub(super) fn show(&mut self, ui: &mut Ui, session: &mut Session, now: f64) {
        transport(ui, session, now);
        ui.add_space(2.0);
        let width = ui.available_width();
        let [first, last] = session.playhead.shot_range();
        let count = (last - first + 1).max(1) as f32;
        let rect = ui.available_rect_before_wrap();
        let per_frame = (width - NAMES - 16.0).max(40.0) / count;
        let scale = Scale { first: first as f32, left: rect.left() + NAMES, per_frame };
        self.ruler(ui, session, scale);
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.rows(ui, session, scale));
    }

    fn ruler(&mut self, ui: &mut Ui, session: &mut Session, scale: Scale) {
        let (response, painter) = ui.allocate_painter(vec2(ui.available_width(), RULER), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Slider, true, "Frames"));
        let rect = response.rect;
        let weak = ui.visuals().weak_text_color();
        let [first, last] = session.playhead.shot_range();
        let [from, to] = session.playhead.range();
        let range = Rect::from_x_y_ranges(
            scale.x(f64::from(from)) - 0.5 * scale.per_frame..=scale.x(f64::from(to)) + 0.5 * scale.per_frame,
            rect.bottom() - 5.0..=rect.bottom() - 1.0,
        );
        painter.rect_filled(range, 2, if session.playhead.has_range() { ACCENT } else { weak.gamma_multiply(0.4) });
        // Frames with a picture, so that it is seen what plays at once.
        for frame in (first..=last).filter(|&frame| session.picture_of(frame).is_some()) {
            let x = scale.x(f64::from(frame));
            let half = (0.5 * scale.per_frame).max(0.5);
            painter.rect_filled(
                Rect::from_x_y_ranges(x - half..=x + half, rect.bottom() - 8.0..=rect.bottom() - 6.0),
                0,
                Color32::from_rgb(90, 160, 100),
            );
        }
        let step = nice_step(60.0 / scale.per_frame);
        for frame in (first..=last).filter(|frame| frame.rem_euclid(step) == 0 || *frame == first) {
            let x = scale.x(f64::from(frame));
            painter.vline(x, rect.bottom() - 10.0..=rect.bottom() - 5.0, Stroke::new(1.0, weak));
            painter.text(pos2(x, rect.top()), Align2::CENTER_TOP, frame, FontId::proportional(10.5), weak);
        }
        self.scrub(&response, session, scale);
        playhead(&painter, rect, session, scale);
    }

    fn scrub(&mut self, response: &Response, session: &mut Session, scale: Scale) {
        if response.is_pointer_button_down_on()
            && let Some(at) = response.interact_pointer_pos()
        {
            self.scrubs = true;
            let frame = scale.frame(at.x).round() as i32;
            if frame != session.playhead.frame() {
                session.go(frame);
            }
        } else if std::mem::take(&mut self.scrubs) {
            session.go(session.playhead.frame());
        }
    }

    fn rows(&mut self, ui: &mut Ui, session: &mut Session, scale: Scale) {
        let layer = session.selection.layer;
        let Some(owner) = session.shot().layers.get(layer) else { return };
        let pins: Vec<(String, Vec<(f64, Ease)>)> = owner
            .pins
            .iter()
            .map(|pin| (pin.name.clone(), pin.keys.iter().map(|key| (key.frame, key.ease)).collect()))
            .collect();
        if pins.is_empty() {
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                ui.add_space(8.0);
                ui.weak(format!("Layer '{}' has no pins: click the model to place one.", owner.name));
            });
        }
        for (pin, (name, keys)) in pins.iter().enumerate() {
            self.row(ui, session, ([layer, pin], name, keys), scale);
        }
        let rect = ui.min_rect();
        playhead(&ui.painter_at(rect.expand(2.0)), rect, session, scale);
    }

    fn row(
        &mut self,
        ui: &mut Ui,
        session: &mut Session,
        (at, name, keys): ([usize; 2], &str, &[(f64, Ease)]),
        scale: Scale,
    ) {
        let (response, painter) = ui.allocate_painter(vec2(ui.available_width(), ROW), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Row, true, format!("Keys of {name}")));
        let rect = response.rect;
        let is_chosen = session.selection.pins.contains(&at);
        if is_chosen {
            painter.rect_filled(rect, 0, ui.visuals().selection.bg_fill.gamma_multiply(0.35));
        }
        let text = if is_chosen { ui.visuals().strong_text_color() } else { ui.visuals().text_color() };
        let names = Rect::from_min_max(rect.min, pos2(rect.left() + NAMES - 8.0, rect.bottom()));
        painter.with_clip_rect(names).text(
            pos2(rect.left() + 8.0, rect.center().y),
            Align2::LEFT_CENTER,
            name,
            FontId::proportional(12.5),
            text,
        );
        let line = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
        painter.hline(rect.x_range(), rect.bottom(), line);
        let by = self.moved.map_or(0, |(_, by)| by);
        let place = |(frame, _): &(f64, Ease)| {
            let shift = if session.selection.has_key(at, *frame) { f64::from(by) } else { 0.0 };
            pos2(scale.x(frame + shift), rect.center().y)
        };
        for pair in keys.windows(2) {
            if pair[0].1 != Ease::Hold {
                painter.line_segment([place(&pair[0]), place(&pair[1])], Stroke::new(2.0, line.color));
            }
        }
        for key in keys {
            let usual = Color32::from_gray(if ui.visuals().dark_mode { 200 } else { 90 });
            let fill = if session.selection.has_key(at, key.0) { ACCENT } else { usual };
            diamond(&painter, place(key), key.1, fill);
        }
        self.row_pen(ui, session, (&response, names), (at, keys, scale));
    }

    fn row_pen(
        &mut self,
        ui: &Ui,
        session: &mut Session,
        (response, names): (&Response, Rect),
        (at, keys, scale): ([usize; 2], &[(f64, Ease)], Scale),
    ) {
        let pressed = ui.input(|input| input.pointer.primary_pressed());
        let shift = ui.input(|input| input.modifiers.shift);
        let Some(pen) = response.interact_pointer_pos() else { return };
        if pressed && response.contains_pointer() {
            let far = |key: &&(f64, Ease)| (scale.x(key.0) - pen.x).abs();
            let near = keys.iter().filter(|key| far(key) <= 7.0).min_by(|a, b| far(a).total_cmp(&far(b)));
            match near {
                Some((time, _)) => {
                    session.choose_key(at, *time, shift);
                    self.moved = Some((scale.frame(pen.x), 0));
                }
                None if names.contains(pen) && shift => _ = session.selection.pins.insert(at),
                None if names.contains(pen) => session.selection.only_pin(at),
                None => {
                    session.selection.keys.clear();
                    session.go(scale.frame(pen.x).round() as i32);
                }
            }
        } else if let Some((from, by)) = &mut self.moved
            && response.dragged()
        {
            *by = (scale.frame(pen.x) - *from).round() as i32;
        }
        if response.drag_stopped()
            && let Some((_, by)) = self.moved.take()
        {
            session.shift_keys(by);
        }
    }
}

fn playhead(painter: &Painter, rect: Rect, session: &Session, scale: Scale) {
    let x = scale.x(f64::from(session.playhead.frame()));
    painter.vline(x, rect.y_range(), Stroke::new(1.5, ACCENT));
}

/// A key: a diamond; one that is held a square, a smooth one round.
fn diamond(painter: &Painter, at: Pos2, ease: Ease, fill: Color32) {
    let size = 5.0;
    match ease {
        Ease::Hold => _ = painter.rect_filled(Rect::from_center_size(at, vec2(8.0, 8.0)), 0, fill),
        Ease::Smooth => _ = painter.circle_filled(at, 4.8, fill),
        Ease::Linear | Ease::Bezier(_) => {
            let corners = [vec2(0.0, -size), vec2(size, 0.0), vec2(0.0, size), vec2(-size, 0.0)].map(|arm| at + arm);
            painter.add(Shape::convex_polygon(corners.to_vec(), fill, Stroke::NONE));
        }
    }
}

/// 1, 2 or 5 times a power of ten, at least so many frames.
fn nice_step(least: f32) -> i32 {
    let steps = [1, 2, 4, 6, 12, 24, 48, 120, 240, 480, 1200, 2400, 4800, 12_000, 48_000, 240_000];
    steps.into_iter().find(|&step| step as f32 >= least).unwrap_or(1_000_000)
}

fn transport(ui: &mut Ui, session: &mut Session, now: f64) {
    ui.horizontal(|ui| {
        ui.add_space(4.0);
        let [first, last] = session.playhead.range();
        if icons::button(ui, Icon::First, "First frame").clicked() {
            session.go(first);
        }
        if icons::button(ui, Icon::Back, "Frame back").clicked() {
            session.step(-1);
        }
        let (play, name) = if session.playhead.is_playing() { (Icon::Pause, "Stop") } else { (Icon::Play, "Play") };
        if icons::button(ui, play, name).clicked() {
            session.toggle_play(now);
        }
        if icons::button(ui, Icon::Forward, "Frame forward").clicked() {
            session.step(1);
        }
        if icons::button(ui, Icon::Last, "Last frame").clicked() {
            session.go(last);
        }
        let mut frame = session.playhead.frame();
        let [least, most] = session.playhead.shot_range();
        let value = ui.add(DragValue::new(&mut frame).range(least..=most.max(least)).speed(0.2)).accessible("Frame");
        if value.changed() {
            session.go(frame);
        }
        ui.weak(format!("of {most}"));
        ui.separator();
        let mut is_auto = session.auto_key == AutoKey::On;
        if ui
            .toggle_value(&mut is_auto, "Auto key")
            .on_hover_text("Dragging keys this frame. Off: all keys of the pin move alike.")
            .changed()
        {
            session.auto_key = if is_auto { AutoKey::On } else { AutoKey::Off };
        }
        if ui.button("Key").on_hover_text("Insert a key for the chosen pins").clicked() {
            session.insert_keys();
        }
        eases(ui, session);
        exposure(ui, session);
        let mut is_every = session.playhead.pace == Pace::EveryFrame;
        if ui
            .toggle_value(&mut is_every, "Every frame")
            .on_hover_text("Play every frame; off: in real time, dropping frames")
            .changed()
        {
            session.playhead.pace = if is_every { Pace::EveryFrame } else { Pace::RealTime };
        }
    });
}

fn eases(ui: &mut Ui, session: &mut Session) {
    let chosen = session.selection.keys.first().and_then(|(at, time)| {
        let pin = session.shot().layers.get(at[0])?.pins.get(at[1])?;
        pin.keys.iter().find(|key| key.frame == *time).map(|key| key.ease)
    });
    let text = chosen.map_or("Ease", |ease| EasePreset::of(ease).map_or("Curve", EasePreset::name));
    let list = ComboBox::from_id_salt("ease").selected_text(text).width(90.0).show_ui(ui, |ui| {
        for preset in EasePreset::ALL {
            if ui.selectable_label(chosen == Some(preset.ease()), preset.name()).clicked() {
                session.ease_keys(preset);
            }
        }
    });
    list.response.accessible("Ease");
}

fn exposure(ui: &mut Ui, session: &mut Session) {
    let step = session.shot().layers.get(session.selection.layer).map_or(1, |layer| layer.step);
    let name = |step: u32| match step {
        1 => "On ones".to_owned(),
        2 => "On twos".to_owned(),
        3 => "On threes".to_owned(),
        more => format!("On {more}s"),
    };
    let list = ComboBox::from_id_salt("exposure").selected_text(name(step)).width(84.0).show_ui(ui, |ui| {
        for wanted in [1, 2, 3, 4] {
            if ui.selectable_label(step == wanted, name(wanted)).clicked() {
                session.set_exposure(wanted);
            }
        }
    });
    list.response.accessible("Exposure");
}

/// A widget whose face is a sign gets a name.
pub(super) trait Accessible {
    /// The name that screen readers and tests know it by, shown on hover, too.
    fn accessible(self, name: &str) -> Self;
}

impl Accessible for Response {
    fn accessible(self, name: &str) -> Self {
        self.accessible_name(name).on_hover_text(name)
    }
}
