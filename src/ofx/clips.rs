//! The optional clips of the plugins, in addition to Source and Output.
//!
//! In: an action. Out: optional clips that are connected.

use super::api::names::image;
use super::call::{Call, PluginKind};
use super::host::Clip;
use std::ffi::CStr;

/// The mask of what is warped; nothing is where it is black.
pub(super) const MASK_CLIP: &CStr = c"Mask";
/// The matte of where the warped picture is visible; where it is black, the source shows.
pub(super) const MATTE_CLIP: &CStr = c"Matte";
/// The picture that shows where the source was moved away.
pub(super) const BACKGROUND_CLIP: &CStr = c"Background";

/// Returns an optional clip if it is connected.
pub(super) fn connected<'a>(call: Call<'a>, name: &'static CStr) -> Option<Clip<'a>> {
    let is_there = call.kind == PluginKind::PinWarp;
    let clip = is_there.then(|| call.effect.clip(name)).flatten()?;
    (clip.props().int(image::CLIP_CONNECTED) == Some(1)).then_some(clip)
}
