//! Reads and writes STMaps, the exchange format of compositors for warps.
//!
//! In: a [`WarpMap`] or an STMap of any program. Out: the other. u = (x + .5)/W, v = 1 − (y + .5)/H with y from the top
//! and W, H of the display window, even if the data window extends beyond it. The identity is then exact in
//! OpenImageIO's `st_warp`, in Nuke and in Natron; (x / (W − 1)) is not.

use super::{PlateError, WarpMap};
use crate::image::{Channel, Frame, Plate, PlatePart, Storage};
use crate::space::{FrameSize, PixelRect};
use rayon::prelude::*;

/// Channel names of u and v in STMaps, most likely first.
const NAMES: [[&str; 2]; 5] = [["R", "G"], ["u", "v"], ["U", "V"], ["X", "Y"], ["red", "green"]];
/// Tolerance within which u and v count as identity: single-precision rounding, and division by multiplication with a reciprocal.
const REST: f64 = 1.5e-7;
/// Largest plausible coordinate, in frame widths or heights; larger values are pixels.
const FURTHEST: f32 = 64.0;

/// Converts a map to 32-bit float channels R (u), G (v), B (0) and A (1). Where the map is undefined, A is 0 and both u
/// and v are −1, which every reader renders as black.
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

/// Converts an STMap to a map.
///
/// Takes u and v from channels R and G (or u and v, forward.u and forward.v, ... if there is no such layer) of the
/// first part that has them. The map is undefined where they are not finite or the alpha of the same layer is 0. Values
/// that equal the identity in single precision become exactly the identity.
///
/// # Errors
/// [`PlateError::NoStMap`] if there are no such channels; [`PlateError::StMapOfIntegers`] if they are integers;
/// [`PlateError::StMapInPixels`] if the values are not fractions of the frame; [`PlateError::RenderAsStMap`] if the picture
/// is a render of pinwarp.
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
        // The maps of this program have B = 0, and those of others may hold anything there.
        None if stmap.is_own_render() && has_blue(part, layer) && map.doubt().is_some() => {
            Err(PlateError::RenderAsStMap)
        }
        None => Ok(map),
    }
}

/// Whether the third channel of a layer holds anything.
fn has_blue(part: &PlatePart, layer: &str) -> bool {
    part.channel(&format!("{layer}B")).is_some_and(|blue| blue.samples.iter().any(|sample| *sample != 0.0))
}

/// Returns the offset from a pixel centre to the position (u, v), in pixels, y down; NaN if the position is not finite.
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

/// Returns u and v of the identity at a pixel.
fn rest(frame: FrameSize, window: PixelRect, index: usize) -> [f64; 2] {
    let width = window.width as usize;
    let (x, y) = (f64::from(window.x) + (index % width) as f64, f64::from(window.y) + (index / width) as f64);
    // Image rows run down, v runs up.
    [(x + 0.5) / f64::from(frame.width), (f64::from(frame.height) - y - 0.5) / f64::from(frame.height)]
}

/// The location of an STMap in a file.
struct Found<'a> {
    part: &'a PlatePart,
    /// Layer prefix including its dot; empty for none.
    layer: &'a str,
    uv: [&'a Channel; 2],
}

/// Finds the most likely layer of the first part that has one.
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

/// Checks from the header alone that a plate holds an STMap of another plate's frame size; needs no samples.
///
/// # Errors
/// [`PlateError::NoStMap`], [`PlateError::StMapOfIntegers`], [`PlateError::WrongMap`].
pub(crate) fn check_stmap(stmap: &Plate, plate: &Plate) -> Result<(), PlateError> {
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
