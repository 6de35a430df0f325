//! Regions hold what is drawn and what is read; STMaps are those of the engine.

use super::support::{WIDE, bent, job, noise, picture};
use pinwarp::image::{Compression, Frame, Storage};
use pinwarp::live::{Alpha, OutputGuard, Render, StMapFile, render, save_stmap, stmap};
use pinwarp::plate::{Filter, WarpMap, stmap_of};
use pinwarp::space::PixelRect;

const FILTERS: [Filter; 4] = [Filter::Nearest, Filter::Cubic, Filter::Lanczos, Filter::Ewa];

#[test]
fn everything_drawn_lies_in_the_destination() {
    let (warp, around) = (bent(), PixelRect { x: -200, y: -100, width: 1100, height: 500 });
    for window in [WIDE.window(), PixelRect { x: 120, y: 90, width: 200, height: 120 }] {
        let planes = [vec![1.0; window.area()]];
        let source = picture(window, &planes, Alpha::Opaque);
        let region = warp.destination_of(window, WIDE);
        for filter in FILTERS {
            let drawn = render(&warp, &Render { filter, ..job(&source, around) }).expect("rendered");
            for (k, _) in drawn[0].iter().enumerate().filter(|(_, sample)| **sample != 0.0) {
                let (x, y) = (around.x + (k % 1100) as i32, around.y + (k / 1100) as i32);
                let is_in = (region.x..region.x + region.width as i32).contains(&x)
                    && (region.y..region.y + region.height as i32).contains(&y);
                assert!(is_in, "{filter:?}: {x}, {y} is drawn outside {region:?}");
            }
        }
    }
}

#[test]
fn endless_regions_are_answered_without_a_walk_over_their_pixels() {
    // A walk over as many pixels would not end.
    let warp = bent();
    for (k, side) in [1_000_000_u32, 2_000_000].into_iter().enumerate() {
        let half = side as i32 / 2;
        let endless = PixelRect { x: -half, y: -half, width: side, height: side };
        let holds = |region: PixelRect| region.intersection(endless) == endless;
        assert!(holds(warp.destination_of(endless, WIDE)) && holds(warp.source_of(endless, WIDE, FILTERS[k])));
        // Far away nothing moves further than anywhere.
        let far = PixelRect { x: half / 2, y: 0, ..endless };
        let read = warp.source_of(far, WIDE, Filter::Ewa);
        assert!(read.intersection(far) == far && read.x > far.x - 1000, "{read:?}");
    }
}

#[test]
fn stmaps_are_written_over_stmaps_alone() {
    let (warp, folder) = (bent(), tempfile::tempdir().expect("a folder"));
    let path = folder.path().join("map.exr");
    let file = StMapFile { path: &path, frame: 7, rate: 25.0 };
    let guard = OutputGuard::default();
    save_stmap(&warp, WIDE, file, &guard).expect("written");
    save_stmap(&warp, WIDE, file, &guard).expect("written again");
    let told = pinwarp::image::read_metadata(&path).expect("readable").expect("ours");
    assert_eq!((told.frame, told.frames_per_second), (7, 25.0));
    let render = Frame::blank(WIDE.window(), WIDE.window(), &["R", "G", "B", "A"].map(|name| (name, Storage::Half)));
    pinwarp::image::write_exr(&path, &render, &told, Compression::Zip).expect("written");
    let refused = save_stmap(&warp, WIDE, file, &guard).expect_err("a render");
    assert!(refused.to_string().contains("not an STMap written by this program"), "{refused}");
    std::fs::write(&path, b"my notes").expect("written");
    save_stmap(&warp, WIDE, file, &guard).expect_err("notes");
    assert_eq!(std::fs::read(&path).expect("there"), b"my notes");
}

#[test]
fn what_lies_outside_the_source_region_is_not_read() {
    let (warp, window) = (bent(), WIDE.window());
    let clean = [noise(window, 3)];
    for tile in
        [PixelRect { x: 200, y: 80, width: 60, height: 50 }, PixelRect { x: 610, y: 240, width: 60, height: 40 }]
    {
        for filter in FILTERS {
            let region = warp.source_of(tile, WIDE, filter);
            assert!(region.area() < window.area() / 2, "{filter:?}: all of the frame is no answer: {region:?}");
            let is_in = |k: usize| {
                let (x, y) = ((k % 700) as i32, (k / 700) as i32);
                (region.x..region.x + region.width as i32).contains(&x)
                    && (region.y..region.y + region.height as i32).contains(&y)
            };
            let spoiled =
                [clean[0].iter().enumerate().map(|(k, &s)| if is_in(k) { s } else { 1e6 }).collect::<Vec<f32>>()];
            let draw = |planes: &[Vec<f32>]| {
                let source = picture(window, planes, Alpha::Opaque);
                render(&warp, &Render { filter, ..job(&source, tile) }).expect("rendered")
            };
            assert!(draw(&clean) == draw(&spoiled), "{filter:?}, {tile:?}: {region:?} is too small");
        }
    }
}

#[test]
fn the_stmap_is_the_engines() {
    let (warp, window) = (bent(), PixelRect { x: -10, y: 5, width: 710, height: 280 });
    let map = stmap(&warp, WIDE, window);
    let whole = stmap_of(&WarpMap::backward(&warp.field, WIDE, window));
    for (plane, channel) in [&map.u, &map.v].into_iter().zip(&whole.channels) {
        let furthest = plane.iter().zip(&channel.samples).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(furthest * 700.0 < 2e-3, "{} is off by {furthest}", channel.name);
    }
    assert!(map.coverage.iter().all(|coverage| *coverage == 1.0));
    let rest = stmap(&super::live_warp_at_rest(), WIDE, WIDE.window());
    assert_eq!((rest.u[0], rest.v[0]), (0.5 / 700.0, (289.5_f64 / 290.0) as f32));
}
