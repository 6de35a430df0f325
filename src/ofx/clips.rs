//! The clips of the plugins beside Source and Output.
//!
//! In: an action. Out: optional clips that are connected.

use super::api::names::image;
use super::call::{Call, PluginKind};
use super::host::Clip;
use std::ffi::CStr;

/// What is moved; where it is black, nothing is.
pub(super) const MASK_CLIP: &CStr = c"Mask";
/// Where the warped picture is seen; where it is black, the source is.
pub(super) const MATTE_CLIP: &CStr = c"Matte";
/// What is seen where something moved away.
pub(super) const BACKGROUND_CLIP: &CStr = c"Background";

/// An optional clip with a picture connected to it.
pub(super) fn connected<'a>(call: Call<'a>, name: &'static CStr) -> Option<Clip<'a>> {
    let is_there = call.kind == PluginKind::PinWarp;
    let clip = is_there.then(|| call.effect.clip(name)).flatten()?;
    (clip.props().int(image::CLIP_CONNECTED) == Some(1)).then_some(clip)
}
