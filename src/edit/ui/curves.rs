//! The curve editor: keys of the selected pins and handles as curves, in place of the timeline's rows.
//!
//! In: a [`Session`], the time scale. Out: curves; keys dragged to other times and values.

use super::accessible::{self, Part};
use super::arrow_keys::{self, Arrow, With};
use super::frame_scale::{FrameScale, NAMES, playhead};
use super::theme::ACCENT;
use crate::edit::{Channel, CurveUnit, KeyStep, Session, Tangent, TangentEnd, Track};
use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Response, Role, Sense, Stroke, StrokeKind, Ui, UiBuilder, Vec2,
    WidgetInfo, pos2, vec2,
};

/// Samples of a curve per frame, at most.
const PER_FRAME: i32 = 4;

/// Hit distance of keys in points.
const REACH: f32 = 8.0;

/// The displayed channels, and the drag in progress.
#[derive(Default)]
pub(super) struct CurveView {
    kind: Kind,
    drag: Option<Drag>,
    /// The curve that the keyboard edits.
    current: Option<(Track, Channel)>,
}

/// Channels that share an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Kind {
    #[default]
    Place,
    Rotation,
    Scale,
}

impl Kind {
    const ALL: [(Self, &'static str); 3] = [(Self::Place, "Place"), (Self::Rotation, "Turn"), (Self::Scale, "Scale")];

    const fn channels(self) -> &'static [Channel] {
        match self {
            Self::Place => &[Channel::X, Channel::Y, Channel::Z],
            Self::Rotation => &[Channel::Rotation, Channel::RotationX, Channel::RotationY, Channel::RotationZ],
            Self::Scale => &[Channel::Scale],
        }
    }

    /// Returns what to do where there are no curves.
    const fn missing(self) -> &'static str {
        match self {
            Self::Place => "There is no pin yet: click the model in the picture.",
            Self::Rotation => "No key turns a pin: click a pin, and drag the ring around it.",
            Self::Scale => "No key scales a pin: click a pin, hold Shift, and drag the ring around it.",
        }
    }
}

/// The drag in progress. The axis is frozen when the drag begins.
#[derive(Clone, Copy)]
struct Drag {
    track: Track,
    channel: Channel,
    /// Time of the key, or of the key that holds the ease.
    time: f64,
    /// The end of the tangent that is dragged, if not the key itself.
    control: Option<usize>,
    axis: Axis,
}

impl Drag {
    /// Applies a pointer movement.
    fn go(&mut self, session: &mut Session, scale: FrameScale, pen: Pos2) {
        let (time, value) = (f64::from(scale.frame(pen.x)), self.axis.value(pen.y));
        if let Some(control) = self.control {
            return session.bend_curve(self.track, TangentEnd { key: self.time, control }, self.channel, [time, value]);
        }
        session.move_curve_key((self.track, self.time), self.channel, [time.round(), value]);
        let times = session.selection.times_of(self.track);
        self.time = times.first().copied().unwrap_or(self.time);
    }
}

/// The value axis.
#[derive(Clone, Copy)]
struct Axis {
    low: f64,
    high: f64,
    rect: Rect,
}

impl Axis {
    fn y(&self, value: f64) -> f32 {
        let part = (value - self.low) / (self.high - self.low);
        self.rect.bottom() - part as f32 * self.rect.height()
    }

    fn value(&self, y: f32) -> f64 {
        let part = f64::from((self.rect.bottom() - y) / self.rect.height());
        self.low + part * (self.high - self.low)
    }
}

/// The curves as they lie in the view.
struct Plot {
    curves: Vec<Curve>,
    scale: FrameScale,
    axis: Axis,
    /// The view without the names.
    rect: Rect,
}

impl Plot {
    /// Returns the position of (time, value).
    fn at(&self, [time, value]: [f64; 2]) -> Pos2 {
        pos2(self.scale.x(time), self.axis.y(value))
    }

    fn draw(&self, painter: &Painter, curve: &Curve, session: &Session) {
        let color = color(curve.channel);
        painter.line(curve.points.iter().map(|&point| self.at(point)).collect(), Stroke::new(1.6, color));
        for tangent in &curve.tangents {
            let ends = [self.at(tangent.from), self.at(tangent.to)];
            painter.line_segment(ends, Stroke::new(1.0, color.gamma_multiply(0.8)));
            painter.circle_filled(ends[1], 3.0, color);
        }
        for &key in &curve.keys {
            let is_chosen = session.selection.has_key(curve.track, key[0]);
            painter.circle_filled(self.at(key), 4.5, if is_chosen { ACCENT } else { color });
            painter.circle_stroke(self.at(key), 4.5, Stroke::new(1.0, Color32::from_black_alpha(160)));
        }
    }

    /// Returns the key or tangent end under the pointer.
    fn nearest(&self, pen: Pos2) -> Option<Drag> {
        let axis = self.axis;
        let mut found: Option<(f32, Drag)> = None;
        let mut look = |at: &[f64; 2], drag: Drag| {
            let far = pen.distance(self.at(*at));
            if far <= REACH && found.as_ref().is_none_or(|(other, _)| far < *other) {
                found = Some((far, drag));
            }
        };
        for &Curve { track, channel, ref keys, ref tangents, .. } in &self.curves {
            keys.iter().for_each(|key| look(key, Drag { track, channel, time: key[0], control: None, axis }));
            let end = |end: TangentEnd| Drag { track, channel, time: end.key, control: Some(end.control), axis };
            tangents.iter().for_each(|tangent| look(&tangent.to, end(tangent.end)));
        }
        found.map(|(_, drag)| drag)
    }
}

/// A curve and its keys.
struct Curve {
    track: Track,
    channel: Channel,
    points: Vec<[f64; 2]>,
    keys: Vec<[f64; 2]>,
    /// Tangents of selected keys.
    tangents: Vec<Tangent>,
}

impl CurveView {
    /// Shows the curves; returns whether they have keyboard focus.
    pub(super) fn show(&mut self, ui: &mut Ui, session: &mut Session, scale: FrameScale) -> bool {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::ListBox, true, "Curves of keys"));
        let names = Rect::from_min_max(rect.min, pos2(rect.left() + NAMES - 8.0, rect.bottom()));
        let curves = self.curves(session, scale);
        ui.scope_builder(UiBuilder::new().max_rect(names.shrink(6.0)), |ui| self.kinds(ui, session, &curves));
        let axis = self.drag.map_or_else(|| axis_of(&curves, rect.shrink2(vec2(0.0, 10.0))), |drag| drag.axis);
        let area = Rect::from_min_max(pos2(rect.left() + NAMES, rect.top()), rect.max);
        let plot = Plot { curves, scale, axis, rect: area };
        let (painter, weak) = (ui.painter_at(rect), ui.visuals().weak_text_color());
        if plot.curves.is_empty() {
            let words = self.kind.missing();
            painter.text(area.center(), Align2::CENTER_CENTER, words, FontId::proportional(12.5), weak);
        } else {
            grid(&painter, area, axis, weak);
        }
        playhead(&painter, area, session, scale);
        plot.curves.iter().for_each(|curve| plot.draw(&painter, curve, session));
        self.name_keys(ui, session, &response, &plot);
        self.keyboard(ui, session, &response, &plot.curves);
        if response.has_focus() {
            painter.rect_stroke(area.shrink(1.0), 2, Stroke::new(1.0, ACCENT), StrokeKind::Inside);
        }
        self.pen(ui, session, &response, &plot);
        response.has_focus()
    }

    fn pen(&mut self, ui: &Ui, session: &mut Session, response: &Response, plot: &Plot) {
        let pressed = ui.input(|input| input.pointer.primary_pressed());
        let Some(pen) = response.interact_pointer_pos() else {
            self.drag = None;
            return;
        };
        if pressed && response.contains_pointer() {
            response.request_focus();
            self.drag = plot.nearest(pen);
            self.current = self.drag.map(|drag| (drag.track, drag.channel)).or(self.current);
            match self.drag {
                Some(Drag { control: None, track, time, .. }) => session.choose_key(track, time, false),
                Some(_) => {}
                None if pen.x >= plot.rect.left() => session.go(plot.scale.frame(pen.x).round() as i32),
                None => {}
            }
        } else if let Some(drag) = self.drag.as_mut().filter(|_| response.dragged()) {
            drag.go(session, plot.scale, pen);
        }
        if response.drag_stopped() {
            self.drag = None;
        }
    }

    /// Makes the keys known to screen readers, which choose them.
    fn name_keys(&mut self, ui: &Ui, session: &mut Session, response: &Response, plot: &Plot) {
        let all = || plot.curves.iter().flat_map(|curve| curve.keys.iter().map(move |key| (curve, key)));
        let parts = all().map(|(curve, &[time, value])| Part {
            id: response.id.with((curve.track, curve.channel, time.to_bits())),
            rect: Rect::from_center_size(plot.at([time, value]), Vec2::splat(2.0 * REACH)),
            label: format!(
                "{} of {}, frame {time}: {}",
                curve.channel.name(),
                curve.track.name(session.shot()),
                (value * 1e3).round() / 1e3
            ),
            is_chosen: self.current == Some((curve.track, curve.channel))
                && session.selection.has_key(curve.track, time),
        });
        let chosen = accessible::parts(ui, response, parts);
        if let Some((curve, key)) = chosen.and_then(|place| all().nth(place)) {
            self.current = Some((curve.track, curve.channel));
            session.choose_key(curve.track, key[0], false);
            response.request_focus();
        }
    }

    /// Handles the keyboard: arrows step from key to key and raise or lower keys; with Alt they move keys in time, or
    /// go to another curve.
    fn keyboard(&mut self, ui: &Ui, session: &mut Session, response: &Response, curves: &[Curve]) {
        for Arrow { way: [right, up], with } in arrow_keys::take(ui, response) {
            let of = |curve: &Curve| (curve.track, curve.channel);
            let place = curves.iter().position(|curve| Some(of(curve)) == self.current);
            let Some((track, channel)) = curves.get(place.unwrap_or(0)).map(of) else { return };
            self.current = Some((track, channel));
            match with {
                With::Alt if right != 0 => session.nudge_keys(right),
                With::Alt => {
                    let next = (place.unwrap_or(0) as i32 - up).rem_euclid(curves.len() as i32);
                    self.current = curves.get(next as usize).map(of);
                }
                With::Shift if right != 0 => session.step_key(track, right > 0, KeyStep::Add),
                With::Nothing if right != 0 => session.step_key(track, right > 0, KeyStep::Only),
                With::Shift => session.raise_keys(channel, 10.0 * f64::from(up)),
                With::Nothing => session.raise_keys(channel, f64::from(up)),
            }
        }
    }

    fn kinds(&mut self, ui: &mut Ui, session: &Session, curves: &[Curve]) {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().button_padding.x = 4.0;
            ui.spacing_mut().item_spacing.x = 3.0;
            for (kind, name) in Kind::ALL {
                if ui.selectable_label(self.kind == kind, name).clicked() {
                    self.kind = kind;
                }
            }
        });
        for &channel in self.kind.channels() {
            let own = curves.iter().filter(|curve| curve.channel == channel);
            let units: Vec<CurveUnit> = own.map(|curve| session.unit_of(curve.track, channel)).collect();
            let Some(&unit) = units.first() else { continue };
            // Curves of pins and handles may have different units.
            let unit = if units.iter().all(|other| *other == unit) { unit.name() } else { "" };
            let comma = if unit.is_empty() { "" } else { ", " };
            ui.colored_label(color(channel), format!("{}{comma}{unit}", channel.name()));
        }
    }

    /// Returns the curves of the selected pins and handles, or of all in the layer if none is selected.
    fn curves(&self, session: &Session, scale: FrameScale) -> Vec<Curve> {
        let [first, last] = session.playhead.shot_range();
        let per_frame = if scale.x(1.0) - scale.x(0.0) > 4.0 { PER_FRAME } else { 1 };
        let times: Vec<f64> =
            (first * per_frame..=last * per_frame).map(|k| f64::from(k) / f64::from(per_frame)).collect();
        let curve = |(track, channel): (Track, Channel)| Curve {
            track,
            channel,
            points: session.curve(track, channel, &times),
            keys: session.curve_keys(track, channel),
            tangents: session.tangents(track, channel),
        };
        let tracks = session.tracks_of_interest().into_iter();
        let all = tracks.flat_map(|track| self.kind.channels().iter().map(move |&channel| (track, channel)));
        all.map(curve).filter(|curve| !curve.points.is_empty()).collect()
    }
}

/// Fits the value axis to all curves, with a margin to drag keys into.
fn axis_of(curves: &[Curve], rect: Rect) -> Axis {
    let values = || curves.iter().flat_map(|curve| curve.points.iter().chain(&curve.keys)).map(|point| point[1]);
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
    let room = (0.15 * (high - low)).max(0.1 * high.abs().max(low.abs())).max(0.5);
    Axis { low: low - room, high: high + room, rect }
}

const fn color(channel: Channel) -> Color32 {
    match channel {
        Channel::X | Channel::RotationX => Color32::from_rgb(226, 92, 80),
        Channel::Y | Channel::RotationY => Color32::from_rgb(96, 176, 88),
        Channel::Z | Channel::Rotation | Channel::RotationZ => Color32::from_rgb(92, 146, 226),
        Channel::Scale => Color32::from_rgb(196, 140, 220),
    }
}

fn grid(painter: &Painter, plot: Rect, axis: Axis, weak: Color32) {
    let least = (axis.high - axis.low) * 26.0 / f64::from(axis.rect.height().max(1.0));
    let power = 10.0_f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|part| part * power).into_iter().find(|step| *step >= least);
    let Some(step) = step.filter(|step| step.is_finite() && *step > 0.0) else { return };
    let decimals = usize::from(step < 1.0) + usize::from(step < 0.1);
    for line in (axis.low / step).ceil() as i64..=(axis.high / step).floor() as i64 {
        let value = line as f64 * step;
        let width = if line == 0 { 1.2 } else { 0.6 };
        painter.hline(plot.x_range(), axis.y(value), Stroke::new(width, weak.gamma_multiply(0.35)));
        let place = pos2(plot.left() - 6.0, axis.y(value));
        painter.text(place, Align2::RIGHT_CENTER, format!("{value:.decimals$}"), FontId::proportional(10.0), weak);
    }
}
