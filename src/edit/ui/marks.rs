//! Draws the overlays of the picture: lattices, pins, regions, folds, trails, guides.
//!
//! In: a [`Session`], a [`Lens`]. Out: shapes.

use super::over;
use super::pin_names::{GAP, MARGIN, NamePlaces, PinName};
use super::theme::heat;
use crate::edit::{AxisRing, Lens, Session};
use crate::pipeline::{LayerMarks, PinMark};
use crate::space::ScreenPoint;
use eframe::egui::{Align2, Color32, FontId, Mesh, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, vec2};
use std::collections::BTreeMap;

/// Radius of the ring around a selected pin in points.
pub(super) const RING: f32 = 44.0;

/// Radii of the circles around the pin that the tour points at, in points.
const POINTED: [f32; 2] = [13.0, 19.0];

/// Number of frames on either side that trails cover.
const TRAIL: i32 = 24;

/// Spacing of lattice lines, in points, from which they are drawn at full opacity.
const WIDE: f32 = 36.0;

/// Opacity of the filled distortion.
const HEAT: f32 = 0.55;

/// Width in points of lines that show their distortion.
const HEATED_LINE: f32 = 2.0;

/// Draws the overlays of a picture.
pub(super) struct Over<'a> {
    pub(super) session: &'a Session,
    pub(super) lens: Lens,
    pub(super) painter: Painter,
    pub(super) origin: Pos2,
    /// The pin under the pointer, by its layer and its index.
    pub(super) hovered: Option<[usize; 2]>,
}

impl Over<'_> {
    /// Returns the place of a point of the screen in the window.
    pub(super) fn at(&self, point: ScreenPoint) -> Pos2 {
        let place = self.lens.viewport_from_screen(point);
        self.origin + vec2(place.x as f32, place.y as f32)
    }

    /// Draws all enabled overlays.
    pub(super) fn draw(&self) {
        let shown = self.session.shown;
        if shown.is_hidden || self.session.shows_rendered() {
            return;
        }
        if shown.safe_areas {
            self.safe_areas();
        }
        let chosen = self.session.selection.layer;
        let marks = self.session.marks();
        let ordered = marks
            .iter()
            .filter(|marks| marks.layer != chosen)
            .chain(marks.iter().filter(|marks| marks.layer == chosen));
        let ordered: Vec<&LayerMarks> = ordered.collect();
        for marks in &ordered {
            // Lines in the scene have the colours of their distortion themselves.
            let (is_heated, is_in_scene) = (shown.distortion && marks.layer == chosen, marks.rest_box.is_none());
            match is_in_scene {
                _ if !is_heated => {}
                true => self.distorted_lines(marks),
                false => self.distortion(marks),
            }
            if shown.lattice && !(is_heated && is_in_scene) {
                self.lattice(marks, marks.layer == chosen);
            }
            if shown.folds {
                marks.folded.iter().for_each(|cell| self.fold(cell));
            }
        }
        if shown.trails {
            self.trails();
        }
        if shown.handles {
            ordered.iter().for_each(|marks| self.handles(marks));
        }
        if shown.pins {
            self.names(marks);
            ordered.iter().for_each(|marks| marks.pins.iter().for_each(|pin| self.pin(marks.layer, pin)));
            self.ring();
        }
        if let Some(corners) = self.session.choosing_box() {
            let rect = Rect::from_two_pos(self.at(corners[0]), self.at(corners[1]));
            self.painter.rect(
                rect,
                0,
                Color32::from_white_alpha(16),
                Stroke::new(1.0, over::CHOSEN),
                StrokeKind::Middle,
            );
        }
    }

    fn lattice(&self, marks: &LayerMarks, is_chosen: bool) {
        let color = over::lattice(&self.painter.ctx().global_style().visuals, is_chosen);
        // Dense lines would cover the picture, so they are faded.
        let color = color.gamma_multiply((self.line_spacing(marks) / WIDE).clamp(0.35, 1.0));
        for line in &marks.lines {
            let points: Vec<Pos2> = line.iter().map(|&point| self.at(point)).collect();
            self.painter.line(points, Stroke::new(1.0, color));
        }
    }

    /// Fills a lattice on the screen with its distortion, between the lines across and at the points of each.
    fn distortion(&self, marks: &LayerMarks) {
        let mut mesh = Mesh::default();
        for (line, stretches) in marks.lines.iter().zip(&marks.distortion).take(lines_across(&marks.lines)) {
            let (count, first) = (line.len() as u32, mesh.vertices.len() as u32);
            for (&point, &stretch) in line.iter().zip(stretches) {
                mesh.colored_vertex(self.at(point), heat(stretch).gamma_multiply(HEAT));
            }
            if first < count {
                continue;
            }
            for below in first - count..first - 1 {
                mesh.add_triangle(below, below + 1, below + count);
                mesh.add_triangle(below + 1, below + count + 1, below + count);
            }
        }
        if !mesh.is_empty() {
            self.painter.add(Shape::mesh(mesh));
        }
    }

    /// Draws the lines of a lattice in the scene in the colours of the distortion at their points.
    fn distorted_lines(&self, marks: &LayerMarks) {
        let mut mesh = Mesh::default();
        for (line, stretches) in marks.lines.iter().zip(&marks.distortion) {
            let points: Vec<(Pos2, Color32)> =
                line.iter().zip(stretches).map(|(&point, &stretch)| (self.at(point), heat(stretch))).collect();
            for ends in points.windows(2) {
                let side = 0.5 * HEATED_LINE * (ends[1].0 - ends[0].0).normalized().rot90();
                let first = mesh.vertices.len() as u32;
                for (place, color) in ends {
                    mesh.colored_vertex(*place - side, *color);
                    mesh.colored_vertex(*place + side, *color);
                }
                mesh.add_triangle(first, first + 1, first + 2);
                mesh.add_triangle(first + 1, first + 3, first + 2);
            }
        }
        if !mesh.is_empty() {
            self.painter.add(Shape::mesh(mesh));
        }
    }

    /// Returns the spacing of a screen-space lattice's lines in points.
    fn line_spacing(&self, marks: &LayerMarks) -> f32 {
        let Some(rest) = marks.rest_box else { return WIDE };
        let [low, high] = [rest.upright.min, rest.upright.max].map(|corner| self.at(corner));
        let cells = (marks.lines.len() as f32 / 2.0 - 1.0).max(1.0);
        (high.x - low.x).abs().max((high.y - low.y).abs()) / cells
    }

    fn fold(&self, cell: &[ScreenPoint]) {
        // A triangle fan around the centroid, as folded cells are not convex.
        let points: Vec<Pos2> = cell.iter().map(|&point| self.at(point)).collect();
        let sum = points.iter().fold(vec2(0.0, 0.0), |sum, point| sum + point.to_vec2());
        let mut mesh = Mesh::default();
        mesh.colored_vertex((sum / points.len().max(1) as f32).to_pos2(), over::FOLD);
        points.iter().for_each(|&point| mesh.colored_vertex(point, over::FOLD));
        let count = points.len() as u32;
        (0..count).for_each(|k| mesh.add_triangle(0, 1 + k, 1 + (k + 1) % count));
        self.painter.add(Shape::mesh(mesh));
    }

    fn handles(&self, marks: &LayerMarks) {
        for (handle, place) in self.session.handles_in_view(marks) {
            let place = self.at(place);
            let is_chosen = self.session.selection.handles.contains(&handle);
            let color = if is_chosen { over::CHOSEN } else { over::HANDLE };
            let half = if is_chosen { 4.0 } else { 3.0 };
            self.painter.rect_filled(
                Rect::from_center_size(place, vec2(2.0 * half + 2.0, 2.0 * half + 2.0)),
                1,
                over::SHADE,
            );
            self.painter.rect_filled(Rect::from_center_size(place, vec2(2.0 * half, 2.0 * half)), 1, color);
        }
    }

    fn pin(&self, layer: usize, pin: &PinMark) {
        let session = self.session;
        let is_chosen = session.selection.pins.contains(&[layer, pin.pin]);
        let (rest, target) = (self.at(pin.rest), self.at(pin.target));
        let color = if session.is_heard(layer) { over::PIN } else { over::MUTED_PIN };
        if !pin.rim.is_empty() && is_chosen {
            let rim: Vec<Pos2> = pin.rim.iter().map(|&point| self.at(point)).collect();
            self.painter.line(rim, Stroke::new(1.5, over::REGION));
        }
        if session.shown.rest && rest.distance(target) > 3.0 {
            self.painter.line_segment([rest, target], Stroke::new(3.0, over::SHADE));
            self.painter.line_segment([rest, target], Stroke::new(1.2, color));
            self.painter.circle_stroke(rest, 4.0, Stroke::new(3.0, over::SHADE));
            self.painter.circle_stroke(rest, 4.0, Stroke::new(1.4, over::REST));
        }
        let is_near = layer == session.selection.layer;
        let radius = if is_chosen {
            6.0
        } else if is_near {
            4.5
        } else {
            3.0
        };
        if session.shown.pointed == Some([layer, pin.pin]) {
            for around in POINTED {
                self.painter.circle_stroke(target, around, Stroke::new(4.0, over::SHADE));
                self.painter.circle_stroke(target, around, Stroke::new(2.0, over::PIN));
            }
        }
        self.painter.circle_filled(target, radius + 1.5, over::SHADE);
        self.painter.circle_filled(target, radius, color);
        if is_chosen {
            self.painter.circle_stroke(target, radius, Stroke::new(2.0, over::CHOSEN));
        }
    }

    /// Draws names beside the pins of the selected layer, those of selected pins and of the one under the pointer first; others are
    /// left out where there is no room.
    fn names(&self, marks: &[LayerMarks]) {
        let session = self.session;
        let Some(own) = marks.iter().find(|own| session.shown.names && own.layer == session.selection.layer) else {
            return;
        };
        let is_seen = |pin: &&PinMark| self.painter.clip_rect().contains(self.at(pin.target));
        let seen: Vec<&PinMark> = own.pins.iter().filter(is_seen).collect();
        let is_chosen = |pin: &PinMark| session.selection.pins.contains(&[own.layer, pin.pin]);
        let is_needed = |pin: &PinMark| is_chosen(pin) || self.hovered == Some([own.layer, pin.pin]);
        let mut places = NamePlaces::among(seen.iter().map(|pin| self.at(pin.target)));
        let (needed, others): (Vec<&PinMark>, Vec<&PinMark>) = seen.into_iter().partition(|pin| is_needed(pin));
        for pin in needed.into_iter().chain(others) {
            let named = session.shot().layers.get(own.layer).and_then(|layer| layer.pins.get(pin.pin));
            let Some(named) = named else { continue };
            let color = if is_chosen(pin) { over::CHOSEN } else { Color32::from_gray(225) };
            let galley = self.painter.layout_no_wrap(named.name.clone(), FontId::proportional(12.0), color);
            let has_ring = session.selection.single_pin() == Some([own.layer, pin.pin]);
            let gap = if has_ring { RING + 12.0 } else { GAP };
            let (at, size, is_needed) = (self.at(pin.target), galley.size(), is_needed(pin));
            let Some(place) = places.place(PinName { at, size, gap, is_needed }) else { continue };
            self.painter.rect_filled(place.expand2(MARGIN), 3, Color32::from_black_alpha(120));
            self.painter.galley(place.min, galley, color);
        }
    }

    fn ring(&self) {
        let Some(center) = self.session.ring_center().map(|center| self.at(center)) else { return };
        if let Some(rings) = self.session.axis_rings() {
            return rings.into_iter().zip(over::AXES).for_each(|(ring, color)| self.axis_ring(center, ring, color));
        }
        self.painter.circle_stroke(center, RING, Stroke::new(3.0, Color32::from_black_alpha(70)));
        self.painter.circle_stroke(center, RING, Stroke::new(1.3, Color32::from_white_alpha(170)));
        let angle = self.session.selection.single_pin().and_then(|pin| self.session.key_here(pin)).and_then(|key| {
            let Some(crate::shot::Rotation::InView(angle)) = key.rotate_degrees else { return None };
            Some(angle.to_radians() as f32)
        });
        let knob = center + RING * vec2(angle.unwrap_or(0.0).cos(), -angle.unwrap_or(0.0).sin());
        self.painter.circle_filled(knob, 5.0, over::SHADE);
        self.painter.circle_filled(knob, 3.5, over::CHOSEN);
    }

    /// Draws a ring about an axis: its far half is faint.
    fn axis_ring(&self, center: Pos2, ring: AxisRing, color: Color32) {
        let points: Vec<(Pos2, bool)> =
            ring.points().map(|at| (center + RING * vec2(at.x as f32, -at.y as f32), at.z >= 0.0)).collect();
        let pieces = || points.windows(2).map(|pair| ([pair[0].0, pair[1].0], pair[0].1 && pair[1].1));
        for (line, _) in pieces().filter(|(_, is_near)| *is_near) {
            self.painter.line_segment(line, Stroke::new(4.0, Color32::from_black_alpha(60)));
        }
        for (line, is_near) in pieces() {
            let (width, color) = if is_near { (2.0, color) } else { (1.0, color.gamma_multiply(0.35)) };
            self.painter.line_segment(line, Stroke::new(width, color));
        }
    }

    /// Draws the trails of the selected pins, or of all pins of the selected layer if no pin is selected.
    fn trails(&self) {
        let (chosen, here) = (&self.session.selection, self.session.playhead.frame());
        let mut ways: BTreeMap<[usize; 2], Vec<(i32, Pos2)>> = BTreeMap::new();
        for solve in self.session.solves().filter(|solve| (solve.frame - here).abs() <= TRAIL) {
            for marks in &solve.marks {
                for pin in &marks.pins {
                    let at = [marks.layer, pin.pin];
                    if chosen.pins.contains(&at) || chosen.pins.is_empty() && marks.layer == chosen.layer {
                        ways.entry(at).or_default().push((solve.frame, self.at(pin.target)));
                    }
                }
            }
        }
        for way in ways.values() {
            for step in way.windows(2).filter(|step| step[1].0 - step[0].0 == 1) {
                let far = (step[1].0 - here).abs() as f32 / TRAIL as f32;
                let color =
                    if step[1].0 <= here { Color32::from_rgb(255, 120, 90) } else { Color32::from_rgb(90, 190, 255) };
                self.painter
                    .line_segment([step[0].1, step[1].1], Stroke::new(1.6, color.gamma_multiply(1.0 - 0.8 * far)));
            }
            for (frame, at) in way {
                let far = (frame - here).abs() as f32 / TRAIL as f32;
                self.painter.circle_filled(*at, 1.8, Color32::WHITE.gamma_multiply(1.0 - 0.9 * far));
            }
        }
    }

    fn safe_areas(&self) {
        let [low, high] = self.lens.corners().map(|corner| self.origin + vec2(corner.x as f32, corner.y as f32));
        let frame = Rect::from_min_max(low, high);
        for (share, name) in [(0.93, "action"), (0.90, "title")] {
            let rect = Rect::from_center_size(frame.center(), frame.size() * share);
            self.painter.rect_stroke(rect, 0, Stroke::new(1.0, over::GUIDE), StrokeKind::Middle);
            let font = FontId::proportional(10.0);
            self.painter.text(rect.left_top() + vec2(4.0, 2.0), Align2::LEFT_TOP, name, font, over::GUIDE);
        }
        let middle = frame.center();
        for arm in [vec2(9.0, 0.0), vec2(0.0, 9.0)] {
            self.painter.line_segment([middle - arm, middle + arm], Stroke::new(1.0, over::GUIDE));
        }
        self.painter.rect_stroke(frame, 0, Stroke::new(1.0, over::GUIDE), StrokeKind::Outside);
    }
}

/// Returns how many of the lines of a lattice on the screen run across; they come first. All cells have the same number of points
/// on each side.
fn lines_across(lines: &[Vec<ScreenPoint>]) -> usize {
    let [Some(across), Some(up)] = [lines.first(), lines.last()].map(|line| line?.len().checked_sub(1)) else {
        return 0;
    };
    up * lines.len().saturating_sub(2) / (across + up).max(1) + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_across_are_told_from_lines_up() {
        for (columns, rows) in [(1, 1), (3, 3), (7, 2), (2, 7)] {
            let line = |cells: usize| vec![ScreenPoint::new(0.0, 0.0); 4 * cells + 1];
            let across = (0..=rows).map(|_| line(columns));
            let lines: Vec<_> = across.chain((0..=columns).map(|_| line(rows))).collect();
            assert_eq!(lines_across(&lines), rows + 1);
        }
        assert_eq!(lines_across(&[]), 0);
    }
}
