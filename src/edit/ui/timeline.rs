//! The timeline: transport, ruler, and a row of keys for each pin of the selected layer, or their curves.

use super::accessible::{self, Part};
use super::curves::CurveView;
use super::frame_scale::{FrameScale, NAMES, playhead};
use super::theme::{ACCENT, heat};
use super::track_row::{self, Pen, Row, RowView};
use super::transport::transport;
use crate::edit::{Figure, Session, Track};
use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rangef, Rect, Response, Role, ScrollArea, Sense, Shape, Stroke, StrokeKind,
    Ui, WidgetInfo, pos2, vec2,
};
use std::collections::BTreeMap;

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
    /// Two opposite corners of the box that selects keys.
    boxed: Option<[Pos2; 2]>,
    /// Whether a row or the curves have keyboard focus.
    has_focus: bool,
}

impl Timeline {
    /// Toggles between curves and rows.
    pub(super) fn toggle_curves(&mut self) {
        self.curves = if self.curves.is_some() { None } else { Some(CurveView::default()) };
    }

    /// Returns whether a row or the curves had keyboard focus in the last pass.
    pub(super) const fn has_focus(&self) -> bool {
        self.has_focus
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
        self.has_focus = false;
        match &mut self.curves {
            Some(curves) => self.has_focus = curves.show(ui, session, scale),
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
        for run in joined_runs(session.drawn_frames(), scale) {
            let bar = Rect::from_x_y_ranges(run, rect.bottom() - 8.0..=rect.bottom() - 6.0);
            painter.rect_filled(bar, 0, Color32::from_rgb(90, 160, 100));
        }
        let step = nice_step(60.0 / scale.per_frame);
        // The first frame, and multiples of the step.
        let next = first.saturating_add(step - first.rem_euclid(step));
        for frame in std::iter::once(first).chain((next..=last).step_by(step.unsigned_abs() as usize)) {
            let x = scale.x(f64::from(frame));
            painter.vline(x, rect.bottom() - 10.0..=rect.bottom() - 5.0, Stroke::new(1.0, weak));
            painter.text(pos2(x, rect.top()), Align2::CENTER_TOP, frame, FontId::proportional(10.5), weak);
        }
        mark_worst(ui, session, (&response, &painter), scale);
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
        let rows = track_row::rows(session);
        if rows.is_empty() {
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                ui.add_space(8.0);
                ui.weak(format!("Layer '{}' has no pins: click the {} to place one.", owner.name, session.subject()));
            });
        }
        let by = self.moved.map_or(0, |(_, by)| by);
        let mut seen: Vec<(Rect, Row)> = Vec::new();
        let (mut pen, mut ids, mut entered) = (Pen::Away, Vec::new(), None);
        for row in rows {
            let alone = session.selection.single_pin().filter(|&at| row.track == Track::Pin(at));
            let follows = alone.is_some() && self.followed != alone;
            if follows {
                self.followed = alone;
            }
            let shown = track_row::show(ui, session, &row, RowView { scale, moved_by: by, scrolls_here: follows });
            pen = if shown.pen == Pen::Away { pen } else { shown.pen };
            if shown.leaves != 0 {
                entered = Some(seen.len().saturating_add_signed(shown.leaves as isize));
            }
            self.has_focus |= shown.response.has_focus();
            ids.push(shown.response.id);
            seen.push((shown.response.rect, row));
        }
        if let Some(&id) = entered.and_then(|place| ids.get(place)) {
            ui.memory_mut(|memory| memory.request_focus(id));
        }
        self.pen(session, scale, (pen, &seen));
        let rect = ui.min_rect();
        let painter = ui.painter_at(rect.expand(2.0));
        if let Some([from, to]) = self.boxed {
            let stroke = Stroke::new(1.0, ACCENT);
            painter.rect(Rect::from_two_pos(from, to), 0, Color32::from_white_alpha(14), stroke, StrokeKind::Middle);
        }
        // It would cross the words that stand in for rows.
        if !seen.is_empty() {
            playhead(&painter, rect, session, scale);
        }
    }

    /// Moves keys, or selects those in a box.
    fn pen(&mut self, session: &mut Session, scale: FrameScale, (pen, rows): (Pen, &[(Rect, Row)])) {
        match pen {
            Pen::Away => {}
            Pen::Key(at) => (self.moved, self.boxed) = (Some((scale.frame(at.x), 0)), None),
            Pen::Empty(at) => {
                session.selection.keys.clear();
                session.go(scale.frame(at.x).round() as i32);
                (self.moved, self.boxed) = (None, Some([at, at]));
            }
            Pen::Dragged(at) => {
                if let Some((from, by)) = &mut self.moved {
                    *by = (scale.frame(at.x) - *from).round() as i32;
                } else if let Some([_, to]) = &mut self.boxed {
                    *to = at;
                }
            }
            Pen::Up => {
                if let Some((_, by)) = self.moved.take() {
                    session.shift_keys(by);
                }
                let Some([from, to]) = self.boxed.take() else { return };
                let chosen = Rect::from_two_pos(from, to);
                for (_, row) in rows.iter().filter(|(rect, _)| chosen.y_range().contains(rect.center().y)) {
                    for (time, _) in row.keys.iter().filter(|(time, _)| chosen.x_range().contains(scale.x(*time))) {
                        track_row::add_key(session, row.track, *time);
                    }
                }
            }
        }
    }
}

/// Marks the worst frames of the played range, in red those whose figures deserve a look. Screen readers find each by the figure, and
/// go to it.
fn mark_worst(ui: &Ui, session: &mut Session, (ruler, painter): (&Response, &Painter), scale: FrameScale) {
    let mut marks: BTreeMap<i32, (bool, Vec<&str>)> = BTreeMap::new();
    for figure in Figure::ALL {
        let Some((frame, value)) = session.worst(figure) else { continue };
        let (is_bad, names) = marks.entry(frame).or_default();
        *is_bad |= figure.is_bad(value);
        names.push(figure.name());
    }
    let tip = |frame: i32| pos2(scale.x(f64::from(frame)), ruler.rect.bottom() - 9.0);
    for (&frame, (is_bad, _)) in &marks {
        let corners = [vec2(0.0, 0.0), vec2(-4.0, -6.0), vec2(4.0, -6.0)].map(|arm| tip(frame) + arm);
        let color = if *is_bad { heat(3.0) } else { ui.visuals().weak_text_color() };
        painter.add(Shape::convex_polygon(corners.to_vec(), color, Stroke::NONE));
    }
    let worst = |frame: i32, names: &[&str]| format!("Worst by {}: frame {frame}", names.join(" and "));
    let pointed = ruler.hover_pos().and_then(|at| {
        let mark = |frame: &i32| Rect::from_center_size(tip(*frame) - vec2(0.0, 3.0), vec2(10.0, 8.0));
        marks.iter().find(|(frame, _)| mark(frame).contains(at))
    });
    if let Some((&frame, (is_bad, names))) = pointed {
        let hint = if *is_bad { "; it deserves a look" } else { "" };
        ruler.clone().on_hover_text_at_pointer(format!("{}{hint}", worst(frame, names)));
    }
    let parts = marks.iter().map(|(&frame, (_, names))| Part {
        id: ruler.id.with(("worst", frame)),
        rect: Rect::from_center_size(tip(frame) - vec2(0.0, 3.0), vec2(8.0, 6.0)),
        label: worst(frame, names),
        is_chosen: frame == session.playhead.frame(),
    });
    let chosen = accessible::parts(ui, ruler, parts);
    if let Some(&frame) = chosen.and_then(|place| marks.keys().nth(place)) {
        session.go(frame);
    }
}

/// Returns the smallest step of the ruler that is at least `least` frames.
fn nice_step(least: f32) -> i32 {
    let steps = [1, 2, 4, 6, 12, 24, 48, 120, 240, 480, 1200, 2400, 4800, 12_000, 48_000, 240_000];
    steps.into_iter().find(|&step| step as f32 >= least).unwrap_or(1_000_000)
}

/// Returns where frames lie, in ascending order. Those that touch are one run, so that long shots have no more of them than points.
fn joined_runs(frames: impl Iterator<Item = i32>, scale: FrameScale) -> Vec<Rangef> {
    let half = (0.5 * scale.per_frame).max(0.5);
    let mut runs: Vec<Rangef> = Vec::new();
    for x in frames.map(|frame| scale.x(f64::from(frame))) {
        match runs.last_mut() {
            Some(run) if x - half <= run.max + 0.01 => run.max = x + half,
            _ => runs.push(Rangef::new(x - half, x + half)),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawn_frames_of_a_long_shot_are_no_more_runs_than_points() {
        let runs = |per_frame: f32, frames: &mut dyn Iterator<Item = i32>| {
            joined_runs(frames, FrameScale { first: 1.0, left: 150.0, per_frame })
        };
        assert_eq!(runs(10.0, &mut [1, 2, 3, 7].into_iter()), [Rangef::new(150.0, 180.0), Rangef::new(210.0, 220.0)]);
        assert_eq!(runs(0.1, &mut (1..=10_000)).len(), 1);
        let odd = runs(0.1, &mut (1..=10_000).step_by(2));
        assert!(odd.len() == 1 && (odd[0].span() - 1000.9).abs() < 0.5, "{odd:?}");
        assert_eq!(runs(0.1, &mut (1..=10_000).step_by(20)).len(), 500);
        assert!(runs(0.1, &mut std::iter::empty()).is_empty());
    }
}
