//! A row of the timeline: the keys of one pin or handle, or of a channel of a pin that has keys of its own.
//!
//! In: a [`Session`], the time scale. Out: shapes; selected keys.

use super::accessible::{self, Part};
use super::arrow_keys::{self, Arrow, With};
use super::frame_scale::{FrameScale, NAMES};
use super::theme::ACCENT;
use crate::edit::{EasePreset, KeyStep, Session, Track};
use crate::shot::Ease;
use eframe::egui::{
    Align2, Color32, FontId, Key, Painter, Pos2, Rect, Response, Role, Sense, Shape, Stroke, StrokeKind, Ui, Vec2,
    WidgetInfo, pos2, vec2,
};

/// Height of a row of keys.
const ROW: f32 = 20.0;

/// Distance in points within which a key is hit.
const REACH: f32 = 7.0;

/// Adds a key to the selection.
pub(super) fn add_key(session: &mut Session, track: Track, time: f64) {
    if !session.selection.has_key(track, time) {
        session.choose_key(track, time, true);
    }
}

fn choose(session: &mut Session, track: Track, adds: bool) {
    if !adds {
        session.selection.clear();
    }
    session.selection.add(track);
}

/// A row with its keys.
pub(super) struct Row {
    pub(super) track: Track,
    pub(super) name: String,
    pub(super) keys: Vec<(f64, Ease)>,
}

/// What the pen did in a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pen {
    /// Nothing.
    Away,
    /// It went down on a key, here.
    Key(Pos2),
    /// It went down beside the keys, here.
    Empty(Pos2),
    /// It is dragged, and is here.
    Dragged(Pos2),
    /// A drag or a click ended.
    Up,
}

/// Returns the rows of the selected layer: its pins, each with the channels that have keys of their own, then its handles.
pub(super) fn rows(session: &Session) -> Vec<Row> {
    let shot = session.shot();
    let row = |track: Track| Row { track, name: track.name(shot), keys: track.times(shot) };
    session.tracks().into_iter().map(row).collect()
}

/// A row that was shown.
pub(super) struct ShownRow {
    pub(super) response: Response,
    /// What the pen did.
    pub(super) pen: Pen,
    /// By how many rows the keyboard leaves this one.
    pub(super) leaves: i32,
}

/// How a row is shown.
#[derive(Clone, Copy)]
pub(super) struct RowView {
    pub(super) scale: FrameScale,
    /// Frames by which selected keys are being moved.
    pub(super) moved_by: i32,
    /// Whether the row scrolls into view.
    pub(super) scrolls_here: bool,
}

/// A row in its place.
struct PlacedRow<'a> {
    row: &'a Row,
    scale: FrameScale,
    response: Response,
    /// The place of the name.
    names: Rect,
}

/// Shows a row.
pub(super) fn show(ui: &mut Ui, session: &mut Session, row: &Row, view: RowView) -> ShownRow {
    let RowView { scale, moved_by, scrolls_here } = view;
    let (response, painter) = ui.allocate_painter(vec2(ui.available_width(), ROW), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Row, true, format!("Keys of {}", row.name)));
    let rect = response.rect;
    if scrolls_here {
        response.scroll_to_me(None);
    }
    let is_chosen = session.selection.has(row.track);
    if is_chosen {
        painter.rect_filled(rect, 0, ui.visuals().selection.bg_fill.gamma_multiply(0.35));
    }
    let text = if is_chosen { ui.visuals().strong_text_color() } else { ui.visuals().text_color() };
    let names = Rect::from_min_max(rect.min, pos2(rect.left() + NAMES - 8.0, rect.bottom()));
    let font = FontId::proportional(12.5);
    let at = pos2(rect.left() + 8.0, rect.center().y);
    // A channel stands below its pin, whose name it need not repeat.
    let (at, name) =
        row.track.channel_name().map_or((at, row.name.as_str()), |channel| (at + vec2(14.0, 0.0), channel));
    painter.with_clip_rect(names).text(at, Align2::LEFT_CENTER, name, font, text);
    let line = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
    painter.hline(rect.x_range(), rect.bottom(), line);
    let place = |(frame, _): &(f64, Ease)| {
        let shift = if session.selection.has_key(row.track, *frame) { f64::from(moved_by) } else { 0.0 };
        pos2(scale.x(frame + shift), rect.center().y)
    };
    // Keys before the first frame must not cross the name.
    let painter = painter.with_clip_rect(Rect::from_min_max(pos2(names.right(), rect.top()), rect.max));
    for pair in row.keys.windows(2).filter(|pair| pair[0].1 != Ease::Hold) {
        painter.line_segment([place(&pair[0]), place(&pair[1])], Stroke::new(2.0, line.color));
    }
    for key in &row.keys {
        let usual = Color32::from_gray(if ui.visuals().dark_mode { 200 } else { 90 });
        let fill = if session.selection.has_key(row.track, key.0) { ACCENT } else { usual };
        diamond(&painter, place(key), key.1, fill);
    }
    if response.has_focus() {
        ui.painter_at(rect).rect_stroke(rect.shrink(1.0), 2, Stroke::new(1.0, ACCENT), StrokeKind::Inside);
    }
    let placed = PlacedRow { row, scale, response, names };
    placed.name_keys(ui, session);
    let leaves = placed.keyboard(ui, session);
    ShownRow { pen: placed.pen(ui, session), response: placed.response, leaves }
}

impl PlacedRow<'_> {
    /// Makes the keys known to screen readers, which choose them.
    fn name_keys(&self, ui: &Ui, session: &mut Session) {
        let Self { row, scale, ref response, .. } = *self;
        let keys = row.keys.iter().map(|&(time, ease)| Part {
            id: response.id.with(time.to_bits()),
            rect: Rect::from_center_size(pos2(scale.x(time), response.rect.center().y), Vec2::splat(2.0 * REACH)),
            label: format!(
                "Key of {}, frame {time}, {}",
                row.name,
                EasePreset::of(ease).map_or("Curve", EasePreset::name)
            ),
            is_chosen: session.selection.has_key(row.track, time),
        });
        let chosen = accessible::parts(ui, response, keys);
        if let Some((time, _)) = chosen.and_then(|place| row.keys.get(place)) {
            session.choose_key(row.track, *time, false);
            response.request_focus();
        }
    }

    /// Handles the keyboard: arrows step from key to key, with Alt they move keys. Returns by how many rows it leaves.
    fn keyboard(&self, ui: &Ui, session: &mut Session) -> i32 {
        let Self { row, response, .. } = self;
        let is_entered = response.has_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        if is_entered {
            choose(session, row.track, ui.input(|input| input.modifiers.shift));
        }
        let mut leaves = 0;
        for Arrow { way: [right, up], with } in arrow_keys::take(ui, response) {
            match with {
                With::Alt if right != 0 => session.nudge_keys(right),
                With::Alt => {}
                _ if right == 0 => leaves -= up,
                With::Shift => session.step_key(row.track, right > 0, KeyStep::Add),
                With::Nothing => session.step_key(row.track, right > 0, KeyStep::Only),
            }
        }
        leaves
    }

    fn pen(&self, ui: &Ui, session: &mut Session) -> Pen {
        let Self { row, scale, ref response, names } = *self;
        let (pressed, adds) = ui.input(|input| (input.pointer.primary_pressed(), input.modifiers.shift));
        if response.drag_stopped() || response.clicked() && !pressed {
            return Pen::Up;
        }
        let Some(at) = response.interact_pointer_pos() else { return Pen::Away };
        if pressed && response.contains_pointer() {
            response.request_focus();
        }
        if !(pressed && response.contains_pointer()) {
            return if response.dragged() { Pen::Dragged(at) } else { Pen::Away };
        }
        let far = |key: &&(f64, Ease)| (scale.x(key.0) - at.x).abs();
        let near = row.keys.iter().filter(|key| far(key) <= REACH).min_by(|a, b| far(a).total_cmp(&far(b)));
        match near {
            Some((time, _)) => {
                session.choose_key(row.track, *time, adds);
                Pen::Key(at)
            }
            None if names.contains(at) => {
                let is_double =
                    ui.input(|input| input.pointer.button_double_clicked(eframe::egui::PointerButton::Primary));
                choose(session, row.track, adds || is_double);
                if is_double || session.selection.has(row.track) && ui.input(|input| input.modifiers.command) {
                    row.keys.iter().for_each(|(time, _)| add_key(session, row.track, *time));
                }
                Pen::Away
            }
            None => Pen::Empty(at),
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
