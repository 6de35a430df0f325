//! Regions, identity and clip preferences: what a host asks before it renders.
//!
//! In: time and region. Out: regions, canonical. Only renders have pixels; where the shape comes from them, regions are
//! generous.

use super::api::Status;
use super::api::names::{image, prop};
use super::describe::{BACKGROUND_CLIP, MASK_CLIP};
use super::entry::{Call, Kind};
use super::fault::Fault;
use super::host::Clip;
use super::params::{SHAPES, ShapeFrom};
use super::settings::{Moment, Settings, ShapeChoice, at_arguments};
use crate::live::Canvas;
use crate::space::PixelRect;
use std::ffi::{CStr, CString};

/// Where the output has pixels.
pub(super) fn definition(call: Call) -> Result<Status, Fault> {
    let (time, canvas, settings) = at_arguments(call)?;
    let Some(source) = call.effect.clip(image::SOURCE_CLIP).and_then(|clip| clip.region(time)) else {
        return Ok(Status::REPLY_DEFAULT);
    };
    let mut region = canvas.region(canvas.window_of(source));
    if call.kind == Kind::StMap {
        region = joined(region, frame(&canvas));
    } else if !settings.is_at_rest() {
        region = canvas.region(warped(&settings, &canvas, source)?);
    }
    for name in [MASK_CLIP, BACKGROUND_CLIP] {
        // Where the mask hides the warp the source shows; a background shows everywhere.
        if let Some(clip) = connected(call, name) {
            let shown = if name == MASK_CLIP { Some(source) } else { clip.region(time) };
            region = shown.map_or(region, |shown| joined(region, shown));
        }
    }
    call.out.set_doubles(image::REGION_OF_DEFINITION, &as_endless(region, source));
    Ok(Status::OK)
}

/// The same region, without end where the source is: hosts cut only what they know to have no end to a project's size.
fn as_endless(region: [f64; 4], source: [f64; 4]) -> [f64; 4] {
    std::array::from_fn(|side| if is_endless(source[side]) { source[side] } else { region[side] })
}

/// Whether a side of a region says that there is no end to it.
pub(super) fn is_endless(side: f64) -> bool {
    side <= f64::from(i32::MIN) || side >= f64::from(i32::MAX)
}

/// What a region of the source becomes.
fn warped(settings: &Settings, canvas: &Canvas, source: [f64; 4]) -> Result<PixelRect, Fault> {
    let window = canvas.window_of(source);
    if settings.shape == ShapeChoice::Alpha {
        return Ok(settings.controls.destination_of(window, canvas.frame));
    }
    Ok(settings.warp(canvas, None)?.destination_of(window, canvas.frame))
}

/// What is needed of each clip for a part of the output.
pub(super) fn interest(call: Call) -> Result<Status, Fault> {
    let (time, canvas, settings) = at_arguments(call)?;
    let Some(asked) = call.args.doubles(image::REGION_OF_INTEREST) else { return Ok(Status::REPLY_DEFAULT) };
    let source = call.effect.clip(image::SOURCE_CLIP).and_then(|clip| clip.region(time));
    // Of a source without end the alpha within the picture gives the shape.
    let source = source
        .map(|source| if source.iter().any(|side| is_endless(*side)) { joined(asked, frame(&canvas)) } else { source });
    let mut needed = source.unwrap_or(asked);
    if settings.shape != ShapeChoice::Alpha {
        let warp = settings.warp(&canvas, None)?;
        needed = canvas.region(warp.source_of(canvas.window_of(asked), canvas.frame, settings.filter));
        if connected(call, MASK_CLIP).is_some() {
            needed = joined(needed, asked);
        }
    }
    set_region(call, image::SOURCE_CLIP, needed);
    for name in [MASK_CLIP, BACKGROUND_CLIP] {
        if connected(call, name).is_some() {
            set_region(call, name, asked);
        }
    }
    Ok(Status::OK)
}

fn set_region(call: Call, clip: &CStr, region: [f64; 4]) {
    call.out.set_doubles(&of_clip(image::CLIP_ROI_PREFIX, clip), &region);
}

/// A property's name for one clip.
fn of_clip(prefix: &CStr, clip: &CStr) -> CString {
    CString::new([prefix.to_bytes(), clip.to_bytes()].concat()).unwrap_or_default()
}

/// An optional clip with something at its other end.
pub(super) fn connected<'a>(call: Call<'a>, name: &'static CStr) -> Option<Clip<'a>> {
    let is_there = call.kind == Kind::PinWarp;
    let clip = is_there.then(|| call.effect.clip(name)).flatten()?;
    (clip.props().int(image::CLIP_CONNECTED) == Some(1)).then_some(clip)
}

/// The project's picture.
fn frame(canvas: &Canvas) -> [f64; 4] {
    canvas.region(canvas.frame.window())
}

fn joined(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
}

/// Whether the source may be passed on.
pub(super) fn is_identity(call: Call) -> Result<Status, Fault> {
    if call.kind == Kind::StMap || connected(call, BACKGROUND_CLIP).is_some() {
        return Ok(Status::REPLY_DEFAULT);
    }
    let (time, canvas, settings) = at_arguments(call)?;
    let rests = settings.is_at_rest()
        || matches!(settings.shape, ShapeChoice::Shot(_)) && settings.warp(&canvas, None)?.is_identity();
    if !rests {
        return Ok(Status::REPLY_DEFAULT);
    }
    call.out.set_names(prop::NAME, &[image::SOURCE_CLIP]);
    call.out.set_doubles(prop::TIME, &[time]);
    Ok(Status::OK)
}

/// Premultiplication follows the source: an opaque one gets holes where it is pulled away.
pub(super) fn clip_preferences(call: Call) -> Result<Status, Fault> {
    // The model of a shot is animated, even where neither the source nor a parameter is.
    let is_shot = Moment::of(call.effect, 0.0)?.choice("shape", &SHAPES) == ShapeFrom::Shot;
    call.out.set_int(image::FRAME_VARYING, i32::from(is_shot));
    if call.kind == Kind::StMap {
        let output = image::OUTPUT_CLIP;
        call.out.set_names(&of_clip(image::CLIP_DEPTH_PREFIX, output), &[image::DEPTH_FLOAT]);
        call.out.set_names(&of_clip(image::CLIP_COMPONENTS_PREFIX, output), &[image::COMPONENT_RGBA]);
        call.out.set_names(image::PREMULTIPLICATION, &[image::UNPREMULTIPLIED]);
        return Ok(Status::OK);
    }
    let source = call.effect.clip(image::SOURCE_CLIP).map(Clip::props);
    let told = source.and_then(|props| props.text(image::PREMULTIPLICATION)).unwrap_or_default();
    let kinds = [
        (image::UNPREMULTIPLIED, image::UNPREMULTIPLIED),
        (image::PREMULTIPLIED, image::PREMULTIPLIED),
        (image::OPAQUE, image::PREMULTIPLIED),
    ];
    if let Some((_, kind)) = kinds.into_iter().find(|(known, _)| known.to_bytes() == told.as_bytes()) {
        call.out.set_names(image::PREMULTIPLICATION, &[kind]);
    }
    Ok(Status::OK)
}
