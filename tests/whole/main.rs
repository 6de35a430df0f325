//! Whole pictures whose border rests: any pins are met, nothing tears, nothing folds.

mod cases;
mod measure;

use crate::internal::numbers::SplitMix;
use cases::{Case, FRAMES, scattered};
use measure::{Measures, measure};
use pinwarp::lattice::Basis;
use pinwarp::live::{Controls, Pin, ShapeSource, Warp, Wording, warp};
use pinwarp::plate::{Field, WarpMap};
use pinwarp::space::{FrameSize, ImagePoint, PixelRect, ScreenPoint};
use std::sync::Arc;

/// Pixels within which a pin is met.
const MET: f64 = 0.05;

fn solved(case: &Case, basis: Basis) -> Arc<Warp> {
    let controls = Controls { basis, pins: case.pins(), ..Controls::default() };
    warp(&controls, &ShapeSource::Frame, case.frame).expect("pins that can be solved")
}

fn assert_whole(case: &Case, basis: Basis) -> Measures {
    let warp = solved(case, basis);
    let found = measure(&warp, case);
    let limit = if case.moves.len() == 1 { 1.05 } else { 1.5 };
    let is_whole = found.miss_px <= MET && found.ratio <= limit && found.min_det > 0.0 && found.border_px == 0.0;
    assert!(is_whole, "{basis:?} {}: {found:?} in {case:?}", case.frame.height);
    assert!(warp.notices(&wording(case)).is_empty(), "{:?} in {case:?}", warp.notices(&wording(case)));
    found
}

fn wording(case: &Case) -> Wording<'static> {
    Wording { pin: &|pin| (pin + 1).to_string(), place: &|_| String::new(), pixels: f64::from(case.frame.height) }
}

#[test]
fn scattered_pins_are_met_and_the_picture_stays_whole() {
    let seed = cases::seed();
    println!("seed {seed}");
    let mut random = SplitMix(seed);
    for frame in FRAMES {
        for basis in Basis::ALL {
            let mut worst = Measures::default();
            for count in [1, 1, 2, 3, 5, 8, 16, 32] {
                let case = scattered(&mut random, frame, count);
                worst = worst.or_worse(assert_whole(&case, basis));
            }
            println!("{} {basis:?}: {worst:?}", frame.height);
        }
    }
}

#[test]
fn one_pin_anywhere_moves_nothing_further_than_itself() {
    for frame in FRAMES {
        let [width, height] = [f64::from(frame.width), f64::from(frame.height)];
        for basis in Basis::ALL {
            for (x, y) in [
                (5.0_f64, 5.0_f64),
                (5.0, 0.5 * height),
                (120.0, 120.0),
                (0.5 * width, 40.0),
                (0.7 * width, 0.4 * height),
            ] {
                let room = x.min(y).min(width - x).min(height - y);
                for way in [[0.4, 0.0], [-0.4, 0.0], [0.2, 0.3]] {
                    let case = Case { frame, moves: vec![([x, y], way.map(|part: f64| part * room))] };
                    assert_whole(&case, basis);
                }
            }
        }
    }
}

#[test]
fn problems_that_once_tore_pictures_no_longer_do() {
    let frame = FRAMES[0];
    let nine = (0..9).map(|k| ([800.0 + f64::from(k % 3) * 80.0, 400.0 + f64::from(k / 3) * 80.0], [0.0; 2]));
    let mut nine: Vec<_> = nine.collect();
    nine[4].1 = [23.0, 0.0];
    for moves in [vec![([960.0, 100.0], [0.0, 36.0])], vec![([120.0, 120.0], [1.0, 0.0])], nine] {
        let case = Case { frame, moves };
        for basis in Basis::ALL {
            assert_whole(&case, basis);
        }
    }
}

#[test]
fn the_warp_follows_its_pins_steadily() {
    let seed = cases::seed();
    println!("seed {seed}");
    let mut random = SplitMix(seed);
    let frame = FRAMES[0];
    for basis in [Basis::Bspline, Basis::Barytri] {
        for count in [1, 2, 4, 8, 16] {
            let case = scattered(&mut random, frame, count);
            for part in [0.0, 0.05, 0.4, 0.7, 1.0] {
                let mut at = case.clone();
                at.moves.iter_mut().for_each(|(_, by)| *by = by.map(|by| by * part));
                let jump = jump_px(&at, basis, 1e-3);
                assert!(jump < 0.1, "{basis:?}, {count} pins, {part}: {jump} px in {at:?}");
            }
        }
    }
}

#[test]
fn nothing_jumps_where_a_pin_crosses_the_border_or_passes_others() {
    let frame = FRAMES[0];
    let still = [([700.0, 300.0], [0.0, 30.0]), ([640.0, 120.0], [0.0; 2])];
    for step in 0..40 {
        // Past both of the others, over the border and beyond.
        let way = f64::from(step) * 20.0;
        let case = Case { frame, moves: [([680.0, 620.0], [-0.1 * way, -way])].into_iter().chain(still).collect() };
        let jump = jump_px(&case, Basis::Bspline, 1e-6);
        // Solves end within a millionth of the diagonal: two thousandths of a pixel.
        assert!(jump < 0.02, "{way}: {jump} px");
    }
}

/// How far any point moves when the first pin and its target do, by `by` pixels.
fn jump_px(case: &Case, basis: Basis, by: f64) -> f64 {
    let mut beside = case.clone();
    let (at, way) = &mut beside.moves[0];
    (at[0], way[1]) = (at[0] + by, way[1] - by);
    measure::difference_px(&solved(case, basis), &solved(&beside, basis), case.frame)
}

#[test]
fn the_border_gives_way_to_a_pin_that_is_dragged_past_it_and_says_so() {
    let frame = FRAMES[0];
    for by in [20.0, 60.0, 150.0] {
        let case = Case { frame, moves: vec![([30.0, 500.0], [-30.0 - by, 0.0]), ([900.0, 500.0], [40.0, 0.0])] };
        let warp = solved(&case, Basis::Bspline);
        let found = measure(&warp, &case);
        assert!(found.miss_px <= MET && found.ratio <= 1.5 && found.min_det > 0.0, "{by}: {found:?}");
        assert!(found.border_px > 0.3 * by && found.border_px < 1.5 * (30.0 + by), "{by}: {found:?}");
        let notices = warp.notices(&wording(&case));
        assert!(
            notices.len() == 1 && notices[0].text.starts_with("pin 1 comes too close to the border"),
            "{notices:?}"
        );
        // Far from the pin the border rests.
        let corner = ScreenPoint::new(0.0, 1.0);
        assert_eq!(warp.field.carry(corner).0, corner.0);
    }
}

#[test]
fn the_border_rests_where_a_pin_is_dragged_away_from_it() {
    for frame in FRAMES {
        let [width, height] = [f64::from(frame.width), f64::from(frame.height)];
        for (at, inwards) in [
            ([5.0, 0.5 * height], [1.0, 0.0]),
            ([3.0, 0.3 * height], [1.0, 0.4]),
            ([width - 5.0, 0.7 * height], [-1.0, -0.1]),
            ([0.4 * width, 5.0], [0.0, 1.0]),
            ([5.0, height - 5.0], [0.7, -0.7]),
        ] {
            for by in [20.0, 96.0, 300.0] {
                let case = Case { frame, moves: vec![(at, inwards.map(|part| part * by))] };
                assert_whole(&case, Basis::Bspline);
            }
        }
    }
}

#[test]
fn pins_that_contradict_each_other_stop_and_are_reported() {
    let frame = FRAMES[0];
    let case = Case {
        frame,
        moves: vec![([800.0, 500.0], [50.0, 0.0]), ([900.0, 500.0], [-50.0, 0.0]), ([400.0, 300.0], [30.0, 20.0])],
    };
    let warp = solved(&case, Basis::Bspline);
    let found = measure(&warp, &case);
    assert!(found.min_det > 0.0 && found.ratio <= 1.5 && found.border_px == 0.0, "{found:?}");
    let errors = &warp.report.as_ref().expect("solved").pin_errors;
    assert!(errors[0] * 1080.0 > MET && errors[2] * 1080.0 < MET, "the third pin is met all the same: {errors:?}");
    let notices = warp.notices(&wording(&case));
    assert!(notices.iter().any(|notice| notice.text.contains("pins 1 and 2 miss")), "{notices:?}");
}

#[test]
fn a_pin_that_turns_and_scales_does_so_exactly() {
    let frame = FRAMES[0];
    let at = frame.screen_from_image(ImagePoint::new(700.0, 600.0));
    let to = frame.screen_from_image(ImagePoint::new(760.0, 560.0));
    for (turn, scale) in [(0.6, 1.0), (-2.0, 1.7), (7.5, 0.4)] {
        let pin = Pin { rotation: Some(turn), scale: Some(scale), ..Pin::new(at, to) };
        let controls = Controls { pins: vec![pin], ..Controls::default() };
        let warp = warp(&controls, &ShapeSource::Frame, frame).expect("a pin that turns");
        let (end, gradient) = warp.field.evaluate_with_gradient(at);
        assert!((end.0 - to.0).length() * 1080.0 < MET);
        let (sin, cos) = turn.sin_cos();
        let conformal = [gradient.x_axis.x + gradient.y_axis.y, gradient.x_axis.y - gradient.y_axis.x];
        let off = [0.5 * conformal[0] - scale * cos, 0.5 * conformal[1] - scale * sin];
        assert!(off[0].hypot(off[1]) < 0.05 * scale, "{turn} {scale}: {gradient:?}");
        assert!((gradient.determinant().sqrt() / scale - 1.0).abs() < 1e-6, "{turn} {scale}: {gradient:?}");
    }
}

#[test]
fn maps_agree_with_the_field_both_ways() {
    let mut random = SplitMix(7);
    for (frame, count) in [(FRAMES[0], 12), (FRAMES[0], 32), (FRAMES[1], 16)] {
        let case = scattered(&mut random, frame, count);
        let mut pins = case.pins();
        pins.iter_mut().step_by(3).for_each(|pin| (pin.rotation, pin.scale) = (Some(2.0), Some(1.4)));
        let controls = Controls { pins, ..Controls::default() };
        let warp = warp(&controls, &ShapeSource::Frame, frame).expect("pins that can be solved");
        let backward = WarpMap::backward(&warp.field, frame, frame.window());
        let forward = WarpMap::forward(&warp.field, frame, frame.window());
        assert!(backward.folded_pixels.is_empty() && forward.folded_pixels.is_empty());
        let scale = f64::from(frame.height);
        let mut worst = [0.0_f64; 2];
        for index in (0..backward.offsets.len()).step_by(37) {
            let [x, y] = frame.window().pixel_at(index);
            let center = [f64::from(x) + 0.5, f64::from(y) + 0.5];
            let source = backward.source(x, y).expect("every pixel comes from somewhere");
            let landed = warp.field.carry(frame.screen_from_image(ImagePoint::new(source[0], source[1])));
            let target = frame.screen_from_image(ImagePoint::new(center[0], center[1]));
            worst[0] = worst[0].max((landed.0 - target.0).length() * scale);
            assert!(slope_error(&warp.field, target) < 1e-4, "{target:?}");
            let [dx, dy] = forward.offsets[index].map(f64::from);
            let to = frame.screen_from_image(ImagePoint::new(center[0] + dx, center[1] + dy));
            worst[1] = worst[1].max((warp.field.carry(target).0 - to.0).length() * scale);
        }
        assert!(worst[0] < 0.02 && worst[1] < 0.02, "{} {count}: {worst:?}", frame.height);
        let tile = PixelRect { x: 320, y: 256, width: 64, height: 32 };
        assert!(WarpMap::backward(&warp.field, frame, tile).offsets.iter().all(|offset| offset[0].is_finite()));
    }
}

/// How far the gradient of a field is from its differences.
fn slope_error(field: &Field, at: ScreenPoint) -> f64 {
    let (_, gradient) = field.evaluate_with_gradient(at);
    let change = |[x, y]: [f64; 2]| {
        let end = |sign: f64| field.carry(ScreenPoint::new(at.0.x + sign * x, at.0.y + sign * y)).0;
        (end(1.0) - end(-1.0)) / (2.0 * STEP)
    };
    let off = [change([STEP, 0.0]) - gradient.x_axis, change([0.0, STEP]) - gradient.y_axis];
    off[0].length().max(off[1].length())
}

/// Of differences, frame heights.
const STEP: f64 = 1e-7;

/// A frame of that many pixels.
const fn frame(width: u32, height: u32) -> FrameSize {
    FrameSize::new(width, height)
}
