//! A row of the timeline: the keys of one pin or handle.
//!
//! In: a [`Session`], the time scale. Out: shapes; selected keys.

use super::frame_scale::{FrameScale, NAMES};
use super::theme::ACCENT;
use crate::edit::Session;
use crate::shot::Ease;
use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Response, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2,
};

/// Height of a row of keys.
const ROW: f32 = 20.0;

/// Distance in points within which a key is hit.
const REACH: f32 = 7.0;

/// What a row shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Track {
    /// Indices of layer and pin.
    Pin([usize; 2]),
    /// Index of the layer, and lattice coordinates of the handle.
    Handle((usize, [usize; 3])),
}

impl Track {
    fn is_chosen(self, session: &Session) -> bool {
        match self {
            Self::Pin(at) => session.selection.pins.contains(&at),
            Self::Handle(at) => session.selection.handles.contains(&at),
        }
    }

    fn has_key(self, session: &Session, time: f64) -> bool {
        match self {
            Self::Pin(at) => session.selection.has_key(at, time),
            Self::Handle(at) => session.selection.handle_keys.contains(&(at, time)),
        }
    }

    /// Selects a key; with `adds`, toggles it and keeps the others.
    fn choose_key(self, session: &mut Session, time: f64, adds: bool) {
        match self {
            Self::Pin(at) => session.choose_key(at, time, adds),
            Self::Handle(at) => session.choose_handle_key(at, time, adds),
        }
    }

    /// Adds a key to the selection.
    pub(super) fn add_key(self, session: &mut Session, time: f64) {
        if !self.has_key(session, time) {
            self.choose_key(session, time, true);
        }
    }

    fn choose(self, session: &mut Session, adds: bool) {
        if !adds {
            session.selection.clear();
        }
        match self {
            Self::Pin(at) => {
                session.selection.layer = at[0];
                session.selection.pins.insert(at);
            }
            Self::Handle(at) => {
                session.selection.layer = at.0;
                session.selection.handles.insert(at);
            }
        }
    }
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
    /// A drag ended.
    Up,
}

/// Returns the rows of the selected layer: its pins, then its handles.
pub(super) fn rows(session: &Session) -> Vec<Row> {
    let layer = session.selection.layer;
    let Some(owner) = session.shot().layers.get(layer) else { return Vec::new() };
    let pins = owner.pins.iter().enumerate().map(|(pin, own)| Row {
        track: Track::Pin([layer, pin]),
        name: own.name.clone(),
        keys: own.keys.iter().map(|key| (key.frame, key.ease)).collect(),
    });
    let axes = if owner.space.dims()[2] > 1 { 3 } else { 2 };
    let handles = owner.handles.iter().map(|own| Row {
        track: Track::Handle((layer, own.index)),
        name: format!("handle {}", own.index[..axes].iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")),
        keys: own.keys.iter().map(|key| (key.frame, key.ease)).collect(),
    });
    pins.chain(handles).collect()
}

/// Shows a row; `by`: frames by which selected keys are being moved. Returns its rectangle, and what the pen did.
pub(super) fn show(
    ui: &mut Ui,
    session: &mut Session,
    row: &Row,
    (scale, by, follows): (FrameScale, i32, bool),
) -> (Rect, Pen) {
    let (response, painter) = ui.allocate_painter(vec2(ui.available_width(), ROW), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Row, true, format!("Keys of {}", row.name)));
    let rect = response.rect;
    if follows {
        response.scroll_to_me(None);
    }
    let is_chosen = row.track.is_chosen(session);
    if is_chosen {
        painter.rect_filled(rect, 0, ui.visuals().selection.bg_fill.gamma_multiply(0.35));
    }
    let text = if is_chosen { ui.visuals().strong_text_color() } else { ui.visuals().text_color() };
    let names = Rect::from_min_max(rect.min, pos2(rect.left() + NAMES - 8.0, rect.bottom()));
    let font = FontId::proportional(12.5);
    let at = pos2(rect.left() + 8.0, rect.center().y);
    painter.with_clip_rect(names).text(at, Align2::LEFT_CENTER, &row.name, font, text);
    let line = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
    painter.hline(rect.x_range(), rect.bottom(), line);
    let place = |(frame, _): &(f64, Ease)| {
        let shift = if row.track.has_key(session, *frame) { f64::from(by) } else { 0.0 };
        pos2(scale.x(frame + shift), rect.center().y)
    };
    for pair in row.keys.windows(2).filter(|pair| pair[0].1 != Ease::Hold) {
        painter.line_segment([place(&pair[0]), place(&pair[1])], Stroke::new(2.0, line.color));
    }
    for key in &row.keys {
        let usual = Color32::from_gray(if ui.visuals().dark_mode { 200 } else { 90 });
        let fill = if row.track.has_key(session, key.0) { ACCENT } else { usual };
        diamond(&painter, place(key), key.1, fill);
    }
    (rect, pen(ui, session, (&response, names), (row, scale)))
}

fn pen(ui: &Ui, session: &mut Session, (response, names): (&Response, Rect), (row, scale): (&Row, FrameScale)) -> Pen {
    let (pressed, adds) = ui.input(|input| (input.pointer.primary_pressed(), input.modifiers.shift));
    if response.drag_stopped() {
        return Pen::Up;
    }
    let Some(at) = response.interact_pointer_pos() else { return Pen::Away };
    if !(pressed && response.contains_pointer()) {
        return if response.dragged() { Pen::Dragged(at) } else { Pen::Away };
    }
    let far = |key: &&(f64, Ease)| (scale.x(key.0) - at.x).abs();
    let near = row.keys.iter().filter(|key| far(key) <= REACH).min_by(|a, b| far(a).total_cmp(&far(b)));
    match near {
        Some((time, _)) => {
            row.track.choose_key(session, *time, adds);
            Pen::Key(at)
        }
        None if names.contains(at) => {
            let is_double = ui.input(|input| input.pointer.button_double_clicked(eframe::egui::PointerButton::Primary));
            row.track.choose(session, adds || is_double);
            if is_double || row.track.is_chosen(session) && ui.input(|input| input.modifiers.command) {
                row.keys.iter().for_each(|(time, _)| row.track.add_key(session, *time));
            }
            Pen::Away
        }
        None => Pen::Empty(at),
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
