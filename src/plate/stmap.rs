//! STMaps: maps as pictures that other compositors read and write.
//!
//! In: a [`WarpMap`], or a picture of any program. Out: the other. u = (x + .5)/W, v = 1 − (y + .5)/H with y from the top and
//! W, H of the display window, also where the data window reaches beyond it: the identity is exact in OpenImageIO's
//! `st_warp`, in Nuke and in Natron; (x / (W − 1)) is not.

use super::{PlateError, WarpMap};
use crate::image::{Channel, Frame, Plate, PlatePart, Storage};
use crate::space::{FrameSize, PixelRect};
use rayon::prelude::*;

/// Layers and names under which STMaps lie in files, likeliest first.
const NAMES: [[&str; 2]; 5] = [["R", "G"], ["u", "v"], ["U", "V"], ["X", "Y"], ["red", "green"]];
/// u and v of pixels at rest lie this near to the exact quotient: single precision and a quotient taken as a product.
const REST: f64 = 1.5e-7;
/// No sensible map looks further than this, in frame widths or heights: its numbers are pixels.
const FURTHEST: f32 = 64.0;

/// The map as 32-bit float channels R (u), G (v), B (0) and A (1; where nothing is seen 0, with u = v = −1, which every
/// reader takes for black).
#[must_use]
pub fn stmap_of(map: &WarpMap) -> Frame {
    let (frame, window) = (map.frame, map.window);
    let names = ["R", "G", "B", "A"].map(|name| (name, Storage::Float));
    let mut stmap = Frame::blank(frame.window(), window, &names);
    stmap.pixel_aspect = frame.pixel_aspect;
    let [red, green, _, alpha] = &mut stmap.channels[..] else { return stmap };
    for (index, offset) in map.offsets.iter().enumerate() {
        let rest = rest(frame, window, index);
        let is_seen = offset.iter().all(|offset| offset.is_finite());
        let [dx, dy] = offset.map(f64::from);
        let u = rest[0] + dx / f64::from(frame.width);
        let v = rest[1] - dy / f64::from(frame.height);
        red.samples[index] = if is_seen { u as f32 } else { -1.0 };
        green.samples[index] = if is_seen { v as f32 } else { -1.0 };
        alpha.samples[index] = if is_seen { 1.0 } else { 0.0 };
    }
    stmap
}

/// The map that an STMap holds: channels R and G (u and v, forward.u and forward.v, ... where there is no such layer) of
/// the first part that has them. Where they are no finite numbers, and where the alpha of the same layer is 0, nothing
/// is seen. What single precision cannot tell from rest rests.
///
/// # Errors
/// [`PlateError::NoStMap`] where there are no such channels; [`PlateError::StMapOfIntegers`] where they hold whole
/// numbers; [`PlateError::StMapInPixels`] where the values are no shares of the frame.
pub fn map_of_stmap(stmap: &Plate) -> Result<WarpMap, PlateError> {
    let Found { part, layer, uv } = found_in(stmap)?;
    let alpha = part.channel(&format!("{layer}A")).map(|alpha| alpha.samples.as_slice());
    let mut map = WarpMap::identity(stmap.frame_size(), stmap.window_of(part));
    let place = |index: usize| uv.map(|channel| channel.samples[index]);
    let (frame, window) = (map.frame, map.window);
    map.offsets.par_iter_mut().enumerate().for_each(|(index, offset)| {
        let is_seen = alpha.is_none_or(|alpha| alpha[index] > 0.0);
        *offset = if is_seen { offset_of(place(index), rest(frame, window, index), frame) } else { [f32::NAN; 2] };
    });
    let is_pixels = |&index: &usize| {
        let is_seen = map.offsets[index].iter().all(|offset| offset.is_finite());
        is_seen && place(index).iter().any(|share| share.abs() > FURTHEST)
    };
    match (0..map.offsets.len()).find(is_pixels) {
        Some(index) => Err(in_pixels(uv[0], place(index), [frame.width, frame.height])),
        None => Ok(map),
    }
}

/// From the centre of a pixel to the place (u, v), in pixels, y down; NaN where it is no place.
fn offset_of(place: [f32; 2], rest: [f64; 2], frame: FrameSize) -> [f32; 2] {
    if !place.iter().all(|share| share.is_finite()) {
        return [f32::NAN; 2];
    }
    let [du, dv] = [0, 1].map(|axis| {
        let moved = f64::from(place[axis]) - rest[axis];
        if moved.abs() <= REST * rest[axis].abs().max(1.0) { 0.0 } else { moved }
    });
    [(du * f64::from(frame.width)) as f32, (-dv * f64::from(frame.height)) as f32]
}

/// u and v of a pixel at rest.
fn rest(frame: FrameSize, window: PixelRect, index: usize) -> [f64; 2] {
    let width = window.width as usize;
    let (x, y) = (f64::from(window.x) + (index % width) as f64, f64::from(window.y) + (index / width) as f64);
    // The image's rows run down, v runs up.
    [(x + 0.5) / f64::from(frame.width), (f64::from(frame.height) - y - 0.5) / f64::from(frame.height)]
}

/// Where an STMap lies in a file.
struct Found<'a> {
    part: &'a PlatePart,
    /// Name of the layer with its dot; empty: none.
    layer: &'a str,
    uv: [&'a Channel; 2],
}

/// The likeliest layer of the first part that has one.
fn found_in(stmap: &Plate) -> Result<Found<'_>, PlateError> {
    let found = stmap.parts.iter().find_map(found_in_part).ok_or_else(|| {
        let channels = stmap.parts.iter().flat_map(|part| &part.channels);
        let found: Vec<&str> = channels.map(|channel| channel.name.as_str()).collect();
        PlateError::NoStMap { found: found.join(", ") }
    })?;
    match found.uv.iter().find(|channel| channel.storage == Storage::Uint) {
        Some(channel) => Err(PlateError::StMapOfIntegers { channel: channel.name.clone() }),
        None => Ok(found),
    }
}

/// Checks what the head of an STMap tells: that it has channels for a map of the plate's frame. No samples are needed.
///
/// # Errors
/// [`PlateError::NoStMap`], [`PlateError::StMapOfIntegers`], [`PlateError::WrongMap`].
pub fn check_stmap(stmap: &Plate, plate: &Plate) -> Result<(), PlateError> {
    found_in(stmap)?;
    let [map, plate] = [stmap, plate].map(|picture| [picture.display.width, picture.display.height]);
    if map == plate { Ok(()) } else { Err(PlateError::WrongMap { map, plate }) }
}

fn found_in_part(part: &PlatePart) -> Option<Found<'_>> {
    let layer_of = |channel: &'_ Channel| channel.name.rfind('.').map_or(0, |dot| dot + 1);
    let layers =
        || std::iter::once("").chain(part.channels.iter().map(move |channel| &channel.name[..layer_of(channel)]));
    let pairs = NAMES.iter().flat_map(|names| layers().map(move |layer| (layer, names)));
    pairs.into_iter().find_map(|(layer, [u, v])| {
        let [u, v] = [u, v].map(|name| part.channel(&format!("{layer}{name}")));
        Some(Found { part, layer, uv: [u?, v?] })
    })
}

fn in_pixels(u: &Channel, place: [f32; 2], frame: [u32; 2]) -> PlateError {
    PlateError::StMapInPixels { channel: u.name.clone(), found: format!("{} {}", place[0], place[1]), frame }
}
