//! Regions, identity and clip preferences: what a host asks before it renders.
//!
//! In: time and region. Out: regions, canonical. Only renders have pixels; where the shape comes from them, regions are
//! generous.

use super::api::names::{image, prop};
use super::api::{RectD, Status};
use super::canvas::Canvas;
use super::describe::{BACKGROUND_CLIP, MASK_CLIP};
use super::effect::Clip;
use super::entry::{Call, Kind};
use super::fault::Fault;
use super::settings::{Settings, ShapeChoice, at_arguments};
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
        region = joined(region, canvas.region(canvas.frame.window()));
    } else if !settings.is_at_rest() {
        region = canvas.region(warped(&settings, &canvas, source)?);
    }
    for name in [MASK_CLIP, BACKGROUND_CLIP] {
        // Where the mask hides the warp the source shows; a background shows everywhere.
        if let Some(clip) = connected(call, name) {
            let shown = if name == MASK_CLIP { Some(source) } else { clip.region(time) };
            region = shown.map_or(region, |shown| joined(region, [shown.x1, shown.y1, shown.x2, shown.y2]));
        }
    }
    call.out.set_doubles(image::REGION_OF_DEFINITION, &region);
    Ok(Status::OK)
}

/// What a region of the source becomes.
fn warped(settings: &Settings, canvas: &Canvas, source: RectD) -> Result<PixelRect, Fault> {
    let window = canvas.window_of(source);
    if settings.shape == ShapeChoice::Alpha {
        // Nothing is solved without pixels; no sensible warp carries a point further than its furthest pin and half more.
        let pins = settings.controls.pins.iter();
        let turns = settings.controls.pins.iter().any(|pin| pin.rotation.is_some());
        let furthest = pins.map(|pin| (pin.target - pin.rest).0.length()).fold(0.0, f64::max);
        let reach = settings.controls.strength.abs() * furthest * 1.5 + if turns { 1.0 } else { 0.0 };
        return Ok(grown(window, reach * f64::from(canvas.frame.height)));
    }
    Ok(settings.warp(canvas, None)?.destination_of(window, canvas.frame))
}

/// What is needed of each clip for a part of the output.
pub(super) fn interest(call: Call) -> Result<Status, Fault> {
    let (time, canvas, settings) = at_arguments(call)?;
    let Some([x1, y1, x2, y2]) = call.args.doubles(image::REGION_OF_INTEREST) else {
        return Ok(Status::REPLY_DEFAULT);
    };
    let asked = RectD { x1, y1, x2, y2 };
    let source = call.effect.clip(image::SOURCE_CLIP).and_then(|clip| clip.region(time)).unwrap_or(asked);
    let mut needed = [source.x1, source.y1, source.x2, source.y2];
    if settings.shape != ShapeChoice::Alpha {
        let warp = settings.warp(&canvas, None)?;
        needed = canvas.region(warp.source_of(canvas.window_of(asked), canvas.frame, settings.filter));
        if connected(call, MASK_CLIP).is_some() {
            needed = joined(needed, [x1, y1, x2, y2]);
        }
    }
    set_region(call, image::SOURCE_CLIP, needed);
    for name in [MASK_CLIP, BACKGROUND_CLIP] {
        if connected(call, name).is_some() {
            set_region(call, name, [x1, y1, x2, y2]);
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

/// A window with a border of so many pixels more.
fn grown(window: PixelRect, border: f64) -> PixelRect {
    let border = border.ceil().clamp(0.0, 1e5) as u32;
    PixelRect {
        x: window.x.saturating_sub_unsigned(border),
        y: window.y.saturating_sub_unsigned(border),
        width: window.width.saturating_add(2 * border),
        height: window.height.saturating_add(2 * border),
    }
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
    if call.kind == Kind::StMap {
        let output = image::OUTPUT_CLIP;
        call.out.set_names(&of_clip(image::CLIP_DEPTH_PREFIX, output), &[image::DEPTH_FLOAT]);
        call.out.set_names(&of_clip(image::CLIP_COMPONENTS_PREFIX, output), &[image::COMPONENT_RGBA]);
        call.out.set_names(image::PREMULTIPLICATION, &[image::UNPREMULTIPLIED]);
        return Ok(Status::OK);
    }
    let source = call.effect.clip(image::SOURCE_CLIP).map(Clip::props);
    let told = source.and_then(|props| props.text(image::PREMULTIPLICATION)).unwrap_or_default();
    let kinds = [image::UNPREMULTIPLIED, image::PREMULTIPLIED];
    if let Some(kind) = kinds.into_iter().find(|kind| kind.to_bytes() == told.as_bytes()) {
        call.out.set_names(image::PREMULTIPLICATION, &[kind]);
    }
    Ok(Status::OK)
}
