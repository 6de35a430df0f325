//! What the plugins can do, and the clips and parameters they have.
//!
//! In: a descriptor. Out: its properties, set.

use super::api::Status;
use super::api::names::{image, prop};
use super::entry::{Call, Kind};
use super::fault::Fault;
use std::ffi::CStr;

/// Clip name: where it is black, nothing is warped.
pub(super) const MASK_CLIP: &CStr = c"Mask";
/// Clip name: what the warped picture is laid over.
pub(super) const BACKGROUND_CLIP: &CStr = c"Background";

/// Contexts, depths and abilities.
pub(super) fn describe(call: Call) -> Result<Status, Fault> {
    let props = call.effect.props();
    let (label, about) = match call.kind {
        Kind::PinWarp => {
            (c"PinWarp", c"Warps the picture softly with pins: the lattice bends, the local look survives.")
        }
        Kind::StMap => {
            (c"PinWarp ST", c"The STMap of a PinWarp with the same parameters, for other channels and nodes.")
        }
    };
    props.set_names(prop::LABEL, &[label]);
    props.set_names(prop::SHORT_LABEL, &[label]);
    props.set_names(prop::LONG_LABEL, &[label]);
    props.set_names(prop::PLUGIN_DESCRIPTION, &[about]);
    props.set_names(image::GROUPING, &[c"Distort"]);
    props.set_names(image::SUPPORTED_CONTEXTS, &[image::CONTEXT_FILTER, image::CONTEXT_GENERAL]);
    props.set_names(image::RENDER_THREAD_SAFETY, &[image::RENDER_FULLY_SAFE]);
    let depths: &[&CStr] = match call.kind {
        Kind::PinWarp => &[image::DEPTH_FLOAT, image::DEPTH_HALF, image::DEPTH_SHORT, image::DEPTH_BYTE],
        Kind::StMap => &[image::DEPTH_FLOAT],
    };
    props.set_names(image::SUPPORTED_PIXEL_DEPTHS, depths);
    for (name, is_set) in [
        (image::SINGLE_INSTANCE, 0),
        (image::HOST_FRAME_THREADING, 0),
        (image::SUPPORTS_MULTI_RESOLUTION, 1),
        (image::SUPPORTS_TILES, i32::from(!call.effect.suites.host_is("Resolve"))),
        (image::TEMPORAL_CLIP_ACCESS, 0),
        (image::FIELD_RENDER_TWICE_ALWAYS, 0),
        (image::SUPPORTS_MULTIPLE_CLIP_DEPTHS, 0),
        (image::SUPPORTS_MULTIPLE_CLIP_PARS, 0),
    ] {
        props.set_int(name, is_set);
    }
    Ok(Status::OK)
}

/// Clips and parameters of a context.
pub(super) fn describe_in_context(call: Call) -> Result<Status, Fault> {
    let context = call.args.text(image::CONTEXT).unwrap_or_default();
    let colour = [image::COMPONENT_RGBA, image::COMPONENT_RGB, image::COMPONENT_ALPHA];
    let tiles = i32::from(!call.effect.suites.host_is("Resolve"));
    let clip = |name, components: &[&CStr]| {
        let clip = call.effect.define_clip(name);
        clip.set_names(image::SUPPORTED_COMPONENTS, components);
        clip.set_int(image::SUPPORTS_TILES, tiles);
        clip.set_int(image::TEMPORAL_CLIP_ACCESS, 0);
        clip
    };
    clip(image::SOURCE_CLIP, &colour);
    if context.as_bytes() == image::CONTEXT_GENERAL.to_bytes() && call.kind == Kind::PinWarp {
        let mask = clip(MASK_CLIP, &[image::COMPONENT_ALPHA]);
        mask.set_int(image::CLIP_IS_MASK, 1);
        mask.set_int(image::CLIP_OPTIONAL, 1);
        clip(BACKGROUND_CLIP, &colour).set_int(image::CLIP_OPTIONAL, 1);
    }
    clip(image::OUTPUT_CLIP, &colour);
    Ok(Status::OK)
}
