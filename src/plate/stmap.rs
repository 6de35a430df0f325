//! STMaps: maps as pictures that other compositors read and write.
//!
//! In: a [`WarpMap`] or a frame of channels. Out: the other. u = (x + .5)/W, v = 1 − (y + .5)/H with y from the top and
//! W, H of the display window, also where the data window reaches beyond it: the identity is exact in OpenImageIO's
//! `st_warp`, in Nuke and in Natron; (x / (W − 1)) is not.

use super::{PlateError, WarpMap};
use crate::image::{Channel, Frame, Storage};
use crate::space::{FrameSize, PixelRect};

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

/// The map that an STMap holds: channels R and G (u and v, forward.u and forward.v, ... where there is no such layer).
/// Where they are no finite numbers, and where the alpha of the same layer is 0, nothing is seen. What single precision
/// cannot tell from rest rests.
///
/// # Errors
/// [`PlateError::NoStMap`] where there are no such channels; [`PlateError::StMapInPixels`] where the values are no
/// shares of the frame.
pub fn map_of_stmap(stmap: &Frame) -> Result<WarpMap, PlateError> {
    let (layer, [u, v]) = channels_of(stmap)?;
    let alpha = stmap.channel(&format!("{layer}A"));
    let display = stmap.display;
    let frame = FrameSize { width: display.width, height: display.height, pixel_aspect: stmap.pixel_aspect };
    let window = stmap.data_window;
    let window = PixelRect { x: window.x - display.x, y: window.y - display.y, ..window };
    let mut map = WarpMap::identity(frame, window);
    for (index, offset) in map.offsets.iter_mut().enumerate() {
        let place = [u.samples[index], v.samples[index]];
        let is_covered = alpha.is_none_or(|alpha| alpha.samples[index] > 0.0);
        if !(is_covered && place.iter().all(|share| share.is_finite())) {
            *offset = [f32::NAN; 2];
            continue;
        }
        if place.iter().any(|share| share.abs() > FURTHEST) {
            return Err(in_pixels(u, place, [display.width, display.height]));
        }
        let rest = rest(frame, window, index);
        let [du, dv] = [0, 1].map(|axis| {
            let moved = f64::from(place[axis]) - rest[axis];
            if moved.abs() <= REST * rest[axis].abs().max(1.0) { 0.0 } else { moved }
        });
        *offset = [(du * f64::from(frame.width)) as f32, (-dv * f64::from(frame.height)) as f32];
    }
    Ok(map)
}

/// u and v of a pixel at rest.
fn rest(frame: FrameSize, window: PixelRect, index: usize) -> [f64; 2] {
    let width = window.width as usize;
    let (x, y) = (f64::from(window.x) + (index % width) as f64, f64::from(window.y) + (index / width) as f64);
    // The image's rows run down, v runs up.
    [(x + 0.5) / f64::from(frame.width), (f64::from(frame.height) - y - 0.5) / f64::from(frame.height)]
}

/// The channels of the likeliest layer, and its name with the dot.
fn channels_of(stmap: &Frame) -> Result<(String, [&Channel; 2]), PlateError> {
    let layers = || {
        let named =
            stmap.channels.iter().map(|channel| channel.name.rfind('.').map_or("", |dot| &channel.name[..=dot]));
        std::iter::once("").chain(named)
    };
    let pairs = NAMES.iter().flat_map(|names| layers().map(move |layer| (layer, names)));
    for (layer, [u, v]) in pairs {
        let found = [u, v].map(|name| stmap.channel(&format!("{layer}{name}")));
        if let [Some(u), Some(v)] = found
            && [u, v].iter().all(|channel| channel.samples.len() == stmap.data_window.area())
        {
            return Ok((layer.to_owned(), [u, v]));
        }
    }
    let found: Vec<&str> = stmap.channels.iter().map(|channel| channel.name.as_str()).collect();
    Err(PlateError::NoStMap { found: found.join(", ") })
}

fn in_pixels(u: &Channel, place: [f32; 2], frame: [u32; 2]) -> PlateError {
    PlateError::StMapInPixels { channel: u.name.clone(), found: format!("{} {}", place[0], place[1]), frame }
}
