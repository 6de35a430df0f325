//! When two pictures count as the same: three limits, after OpenImageIO's test suite (`--fail`, `--failpercent`,
//! `--hardfail`): differences up to `small` are nothing, few pixels may differ by more, and the mean stays low.
//!
//! Rasters differ at edges (a pixel centre on an edge belongs to either side) and in how devices filter textures.

use pinwarp::image::Frame;

/// Limits of a channel's differences.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Differences up to this are nothing.
    pub(crate) small: f32,
    /// Share of the pixels that may differ by more.
    pub(crate) share: f32,
    /// Mean of the differences, each counted up to `cap`.
    pub(crate) mean: f32,
    /// The most that one pixel counts in the mean (background depth is 1e10).
    pub(crate) cap: f32,
}

/// Limits for a channel by its name, software drivers and graphics cards alike.
pub(crate) fn limits_of(channel: &str) -> Limits {
    let limits = |small, share, mean, cap| Limits { small, share, mean, cap };
    match channel {
        // Anisotropic filters are free in their taps; cut-outs turn that into whole texels.
        "R" | "G" | "B" => limits(0.02, 0.05, 0.006, 1.0),
        "A" => limits(0.004, 0.005, 0.003, 1.0),
        "depth.Z" => limits(0.002, 0.006, 0.006, 1.0),
        name if name.starts_with("id.") => limits(0.0, 0.006, 0.02, 4.0),
        name if name.starts_with("N.") => limits(0.02, 0.01, 0.004, 2.0),
        // Motion: pixels.
        _ => limits(0.01, 0.006, 0.06, 20.0),
    }
}

/// What is wrong with a channel; `None`: nothing.
fn fault(name: &str, (ours, theirs): (&[f32], &[f32]), limits: Limits) -> Option<String> {
    if ours.len() != theirs.len() {
        return Some(format!("{name}: {} samples, not {}", ours.len(), theirs.len()));
    }
    if ours.iter().chain(theirs).any(|sample| !sample.is_finite()) {
        return Some(format!("{name}: not finite"));
    }
    let differences: Vec<f32> = ours.iter().zip(theirs).map(|(a, b)| (a - b).abs()).collect();
    let count = differences.len() as f32;
    let share = differences.iter().filter(|&&difference| difference > limits.small).count() as f32 / count;
    let mean = differences.iter().map(|difference| difference.min(limits.cap)).sum::<f32>() / count;
    let is_wrong = share > limits.share || mean > limits.mean;
    is_wrong.then(|| format!("{name}: {share} of the pixels differ by more, mean {mean}; allowed: {limits:?}"))
}

/// Fails where two frames differ by more than the limits of their channels, times `slack`.
pub(crate) fn assert_alike(ours: &Frame, theirs: &Frame, slack: f32) {
    let names = |frame: &Frame| frame.channels.iter().map(|channel| channel.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(ours), names(theirs));
    assert_eq!((ours.display, ours.data_window), (theirs.display, theirs.data_window));
    let faults: Vec<String> = ours
        .channels
        .iter()
        .zip(&theirs.channels)
        .filter_map(|(a, b)| {
            assert_eq!(a.storage, b.storage, "{}", a.name);
            let limits = limits_of(&a.name);
            let limits = Limits { share: limits.share * slack, mean: limits.mean * slack, ..limits };
            fault(&a.name, (&a.samples, &b.samples), limits)
        })
        .collect();
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn each_limit_can_fail() {
    let limits = Limits { small: 0.01, share: 0.1, mean: 0.01, cap: 1.0 };
    let base = vec![0.5f32; 100];
    let changed = |count: usize, by: f32| {
        let mut changed = base.clone();
        changed[..count].iter_mut().for_each(|sample| *sample += by);
        fault("x", (&base, &changed), limits)
    };
    assert_eq!(changed(100, 0.005), None);
    assert_eq!(changed(9, 0.05), None);
    assert!(changed(11, 0.05).is_some(), "share");
    assert!(changed(2, 0.9).is_some(), "mean");
    assert!(changed(1, f32::NAN).is_some(), "not finite");
    assert!(fault("x", (&base, &base[1..]), limits).is_some(), "length");
}
