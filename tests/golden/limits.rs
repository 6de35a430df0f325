//! How much a picture may differ from the stored one: a row a backend and kind of channel.
//!
//! The stored pictures come from the CPU raster, so there only the rounding of another processor is left. Drivers round
//! edges and textures their own way; at this size every edge pixel counts.

use crate::compare::{Limits, compare};
use pinwarp::image::Frame;
use std::collections::BTreeSet;

/// What drew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Backend {
    Cpu,
    Vulkan,
}

/// Kinds of channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Color,
    Alpha,
    Depth,
    Id,
    Other,
}

impl Kind {
    fn of(channel: &str) -> Self {
        match channel {
            "R" | "G" | "B" => Self::Color,
            "A" => Self::Alpha,
            "depth.Z" => Self::Depth,
            name if name.starts_with("id.") => Self::Id,
            _ => Self::Other,
        }
    }
}

/// (backend, kind, limits): fail, fail per cent, hard, mean.
const TABLE: [(Backend, Kind, Limits); 10] = [
    (Backend::Cpu, Kind::Color, limits(0.002, 0.2, 0.2, 1e-4)),
    (Backend::Cpu, Kind::Alpha, limits(0.002, 0.2, 0.2, 1e-4)),
    // 1/Z: an edge may fall to its other side.
    (Backend::Cpu, Kind::Depth, limits(1e-5, 0.2, 2.0, 1e-4)),
    (Backend::Cpu, Kind::Id, limits(0.0, 0.2, 9.0, 0.01)),
    (Backend::Cpu, Kind::Other, limits(1e-3, 0.2, 40.0, 1e-3)),
    (Backend::Vulkan, Kind::Color, limits(0.02, 5.0, 20.0, 0.006)),
    (Backend::Vulkan, Kind::Alpha, limits(0.01, 1.0, 1.0, 0.003)),
    // Data are one sample at the pixel centre, and edges lie on one grid: only where surfaces cross, rounding decides.
    (Backend::Vulkan, Kind::Depth, limits(1e-4, 0.3, 2.0, 5e-4)),
    (Backend::Vulkan, Kind::Id, limits(0.0, 0.3, 9.0, 0.02)),
    (Backend::Vulkan, Kind::Other, limits(0.01, 0.3, 40.0, 0.005)),
];

const fn limits(fail: f32, fail_percent: f64, hard: f32, mean: f64) -> Limits {
    Limits { fail, fail_percent, hard, mean }
}

/// What is beyond its limits, channel by channel.
pub(crate) fn faults(drawn: &Frame, expected: &Frame, backend: Backend) -> Vec<String> {
    // Files hold channels by name, frames in any order.
    let heads = |frame: &Frame| frame.channels.iter().map(|one| one.name.clone()).collect::<BTreeSet<_>>();
    if heads(drawn) != heads(expected) || drawn.display != expected.display {
        return vec![format!("channels {:?} instead of {:?}, or another window", heads(drawn), heads(expected))];
    }
    let (drawn, expected) = (with_inverse_depth(drawn), with_inverse_depth(expected));
    let fault = |name: &String| {
        let row = TABLE.iter().find(|row| row.0 == backend && row.1 == Kind::of(name)).expect("a row a kind");
        compare(&drawn, &expected, &[name], &row.2).err()
    };
    heads(&drawn).iter().filter_map(fault).collect()
}

fn with_inverse_depth(frame: &Frame) -> Frame {
    let mut frame = frame.clone();
    let depth = frame.channels.iter_mut().filter(|channel| channel.name == "depth.Z");
    depth.flat_map(|channel| &mut channel.samples).for_each(|sample| *sample = 1.0 / *sample);
    frame
}
