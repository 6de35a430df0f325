//! Planes resampled on the device and on the CPU: the same picture within rounding, the same bits where nothing moves.

use crate::internal::skip::skip;
use pinwarp::image::{Frame, Plate, Storage};
use pinwarp::plate::{Filter, Planes, WarpMap, WarpSettings, Warper, remap_plate, resampled};
use pinwarp::raster::vulkan::{Messages, VulkanRemap};
use pinwarp::raster::{DeviceChoice, RasterError};
use pinwarp::space::{FrameSize, PixelRect};

const FILTERS: [Filter; 4] = [Filter::Ewa, Filter::Cubic, Filter::Lanczos, Filter::Nearest];
const FRAME: FrameSize = FrameSize::new(97, 65);

/// Runs `work` with a device, validation on; fails on any message. Skips, and says so, where there is no device.
fn with_device(work: impl FnOnce(VulkanRemap)) {
    let messages = Messages::default();
    match VulkanRemap::open_validated(&DeviceChoice::Vulkan, &messages) {
        Ok(remap) => work(remap),
        Err(error) => {
            let is_required = std::env::var_os("PINWARP_REQUIRE_VULKAN").is_some_and(|value| value == "1");
            assert!(!is_required, "PINWARP_REQUIRE_VULKAN is set, but {error}");
            skip(&error.to_string());
        }
    }
    assert_eq!(messages.take(), Vec::<String>::new());
}

/// Values that mean nothing, from -1 to 1.
fn noise(index: usize) -> f32 {
    ((index as f32 * 12.9898).sin() * 43_758.547).fract()
}

fn rect(x: i32, y: i32, width: u32, height: u32) -> PixelRect {
    PixelRect { x, y, width, height }
}

/// A map of a window, from functions of pixels counted from the window's corner.
fn map(window: PixelRect, offset: impl Fn(f32, f32) -> [f32; 2]) -> WarpMap {
    let mut map = WarpMap::identity(FRAME, window);
    for (index, to) in map.offsets.iter_mut().enumerate() {
        *to = offset((index % window.width as usize) as f32, (index / window.width as usize) as f32);
    }
    map
}

/// A smooth map that turns, shrinks by up to eight, grows, leaves the picture and holds still in places.
fn random_map(seed: usize, window: PixelRect) -> WarpMap {
    let r = |k: usize| noise(17 * seed + k + 1);
    let matrix = [1.5 * r(0), r(1), r(2), 1.5 * r(3)].map(|x| x * (1 << (seed % 4)) as f32 * 0.6);
    let center = [window.width as f32 * (0.5 + 0.4 * r(4)), window.height as f32 * (0.5 + 0.4 * r(5))];
    map(window, |x, y| {
        let (u, v) = (x - center[0], y - center[1]);
        if u.hypot(v) < 9.0 {
            return [0.0; 2];
        }
        let wave = [5.0 * (0.1 * v + r(6)).sin(), 4.0 * (0.13 * u + r(7)).cos()];
        [wave[0] + matrix[0] * u + matrix[1] * v, wave[1] + matrix[2] * u + matrix[3] * v]
    })
}

/// How much two results differ.
#[derive(Clone, Copy, Debug, Default)]
struct Difference {
    /// Share of samples that differ by more than rounding.
    share: f32,
    worst: f32,
}

/// Rounding: a hundred-thousandth of what the source holds.
const ROUNDING: f32 = 1e-5;

fn difference(found: &[Vec<f32>], wanted: &[Vec<f32>]) -> Difference {
    assert_eq!(found.len(), wanted.len());
    let pairs: Vec<f32> = found.iter().flatten().zip(wanted.iter().flatten()).map(|(a, b)| (a - b).abs()).collect();
    assert_eq!(pairs.len(), wanted.iter().map(Vec::len).sum::<usize>());
    let many = pairs.iter().filter(|x| x.is_nan() || **x > ROUNDING).count();
    Difference {
        share: many as f32 / pairs.len().max(1) as f32,
        worst: pairs.iter().fold(0.0, |worst, x| if *x > worst || x.is_nan() { *x } else { worst }),
    }
}

/// Whether rounding explains a difference. A footprint's range steps where a sample crosses its inner square's edge, so
/// rounding may let a few samples of [`Filter::Ewa`] through or hold them back.
fn is_rounding(filter: Filter, found: Difference) -> bool {
    match filter {
        Filter::Nearest => found.worst == 0.0,
        Filter::Ewa => found.share < 1e-3,
        Filter::Cubic | Filter::Lanczos => found.share == 0.0,
    }
}

fn planes(window: PixelRect, count: usize) -> Vec<Vec<f32>> {
    (0..count).map(|p| (0..window.area()).map(|k| noise(k + 7919 * p)).collect()).collect()
}

fn view(window: PixelRect, planes: &[Vec<f32>]) -> Planes<'_> {
    Planes { window, planes: planes.iter().map(Vec::as_slice).collect() }
}

fn bits(planes: &[Vec<f32>]) -> Vec<Vec<u32>> {
    planes.iter().map(|plane| plane.iter().map(|sample| sample.to_bits()).collect()).collect()
}

#[test]
fn device_and_cpu_agree() {
    // The whole frame, a crop (its sides are edges of the picture), overscan, and windows that share little or nothing.
    let sources = [FRAME.window(), rect(20, 10, 40, 30), rect(-9, -5, 120, 80), rect(60, 40, 80, 90)];
    let windows = [FRAME.window(), rect(-11, 7, 130, 33), rect(50, -20, 33, 65)];
    with_device(|mut remap| {
        for seed in 0..12 {
            let (from, to) = (sources[seed % 4], windows[seed % 3]);
            let (map, source) = (random_map(seed, to), planes(from, 1 + seed % 5));
            for filter in FILTERS {
                let found = remap.resample(&map, &view(from, &source), filter).expect("memory");
                let wanted = resampled(&map, &view(from, &source), filter);
                let difference = difference(&found, &wanted);
                assert!(is_rounding(filter, difference), "seed {seed}, {filter:?}: {difference:?}");
            }
        }
    });
}

#[test]
fn a_wrong_filter_is_found() {
    with_device(|mut remap| {
        let source = planes(FRAME.window(), 1);
        let map = random_map(4, FRAME.window());
        for (filter, other) in FILTERS.into_iter().zip([Filter::Cubic, Filter::Lanczos, Filter::Nearest, Filter::Ewa]) {
            let found = remap.resample(&map, &view(FRAME.window(), &source), filter).expect("memory");
            let wanted = resampled(&map, &view(FRAME.window(), &source), other);
            assert!(!is_rounding(other, difference(&found, &wanted)), "{filter:?} passes for {other:?}");
        }
    });
}

#[test]
fn pixels_that_do_not_move_keep_their_bits() {
    let odd = [f32::NAN, -0.0, f32::INFINITY, 3e38, f32::from_bits(0x7fc1_2345), 1e-42, -5.0];
    let source: Vec<Vec<f32>> =
        (0..5).map(|p| (0..FRAME.window().area()).map(|k| odd[(k + p) % odd.len()]).collect()).collect();
    let still = WarpMap::identity(FRAME, FRAME.window());
    let far = map(FRAME.window(), |x, y| [(x * 7.0).rem_euclid(31.0) - 15.0, (y * 5.0).rem_euclid(13.0) - 6.0]);
    with_device(|mut remap| {
        for filter in FILTERS {
            let found = remap.resample(&still, &view(FRAME.window(), &source), filter).expect("memory");
            assert_eq!(bits(&found), bits(&source), "{filter:?}");
        }
        let found = remap.resample(&far, &view(FRAME.window(), &source), Filter::Nearest).expect("memory");
        let wanted = resampled(&far, &view(FRAME.window(), &source), Filter::Nearest);
        assert_eq!(bits(&found), bits(&wanted));
    });
}

/// Samples that are no numbers stay where they are, and nothing is seen where the map says so, as on the CPU.
#[test]
fn faults_stay_in_their_place() {
    let mut source = planes(FRAME.window(), 3);
    for (plane, fault) in source.iter_mut().zip([f32::NAN, f32::INFINITY, f32::NEG_INFINITY]) {
        (0..60).for_each(|k| plane[(k * 1013 + k * k) % FRAME.window().area()] = fault);
    }
    source[0][30 * 97..30 * 97 + 700].fill(f32::NAN);
    let hostile = [[f32::NAN, 0.0], [0.0, f32::INFINITY], [-1e30, 3.0], [1e9, -1e9]];
    with_device(|mut remap| {
        for (seed, filter) in (0..4).flat_map(|seed| FILTERS.map(|filter| (seed, filter))) {
            let mut map = random_map(seed, FRAME.window());
            (0..80).for_each(|k| map.offsets[k * 79] = hostile[k % 4]);
            let found = remap.resample(&map, &view(FRAME.window(), &source), filter).expect("memory");
            let wanted = resampled(&map, &view(FRAME.window(), &source), filter);
            if filter == Filter::Nearest {
                assert_eq!(bits(&found), bits(&wanted));
                continue;
            }
            // Copies of what does not move keep what is no number; infinities count as 65504.
            let scaled = |planes: &[Vec<f32>]| -> Vec<Vec<f32>> {
                let contain = |x: &f32, scale| if x.is_finite() { x / scale } else { 2.0 };
                let scales = [1.0, 65504.0, 65504.0];
                planes
                    .iter()
                    .zip(scales)
                    .map(|(plane, scale)| plane.iter().map(|x| contain(x, scale)).collect())
                    .collect()
            };
            let difference = difference(&scaled(&found), &scaled(&wanted));
            assert!(is_rounding(Filter::Ewa, difference), "seed {seed}, {filter:?}: {difference:?}");
        }
    });
}

/// What does not fit into a device's buffers is drawn in tiles, and no seam shows.
#[test]
fn tiles_change_no_bit() {
    with_device(|mut remap| {
        let source = planes(FRAME.window(), 5);
        for filter in FILTERS {
            let map = random_map(2, rect(30, 20, 41, 23));
            let whole = remap.resample(&map, &view(FRAME.window(), &source), filter).expect("memory");
            for bytes in [60_000, 9_000, 16] {
                remap.limit_buffers(bytes);
                let tiled = remap.resample(&map, &view(FRAME.window(), &source), filter).expect("memory");
                assert_eq!(bits(&tiled), bits(&whole), "{filter:?}, {bytes} bytes");
            }
            remap.limit_buffers(u64::MAX);
        }
    });
}

#[test]
fn empty_and_invalid_inputs_are_reported() {
    with_device(|mut remap| {
        let window = FRAME.window();
        let empty = rect(0, 0, 0, 7);
        let map = random_map(1, window);
        let found = remap.resample(&map, &view(empty, &[Vec::new()]), Filter::Ewa).expect("nothing to draw");
        assert_eq!(found, [vec![0.0; window.area()]]);
        let nothing = WarpMap::identity(FRAME, empty);
        let found = remap.resample(&nothing, &view(window, &planes(window, 1)), Filter::Ewa).expect("nothing to draw");
        assert_eq!(found, [Vec::<f32>::new()]);
        let wrong = remap.resample(&map, &view(window, &[vec![0.0; 3]]), Filter::Cubic);
        assert!(matches!(wrong, Err(RasterError::Misuse(_))), "{wrong:?}");
    });
    assert!(matches!(
        VulkanRemap::open(&DeviceChoice::Cpu).map(drop),
        Err(RasterError::Misuse(_) | RasterError::NoDevice { .. })
    ));
}

/// A plate warped on a device is the plate warped on the CPU, within rounding, and no plane is forgotten.
#[test]
fn plates_are_warped_on_the_device() {
    let names =
        ["R", "G", "B", "A", "specular.R", "specular.G", "specular.B", "depth.Z"].map(|name| (name, Storage::Float));
    let mut frame = Frame::blank(FRAME.window(), FRAME.window(), &names);
    for (p, channel) in frame.channels.iter_mut().enumerate() {
        channel.samples.iter_mut().enumerate().for_each(|(k, sample)| *sample = noise(k + 7919 * p));
    }
    let plate = Plate::from_frame(frame);
    let map = random_map(3, FRAME.window());
    with_device(|device| check_plate(&Warper::on(Box::new(device)), &plate, &map));
}

fn check_plate(warper: &Warper, plate: &Plate, map: &WarpMap) {
    for settings in FILTERS.map(|filter| WarpSettings { filter, ..WarpSettings::default() }) {
        let (wanted, _) = remap_plate(plate, map, &settings).expect("the map is of this frame");
        let samples = |plate: &Plate| -> Vec<Vec<f32>> {
            plate.parts[0].channels.iter().map(|channel| channel.samples.clone()).collect()
        };
        let (found, report) = warper.remap(plate, map, &settings).expect("the map is of this frame");
        assert!(warper.device().is_some() && report.warnings.is_empty(), "{:?}", report.warnings);
        let difference = difference(&samples(&found), &samples(&wanted));
        assert!(is_rounding(settings.filter, difference), "{:?}: {difference:?}", settings.filter);
    }
}
