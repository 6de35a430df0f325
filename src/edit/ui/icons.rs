//! Button icons, drawn as shapes: the toolkit's fonts lack these glyphs.

use super::theme::ACCENT;
use eframe::egui::{Color32, Painter, Pos2, Rect, Response, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2};

/// An icon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Icon {
    First,
    Back,
    Play,
    Pause,
    Forward,
    Last,
    Plus,
    Minus,
    Up,
    Down,
    Seen,
    Unseen,
}

/// Shows an icon button; its name is for screen readers, tests and the tooltip.
pub(super) fn button(ui: &mut Ui, icon: Icon, name: &str) -> Response {
    let width = if matches!(icon, Icon::Play | Icon::Pause) { 36.0 } else { 24.0 };
    let (rect, response) = ui.allocate_exact_size(vec2(width, 22.0), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, name));
    let visuals = ui.style().interact(&response);
    let is_framed = !matches!(icon, Icon::Seen | Icon::Unseen) || response.hovered() || response.has_focus();
    if is_framed {
        ui.painter().rect_filled(rect, 4, visuals.weak_bg_fill);
    }
    draw(ui.painter(), rect.center(), icon, visuals.text_color());
    response.on_hover_text(name)
}

fn draw(painter: &Painter, at: Pos2, icon: Icon, color: Color32) {
    let triangle = |x: f32, way: f32| {
        let corners = [vec2(x - 3.5 * way, -5.0), vec2(x + 4.5 * way, 0.0), vec2(x - 3.5 * way, 5.0)];
        painter.add(Shape::convex_polygon(corners.map(|arm| at + arm).to_vec(), color, Stroke::NONE));
    };
    let bar = |x: f32, width: f32| {
        painter.rect_filled(Rect::from_center_size(at + vec2(x, 0.0), vec2(width, 10.0)), 0, color);
    };
    let line = |from: Pos2, to: Pos2| painter.line_segment([from, to], Stroke::new(1.8, color));
    match icon {
        Icon::First => {
            bar(-5.0, 2.0);
            triangle(1.0, -1.0);
        }
        Icon::Last => {
            bar(5.0, 2.0);
            triangle(-1.0, 1.0);
        }
        Icon::Back => triangle(0.0, -1.0),
        Icon::Forward | Icon::Play => triangle(0.0, 1.0),
        Icon::Pause => {
            bar(-3.0, 3.0);
            bar(3.0, 3.0);
        }
        Icon::Plus | Icon::Minus => {
            line(at - vec2(5.0, 0.0), at + vec2(5.0, 0.0));
            if icon == Icon::Plus {
                line(at - vec2(0.0, 5.0), at + vec2(0.0, 5.0));
            }
        }
        Icon::Up | Icon::Down => {
            let way = if icon == Icon::Up { -1.0 } else { 1.0 };
            line(at + vec2(-4.5, -2.0 * way), at + vec2(0.0, 2.5 * way));
            line(at + vec2(4.5, -2.0 * way), at + vec2(0.0, 2.5 * way));
        }
        Icon::Seen => _ = painter.circle_filled(at, 4.5, color),
        Icon::Unseen => _ = painter.circle_stroke(at, 4.0, Stroke::new(1.3, color.gamma_multiply(0.6))),
    }
}

/// Shows a key icon beside a label: filled where there is a key.
pub(super) fn key_sign(ui: &mut Ui, is_keyed: bool) {
    let (rect, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
    let at = rect.center();
    let corners = [pos2(at.x, at.y - 5.0), pos2(at.x + 5.0, at.y), pos2(at.x, at.y + 5.0), pos2(at.x - 5.0, at.y)];
    let fill = if is_keyed { ACCENT } else { Color32::TRANSPARENT };
    ui.painter().add(Shape::convex_polygon(corners.to_vec(), fill, Stroke::new(1.3, ACCENT)));
}
