//! Which property belongs to what, and of which type and size: the tables of the API's reference, as far as plugins that
//! warp pictures have to do with them.
//!
//! In: what a set belongs to, and a name. Out: type and size, or nothing where the API knows no such property there.

use super::api::names::{image, interact, param, prop};
use std::ffi::CStr;

/// What a set of properties belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Owner {
    Host,
    Descriptor,
    Instance,
    ClipDescriptor,
    Clip,
    Image,
    Param,
    /// Arguments of an action.
    Arguments,
    /// Where an action's answers go.
    Answers,
    Interact,
}

/// Type of a property's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Type {
    Int,
    Double,
    Text,
    Pointer,
    /// That of the parameter.
    OfParam,
}

use Owner::{Answers, Arguments, Clip, ClipDescriptor, Descriptor, Host, Image, Instance, Interact, Param};
use Type::{Double, Int, OfParam, Pointer, Text};

/// Owners, name, type, number of values (0: any).
type Row = (&'static [Owner], &'static CStr, Type, usize);

const ROWS: &[Row] = &[
    (&[Host, Descriptor, Instance, ClipDescriptor, Clip, Image, Param], prop::TYPE, Text, 1),
    (&[Host, ClipDescriptor, Clip, Param, Arguments, Answers], prop::NAME, Text, 1),
    (&[Host, Descriptor, Instance, ClipDescriptor, Clip, Param], prop::LABEL, Text, 1),
    (&[Descriptor, Instance, ClipDescriptor, Clip, Param], prop::SHORT_LABEL, Text, 1),
    (&[Descriptor, Instance, ClipDescriptor, Clip, Param], prop::LONG_LABEL, Text, 1),
    (&[Host, Descriptor], prop::VERSION, Int, 0),
    (&[Host, Descriptor], prop::VERSION_LABEL, Text, 1),
    (&[Host], prop::API_VERSION, Int, 0),
    (&[Descriptor], prop::PLUGIN_DESCRIPTION, Text, 1),
    (&[Descriptor], prop::PLUGIN_FILE_PATH, Text, 1),
    (&[Instance, Interact], prop::INSTANCE_DATA, Pointer, 1),
    (&[Instance, Arguments], prop::IS_INTERACTIVE, Int, 1),
    (&[Arguments, Answers], prop::TIME, Double, 1),
    (&[Arguments], prop::CHANGE_REASON, Text, 1),
    (&[Arguments], prop::TYPE, Text, 1),
    (&[Interact, Arguments], prop::EFFECT_INSTANCE, Pointer, 1),
    (&[Arguments, Instance], image::CONTEXT, Text, 1),
    (&[Host, Descriptor], image::SUPPORTED_CONTEXTS, Text, 0),
    (&[Descriptor], image::GROUPING, Text, 1),
    (&[Descriptor], image::SINGLE_INSTANCE, Int, 1),
    (&[Descriptor], image::HOST_FRAME_THREADING, Int, 1),
    (&[Descriptor], image::RENDER_THREAD_SAFETY, Text, 1),
    (&[Host, Descriptor, Instance, ClipDescriptor, Clip], image::SUPPORTS_TILES, Int, 1),
    (&[Host, Descriptor], image::SUPPORTS_MULTI_RESOLUTION, Int, 1),
    (&[Host, Descriptor, ClipDescriptor, Clip], image::TEMPORAL_CLIP_ACCESS, Int, 1),
    (&[Host, Descriptor], image::SUPPORTS_MULTIPLE_CLIP_DEPTHS, Int, 1),
    (&[Host, Descriptor], image::SUPPORTS_MULTIPLE_CLIP_PARS, Int, 1),
    (&[Descriptor], image::FIELD_RENDER_TWICE_ALWAYS, Int, 1),
    (&[Host, Descriptor], image::SUPPORTED_PIXEL_DEPTHS, Text, 0),
    (&[Host, ClipDescriptor, Clip], image::SUPPORTED_COMPONENTS, Text, 0),
    (&[Descriptor], image::CLIP_PREFERENCES_SLAVE_PARAM, Text, 0),
    (&[Answers], image::FRAME_VARYING, Int, 1),
    (&[Host], image::SUPPORTS_OVERLAYS, Int, 1),
    (&[Descriptor], image::OVERLAY_INTERACT_V1, Pointer, 1),
    (&[Descriptor], image::OVERLAY_INTERACT_V2, Pointer, 1),
    (&[ClipDescriptor, Clip], image::CLIP_OPTIONAL, Int, 1),
    (&[ClipDescriptor, Clip], image::CLIP_IS_MASK, Int, 1),
    (&[Clip], image::CLIP_CONNECTED, Int, 1),
    (&[ClipDescriptor, Clip], image::CLIP_FIELD_EXTRACTION, Text, 1),
    (&[Clip], image::CLIP_FIELD_ORDER, Text, 1),
    (&[Clip, Image], image::PIXEL_DEPTH, Text, 1),
    (&[Clip, Image], image::COMPONENTS, Text, 1),
    (&[Clip, Image, Answers], image::PREMULTIPLICATION, Text, 1),
    (&[Clip, Image], image::PIXEL_ASPECT, Double, 1),
    (&[Clip, Instance, Answers], image::FRAME_RATE, Double, 1),
    (&[Clip, Arguments, Answers], image::FRAME_RANGE, Double, 2),
    (&[Image, Arguments], image::RENDER_SCALE, Double, 2),
    (&[Arguments], image::RENDER_WINDOW, Int, 4),
    (&[Arguments], image::FIELD_TO_RENDER, Text, 1),
    (&[Answers], image::REGION_OF_DEFINITION, Double, 4),
    (&[Arguments], image::REGION_OF_INTEREST, Double, 4),
    (&[Instance], image::PROJECT_SIZE, Double, 2),
    (&[Instance], image::PROJECT_OFFSET, Double, 2),
    (&[Instance], image::PROJECT_EXTENT, Double, 2),
    (&[Instance], image::PROJECT_PIXEL_ASPECT, Double, 1),
    (&[Instance], image::EFFECT_DURATION, Double, 1),
    (&[Image], image::DATA, Pointer, 1),
    (&[Image], image::BOUNDS, Int, 4),
    (&[Image], image::IMAGE_REGION_OF_DEFINITION, Int, 4),
    (&[Image], image::ROW_BYTES, Int, 1),
    (&[Image], image::FIELD, Text, 1),
    (&[Image], image::UNIQUE_IDENTIFIER, Text, 1),
    (&[Param], param::TYPE, Text, 1),
    (&[Param], param::DEFAULT, OfParam, 0),
    (&[Param], param::MIN, OfParam, 0),
    (&[Param], param::MAX, OfParam, 0),
    (&[Param], param::DISPLAY_MIN, OfParam, 0),
    (&[Param], param::DISPLAY_MAX, OfParam, 0),
    (&[Param], param::INCREMENT, Double, 0),
    (&[Param], param::DIGITS, Int, 1),
    (&[Param], param::ANIMATES, Int, 1),
    (&[Param], param::IS_ANIMATING, Int, 1),
    (&[Param], param::EVALUATE_ON_CHANGE, Int, 1),
    (&[Param], param::PLUGIN_MAY_WRITE, Int, 1),
    (&[Param], param::PERSISTENT, Int, 1),
    (&[Param], param::SECRET, Int, 1),
    (&[Param], param::ENABLED, Int, 1),
    (&[Param], param::HINT, Text, 1),
    (&[Param], param::SCRIPT_NAME, Text, 1),
    (&[Param], param::PARENT, Text, 1),
    (&[Param], param::GROUP_OPEN, Int, 1),
    (&[Param], param::PAGE_CHILD, Text, 0),
    (&[Param], param::CHOICE_OPTION, Text, 0),
    (&[Param], param::STRING_MODE, Text, 1),
    (&[Param], param::STRING_FILE_PATH_EXISTS, Int, 1),
    (&[Param], param::DOUBLE_TYPE, Text, 1),
    (&[Param], param::DEFAULT_COORDINATES, Text, 1),
    (&[Param], param::USE_HOST_OVERLAY_HANDLE, Int, 1),
    (&[Param], param::HAS_HOST_OVERLAY_HANDLE, Int, 1),
    (&[Host], param::HOST_CHOICE_ANIMATION, Int, 1),
    (&[Host], param::HOST_BOOLEAN_ANIMATION, Int, 1),
    (&[Host], param::HOST_STRING_ANIMATION, Int, 1),
    (&[Host], param::HOST_MAX_PARAMETERS, Int, 1),
    (&[Descriptor], param::PAGE_ORDER, Text, 0),
    (&[Interact], interact::SLAVE_TO_PARAM, Text, 0),
    (&[Interact, Arguments], interact::PIXEL_SCALE, Double, 2),
    (&[Interact, Arguments], interact::BACKGROUND_COLOUR, Double, 3),
    (&[Interact], interact::SUGGESTED_COLOUR, Double, 3),
    (&[Arguments], interact::PEN_POSITION, Double, 2),
    (&[Arguments], interact::PEN_PRESSURE, Double, 1),
    (&[Arguments], interact::DRAW_CONTEXT, Pointer, 1),
    (&[Arguments], interact::KEY_SYM, Int, 1),
    (&[Arguments], interact::KEY_STRING, Text, 1),
];

/// Names with the name of a clip at their end, in answers.
const OF_CLIPS: &[(&CStr, Type, usize)] = &[
    (image::CLIP_ROI_PREFIX, Double, 4),
    (image::CLIP_COMPONENTS_PREFIX, Text, 1),
    (image::CLIP_DEPTH_PREFIX, Text, 1),
    (image::CLIP_PAR_PREFIX, Double, 1),
    (c"OfxImageClipPropFrameRange_", Double, 0),
];

/// Type and size of a property.
pub(crate) fn spec(owner: Owner, name: &CStr) -> Option<(Type, usize)> {
    let row = ROWS.iter().find(|(owners, known, ..)| *known == name && owners.contains(&owner));
    let of_clip = || {
        let begins = |(prefix, ..): &&(&CStr, Type, usize)| name.to_bytes().starts_with(prefix.to_bytes());
        OF_CLIPS.iter().find(begins).filter(|_| owner == Answers).map(|(_, kind, size)| (*kind, *size))
    };
    row.map(|(_, _, kind, size)| (*kind, *size)).or_else(of_clip)
}

/// Type and size of a parameter's value.
pub(crate) fn of_param(kind: &str) -> (Type, usize) {
    match kind {
        kind if kind.as_bytes() == param::TYPE_DOUBLE.to_bytes() => (Double, 1),
        kind if kind.as_bytes() == param::TYPE_DOUBLE_2D.to_bytes() => (Double, 2),
        kind if kind.as_bytes() == param::TYPE_STRING.to_bytes() => (Text, 1),
        _ => (Int, 1),
    }
}
