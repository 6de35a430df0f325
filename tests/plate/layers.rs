//! Layers over the rest: soft mattes, holes and what fills them, ids and depth of what is seen.

use super::support::{channel, layer, plate, samples, shift, warped, window};
use pinwarp::image::{Channel, EMPTY_DEPTH, Plate, PlatePart, Storage};
use pinwarp::lattice::{Basis, Grid};
use pinwarp::plate::{Field, Matte, PlateError, PlateJob, WarpMap, WarpSettings, remap_plate, warp_plate};
use pinwarp::space::{FrameSize, FrameWindow, PixelRect};

const FRAME: PixelRect = PixelRect { x: 0, y: 0, width: 24, height: 16 };

/// How much of a pixel the square has: whole from 6 to 11, half at its edges (5 and 12).
fn square(x: u32, y: u32) -> f32 {
    let along = |at: u32| match at {
        6..=11 => 1.0,
        5 | 12 => 0.5,
        _ => 0.0,
    };
    along(x) * along(y)
}

/// A white square before a grey wall with a gradient; the square is nearer, and bears the id 7.
fn room() -> Plate {
    let make = |name: &str, storage, value: &dyn Fn(u32, u32) -> f32| channel(name, storage, FRAME, value);
    let wall = |x: u32| 0.25 + x as f32 / 256.0;
    let color = |x: u32, y: u32| square(x, y) * 2.0 + (1.0 - square(x, y)) * wall(x);
    let is_square = |x: u32, y: u32| square(x, y) >= 0.5;
    plate(
        FRAME,
        FRAME,
        vec![
            make("A", Storage::Half, &|_, _| 1.0),
            make("R", Storage::Half, &color),
            make("Z", Storage::Float, &|x, y| if is_square(x, y) { 3.0 } else { 10.0 + x as f32 }),
            make("id", Storage::Uint, &|x, y| f32::from_bits(if is_square(x, y) { 7 } else { 1 })),
            make("mask.A", Storage::Half, &square),
        ],
    )
}

fn mask() -> Option<Matte> {
    Some(Matte::Channel("mask.A".into()))
}

fn at(plate: &Plate, name: &str, x: usize, y: usize) -> f32 {
    samples(plate, name)[y * FRAME.width as usize + x]
}

#[test]
fn a_layer_that_stays_gives_the_picture_back() {
    let (still, report) = warped(&room(), vec![layer("square", Field::identity(), mask())], &WarpSettings::default());
    assert_eq!(report.uncovered_pixels, 0, "soft edges are no holes");
    for part in &room().parts {
        for source in &part.channels {
            let worst = source.samples.iter().zip(samples(&still, &source.name)).map(|(a, b)| (a - b).abs());
            assert!(worst.fold(0.0, f32::max) < 1e-6, "{}", source.name);
        }
    }
    let moved = warped(&room(), vec![layer("square", shift(1, 0, 16), mask())], &WarpSettings::default()).0;
    assert_ne!(samples(&still, "R"), samples(&moved, "R"), "the comparison can fail");
}

#[test]
fn a_layer_that_moves_leaves_a_hole_and_covers_the_rest() {
    let (moved, report) = warped(&room(), vec![layer("square", shift(9, 0, 16), mask())], &WarpSettings::default());
    // 8 x 8 pixels had a share in the square; its left edge lands on 14, where the hole ends at 12.
    assert_eq!(report.uncovered_pixels, 64);
    for (x, r, a, z, id) in [
        (2, 0.25 + 2.0 / 256.0, 1.0, 12.0, 1),
        (8, 0.0, 0.0, EMPTY_DEPTH, 0),
        (17, 2.0, 1.0, 3.0, 7),
        (23, 0.25 + 23.0 / 256.0, 1.0, 33.0, 1),
    ] {
        assert!((at(&moved, "R", x, 8) - r).abs() < 1e-6, "{x}");
        assert_eq!((at(&moved, "A", x, 8), at(&moved, "Z", x, 8), at(&moved, "id", x, 8).to_bits()), (a, z, id), "{x}");
    }
    // The soft edge has half of the square over half of the wall that it was mixed with.
    let mixed = 0.5 * (0.5 * 2.0 + 0.5 * (0.25 + 5.0 / 256.0)) + 0.5 * (0.25 + 14.0 / 256.0);
    assert!((at(&moved, "R", 14, 8) - mixed).abs() < 1e-6, "{} {mixed}", at(&moved, "R", 14, 8));
    assert_eq!(at(&moved, "A", 14, 8), 1.0);
}

#[test]
fn an_edge_that_moves_a_little_stays_closed() {
    let (moved, report) = warped(&room(), vec![layer("square", shift(1, 0, 16), mask())], &WarpSettings::default());
    // Before its new right edge nothing is missing; the pixels it left on the other side are.
    for x in 6..24 {
        let expected = if x == 6 { 0.5 } else { 1.0 };
        assert_eq!(at(&moved, "A", x, 8), expected, "{x}");
    }
    assert_eq!(at(&moved, "A", 5, 8), 0.5);
    assert!(report.uncovered_pixels > 0);
}

#[test]
fn a_clean_plate_fills_holes_and_nothing_else() {
    let blue = |name: &str, value: f32| channel(name, Storage::Half, FRAME, move |_, _| value);
    let mut channels = vec![blue("A", 1.0), blue("R", 0.5), blue("mask.A", 0.0)];
    channels.push(channel("Z", Storage::Float, FRAME, |x, _| 20.0 + x as f32));
    let clean = plate(FRAME, FRAME, channels);
    let settings = WarpSettings::default();
    let layers = vec![layer("square", shift(9, 0, 16), mask())];
    let job = PlateJob { layers, settings: &settings, fill: Some(&clean) };
    let (filled, report) = warp_plate(&room(), &job).expect("the matte is there");
    assert_eq!(report.uncovered_pixels, 64, "filled holes are counted too");
    assert_eq!((at(&filled, "R", 8, 8), at(&filled, "A", 8, 8), at(&filled, "Z", 8, 8)), (0.5, 1.0, 28.0));
    assert_eq!((at(&filled, "R", 17, 8), at(&filled, "Z", 17, 8)), (2.0, 3.0));
    // The soft rim of the hole: half wall, half clean plate.
    assert_eq!(at(&filled, "A", 5, 8), 1.0);
    assert_eq!(at(&filled, "id", 8, 8).to_bits(), 0, "what the clean plate does not have stays empty");
}

#[test]
fn mattes_by_id_and_alpha() {
    let ids = Matte::Id { channel: "id".into(), values: vec![7] };
    let moved = warped(&room(), vec![layer("square", shift(9, 0, 16), Some(ids))], &WarpSettings::default()).0;
    assert_eq!((at(&moved, "Z", 8, 8), at(&moved, "Z", 17, 8)), (EMPTY_DEPTH, 3.0));
    let (moved, report) =
        warped(&room(), vec![layer("all", shift(3, 0, 16), Some(Matte::Alpha))], &WarpSettings::default());
    assert_eq!((at(&moved, "Z", 11, 8), at(&moved, "R", 0, 8), report.uncovered_pixels), (3.0, 0.0, 0));
}

#[test]
fn layers_in_front_hide_those_behind() {
    let far = |x: i32| x as u32;
    let make = |name: &str, inside: std::ops::Range<u32>| {
        channel(name, Storage::Half, FRAME, move |x, _| f32::from(u8::from(inside.contains(&x))))
    };
    let mut channels: Vec<Channel> = vec![make("a.A", far(2)..6), make("b.A", 10..14)];
    channels.push(channel("R", Storage::Half, FRAME, |x, _| x as f32));
    channels.push(channel("Z", Storage::Float, FRAME, |x, _| 100.0 + x as f32));
    let picture = plate(FRAME, FRAME, channels);
    let of = |name: &str| Some(Matte::Channel(name.into()));
    let to_a = || layer("b", shift(-8, 0, 16), of("b.A"));
    let stay = || layer("a", Field::identity(), of("a.A"));
    let (front, _) = warped(&picture, vec![stay(), to_a()], &WarpSettings::default());
    let (behind, _) = warped(&picture, vec![to_a(), stay()], &WarpSettings::default());
    assert_eq!((at(&front, "R", 3, 4), at(&front, "Z", 3, 4)), (11.0, 111.0));
    assert_eq!((at(&behind, "R", 3, 4), at(&behind, "Z", 3, 4)), (3.0, 103.0));
}

#[test]
fn a_layer_without_matte_bends_all_others_too() {
    let layers = vec![layer("square", shift(2, 0, 16), mask()), layer("world", shift(3, 1, 16), None)];
    let moved = warped(&room(), layers, &WarpSettings::default()).0;
    assert_eq!(at(&moved, "id", 8 + 5, 9).to_bits(), 7);
    assert_eq!(at(&moved, "Z", 20, 9), 10.0 + 17.0);
}

#[test]
fn light_without_alpha_survives() {
    let make = |name: &str, value: f32| channel(name, Storage::Half, FRAME, move |_, _| value);
    let flame = plate(FRAME, FRAME, vec![make("A", 0.0), make("R", 3.0), make("G", -0.5), make("mask.A", 1.0)]);
    let moved = warped(&flame, vec![layer("flame", shift(4, 0, 16), mask())], &WarpSettings::default()).0;
    assert_eq!((at(&moved, "R", 12, 8), at(&moved, "G", 12, 8), at(&moved, "A", 12, 8)), (3.0, -0.5, 0.0));
}

#[test]
fn non_finite_numbers_do_not_spread() {
    let bad = |x: u32, y: u32| {
        if (x, y) == (4, 4) {
            f32::NAN
        } else if (x, y) == (9, 4) {
            f32::INFINITY
        } else {
            0.5
        }
    };
    let picture = plate(FRAME, FRAME, vec![channel("R", Storage::Half, FRAME, bad)]);
    let mut lattice = Grid { dims: [4, 4], basis: Basis::Bspline, lo: [-8.0; 2], hi: [8.0; 2], angle: 0.0 }.at_rest();
    lattice.handles.iter_mut().for_each(|handle| handle[0] += 0.4 / 16.0);
    let (moved, report) =
        warped(&picture, vec![layer("all", Field::of_layer(lattice), None)], &WarpSettings::default());
    assert_eq!(report.contained_samples, 2);
    assert!(samples(&moved, "R").iter().all(|sample| sample.is_finite()));
    assert!((at(&moved, "R", 15, 8) - 0.5).abs() < 1e-5);
}

#[test]
fn windows_grow_with_the_picture_and_origins_count() {
    let display = window(-100, 50, 40, 30);
    let own = window(-90, 60, 8, 6);
    let make = |name: &str, value| channel(name, Storage::Half, own, move |_, _| value);
    let sprite = plate(display, own, vec![make("A", 1.0), make("R", 0.5)]);
    let moved = warped(&sprite, vec![layer("all", shift(5, -3, 30), None)], &WarpSettings::default()).0;
    assert_eq!((moved.display, moved.parts[0].data_window), (display, window(-85, 57, 8, 6)));
    assert!(samples(&moved, "R").iter().all(|&sample| sample == 0.5));
    // Far out of sight one empty pixel is left.
    let gone = warped(&sprite, vec![layer("all", shift(500, 0, 30), None)], &WarpSettings::default()).0;
    assert_eq!((gone.parts[0].data_window.area(), samples(&gone, "R")), (1, &[0.0][..]));
    // A plate that fills its frame, overscan included, keeps its window.
    let wide = window(-105, 45, 50, 40);
    let full = plate(display, wide, vec![channel("R", Storage::Half, wide, |x, _| x as f32)]);
    let moved = warped(&full, vec![layer("all", shift(3, 0, 30), None)], &WarpSettings::default()).0;
    assert_eq!(moved.parts[0].data_window, wide);
    assert_eq!(samples(&moved, "R")[10], 7.0);
}

#[test]
fn a_map_without_overscan_cuts_the_plates_and_says_so() {
    let (display, wide) = (window(0, 0, 30, 20), window(-5, -5, 40, 30));
    let full = plate(display, wide, vec![channel("R", Storage::Half, wide, |x, _| x as f32)]);
    let remapped = |around: PixelRect| {
        let map = WarpMap::identity(full.frame_size(), around);
        remap_plate(&full, &map, &WarpSettings::default()).expect("a map of that frame")
    };
    let (cropped, report) = remapped(display);
    assert_eq!(cropped.parts[0].data_window, display);
    assert_eq!(samples(&cropped, "R")[..3], [5.0, 6.0, 7.0]);
    assert!(report.warnings.iter().any(|warning| warning.contains("overscan")), "{:?}", report.warnings);
    let (whole, report) = remapped(wide);
    assert_eq!((whole.parts[0].data_window, report.warnings), (wide, Vec::new()));
}

#[test]
fn a_matte_that_the_plate_lacks_is_named() {
    let settings = WarpSettings::default();
    let refused = |matte: Matte| {
        let layers = vec![layer("square", Field::identity(), Some(matte))];
        warp_plate(&room(), &PlateJob { layers, settings: &settings, fill: None }).expect_err("it is not there")
    };
    let missing = refused(Matte::Channel("mask.a".into()));
    assert_eq!(
        missing.to_string(),
        "layer \"square\": the plate has no channel \"mask.a\" for its matte; did you mean \"mask.A\"?"
    );
    let none = refused(Matte::Cryptomatte { layer: None, names: vec!["Teapot".into()] });
    assert!(matches!(none, PlateError::NoCryptomatte { .. }), "{none}");
    assert!(none.to_string().contains("contains Teapot"), "{none}");
}

#[test]
fn a_folded_layer_shows_what_lies_behind_where_it_is_transparent_in_front() {
    // Right of column 12 the layer turns back and lies over itself; only its left half is opaque.
    let lattice = {
        let mut lattice =
            Grid { dims: [4, 2], basis: Basis::Bilinear, lo: [0.0, 0.0], hi: [1.5, 1.0], angle: 0.0 }.at_rest();
        for handle in &mut lattice.handles {
            // Columns 0, 8, 16 and 24 of the frame go to 0, 16, 8 and 24.
            handle[0] = [0.0, 1.0, 0.5, 1.5][(handle[0] * 2.0).round() as usize];
        }
        lattice
    };
    let left = |x: u32, _: u32| f32::from(u8::from(x < 12));
    let channels = vec![
        channel("A", Storage::Half, FRAME, left),
        channel("R", Storage::Half, FRAME, |x, y| left(x, y) * 2.0),
        channel("mask.A", Storage::Half, FRAME, |_, _| 1.0),
    ];
    let picture = plate(FRAME, FRAME, channels);
    let moved = warped(&picture, vec![layer("all", Field::of_layer(lattice), mask())], &WarpSettings::default()).0;
    // 12 comes from 6 (opaque), from 12 (turned over) and from 20 (transparent).
    assert!(at(&moved, "A", 10, 8) > 0.9, "{}", at(&moved, "A", 10, 8));
    assert!(at(&moved, "A", 20, 8) < 0.1, "{}", at(&moved, "A", 20, 8));
}

#[test]
fn each_view_of_one_part_has_its_own_mask() {
    let value = |x: u32, from: u32| f32::from(u8::from((from..from + 4).contains(&x)));
    let make = |name: &str, from: u32| channel(name, Storage::Float, FRAME, move |x, _| value(x, from));
    let [near, far] = [2, 14];
    let mut stereo =
        plate(FRAME, FRAME, vec![make("R", near), make("cam2.R", far), make("cam2.mask.A", far), make("mask.A", near)]);
    stereo.parts[0].set_views(&["cam1", "cam2"]);
    let moved = warped(&stereo, vec![layer("bar", shift(4, 0, 16), mask())], &WarpSettings::default()).0;
    for (name, from) in [("R", near), ("cam2.R", far)] {
        let expected = make(name, from + 4).samples;
        let worst = expected.iter().zip(samples(&moved, name)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < 1e-5, "{name}: {worst}");
    }
}

/// Columns 0, 8, 16 and 24 of the frame go to 0, 16, 8 and 24: the middle turns over, and from 8 to 16 the picture lies over
/// itself. Left of 12 the right part moved further, so it lies in front.
fn folded() -> Field {
    let mut lattice =
        Grid { dims: [4, 2], basis: Basis::Bilinear, lo: [0.0, 0.0], hi: [1.5, 1.0], angle: 0.0 }.at_rest();
    for handle in &mut lattice.handles {
        handle[0] = [0.0, 1.0, 0.5, 1.5][(handle[0] * 2.0).round() as usize];
    }
    Field::of_layer(lattice)
}

/// Something on the left, nothing on the right, and passes of other layers and parts that have no alpha of their own.
fn thing_on_the_left(alpha: impl Fn(u32, u32) -> f32) -> Plate {
    let left = |x: u32, _: u32| f32::from(u8::from(x < 10));
    let main = vec![
        channel("A", Storage::Half, FRAME, alpha),
        channel("R", Storage::Half, FRAME, |x, y| left(x, y) * 2.0),
        channel("diffuse.R", Storage::Half, FRAME, left),
        channel("Z", Storage::Float, FRAME, |x, _| if x < 10 { 3.0 } else { EMPTY_DEPTH }),
        channel("id", Storage::Uint, FRAME, |x, _| f32::from_bits(if x < 10 { 7 } else { 0 })),
    ];
    let mut part = PlatePart::new(FRAME, vec![channel("specular.R", Storage::Half, FRAME, left)]);
    part.name = Some("light".into());
    Plate::new(FRAME, 1.0, vec![PlatePart::new(FRAME, main), part])
}

#[test]
fn a_transparent_part_of_the_picture_hides_nothing_where_the_warp_folds() {
    let picture = thing_on_the_left(|x, _| f32::from(u8::from(x < 10)));
    let (moved, report) = warped(&picture, vec![layer("all", folded(), None)], &WarpSettings::default());
    // 10 comes from 5 (the thing), from 14 (turned over) and from 17 (nothing, which moved further).
    for x in [9, 10, 11, 14] {
        for (name, wanted) in [("A", 1.0), ("R", 2.0), ("diffuse.R", 1.0), ("specular.R", 1.0), ("Z", 3.0)] {
            assert!((at(&moved, name, x, 8) - wanted).abs() < 1e-3, "{name} at {x}: {}", at(&moved, name, x, 8));
        }
        assert_eq!(at(&moved, "id", x, 8).to_bits(), 7, "{x}");
    }
    assert!(at(&moved, "A", 22, 8) < 0.1 && at(&moved, "Z", 22, 8) == EMPTY_DEPTH);
    assert!((80..=8 * 16).contains(&report.folded_pixels), "{}", report.folded_pixels);
    let warning =
        report.warnings.iter().find(|warning| warning.contains("folds")).expect("a fold that shows is warned of");
    assert!(
        warning.contains("layer \"all\"") && warning.contains(&format!("{} pixels", report.folded_pixels)),
        "{warning}"
    );
}

#[test]
fn folds_of_what_cannot_be_seen_are_not_warned_of() {
    let picture = thing_on_the_left(|x, _| f32::from(u8::from(x < 3)));
    let (_, report) = warped(&picture, vec![layer("all", folded(), None)], &WarpSettings::default());
    assert_eq!((report.folded_pixels, &report.warnings), (0, &Vec::new()));
}

#[test]
fn light_is_not_doubled_in_folds_of_pictures_without_a_matte() {
    let opaque = |_: u32, _: u32| 1.0;
    let none = |_: u32, _: u32| 0.0;
    let without = plate(FRAME, FRAME, vec![channel("R", Storage::Half, FRAME, |_, _| 0.5)]);
    let mut pictures = vec![without];
    for alpha in [opaque, none] {
        let channels = vec![channel("A", Storage::Half, FRAME, alpha), channel("R", Storage::Half, FRAME, |_, _| 0.5)];
        pictures.push(plate(FRAME, FRAME, channels));
    }
    for (index, picture) in pictures.iter().enumerate() {
        let (moved, report) = warped(picture, vec![layer("all", folded(), None)], &WarpSettings::default());
        let off: Vec<_> = samples(&moved, "R").iter().enumerate().collect();
        // The borders that the warp stretches are soft.
        let off: Vec<_> =
            off.into_iter().filter(|(at, light)| (1..23).contains(&(at % 24)) && (*light - 0.5).abs() > 1e-3).collect();
        assert!(off.is_empty(), "{index}: {off:?}");
        assert!(report.folded_pixels > 80 && report.warnings.len() == 1, "{index}: {:?}", report.warnings);
    }
}

#[test]
fn light_without_alpha_in_a_fold_is_added_to_what_lies_behind() {
    // The right part glows: it lies in front of the thing on the left, and does not hide it.
    let picture = plate(
        FRAME,
        FRAME,
        vec![
            channel("A", Storage::Half, FRAME, |x, _| f32::from(u8::from(x < 10))),
            channel("R", Storage::Half, FRAME, |x, _| if x < 10 { 1.0 } else { 4.0 }),
        ],
    );
    let moved = warped(&picture, vec![layer("all", folded(), None)], &WarpSettings::default()).0;
    assert!((at(&moved, "R", 10, 8) - 5.0).abs() < 1e-2 && (at(&moved, "A", 10, 8) - 1.0).abs() < 1e-3);
}

#[test]
fn a_map_shows_the_part_of_a_fold_that_can_be_seen() {
    let frame = FrameSize::new(24, 16);
    let coverage = |[x, _]: [i32; 2]| f32::from(u8::from((0..10).contains(&x)));
    let plain = WarpMap::backward(&folded(), frame, FRAME);
    let showing = WarpMap::backward_showing(&folded(), FrameWindow { frame, window: FRAME }, coverage);
    let source = |map: &WarpMap| map.source(10, 8).expect("it comes from somewhere")[0];
    assert!(source(&plain) > 16.0, "nothing lies in front: {}", source(&plain));
    assert!((source(&showing) - 5.25).abs() < 0.01, "{}", source(&showing));
    assert!(!showing.folded_pixels.is_empty() && showing.folded_pixels.len() <= plain.folded_pixels.len());
    let nothing = WarpMap::backward_showing(&folded(), FrameWindow { frame, window: FRAME }, |_| 0.0);
    assert_eq!((nothing.folded_pixels.len(), nothing.offsets == plain.offsets), (0, true));
}
