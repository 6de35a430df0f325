//! Pixels of warped pictures: tiles, threads, masks, backgrounds, alpha.

use super::support::{WIDE, bent, job, noise, picture};
use glam::DVec2;
use pinwarp::live::{Alpha, Controls, LiveError, Moved, Pin, Render, ShapeSource, render, render_pieces, warp};
use pinwarp::plate::Filter;
use pinwarp::space::{ImagePoint, PixelRect, ScreenPoint};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Samples of a window out of those of a larger one.
fn cut(plane: &[f32], from: PixelRect, to: PixelRect) -> Vec<f32> {
    let start = |row: i32| (to.y + row - from.y) as usize * from.width as usize + (to.x - from.x) as usize;
    (0..to.height as i32).flat_map(|row| plane[start(row)..][..to.width as usize].to_vec()).collect()
}

/// Windows that cross map_tiles, leave the frame, or are a single pixel.
const TILES: [PixelRect; 5] = [
    PixelRect { x: 0, y: 0, width: 64, height: 64 },
    PixelRect { x: 600, y: 220, width: 90, height: 60 },
    PixelRect { x: -20, y: 250, width: 100, height: 50 },
    PixelRect { x: 637, y: 253, width: 2, height: 2 },
    PixelRect { x: 333, y: 100, width: 1, height: 1 },
];

const ALL: PixelRect = PixelRect { x: -30, y: -20, width: 760, height: 330 };

/// The same samples, bit for bit; 0 and -0 are one.
fn check_same(a: &[Vec<f32>], b: &[Vec<f32>], what: &str) {
    for (index, (a, b)) in a.iter().zip(b).enumerate() {
        let differ = a.iter().zip(b).filter(|(a, b)| a != b).count();
        assert_eq!((differ, a.len()), (0, b.len()), "{what}: samples of plane {index} differ");
    }
}

#[test]
fn tiles_are_parts_of_the_whole() {
    let (warp, window) = (bent(), WIDE.window());
    let planes: Vec<Vec<f32>> = (0..4).map(|k| noise(window, k)).collect();
    let (mask, behind) = ([noise(window, 9)], planes.clone().into_iter().rev().collect::<Vec<_>>());
    let mask = picture(window, &mask, Alpha::Opaque);
    for alpha in [Alpha::Premultiplied, Alpha::Straight] {
        let (source, background) = (picture(window, &planes, alpha), picture(window, &behind, alpha));
        for (what, filter, masked) in
            [("cubic", Filter::Cubic, false), ("ewa", Filter::Ewa, false), ("masked", Filter::Ewa, true)]
        {
            let layers = if masked { (Some(&mask), Some(&background)) } else { (None, None) };
            let of = |window| Render { mask: layers.0, background: layers.1, filter, ..job(&source, window) };
            let whole = render(&warp, &of(ALL)).expect("rendered");
            for tile in TILES {
                let part: Vec<Vec<f32>> = whole.iter().map(|plane| cut(plane, ALL, tile)).collect();
                check_same(&part, &render(&warp, &of(tile)).expect("rendered"), &format!("{what} {alpha:?} {tile:?}"));
            }
        }
    }
}

#[test]
fn a_sample_that_is_no_number_changes_no_tile_that_does_not_read_it() {
    let (warp, window) = (bent(), WIDE.window());
    let mut planes = [noise(window, 5)];
    planes[0][145 * 700 + 350] = f32::NAN;
    let source = picture(window, &planes, Alpha::Opaque);
    let whole = render(&warp, &job(&source, window)).expect("rendered");
    assert!(whole[0].iter().all(|sample| sample.is_finite()));
    for (x, y) in [(330, 130), (365, 150), (300, 160)] {
        let tile = PixelRect { x, y, width: 20, height: 20 };
        let part = render(&warp, &job(&source, tile)).expect("rendered");
        check_same(&[cut(&whole[0], window, tile)], &part, "beside a NaN");
    }
}

#[test]
fn eight_threads_show_the_same() {
    let window = WIDE.window();
    let planes: Vec<Vec<f32>> = (0..4).map(|k| noise(window, k)).collect();
    let source = picture(window, &planes, Alpha::Premultiplied);
    // Every thread asks for the warp itself, as hosts do.
    let draw = || render(&bent(), &job(&source, window)).expect("rendered");
    let first = draw();
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|_| scope.spawn(draw)).collect();
        threads.into_iter().for_each(|thread| assert!(thread.join().expect("no panic") == first));
    });
}

#[test]
fn a_picture_can_be_given_up() {
    let window = WIDE.window();
    let planes = [noise(window, 1)];
    let source = picture(window, &planes, Alpha::Opaque);
    let [asked, finished] = [0, 0].map(AtomicUsize::new);
    let abort = || asked.fetch_add(1, Ordering::Relaxed) == 1;
    let job = Render { abort: &abort, ..job(&source, window) };
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let outcome = alone.install(|| render_pieces(&bent(), &job, |_| _ = finished.fetch_add(1, Ordering::Relaxed)));
    // A thread draws two map_tiles before it asks again.
    let pieces = finished.into_inner();
    assert!(matches!(outcome, Err(LiveError::Aborted)) && pieces == 2, "{outcome:?} after {pieces} pieces");
}

#[test]
fn unchanged_pixels_keep_their_bits() {
    let (window, warp) = (WIDE.window(), bent());
    let mut planes: Vec<Vec<f32>> = (0..4).map(|k| noise(window, k)).collect();
    planes[3].iter_mut().step_by(3).for_each(|alpha| *alpha = 0.0);
    let source = picture(window, &planes, Alpha::Straight);
    let mask = [vec![0.0; window.area()]];
    let mask = picture(window, &mask, Alpha::Opaque);
    let masked = render(&warp, &Render { mask: Some(&mask), ..job(&source, window) }).expect("rendered");
    check_same(&masked, &planes, "nothing is selected");
    let still = super::live_warp_at_rest();
    check_same(&render(&still, &job(&source, window)).expect("rendered"), &planes, "nothing moves");
}

#[test]
fn straight_colour_is_filtered_with_its_alpha() {
    let (window, warp) = (WIDE.window(), bent());
    let mut planes: Vec<Vec<f32>> = (0..4).map(|k| noise(window, k)).collect();
    planes[3].iter_mut().for_each(|alpha| *alpha = 0.25 + 0.5 * *alpha);
    let straight = render(&warp, &job(&picture(window, &planes, Alpha::Straight), window)).expect("rendered");
    for color in 0..3 {
        planes[color] = planes[color].iter().zip(&planes[3]).map(|(color, alpha)| color * alpha).collect();
    }
    let multiplied = render(&warp, &job(&picture(window, &planes, Alpha::Premultiplied), window)).expect("rendered");
    for k in (0..window.area()).step_by(37) {
        let again = straight[0][k] * straight[3][k];
        assert!((again - multiplied[0][k]).abs() < 1e-5, "{again} {}", multiplied[0][k]);
    }
}

#[test]
fn light_without_alpha_stays_when_colour_is_straight() {
    let (window, warp) = (WIDE.window(), bent());
    let planes = [vec![0.5; window.area()], vec![0.0; window.area()]];
    let drawn = render(&warp, &job(&picture(window, &planes, Alpha::Straight), window)).expect("rendered");
    let middle = 145 * 700 + 350;
    assert!((drawn[0][middle] - 0.5).abs() < 1e-4 && drawn[1][middle] == 0.0, "{}", drawn[0][middle]);
}

#[test]
fn a_background_fills_what_was_uncovered() {
    let window = WIDE.window();
    let planes = [vec![0.25; window.area()], vec![1.0; window.area()]];
    let behind = [vec![0.75; window.area()], vec![1.0; window.area()]];
    // A square around the first pin, which moves right by 43 and up by 29 pixels.
    let inside = |k: usize| (140..210).contains(&(k % 700)) && (110..180).contains(&(k / 700));
    let mask = [(0..window.area()).map(|k| f32::from(u8::from(inside(k)))).collect::<Vec<f32>>()];
    let (source, behind) =
        (picture(window, &planes, Alpha::Premultiplied), picture(window, &behind, Alpha::Premultiplied));
    let mask = picture(window, &mask, Alpha::Opaque);
    let at = |planes: &[Vec<f32>], x: usize, y: usize| [planes[0][y * 700 + x], planes[1][y * 700 + x]];
    let holes = Render { mask: Some(&mask), ..job(&source, window) };
    let left = render(&bent(), &holes).expect("rendered");
    let filled = render(&bent(), &Render { background: Some(&behind), ..holes }).expect("rendered");
    assert_eq!(at(&left, 150, 170), [0.0, 0.0], "the square left a hole");
    assert_eq!(at(&filled, 150, 170), [0.75, 1.0]);
    for (x, y) in [(50, 50), (217, 115)] {
        assert!((at(&filled, x, y)[0] - 0.25).abs() < 1e-4, "{x} {y}: {:?}", at(&filled, x, y));
    }
    let few = picture(window, &planes[..1], Alpha::Opaque);
    let fault = render(&bent(), &Render { background: Some(&few), ..job(&source, window) });
    assert!(matches!(fault, Err(LiveError::PlaneCount { found: 1, wanted: 2 })));
}

#[test]
fn planes_that_do_not_fit_are_refused() {
    let planes = [vec![0.0; 12]];
    let source = picture(WIDE.window(), &planes, Alpha::Opaque);
    let fault = render(&bent(), &job(&source, WIDE.window())).expect_err("too short");
    assert!(fault.to_string().contains("12 samples"), "{fault}");
    let _ = warp(&Controls::default(), &ShapeSource::Frame, WIDE).expect("solves");
}

#[test]
fn what_is_transparent_in_front_of_a_fold_hides_nothing() {
    // Two pins that change places: the transparent right half comes to lie over the opaque left one.
    let pins = [[0.8, 0.5, 0.9, 0.0], [1.7, 0.5, -1.1, 0.0], [0.1, 0.5, 0.0, 0.0], [2.3, 0.5, 0.0, 0.0]];
    let pin = |[x, y, dx, dy]: [f64; 4]| Pin::new(ScreenPoint::new(x, y), ScreenPoint::new(x + dx, y + dy));
    let pins = pins.map(pin).to_vec();
    let controls = Controls { dims: [12, 10], pins, moved: Moved::Masked, ..Controls::default() };
    let (warp, window) = (warp(&controls, &ShapeSource::Frame, WIDE).expect("solves"), WIDE.window());
    let is_left = |k: usize| k % 700 < 300;
    let alpha: Vec<f32> = (0..window.area()).map(|k| f32::from(u8::from(is_left(k)))).collect();
    let color: Vec<f32> = alpha.iter().map(|alpha| 0.5 * alpha).collect();
    // Where every fourth point of either half lands, turned-over parts left out.
    let mut landed = [vec![false; window.area()], vec![false; window.area()]];
    for k in (0..window.area()).step_by(4).filter(|k| (k % 700).abs_diff(300) > 4) {
        let at = ImagePoint(DVec2::new((k % 700) as f64 + 0.5, (k / 700) as f64 + 0.5));
        let (to, gradient) = warp.field.evaluate_with_gradient(WIDE.screen_from_image(at));
        let to = WIDE.image_from_screen(to).0;
        if gradient.determinant() > 0.05
            && to.cmpge(DVec2::splat(2.0)).all()
            && to.cmplt(DVec2::new(698.0, 288.0)).all()
        {
            landed[usize::from(!is_left(k))][to.y as usize * 700 + to.x as usize] = true;
        }
    }
    let both = landed[0].iter().zip(&landed[1]).filter(|(left, right)| **left && **right).count();
    assert!(both > 100, "the warp folds: {both}");
    for (kind, filter) in
        [(Alpha::Premultiplied, Filter::Ewa), (Alpha::Straight, Filter::Ewa), (Alpha::Straight, Filter::Nearest)]
    {
        let planes = if kind == Alpha::Straight {
            [vec![0.5; window.area()], alpha.clone()]
        } else {
            [color.clone(), alpha.clone()]
        };
        let source = picture(window, &planes, kind);
        let drawn = render(&warp, &Render { filter, ..job(&source, window) }).expect("rendered");
        let lost = landed[0].iter().zip(&drawn[1]).filter(|(left, alpha)| **left && **alpha < 0.5).count();
        let all = landed[0].iter().filter(|left| **left).count();
        assert!(lost * 200 <= all, "{kind:?} {filter:?}: {lost} of {all} pixels are lost");
    }
}
