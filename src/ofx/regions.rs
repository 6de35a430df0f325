//! Regions, identity and clip preferences: the queries of a host before it renders.
//!
//! In: time and region. Out: canonical regions. Pixels are available to renders only; where the shape depends on them,
//! regions are conservative.

use super::api::Status;
use super::api::names::{image, prop};
use super::call::{Call, PluginKind};
use super::clips::{BACKGROUND_CLIP, MASK_CLIP, MATTE_CLIP, connected};
use super::fault::Fault;
use super::host::Clip;
use super::host_frame::{HostFrame, is_endless, project_at};
use super::params::{SHAPES, ShapeFrom};
use super::settings::{Settings, ShapeChoice, at_arguments};
use super::values::ParamValues;
use crate::live;
use std::ffi::{CStr, CString};

/// Computes the output's region of definition.
pub(super) fn definition(call: Call) -> Result<Status, Fault> {
    let (time, host_frame, exposed) = at_arguments(call)?;
    let Some(source) = call.effect.clip(image::SOURCE_CLIP).and_then(|clip| clip.region(time)) else {
        return Ok(Status::REPLY_DEFAULT);
    };
    let mut region = host_frame.region(host_frame.window_of(source));
    if call.kind == PluginKind::StMap {
        let project = project_at(call.effect, time, ([1.0, 1.0], None));
        region = joined(region, project.canonical_region());
    } else {
        let mut parts = exposed.iter().map(|settings| shown(call, settings, &host_frame, source));
        let first = parts.next().unwrap_or(Ok(region))?;
        region = parts.try_fold(first, |region, part| part.map(|part| joined(region, part)))?;
    }
    // The source shows where a mask or matte hides the warp; a background shows everywhere.
    if shows_source(call, &exposed) {
        region = joined(region, source);
    }
    if let Some(shown) = connected(call, BACKGROUND_CLIP).and_then(|clip| clip.region(time)) {
        region = joined(region, shown);
    }
    call.out.set_doubles(image::REGION_OF_DEFINITION, &as_endless(region, source));
    Ok(Status::OK)
}

/// Makes a region infinite on the sides where the source is: hosts crop only infinite regions to the project's size.
fn as_endless(region: [f64; 4], source: [f64; 4]) -> [f64; 4] {
    std::array::from_fn(|side| if is_endless(source[side]) { source[side] } else { region[side] })
}

/// Returns whether parts of the unwarped source show.
fn shows_source(call: Call, exposed: &[Settings]) -> bool {
    let is_masked = [MASK_CLIP, MATTE_CLIP].iter().any(|name| connected(call, name).is_some());
    is_masked || exposed.iter().any(|settings| settings.mix < 1.0)
}

/// Returns the region that the warp maps a region of the source to.
fn shown(call: Call, settings: &Settings, host_frame: &HostFrame, source: [f64; 4]) -> Result<[f64; 4], Fault> {
    let window = host_frame.window_of(source);
    if settings.is_at_rest() {
        return Ok(host_frame.region(window));
    }
    let frame = host_frame.frame;
    let window = match settings.shape {
        ShapeChoice::Alpha => {
            live::destination_of_any_alpha(&settings.controls, window, frame, &|| call.effect.is_aborted())?
        }
        _ => settings.warp(call.effect, host_frame, None)?.destination_of(window, frame),
    };
    Ok(host_frame.region(window))
}

/// Computes the region of interest of each clip for a region of the output.
pub(super) fn interest(call: Call) -> Result<Status, Fault> {
    let (time, host_frame, exposed) = at_arguments(call)?;
    let Some(asked) = call.args.doubles(image::REGION_OF_INTEREST) else { return Ok(Status::REPLY_DEFAULT) };
    let source = call.effect.clip(image::SOURCE_CLIP).and_then(|clip| clip.region(time));
    // For an infinite source, the alpha within the frame gives the shape.
    let source = source.map(|source| {
        if source.iter().any(|side| is_endless(*side)) { joined(asked, host_frame.canonical_region()) } else { source }
    });
    let mut needed = source.unwrap_or(asked);
    if exposed[0].shape != ShapeChoice::Alpha {
        let window = host_frame.window_of(asked);
        let mut parts = exposed.iter().map(|settings| {
            let warp = settings.warp(call.effect, &host_frame, None)?;
            Ok::<_, Fault>(host_frame.region(warp.source_of(window, host_frame.frame, settings.filter)))
        });
        let first = parts.next().unwrap_or(Ok(asked))?;
        needed = parts.try_fold(first, |needed, part| part.map(|part| joined(needed, part)))?;
        if shows_source(call, &exposed) {
            needed = joined(needed, asked);
        }
    }
    set_region(call, image::SOURCE_CLIP, needed);
    for name in [MASK_CLIP, MATTE_CLIP, BACKGROUND_CLIP] {
        if connected(call, name).is_some() {
            set_region(call, name, asked);
        }
    }
    Ok(Status::OK)
}

fn set_region(call: Call, clip: &CStr, region: [f64; 4]) {
    call.out.set_doubles(&of_clip(image::CLIP_ROI_PREFIX, clip), &region);
}

/// Returns a property's name for one clip.
fn of_clip(prefix: &CStr, clip: &CStr) -> CString {
    CString::new([prefix.to_bytes(), clip.to_bytes()].concat()).unwrap_or_default()
}

fn joined(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
}

/// Returns whether the source may be passed through.
pub(super) fn is_identity(call: Call) -> Result<Status, Fault> {
    if call.kind == PluginKind::StMap || connected(call, BACKGROUND_CLIP).is_some() {
        return Ok(Status::REPLY_DEFAULT);
    }
    let (time, host_frame, exposed) = at_arguments(call)?;
    let rests = |settings: &Settings| {
        let is_shot = matches!(settings.shape, ShapeChoice::Shot(_));
        Ok::<_, Fault>(settings.is_at_rest() || is_shot && settings.warp(call.effect, &host_frame, None)?.is_identity())
    };
    if !exposed.iter().map(rests).try_fold(true, |all, rests| rests.map(|rests| all && rests))? {
        return Ok(Status::REPLY_DEFAULT);
    }
    call.out.set_names(prop::NAME, &[image::SOURCE_CLIP]);
    call.out.set_doubles(prop::TIME, &[time]);
    Ok(Status::OK)
}

/// Sets the clip preferences: premultiplication follows the source, but an opaque source gets holes where it is moved
/// away.
pub(super) fn clip_preferences(call: Call) -> Result<Status, Fault> {
    // A shot's model is animated, even if neither the source nor a parameter is.
    let is_shot = ParamValues::of(call.effect, 0.0)?.choice("shape", &SHAPES) == ShapeFrom::Shot;
    call.out.set_int(image::FRAME_VARYING, i32::from(is_shot));
    if call.kind == PluginKind::StMap {
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
