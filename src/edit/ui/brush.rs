//! The brush for stiffness: its ring under the pen, what is painted, and its settings.
//!
//! In: a [`Session`]. Out: shapes over the picture; changed settings.

use super::accessible::Accessible;
use super::over;
use crate::edit::{BRUSH_RADII, BRUSH_STIFFNESSES, Session};
use eframe::egui::{
    Align2, CollapsingHeader, Color32, DragValue, FontId, Grid, Mesh, Painter, Pos2, Shape, Slider, Stroke, Ui, vec2,
};

/// The stiffness of the strongest colour, and its inverse of the strongest colour of what is softer.
const STRONGEST: f64 = 32.0;

/// Returns the colour of a stiffness over the picture: amber to red is stiffer, cyan to blue softer than the rest.
fn color(stiffness: f64) -> Color32 {
    let share = (stiffness.ln() / STRONGEST.ln()).clamp(-1.0, 1.0) as f32;
    let mix = |from: f32, to: f32| (from + (to - from) * share.abs()) as u8;
    let alpha = mix(70.0, 170.0);
    match share >= 0.0 {
        true => Color32::from_rgba_unmultiplied(255, mix(200.0, 30.0), 30, alpha),
        false => Color32::from_rgba_unmultiplied(40, mix(220.0, 90.0), 255, alpha),
    }
}

/// Draws the painted triangles.
pub(super) fn painted(painter: &Painter, session: &Session, place: impl Fn(crate::space::ScreenPoint) -> Pos2) {
    let mut mesh = Mesh::default();
    for triangle in session.painted() {
        let color = color(triangle.stiffness);
        let first = mesh.vertices.len() as u32;
        triangle.corners.iter().for_each(|&corner| mesh.colored_vertex(place(corner), color));
        mesh.add_triangle(first, first + 1, first + 2);
    }
    if !mesh.is_empty() {
        painter.add(Shape::mesh(mesh));
    }
}

/// Draws the way of the brush while it paints, before the surface under it is known.
pub(super) fn way(
    painter: &Painter,
    session: &Session,
    radius: f32,
    place: impl Fn(crate::space::ScreenPoint) -> Pos2,
) {
    let (way, stiffness) = session.painted_way();
    let color = if stiffness == 1.0 { Color32::from_white_alpha(20) } else { color(stiffness).gamma_multiply(0.35) };
    way.iter().for_each(|&point| _ = painter.circle_filled(place(point), radius, color));
}

/// Draws the brush, with what it does.
pub(super) fn ring(painter: &Painter, at: Pos2, radius: f32, words: &str) {
    painter.circle_stroke(at, radius, Stroke::new(3.0, Color32::from_black_alpha(90)));
    painter.circle_stroke(at, radius, Stroke::new(1.4, over::CHOSEN));
    painter.circle_stroke(at, 0.5 * radius, Stroke::new(0.8, over::GUIDE));
    let galley = painter.layout_no_wrap(words.to_owned(), FontId::proportional(12.0), Color32::from_gray(230));
    let place = Align2::CENTER_TOP.anchor_size(at + vec2(0.0, radius + 6.0), galley.size());
    painter.rect_filled(place.expand2(vec2(4.0, 2.0)), 3, Color32::from_black_alpha(130));
    painter.galley(place.min, galley, Color32::WHITE);
}

/// Shows the settings of the brush, and removes what is painted.
pub(super) fn settings(ui: &mut Ui, session: &mut Session) {
    CollapsingHeader::new("Stiffness brush").default_open(false).show(ui, |ui| {
        Grid::new("brush").num_columns(2).spacing([10.0, 6.0]).show(ui, |ui| {
            let lines = f64::from(session.shot().size.height);
            ui.label("Radius");
            let mut radius = session.brush.radius * lines;
            let value = DragValue::new(&mut radius).range(BRUSH_RADII[0] * lines..=BRUSH_RADII[1] * lines);
            if ui
                .add(value.speed(0.5).max_decimals(0).suffix(" px"))
                .explained("Brush radius", "Radius of the brush, in pixels of the frame")
                .changed()
            {
                session.brush.radius = radius / lines;
            }
            ui.end_row();
            ui.label("Stiffness");
            let [low, high] = BRUSH_STIFFNESSES;
            let slider = Slider::new(&mut session.brush.stiffness, low..=high).logarithmic(true).max_decimals(2);
            ui.add(slider)
                .explained("Brush stiffness", "What the brush paints. Above 1: keeps its shape; below 1: gives way");
            ui.end_row();
        });
        ui.checkbox(&mut session.shown.painted, "Show what is painted");
        let strokes = session.shot().layers.get(session.selection.layer).map_or(0, |layer| layer.strokes.len());
        ui.horizontal(|ui| {
            ui.weak(crate::spelling::pluralised(strokes, "stroke", "strokes"));
            if ui.add_enabled(strokes > 0, eframe::egui::Button::new("Remove painting")).clicked() {
                session.clear_painting();
            }
        });
        ui.weak("Hold S and paint over the model; with Shift, erase. Hold R and drag beside pins for the radius.");
    });
}
