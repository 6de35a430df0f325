//! Describes the plugins: their capabilities, clips and parameters.
//!
//! In: a descriptor. Out: its properties, set.

use super::api::names::{image, param, prop};
use super::api::{EntryPoint, Status};
use super::call::{Call, PluginKind};
use super::clips::{BACKGROUND_CLIP, MASK_CLIP, MATTE_CLIP};
use super::fault::Fault;
use super::host::Props;
use super::overlay;
use super::params::{Param, ParamKind, pages, precision, table};
use std::ffi::{CStr, c_void};

/// Properties of limits: of the value, then of its slider. Resolve shows a parameter only if all four are set.
const LIMITS: [&CStr; 4] = [param::MIN, param::MAX, param::DISPLAY_MIN, param::DISPLAY_MAX];

/// Limits of a position's coordinates.
const POINTS: [f64; 2] = [-1e6, 1e6];

/// Parameters that do not affect the rendered picture.
const WITHOUT_EFFECT: [&str; 8] =
    ["handles", "clickAdds", "overlay", "selected", "writePath", "stmapFolder", "stmapName", "stmapPath"];

/// Handles the describe action: contexts, bit depths and capabilities.
pub(super) fn describe(call: Call) -> Result<Status, Fault> {
    let props = call.effect.props();
    let (label, about) = match call.kind {
        PluginKind::PinWarp => (c"PinWarp", c"Warps the picture smoothly with pins and preserves local detail."),
        PluginKind::StMap => {
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
        PluginKind::PinWarp => &[image::DEPTH_FLOAT, image::DEPTH_HALF, image::DEPTH_SHORT, image::DEPTH_BYTE],
        PluginKind::StMap => &[image::DEPTH_FLOAT],
    };
    props.set_names(image::SUPPORTED_PIXEL_DEPTHS, depths);
    for (name, is_set) in [
        (image::SINGLE_INSTANCE, 0),
        (image::HOST_FRAME_THREADING, 0),
        (image::SUPPORTS_MULTI_RESOLUTION, 1),
        (image::SUPPORTS_TILES, takes_tiles(call)),
        (image::TEMPORAL_CLIP_ACCESS, 0),
        (image::FIELD_RENDER_TWICE_ALWAYS, 0),
        (image::SUPPORTS_MULTIPLE_CLIP_DEPTHS, 0),
        (image::SUPPORTS_MULTIPLE_CLIP_PARS, 0),
    ] {
        props.set_int(name, is_set);
    }
    props.set_texts(image::CLIP_PREFERENCES_SLAVE_PARAM, &["shape"]);
    let overlay = overlay::entry as EntryPoint as *mut c_void;
    props.set_pointer(image::OVERLAY_INTERACT_V1, overlay);
    if call.effect.suites.draw.is_some() {
        props.set_pointer(image::OVERLAY_INTERACT_V2, overlay);
    }
    Ok(Status::OK)
}

/// Returns whether tiles are supported: Resolve and Fusion request tiles and then treat them as whole frames.
fn takes_tiles(call: Call) -> i32 {
    i32::from(!["Resolve", "Fusion"].iter().any(|host| call.effect.suites.host_is(host)))
}

/// Handles the describe-in-context action: clips and parameters.
pub(super) fn describe_in_context(call: Call) -> Result<Status, Fault> {
    let context = call.args.text(image::CONTEXT).unwrap_or_default();
    let colour = [image::COMPONENT_RGBA, image::COMPONENT_RGB, image::COMPONENT_ALPHA];
    let tiles = takes_tiles(call);
    let clip = |name, components: &[&CStr]| {
        let clip = call.effect.define_clip(name);
        clip.set_names(image::SUPPORTED_COMPONENTS, components);
        clip.set_int(image::SUPPORTS_TILES, tiles);
        clip.set_int(image::TEMPORAL_CLIP_ACCESS, 0);
        clip
    };
    clip(image::SOURCE_CLIP, &colour);
    if context.as_bytes() == image::CONTEXT_GENERAL.to_bytes() && call.kind == PluginKind::PinWarp {
        for name in [MASK_CLIP, MATTE_CLIP] {
            let mask = clip(name, &[image::COMPONENT_ALPHA]);
            mask.set_int(image::CLIP_IS_MASK, 1);
            mask.set_int(image::CLIP_OPTIONAL, 1);
        }
        clip(BACKGROUND_CLIP, &colour).set_int(image::CLIP_OPTIONAL, 1);
    }
    clip(image::OUTPUT_CLIP, &colour);
    define_parameters(call)?;
    Ok(Status::OK)
}

/// Declares the parameters of the table, and pages for hosts that show pages.
fn define_parameters(call: Call) -> Result<(), Fault> {
    let params = call.effect.params()?;
    for entry in table() {
        let props = params.define(entry.kind.type_name(), &entry.id);
        props.set_texts(prop::LABEL, &[&entry.label]);
        props.set_texts(param::SCRIPT_NAME, &[&entry.id]);
        props.set_texts(param::HINT, &[entry.hint]);
        if WITHOUT_EFFECT.contains(&entry.id.as_str()) {
            props.set_int(param::EVALUATE_ON_CHANGE, 0);
        }
        if !entry.group.is_empty() {
            props.set_texts(param::PARENT, &[&entry.group]);
        }
        define_kind(call, props, entry);
    }
    let pages = pages();
    for (id, label, ids) in &pages {
        let page = params.define(param::TYPE_PAGE, id);
        page.set_texts(prop::LABEL, &[label]);
        page.set_texts(param::PAGE_CHILD, ids);
    }
    let order: Vec<&str> = pages.iter().map(|(id, ..)| id.as_str()).collect();
    params.props().set_texts(param::PAGE_ORDER, &order);
    Ok(())
}

/// Sets the properties specific to a kind of parameter: default, range and so on.
fn define_kind(call: Call, props: Props, entry: &Param) {
    let host = call.effect.suites.host();
    let can = |ability| i32::from(entry.animates && host.int(ability).unwrap_or(0) != 0);
    let mut animates = i32::from(entry.animates);
    // MLT, and so Kdenlive, treats the slider's range as that of the value.
    let has_soft_limits = !call.effect.suites.host_is("MLT");
    match &entry.kind {
        ParamKind::Group(is_open) => return props.set_ints(param::GROUP_OPEN, &[*is_open]),
        ParamKind::Button => return,
        ParamKind::Integer(default, range, shown) => {
            let shown = if has_soft_limits { shown } else { range };
            props.set_ints(param::DEFAULT, &[*default]);
            for (name, value) in LIMITS.into_iter().zip([range[0], range[1], shown[0], shown[1]]) {
                props.set_ints(name, &[value]);
            }
        }
        ParamKind::Double(default, range, shown, meaning) => {
            let shown = if has_soft_limits { shown } else { range };
            let (step, digits) = precision(meaning);
            props.set_doubles(param::INCREMENT, &[step]);
            props.set_int(param::DIGITS, digits);
            props.set_doubles(param::DEFAULT, &[*default]);
            for (name, value) in LIMITS.into_iter().zip([range[0], range[1], shown[0], shown[1]]) {
                props.set_doubles(name, &[value]);
            }
            props.set_names(param::DOUBLE_TYPE, &[meaning]);
        }
        ParamKind::Toggle(default) => {
            props.set_ints(param::DEFAULT, &[*default]);
            animates = can(param::HOST_BOOLEAN_ANIMATION);
        }
        ParamKind::Choice(options) => {
            props.set_texts(param::CHOICE_OPTION, options);
            props.set_ints(param::DEFAULT, &[0]);
        }
        ParamKind::Point => {
            props.set_names(param::DOUBLE_TYPE, &[param::DOUBLE_XY_ABSOLUTE]);
            props.set_names(param::DEFAULT_COORDINATES, &[param::COORDINATES_CANONICAL]);
            props.set_doubles(param::DEFAULT, &[0.0, 0.0]);
            // Pins may lie outside the frame.
            let shown = if has_soft_limits { [-4096.0, 8192.0] } else { POINTS };
            for (name, value) in LIMITS.into_iter().zip([POINTS[0], POINTS[1], shown[0], shown[1]]) {
                props.set_doubles(name, &[value, value]);
            }
            props.set_doubles(param::INCREMENT, &[1.0, 1.0]);
            props.set_int(param::DIGITS, 2);
            let has_overlays = host.int(image::SUPPORTS_OVERLAYS).unwrap_or(0) != 0;
            props.set_ints(param::USE_HOST_OVERLAY_HANDLE, &[i32::from(!has_overlays)]);
        }
        ParamKind::Text(mode) => {
            props.set_names(param::STRING_MODE, &[mode]);
            props.set_ints(param::STRING_FILE_PATH_EXISTS, &[0]);
            props.set_texts(param::DEFAULT, &[""]);
        }
    }
    props.set_ints(param::ANIMATES, &[animates]);
}
