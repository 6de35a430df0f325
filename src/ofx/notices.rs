//! Warnings about a frame, in the host's pixels and pin numbers.
//!
//! In: a warp, its settings, the frame it is measured in. Out: a warning, if any.

use super::host::FrameWarning;
use super::host_frame::HostFrame;
use super::params::pin_id;
use super::settings::Settings;
use super::values::ParamValues;
use crate::live::{Warp, Wording};
use crate::spelling::escaped;

/// Returns the combined warning about the frame at the time of `values`.
pub(super) fn warning(
    values: ParamValues,
    settings: &Settings,
    host_frame: &HostFrame,
    warp: &Warp,
) -> Option<FrameWarning> {
    let name = |pin: usize| {
        let number = settings.pins.get(pin).copied().unwrap_or(pin);
        let name = values.text(&pin_id(number, "Name"));
        name.map_or_else(|| (number + 1).to_string(), |name| format!("{} '{name}'", number + 1))
    };
    let place = |at| {
        let [x, y] = host_frame.canonical(at);
        format!("{x:.0}, {y:.0} px")
    };
    let notices = warp.notices(&Wording { pin: &name, place: &place, pixels: host_frame.canonical_height() });
    if notices.is_empty() {
        return None;
    }
    let [subjects, texts]: [Vec<String>; 2] = [
        notices.iter().map(|notice| notice.subject.clone()).collect(),
        notices.into_iter().map(|notice| notice.text).collect(),
    ];
    let text = escaped(&format!("Frame {}: {}", values.time, texts.join("; "))).into_owned();
    Some(FrameWarning { time: values.time, subject: subjects.join("; "), text })
}
