//! The image rule: two pictures agree where few pixels differ by much, none by too much, and little on the whole.
//!
//! In: two frames, channel names, [`Limits`]. Out: what differs, or a message that says which limit is broken where.
//! Three limits as OpenImageIO's `idiff` has them (fail, failpercent, hardfail), and the mean.

use pinwarp::image::Frame;

/// How much two pictures may differ; all in units of the channel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// A sample that differs by more than this counts as failed.
    pub(crate) fail: f32,
    /// This many samples a hundred may fail.
    pub(crate) fail_percent: f64,
    /// No sample may differ by more than this.
    pub(crate) hard: f32,
    /// Nor may all on the mean.
    pub(crate) mean: f64,
}

/// How much two pictures differ.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Difference {
    /// Mean over all samples.
    pub(crate) mean: f64,
    /// Failed samples a hundred.
    pub(crate) failed_percent: f64,
    /// Largest, and the channel and index where it stands.
    pub(crate) worst: (f32, usize, usize),
}

/// Compares the named channels of two frames. Two samples that are not numbers agree; one alone differs without end.
pub(crate) fn compare(actual: &Frame, expected: &Frame, names: &[&str], limits: &Limits) -> Result<Difference, String> {
    if actual.data_window != expected.data_window {
        return Err(format!("data windows differ: {:?} and {:?}", actual.data_window, expected.data_window));
    }
    let mut found = Difference::default();
    let (mut sum, mut failed, mut count) = (0.0, 0usize, 0usize);
    for (number, name) in names.iter().enumerate() {
        let samples = |frame: &Frame| frame.channel(name).map(|channel| channel.samples.clone());
        let (Some(actual), Some(expected)) = (samples(actual), samples(expected)) else {
            return Err(format!("channel {name} is not in both"));
        };
        for (index, (a, b)) in actual.iter().zip(&expected).enumerate() {
            let apart = apart(*a, *b);
            sum += f64::from(apart);
            failed += usize::from(apart > limits.fail);
            count += 1;
            if apart > found.worst.0 {
                found.worst = (apart, number, index);
            }
        }
    }
    found.mean = sum / count.max(1) as f64;
    found.failed_percent = 100.0 * failed as f64 / count.max(1) as f64;
    judge(&found, limits).map_err(|rule| {
        let width = actual.data_window.width as usize;
        let (worst, channel, index) = found.worst;
        let place = (index % width, index / width);
        format!("{rule}: {found:?}; worst {worst} in {} at {place:?} of the data window", names[channel])
    })?;
    Ok(found)
}

fn apart(a: f32, b: f32) -> f32 {
    match (a.is_nan(), b.is_nan()) {
        (true, true) => 0.0,
        (false, false) if a == b => 0.0,
        (false, false) => (a - b).abs(),
        _ => f32::INFINITY,
    }
}

fn judge(found: &Difference, limits: &Limits) -> Result<(), &'static str> {
    if found.worst.0 > limits.hard {
        return Err("a sample is beyond the hard limit");
    }
    if found.failed_percent > limits.fail_percent {
        return Err("too many samples failed");
    }
    if found.mean > limits.mean {
        return Err("the mean difference is too large");
    }
    Ok(())
}

mod must_fail {
    use super::{Limits, compare};
    use pinwarp::image::{Channel, Frame, Storage};
    use pinwarp::space::PixelRect;

    const LIMITS: Limits = Limits { fail: 0.01, fail_percent: 1.0, hard: 0.5, mean: 0.002 };

    /// 20 x 10 pixels of 0.25 with the first `count` raised by `by`.
    fn picture(count: usize, by: f32) -> Frame {
        let window = PixelRect { x: 0, y: 0, width: 20, height: 10 };
        let mut samples = vec![0.25; window.area()];
        samples[..count].iter_mut().for_each(|sample| *sample += by);
        let channels = vec![Channel { name: "R".into(), storage: Storage::Half, samples }];
        Frame { display: window, data_window: window, pixel_aspect: 1.0, channels }
    }

    fn verdict(count: usize, by: f32) -> String {
        compare(&picture(count, by), &picture(0, 0.0), &["R"], &LIMITS).err().unwrap_or_default()
    }

    #[test]
    fn equal_and_nearly_equal_pictures_pass() {
        assert_eq!(verdict(0, 0.0), "");
        assert_eq!(verdict(2, 0.1), "");
        assert_eq!(verdict(200, 0.001), "");
    }

    #[test]
    fn each_limit_fails_on_its_own() {
        assert!(verdict(1, 0.6).starts_with("a sample is beyond the hard limit"), "{}", verdict(1, 0.6));
        assert!(verdict(3, 0.02).starts_with("too many samples failed"), "{}", verdict(3, 0.02));
        assert!(verdict(200, 0.005).starts_with("the mean difference"), "{}", verdict(200, 0.005));
    }

    #[test]
    fn numbers_and_shapes_that_do_not_fit_fail() {
        assert!(verdict(1, f32::NAN).starts_with("a sample is beyond"));
        assert!(compare(&picture(0, 0.0), &picture(0, 0.0), &["G"], &LIMITS).is_err());
        let mut moved = picture(0, 0.0);
        moved.data_window.x = 1;
        assert!(compare(&moved, &picture(0, 0.0), &["R"], &LIMITS).is_err());
    }

    #[test]
    fn a_moved_edge_fails() {
        let (mut a, mut b) = (picture(0, 0.0), picture(0, 0.0));
        for row in 0..10 {
            (0..10).for_each(|x| a.channels[0].samples[row * 20 + x] = 1.0);
            (0..11).for_each(|x| b.channels[0].samples[row * 20 + x] = 1.0);
        }
        assert!(compare(&a, &b, &["R"], &LIMITS).is_err());
    }
}
