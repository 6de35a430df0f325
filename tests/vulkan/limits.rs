//! How much a Vulkan picture may differ from the CPU twin's, channel by channel.
//!
//! Rasters differ at edges (a pixel centre on an edge belongs to either side) and in how devices filter textures
//! (anisotropic filters are free in their taps; cut-outs turn that into whole texels). So few pixels may differ by all
//! there is, and the mean stays low. Depth is compared as 1/Z, in which nothing (1e10) is 0.

use super::compare::{Limits, compare};
use pinwarp::image::Frame;

/// Limits for a channel by its name: software drivers and graphics cards alike.
fn limits_of(channel: &str) -> Limits {
    let limits = |fail, fail_percent, hard, mean| Limits { fail, fail_percent, hard, mean };
    match channel {
        "R" | "G" | "B" => limits(0.02, 5.0, 20.0, 0.006),
        "A" => limits(0.004, 0.5, 1.0, 0.003),
        "depth.Z" => limits(0.0002, 0.6, 2.0, 0.002),
        name if name.starts_with("id.") => limits(0.0, 0.6, 9.0, 0.02),
        name if name.starts_with("N.") => limits(0.02, 1.0, 2.0, 0.004),
        // Motion: pixels.
        _ => limits(0.01, 0.6, 100.0, 0.06),
    }
}

/// Fails where two frames differ by more than the limits of their channels; `slack` widens percentages and means.
pub(crate) fn assert_alike(ours: &Frame, theirs: &Frame, slack: f64) {
    let heads = |frame: &Frame| frame.channels.iter().map(|one| (one.name.clone(), one.storage)).collect::<Vec<_>>();
    assert_eq!(heads(ours), heads(theirs));
    assert_eq!((ours.display, ours.data_window), (theirs.display, theirs.data_window));
    let (ours, theirs) = (with_inverse_depth(ours), with_inverse_depth(theirs));
    let faults: Vec<String> = ours
        .channels
        .iter()
        .filter_map(|channel| {
            let limits = limits_of(&channel.name);
            let (fail_percent, mean) = (limits.fail_percent * slack, limits.mean * slack);
            compare(&ours, &theirs, &[&channel.name], &Limits { fail_percent, mean, ..limits }).err()
        })
        .collect();
    assert!(faults.is_empty(), "{faults:#?}");
}

fn with_inverse_depth(frame: &Frame) -> Frame {
    let mut frame = frame.clone();
    let depth = frame.channels.iter_mut().filter(|channel| channel.name == "depth.Z");
    depth.flat_map(|channel| &mut channel.samples).for_each(|sample| *sample = 1.0 / *sample);
    frame
}
