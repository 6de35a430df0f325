//! The viewport: the picture, and the pointer over it.
//!
//! In: a [`Session`]. Out: presses, drags, zooms; textures and shapes.

use super::brush;
use super::keys::is_held;
use super::marks::Over;
use super::onion;
use super::pan::{Pan, Scroller};
use super::pen::{self, REACH};
use super::picture_parts;
use super::references;
use super::rendered_bar;
use super::theme;
use crate::edit::{Action, Lens, Picture, Session, Shortcuts, Wipe, Zoom};
use eframe::egui::text::{LayoutJob, TextFormat};
use eframe::egui::{
    self, Align2, Color32, ColorImage, FontId, PointerButton, Rect, Role, Sense, Stroke, TextureHandle, TextureOptions,
    Ui, WidgetInfo, vec2,
};
use glam::DVec2;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What a texture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Seen {
    Frame,
    Before,
    /// A reference picture, by its place.
    Reference(usize),
}

/// Textures of the displayed pictures.
#[derive(Default)]
pub(super) struct Textures {
    seen: BTreeMap<Seen, (Arc<Picture>, TextureHandle)>,
    onion: BTreeMap<i32, (Arc<Picture>, TextureHandle)>,
}

fn upload(ctx: &egui::Context, name: &str, picture: &Picture) -> TextureHandle {
    ctx.load_texture(name, image_of(ctx, picture), TextureOptions::LINEAR)
}

/// Returns a picture in the largest size that the graphics card can hold.
fn image_of(ctx: &egui::Context, picture: &Picture) -> ColorImage {
    let (size, rgba) = picture.within(ctx.input(|input| input.max_texture_side));
    ColorImage::from_rgba_premultiplied(size, &rgba)
}

impl Textures {
    fn of(&mut self, ctx: &egui::Context, name: Seen, picture: &Arc<Picture>) -> egui::TextureId {
        match self.seen.get_mut(&name) {
            Some((known, texture)) if Arc::ptr_eq(known, picture) => texture.id(),
            Some((known, texture)) => {
                texture.set(image_of(ctx, picture), TextureOptions::LINEAR);
                *known = Arc::clone(picture);
                texture.id()
            }
            None => {
                let texture = upload(ctx, "picture", picture);
                let id = texture.id();
                self.seen.insert(name, (Arc::clone(picture), texture));
                id
            }
        }
    }

    fn of_frame(&mut self, ctx: &egui::Context, picture: &Arc<Picture>) -> egui::TextureId {
        let known = self.onion.get(&picture.frame).filter(|(known, _)| Arc::ptr_eq(known, picture));
        if known.is_none() {
            self.onion.insert(picture.frame, (Arc::clone(picture), upload(ctx, "onion", picture)));
        }
        self.onion[&picture.frame].1.id()
    }

    /// Frees the pictures of frames and references that are no longer seen.
    fn keep(&mut self, frames: &[i32], references: usize) {
        self.onion.retain(|frame, _| frames.contains(frame));
        self.seen.retain(|name, _| !matches!(name, Seen::Reference(place) if *place >= references));
    }
}

/// Shows the picture and handles the pointer.
pub(super) fn show(
    ui: &mut Ui,
    session: &mut Session,
    shortcuts: &Shortcuts,
    (textures, pan): (&mut Textures, &mut Pan),
) {
    let rect = ui.available_rect_before_wrap();
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Viewport"));
    let lens = session.zoom.lens(session.shot().size, DVec2::new(rect.width().into(), rect.height().into()));
    session.viewport = lens.viewport;
    if response.has_focus() {
        // Arrow keys nudge, so they must not move the keyboard focus.
        let own = egui::EventFilter { horizontal_arrows: true, vertical_arrows: true, escape: true, tab: false };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, own));
    }
    session.shown.is_hidden = is_held(ui.ctx(), shortcuts, Action::Hide);
    session.show_before(is_held(ui.ctx(), shortcuts, Action::Before));
    scroll(ui, &response, session, &lens, pan);
    match pan.drag(ui, &response, shortcuts) {
        Some(by) => session.zoom = session.zoom.panned(&lens, DVec2::new(by.x.into(), by.y.into())),
        None => pen::follow(ui, &response, (session, &lens), shortcuts),
    }
    let lens = session.zoom.lens(session.shot().size, lens.viewport);
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0, theme::surroundings(ui.visuals()));
    pictures(ui, (rect, lens), session, textures);
    let is_brush = is_held(ui.ctx(), shortcuts, Action::Stiffness) || session.is_painting();
    if is_brush || session.shown.painted {
        session.want_painted();
    }
    let hovered = response.hover_pos().and_then(|at| {
        let at = lens.screen_from_viewport(DVec2::new((at.x - rect.min.x).into(), (at.y - rect.min.y).into()));
        session.pin_near(at, f64::from(REACH) / lens.frame_height()).map(|(pin, _)| pin)
    });
    let over = Over { session, lens, painter: painter.clone(), origin: rect.min, hovered };
    if (is_brush || session.shown.painted) && !session.shown.is_hidden {
        brush::painted(&painter, session, |point| over.at(point));
        let radius = (session.brush.radius * lens.frame_height()) as f32;
        brush::way(&painter, session, radius, |point| over.at(point));
    }
    over.draw();
    brush_ring(ui, &response, (&over, is_brush), shortcuts);
    status(ui, rect, session, &lens);
    fault(ui, rect, session);
    picture_parts::show(ui, &response, (session, &lens), REACH);
    menu(&response, session);
    rendered_bar::show(ui, rect, session);
}

/// Zooms by the wheel or by a pinch, and pans by the middle button or by two fingers on a trackpad.
fn scroll(ui: &Ui, response: &egui::Response, session: &mut Session, lens: &Lens, pan: &mut Pan) {
    let scroller = pan.scroller(ui);
    let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta(), input.zoom_delta()));
    let (wheel, mut by) = match scroller {
        Scroller::Wheel => (scroll.y, vec2(scroll.x, 0.0)),
        Scroller::Trackpad => (0.0, scroll),
    };
    let pointer = response.hover_pos().map(|at| at - response.rect.min);
    let factor = f64::from(pinch) * f64::from(wheel / 240.0).exp();
    if let Some(at) = pointer.filter(|_| factor != 1.0) {
        session.zoom = session.zoom.zoomed(lens, DVec2::new(at.x.into(), at.y.into()), factor);
        return;
    }
    by = if pointer.is_some() { by } else { vec2(0.0, 0.0) };
    if response.dragged_by(PointerButton::Middle) {
        by += response.drag_delta();
    }
    if by != vec2(0.0, 0.0) {
        session.zoom = session.zoom.panned(lens, DVec2::new(by.x.into(), by.y.into()));
    }
}

/// Draws the brush where its key is held and no pin lies under the pen.
fn brush_ring(ui: &Ui, response: &egui::Response, (over, is_brush): (&Over, bool), shortcuts: &Shortcuts) {
    let session = over.session;
    let radius = (session.brush.radius * over.lens.frame_height()) as f32;
    let is_sizing = is_held(ui.ctx(), shortcuts, Action::Region) && !session.is_dragging();
    let (sized, hovered) = (session.sized_brush().map(|center| over.at(center)), response.hover_pos());
    let at = sized.or_else(|| hovered.filter(|_| is_brush || is_sizing));
    let Some(at) = at else { return };
    let seen = at - over.origin;
    let point = over.lens.screen_from_viewport(DVec2::new(seen.x.into(), seen.y.into()));
    let is_free =
        session.is_dragging() || session.pin_near(point, f64::from(REACH) / over.lens.frame_height()).is_none();
    if is_free {
        let words = match (is_brush, ui.input(|input| input.modifiers.shift)) {
            (false, _) => format!("{:.0} px", session.brush.radius * f64::from(session.shot().size.height)),
            (true, true) => "erase".to_owned(),
            (true, false) => {
                format!("stiffness {:.3}", session.brush.stiffness).trim_end_matches(['0', '.']).to_owned()
            }
        };
        brush::ring(&over.painter, at, radius, &words);
    }
}

fn pictures(ui: &Ui, (rect, lens): (Rect, Lens), session: &mut Session, textures: &mut Textures) {
    let painter = ui.painter_at(rect);
    let [low, high] = lens.corners().map(|corner| rect.min + vec2(corner.x as f32, corner.y as f32));
    let frame = Rect::from_min_max(low, high);
    painter.rect_filled(frame, 0, theme::backdrop(ui.visuals()));
    let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
    let draw = |id: egui::TextureId, tint: Color32| _ = painter.image(id, frame, whole, tint);
    let references = references::laid(ui.ctx(), session, (frame, &lens));
    let onions = onion::onions(session);
    let draw_onions = |textures: &mut Textures| {
        onions.iter().for_each(|(picture, color)| draw(textures.of_frame(ui.ctx(), picture), *color));
    };
    // An opaque frame, such as a plate, would hide what lies behind it.
    let is_opaque = session.picture().is_some_and(|picture| picture.is_opaque());
    if !is_opaque {
        draw_onions(textures);
    }
    let seen: Vec<i32> = onions.iter().map(|(picture, _)| picture.frame).collect();
    textures.keep(&seen, references.len());
    let draw_references = |textures: &mut Textures, is_above: bool| {
        for (place, laid) in references.iter().enumerate() {
            let Some(laid) = laid.as_ref().filter(|laid| laid.is_above == is_above && !laid.is_rendered) else {
                continue;
            };
            let id = textures.of(ui.ctx(), Seen::Reference(place), &laid.picture);
            painter.image(id, laid.rect, whole, laid.color);
        }
    };
    draw_references(textures, false);
    let is_before = session.shown.is_before;
    let rendered = references.iter().enumerate().filter_map(|(place, laid)| Some((place, laid.as_ref()?)));
    if let Some((place, laid)) = { rendered }.find(|(_, laid)| laid.is_rendered) {
        return draw(textures.of(ui.ctx(), Seen::Reference(place), &laid.picture), Color32::WHITE);
    }
    if let Some(picture) = session.picture().filter(|_| !is_before || session.before().is_none()) {
        draw(textures.of(ui.ctx(), Seen::Frame, picture), Color32::WHITE);
    }
    if is_opaque {
        draw_onions(textures);
    }
    draw_references(textures, true);
    let wipe = session.shown.wipe;
    let Some(before) = session.before().filter(|_| is_before || wipe != Wipe::Off) else { return };
    let id = textures.of(ui.ctx(), Seen::Before, before);
    match wipe {
        _ if is_before => draw(id, Color32::WHITE),
        Wipe::At(share) => {
            let x = frame.left() + share * frame.width();
            let left = Rect::from_min_max(frame.min, egui::pos2(x, frame.bottom()));
            painter.rect_filled(left, 0, theme::backdrop(ui.visuals()));
            painter.image(id, left, Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(share, 1.0)), Color32::WHITE);
            painter.vline(x, frame.y_range(), Stroke::new(1.5, Color32::WHITE));
            let font = FontId::proportional(12.0);
            painter.text(
                egui::pos2(x - 8.0, frame.top() + 8.0),
                Align2::RIGHT_TOP,
                "before",
                font.clone(),
                Color32::WHITE,
            );
            painter.text(egui::pos2(x + 8.0, frame.top() + 8.0), Align2::LEFT_TOP, "after", font, Color32::WHITE);
        }
        Wipe::Ghost(opacity) => draw(id, Color32::WHITE.gamma_multiply(opacity)),
        Wipe::Off => {}
    }
}

/// Draws the picture's status in the corner.
fn status(ui: &Ui, rect: Rect, session: &Session, lens: &Lens) {
    let painter = ui.painter_at(rect);
    let percent = 100.0 * lens.scale() * f64::from(ui.ctx().pixels_per_point());
    let zoom = if session.zoom == Zoom::Fit { ", fit" } else { "" };
    let text = format!("{}   {percent:.0} %{zoom}", session.corner());
    let galley = painter.layout_no_wrap(text, FontId::proportional(12.0), Color32::from_gray(230));
    let place = Align2::RIGHT_BOTTOM.anchor_size(rect.right_bottom() - vec2(10.0, 8.0), galley.size());
    painter.rect_filled(place.expand2(vec2(6.0, 3.0)), 4, Color32::from_black_alpha(130));
    painter.galley(place.min, galley, Color32::WHITE);
}

/// Says over the picture why the shot cannot be drawn.
fn fault(ui: &Ui, rect: Rect, session: &Session) {
    let Some(fault) = session.fault() else { return };
    let mut text = LayoutJob::default();
    text.wrap.max_width = (rect.width() - 60.0).clamp(80.0, 560.0);
    let format = |color| TextFormat::simple(FontId::proportional(14.0), color);
    text.append("This shot cannot be drawn.\n\n", 0.0, format(ui.visuals().error_fg_color));
    text.append(&format!("{fault}\n\nUndo, or mend the shot file."), 0.0, format(Color32::from_gray(240)));
    let painter = ui.painter_at(rect);
    let galley = painter.layout_job(text);
    let place = Align2::CENTER_CENTER.anchor_size(rect.center(), galley.size());
    painter.rect_filled(place.expand(12.0), 6, Color32::from_black_alpha(210));
    painter.galley(place.min, galley, Color32::WHITE);
}

/// Shows the context menu.
fn menu(response: &egui::Response, session: &mut Session) {
    response.context_menu(|ui| {
        let has_pins = !session.selection.pins.is_empty();
        if ui.add_enabled(has_pins, egui::Button::new("Insert key")).clicked() {
            session.insert_keys();
        }
        if ui.add_enabled(has_pins, egui::Button::new("Mute or unmute pins")).clicked() {
            session.mute_chosen();
        }
        if ui.add_enabled(has_pins, egui::Button::new("Delete pins")).clicked() {
            session.delete_pins();
        }
        ui.separator();
        if ui.button("Select all pins of the layer").clicked() {
            session.choose_all();
        }
        if ui.button("Fit the picture").clicked() {
            session.zoom = Zoom::Fit;
        }
    });
}
