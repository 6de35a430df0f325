//! Invariants of every filter: bit-exactness, constants, integer shifts, sums, and containment of non-finite samples.

use super::*;
use crate::space::FrameSize;
use proptest::prelude::*;

const FILTERS: [Filter; 4] = [Filter::Ewa, Filter::Cubic, Filter::Lanczos, Filter::Nearest];
const WINDOW: PixelRect = PixelRect { x: 0, y: 0, width: 90, height: 70 };
const FRAME: FrameSize = FrameSize::new(90, 70);

/// A map of the whole frame.
fn map(offset: impl Fn(f32, f32) -> [f32; 2]) -> WarpMap {
    let mut map = WarpMap::identity(FRAME, WINDOW);
    for (index, to) in map.offsets.iter_mut().enumerate() {
        *to = offset((index % 90) as f32, (index / 90) as f32);
    }
    map
}

fn wave(x: f32, y: f32) -> [f32; 2] {
    [3.0 * (0.11 * y + 0.05 * x).sin(), 4.0 * (0.09 * x).cos()]
}

/// Pseudorandom values from -1 to 1.
fn noise(index: usize) -> f32 {
    ((index as f32 * 12.9898).sin() * 43_758.547).fract()
}

fn plane(window: PixelRect, value: impl Fn(usize) -> f32) -> Vec<f32> {
    (0..window.area()).map(value).collect()
}

fn one(map: &WarpMap, window: PixelRect, plane: &[f32], filter: Filter) -> Vec<f32> {
    resampled(map, &Planes { window, planes: vec![plane] }, filter).remove(0)
}

#[test]
fn pixels_that_do_not_move_keep_their_bits() {
    let odd = [f32::NAN, -0.0, f32::INFINITY, 3e38, f32::from_bits(0x7fc1_2345), 1e-42, -5.0];
    let source = plane(WINDOW, |k| odd[k % odd.len()]);
    let mut moved = map(|_, _| [0.0; 2]);
    // One pixel in a corner moves, so that the tile is filtered.
    moved.offsets[5] = [0.3, 0.7];
    for (map, filter) in [map(|_, _| [0.0; 2]), moved].iter().flat_map(|map| FILTERS.map(|filter| (map, filter))) {
        let found = one(map, WINDOW, &source, filter);
        let wrong = (0..found.len()).filter(|k| found[*k].to_bits() != source[*k].to_bits() && *k != 5).count();
        assert_eq!(wrong, 0, "{filter:?}");
    }
}

/// Tiles are 64 pixels wide: the last column of 65 has a tile of its own.
#[test]
fn a_still_column_beside_a_shrink_is_drawn() {
    let (frame, window) = (FrameSize::new(65, 40), PixelRect { x: 0, y: 0, width: 65, height: 40 });
    let mut map = WarpMap::identity(frame, window);
    map.offsets.iter_mut().enumerate().for_each(|(k, to)| to[0] = 0.5 * ((k % 65) as f32 - 64.0));
    for filter in FILTERS {
        let found = one(&map, window, &plane(window, |_| 1.0), filter);
        let last = (0..40).map(|row| found[row * 65 + 64]);
        assert!(last.into_iter().all(|x| (x - 1.0).abs() < 1e-6), "{filter:?}");
    }
}

#[test]
fn constants_stay_constant() {
    let source = plane(WINDOW, |_| 0.7);
    // Minifies by up to three, rotates, and nowhere leaves the frame by more than the repeated border.
    let swirl = map(|x, y| [0.6 * (45.0 - x) + 0.2 * (y - 35.0), -0.2 * (x - 45.0) + 0.5 * (35.0 - y)]);
    let squeeze = map(|x, y| [(0.3 * (x - 45.0)).clamp(-x, 89.0 - x), (2.0 * (y - 35.0)).clamp(-y, 69.0 - y)]);
    for (map, filter) in [swirl, squeeze, map(wave_inside)].iter().flat_map(|map| FILTERS.map(|filter| (map, filter))) {
        let worst = one(map, WINDOW, &source, filter).iter().fold(0.0_f32, |worst, x| worst.max((x - 0.7).abs()));
        assert!(worst < 1e-6, "{filter:?}: {worst:e}");
    }
}

/// The wave, clamped to the frame.
fn wave_inside(x: f32, y: f32) -> [f32; 2] {
    let [dx, dy] = wave(x, y);
    [dx.clamp(-x, 89.0 - x), dy.clamp(-y, 69.0 - y)]
}

#[test]
fn whole_shifts_are_exact_and_uncover_nothing_but_zeros() {
    let source = plane(WINDOW, noise);
    for filter in FILTERS {
        let found = one(&map(|_, _| [-7.0, 4.0]), WINDOW, &source, filter);
        for (index, value) in found.iter().enumerate() {
            let (x, y) = ((index % 90) as i32 - 7, index as i32 / 90 + 4);
            let wanted = if x >= 0 && y < 70 { source[(y * 90 + x) as usize] } else { 0.0 };
            assert_eq!(*value, wanted, "{filter:?} at {index}");
        }
    }
}

/// Samples outside the data window are zero: a cropped plate and the full one give the same result.
#[test]
fn cropping_zeros_changes_nothing() {
    let crop = PixelRect { x: 20, y: 11, width: 37, height: 29 };
    let cropped = plane(crop, noise);
    let mut whole = vec![0.0; WINDOW.area()];
    for (index, value) in cropped.iter().enumerate() {
        whole[(index / 37 + 11) * 90 + index % 37 + 20] = *value;
    }
    let squeeze = |x: f32, y: f32| [0.8 * (x - 45.0), wave(x, y)[1]];
    for (map, filter) in [map(wave), map(squeeze)].iter().flat_map(|map| FILTERS.map(|filter| (map, filter))) {
        let (a, b) = (one(map, WINDOW, &whole, filter), one(map, crop, &cropped, filter));
        let worst = a.iter().zip(&b).fold(0.0_f32, |worst, (a, b)| worst.max((a - b).abs()));
        assert!(worst < 1e-6, "{filter:?}: {worst:e}");
    }
}

#[test]
fn a_fault_stays_in_its_footprint() {
    let faulty = |value: f32| plane(WINDOW, |k| if k == 35 * 90 + 45 { value } else { 0.5 });
    let shifted = map(|_, _| [0.3, -0.4]);
    for filter in [Filter::Ewa, Filter::Cubic, Filter::Lanczos] {
        // Constants stay constant around a missing sample.
        let found = one(&shifted, WINDOW, &faulty(f32::NAN), filter);
        let inner = |k: usize| (5..85).contains(&(k % 90)) && (5..65).contains(&(k / 90));
        let wrong = (0..found.len()).filter(|k| inner(*k) && (found[*k] - 0.5).abs() > 1e-5).count();
        assert!(wrong <= 1, "{filter:?}: {wrong} pixels");
        let found = one(&shifted, WINDOW, &faulty(f32::NEG_INFINITY), filter);
        assert!(found.iter().all(|x| x.is_finite()), "{filter:?}");
        let touched = (0..found.len()).filter(|k| inner(*k) && (found[*k] - 0.5).abs() > 1e-5).count();
        assert!(touched <= 36, "{filter:?}: {touched} pixels");
    }
    let both = [f32::NAN, f32::INFINITY].map(faulty);
    let planes = Planes { window: WINDOW, planes: both.iter().map(Vec::as_slice).collect() };
    assert_eq!(planes.not_finite(), NotFinite { nan: 1, infinite: 1 });
}

#[test]
fn nothing_is_seen_where_the_map_says_so() {
    let source = plane(WINDOW, |_| 1.0);
    let hostile = [[f32::NAN, 0.0], [0.0, f32::INFINITY], [-1e30, 3.0], [1e9, -1e9]];
    let map = map(|x, y| hostile[(x as usize + y as usize) % 4]);
    for filter in FILTERS {
        assert!(one(&map, WINDOW, &source, filter).iter().all(|x| *x == 0.0), "{filter:?}");
    }
}

/// A plate that fills its display keeps its brightness where the warp moves along the border, and its cut is soft.
#[test]
fn held_borders_do_not_darken() {
    let source = plane(WINDOW, |_| 1.0);
    for filter in [Filter::Ewa, Filter::Cubic, Filter::Lanczos] {
        let along = one(&map(|x, _| [(0.4_f32).min(89.0 - x), 0.0]), WINDOW, &source, filter);
        assert!(along.iter().all(|x| (x - 1.0).abs() < 1e-6), "{filter:?}");
        let beyond = one(&map(|_, _| [0.25, 0.0]), WINDOW, &source, filter);
        assert!((beyond[89] - 0.75).abs() < 1e-6, "{filter:?}: {}", beyond[89]);
    }
}

/// Beside a border that rests, the centres of the last pixels move a little: that is no cut. Where one begins, nothing jumps.
#[test]
fn borders_that_rest_stay_opaque() {
    let source = plane(WINDOW, |_| 1.0);
    let corner = |by: f32, filter| {
        let at_the_end = move |at: f32, end: f32| if at >= end { by } else { 0.0 };
        one(&map(|x, y| [at_the_end(x, 89.0), at_the_end(y, 69.0)]), WINDOW, &source, filter)
    };
    assert!(corner(1.5e-3, Filter::Ewa).iter().all(|x| *x == 1.0), "an opaque plate stays opaque");
    for filter in [Filter::Ewa, Filter::Cubic, Filter::Lanczos] {
        let covered: Vec<f32> = (0..200).map(|k| corner(k as f32 * 1e-4, filter)[35 * 90 + 89]).collect();
        let worst = covered.windows(2).fold(0.0_f32, |worst, pair| worst.max((pair[1] - pair[0]).abs()));
        assert!(worst < 2.5e-4, "{filter:?}: {worst}");
        assert!((covered[199] - (1.0 - 0.0199)).abs() < 1e-5, "{filter:?}: {}", covered[199]);
    }
}

/// A border that rests stays opaque beside what is stretched away from it, whether the stretch grows or fades inwards. Where the border
/// itself moves inwards, what is magnified ends within a pixel of the result.
#[test]
fn borders_that_rest_beside_a_stretch_stay_opaque() {
    let source = plane(WINDOW, |_| 1.0);
    // The place in the plate of what lies at a distance from the border, in pixels from it.
    let fading = |t: f32| t - 14.0 * t / (t + 15.0);
    let growing = |t: f32| 0.1 * t + 1.6 * (1.0 - (-0.5 * t).exp());
    let linear = |t: f32| 0.1 * t;
    let stretches: [&dyn Fn(f32) -> f32; 3] = [&fading, &growing, &linear];
    for (stretch, filter) in
        stretches.iter().flat_map(|s| [Filter::Ewa, Filter::Cubic, Filter::Lanczos].map(|f| (s, f)))
    {
        let pulled = |at: f32, count: f32| {
            let inner = |t: f32| stretch(t).min(0.5 * count);
            if at < 0.5 * count { inner(at + 0.5) - (at + 0.5) } else { (count - at - 0.5) - inner(count - at - 0.5) }
        };
        let maps = [map(|x, _| [pulled(x, 90.0), 0.0]), map(|x, y| [pulled(x, 90.0), pulled(y, 70.0)])];
        for map in &maps {
            let least = one(map, WINDOW, &source, filter).into_iter().fold(1.0_f32, f32::min);
            assert!((least - 1.0).abs() < 1e-6, "{filter:?}: {least}");
        }
        let mut taps = Vec::new();
        footprint_taps(&maps[1], 0, WINDOW, &mut taps);
        assert!((taps.iter().map(|tap| tap.1).sum::<f32>() - 1.0).abs() < 1e-6, "{taps:?}");
        let slid = one(&map(|x, _| [0.25 * (x - 30.3) - x - 0.5, 0.0]), WINDOW, &source, filter);
        assert!(slid[29] == 0.0 && (slid[30] - 0.2).abs() < 1e-5 && slid[31] == 1.0, "{filter:?}: {:?}", &slid[28..33]);
    }
}

/// A plane wave above the Nyquist frequency of the output must vanish, not alias to a lower one.
#[test]
fn shrinking_does_not_alias() {
    let window = PixelRect { x: 0, y: 0, width: 400, height: 400 };
    let fine = plane(window, |k| ((k % 400) as f32 * 2.6).cos());
    let frame = FrameSize::new(400, 400);
    let inner = PixelRect { x: 30, y: 30, width: 60, height: 60 };
    let mut map = WarpMap::identity(frame, inner);
    for (index, to) in map.offsets.iter_mut().enumerate() {
        *to = [index % 60, index / 60].map(|k| 3.3 * (k as f32 + 30.5) - (k as f32 + 30.5));
    }
    let worst = |filter| one(&map, window, &fine, filter).iter().fold(0.0_f32, |worst, x| worst.max(x.abs()));
    assert!(worst(Filter::Ewa) < 0.02, "{}", worst(Filter::Ewa));
    assert!(worst(Filter::Cubic) > 0.5, "the test shows no aliasing");
}

/// A thin part that lies over another and ends on it, one pixel wide: what is beside it is no part of its footprint.
#[test]
fn a_footprint_does_not_reach_across_a_tear() {
    // In column 40 the source is 20 columns to the left and 8 rows above, everywhere else the pixel itself.
    let torn = map(|x, y| if x == 40.0 && (20.0..50.0).contains(&y) { [-20.0, -8.0] } else { [0.0, 0.0] });
    let lone = map(|x, y| if [x, y] == [40.0, 30.0] { [-20.0, -8.0] } else { [0.0, 0.0] });
    // Black but for a bright part beside the source.
    let source = plane(WINDOW, |k| if (k % 90).abs_diff(20) > 3 { 1.0 } else { 0.0 });
    for map in [torn, lone] {
        let drawn = one(&map, WINDOW, &source, Filter::Ewa);
        assert_eq!(drawn[30 * 90 + 40], 0.0);
        assert_eq!(footprint_of(&map, 40, 30), (true, true));
    }
    // What shrinks evenly keeps its wide footprint.
    let shrunk = map(|x, y| [3.0 * (x - 45.0), 3.0 * (y - 35.0)]);
    assert_eq!(footprint_of(&shrunk, 40, 30), (false, false));
}

/// Whether the footprint of a pixel is that of one that does not shrink, alone and among others.
fn footprint_of(map: &WarpMap, column: usize, row: usize) -> (bool, bool) {
    use super::footprint::Footprint;
    (Footprint::at(map, column, row).is_unit(), Footprint::of_inner(map, column, row)[0].is_unit())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// The Catmull-Rom weights of a position sum to 1 and their absolute values to at most 1.25 per axis, which bounds
    /// the ringing at a step.
    #[test]
    fn ringing_is_bounded(dx in -3.0_f32..3.0, dy in -3.0_f32..3.0, turn in -0.6_f32..0.6, grow in 0.4_f32..3.0) {
        let source = plane(WINDOW, |k| noise(k).signum());
        let (sin, cos) = turn.sin_cos();
        let turned = map(|x, y| {
            let (u, v) = (x - 45.0, y - 35.0);
            [grow * (cos * u - sin * v) - u + dx, grow * (sin * u + cos * v) - v + dy]
        });
        for (filter, bound) in [(Filter::Ewa, 1.9), (Filter::Cubic, 1.5626), (Filter::Lanczos, 2.1), (Filter::Nearest, 1.0)] {
            let worst = one(&turned, WINDOW, &source, filter).iter().fold(0.0_f32, |worst, x| worst.max(x.abs()));
            prop_assert!(worst <= bound, "{:?}: {}", filter, worst);
        }
    }

    /// Weights of a footprint are non-negative and sum to 1 inside the picture.
    #[test]
    fn footprints_are_shares(a in -2.0_f32..2.0, b in -2.0_f32..2.0, c in -2.0_f32..2.0, d in -2.0_f32..2.0) {
        let bent = map(|x, y| [a * (x - 45.0) + b * (y - 35.0) + 0.3, c * (x - 45.0) + d * (y - 35.0) - 0.2]);
        let mut taps = Vec::new();
        footprint_taps(&bent, 35 * 90 + 45, WINDOW, &mut taps);
        let sum: f32 = taps.iter().map(|tap| tap.1).sum();
        prop_assert!((sum - 1.0).abs() < 1e-5, "{}", sum);
        prop_assert!(taps.iter().all(|tap| tap.1 > 0.0 && tap.0 < WINDOW.area()));
    }
}

#[test]
fn a_footprint_that_does_not_move_is_its_pixel() {
    let mut taps = vec![(3, 0.5)];
    footprint_taps(&map(|_, _| [0.0; 2]), 4321, WINDOW, &mut taps);
    assert_eq!(taps, [(4321, 1.0)]);
    footprint_taps(&map(|_, _| [0.5, 0.0]), 4321, WINDOW, &mut taps);
    assert_eq!(taps, [(4321, 0.5), (4322, 0.5)]);
    footprint_taps(&map(|_, _| [f32::NAN; 2]), 4321, WINDOW, &mut taps);
    assert!(taps.is_empty());
}

#[test]
fn threads_change_no_bit() {
    let source: Vec<Vec<f32>> = (0..5).map(|p| plane(WINDOW, |k| noise(k + 977 * p))).collect();
    let planes = Planes { window: WINDOW, planes: source.iter().map(Vec::as_slice).collect() };
    let bent = map(|x, y| [wave(x, y)[0] + 0.7 * (x - 45.0), wave(x, y)[1]]);
    for filter in FILTERS {
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| resampled(&bent, &planes, filter))
        };
        assert_eq!(with(1), with(3), "{filter:?}");
    }
}
