//! The timeline: transport, ruler, and a row of keys for each pin of the selected layer, or their curves.

use super::curves::CurveView;
use super::frame_scale::{FrameScale, NAMES, playhead};
use super::theme::ACCENT;
use super::transport::transport;
use crate::edit::Session;
use crate::shot::Ease;
use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Response, Role, ScrollArea, Sense, Shape, Stroke, Ui, WidgetInfo,
    pos2, vec2,
};

/// Height of a row of keys.
const ROW: f32 = 20.0;

/// Height of the ruler.
const RULER: f32 = 24.0;

/// State of the timeline kept between passes.
#[derive(Default)]
pub(super) struct Timeline {
    /// Whether the pointer is scrubbing.
    scrubs: bool,
    /// Frame at which a drag of keys began, and its offset in frames.
    moved: Option<(f32, i32)>,
    /// The pin whose row was scrolled into view last.
    followed: Option<[usize; 2]>,
    /// The curve editor, if shown instead of rows of keys.
    curves: Option<CurveView>,
}

impl Timeline {
    /// Toggles between curves and rows.
    pub(super) fn toggle_curves(&mut self) {
        self.curves = if self.curves.is_some() { None } else { Some(CurveView::default()) };
    }

    pub(super) fn show(&mut self, ui: &mut Ui, session: &mut Session, now: f64) {
        if transport(ui, session, (now, self.curves.is_some())) {
            self.toggle_curves();
        }
        ui.add_space(2.0);
        let width = ui.available_width();
        let [first, last] = session.playhead.shot_range();
        let count = (last - first + 1).max(1) as f32;
        let rect = ui.available_rect_before_wrap();
        let per_frame = (width - NAMES - 16.0).max(40.0) / count;
        let scale = FrameScale { first: first as f32, left: rect.left() + NAMES, per_frame };
        self.ruler(ui, session, scale);
        match &mut self.curves {
            Some(curves) => curves.show(ui, session, scale),
            None => {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.rows(ui, session, scale));
            }
        }
    }

    fn ruler(&mut self, ui: &mut Ui, session: &mut Session, scale: FrameScale) {
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
        // Marks the frames that are cached and thus play immediately.
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
        let here = session.playhead.frame();
        let galley = painter.layout_no_wrap(here.to_string(), FontId::proportional(10.5), Color32::BLACK);
        let place = Align2::CENTER_TOP.anchor_size(pos2(scale.x(f64::from(here)), rect.top()), galley.size());
        painter.rect_filled(place.expand2(vec2(4.0, 1.0)), 3, ACCENT);
        painter.galley(place.min, galley, Color32::BLACK);
    }

    fn scrub(&mut self, response: &Response, session: &mut Session, scale: FrameScale) {
        // A quick click may end before it is reported as held.
        if (response.is_pointer_button_down_on() || response.clicked())
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

    fn rows(&mut self, ui: &mut Ui, session: &mut Session, scale: FrameScale) {
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
        scale: FrameScale,
    ) {
        let (response, painter) = ui.allocate_painter(vec2(ui.available_width(), ROW), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Row, true, format!("Keys of {name}")));
        let rect = response.rect;
        let is_chosen = session.selection.pins.contains(&at);
        if session.selection.single_pin() == Some(at) && self.followed != Some(at) {
            response.scroll_to_me(None);
            self.followed = Some(at);
        }
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
        (at, keys, scale): ([usize; 2], &[(f64, Ease)], FrameScale),
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

/// Draws a key: a diamond; a square if it holds, a circle if smooth.
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

/// Returns the smallest step of the ruler that is at least `least` frames.
fn nice_step(least: f32) -> i32 {
    let steps = [1, 2, 4, 6, 12, 24, 48, 120, 240, 480, 1200, 2400, 4800, 12_000, 48_000, 240_000];
    steps.into_iter().find(|&step| step as f32 >= least).unwrap_or(1_000_000)
}
