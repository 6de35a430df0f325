//! Onion skins: the frames around the current one, or those of the keys around it.
//!
//! In: a [`Session`]. Out: pictures with their tints.

use crate::edit::{Picture, Session};
use eframe::egui::Color32;
use std::sync::Arc;

/// Returns the onion skins, the farthest first, each with its tint.
pub(super) fn onions(session: &Session) -> Vec<(&Arc<Picture>, Color32)> {
    let onion = session.shown.onion;
    if onion.count == 0 || session.playhead.is_playing() {
        return Vec::new();
    }
    let here = session.playhead.frame();
    let mut found = Vec::new();
    for far in (1..=onion.count as i32).rev() {
        for side in [-1, 1] {
            let Some(frame) = onion_frame(session, here, far * side) else { continue };
            let [red, green, blue] = onion.tints[usize::from(side > 0)];
            let color = Color32::from_rgb(red, green, blue);
            let opacity = onion.opacity / far as f32;
            found.extend(session.picture_of(frame).map(|picture| (picture, color.gamma_multiply(opacity))));
        }
    }
    found
}

/// Returns the frame a number of steps, or of keys, away.
fn onion_frame(session: &Session, here: i32, steps: i32) -> Option<i32> {
    if session.shown.onion.every > 0 {
        return Some(here + steps * session.shown.onion.every as i32);
    }
    let shot = session.shot();
    let tracks = session.selection.tracks(shot).into_iter();
    let mut times: Vec<i32> = tracks.flat_map(|track| track.times(shot)).map(|(time, _)| time.round() as i32).collect();
    times.sort_unstable();
    times.dedup();
    match steps > 0 {
        true => times.iter().filter(|time| **time > here).nth(steps as usize - 1).copied(),
        false => times.iter().rev().filter(|time| **time < here).nth(steps.unsigned_abs() as usize - 1).copied(),
    }
}
