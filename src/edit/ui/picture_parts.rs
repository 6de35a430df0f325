//! Pins and handles of the picture, as screen readers find them.
//!
//! In: a [`Session`], a [`Lens`], the viewport. Out: named parts of the viewport; a selected pin or handle.

use super::accessible::{self, Part};
use crate::edit::{Lens, Session, Track};
use crate::space::ScreenPoint;
use eframe::egui::{Rect, Response, Ui, Vec2, vec2};

/// Makes the pins, and the handles that are shown, known to screen readers, which select them. The arrow keys then nudge what is
/// selected.
pub(super) fn show(ui: &Ui, response: &Response, (session, lens): (&mut Session, &Lens), reach: f32) {
    // The list is made for each pass, so it is not made for nobody.
    if !ui.ctx().has_accesskit_node(response.id) {
        return;
    }
    let place = |point: ScreenPoint| {
        let at = lens.viewport_from_screen(point);
        response.rect.min + vec2(at.x as f32, at.y as f32)
    };
    let parts: Vec<(Track, Part)> = tracks(session)
        .map(|(track, point)| {
            let rect = Rect::from_center_size(place(point), Vec2::splat(2.0 * reach));
            let (id, is_chosen) = (response.id.with(track), session.selection.has(track));
            (track, Part { id, rect, label: label(session, track), is_chosen })
        })
        .filter(|(_, part)| response.rect.intersects(part.rect))
        .collect();
    let (tracks, parts): (Vec<Track>, Vec<Part>) = parts.into_iter().unzip();
    let chosen = accessible::parts(ui, response, parts.into_iter()).and_then(|place| tracks.get(place));
    // A drag goes on with what it began with.
    let chosen = chosen.filter(|_| !session.is_dragging());
    match chosen {
        Some(Track::Pin(at)) => session.selection.only_pin(*at),
        Some(Track::Handle(at)) => session.selection.only_handle(*at),
        Some(Track::Rotation(_) | Track::Scale(_)) | None => {}
    }
    if chosen.is_some() {
        response.request_focus();
    }
}

/// Returns the pins that are shown and the handles that can be moved, with their places.
fn tracks(session: &Session) -> impl Iterator<Item = (Track, ScreenPoint)> {
    let pins = session.marks().iter().filter(|_| session.shown.shows_pins());
    let pins = pins.flat_map(|marks| marks.pins.iter().map(|pin| (Track::Pin([marks.layer, pin.pin]), pin.target)));
    let handles = session.movable_handles().map(|(at, place)| (Track::Handle(at), place));
    pins.chain(handles)
}

/// Returns what is said of a pin or handle: its name, its layer, and whether a pin is keyed here.
fn label(session: &Session, track: Track) -> String {
    let shot = session.shot();
    let layer = shot.layers.get(track.layer()).map_or("", |layer| layer.name.as_str());
    let name = track.name(shot);
    match track.pin() {
        None => format!("{name} of {layer}").replacen("handle", "Handle", 1),
        Some(at) if session.has_key_here(at) => format!("Pin {name} of {layer}, keyed in this frame"),
        Some(_) => format!("Pin {name} of {layer}"),
    }
}
