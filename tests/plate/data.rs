//! Channels that must not be blended: Cryptomatte, motion, normals.

use super::map::random;
use super::support::{channel, layer, plate, samples, shift, warped, window};
use pinwarp::image::cryptomatte::{Manifest, MatteHeader, MatteId};
use pinwarp::image::{Channel, Compression, Frame, FrameMetadata, Plate, Storage, read_plate, write_exr};
use pinwarp::lattice::{Basis, Grid};
use pinwarp::plate::{
    Field, Filter, LayerJob, Matte, MotionEncoding, NormalMode, PlateJob, WarpMap, WarpSettings, footprint_taps,
    remap_plate, undo_plate, warp_plate,
};
use pinwarp::space::{FrameSize, ImagePoint, PixelRect};
use std::collections::BTreeMap;

const FRAME: PixelRect = PixelRect { x: 0, y: 0, width: 32, height: 24 };
const SIZE: FrameSize = FrameSize::new(32, 24);
const NAMES: [&str; 3] = ["ball", "box", "wall"];

/// Turned about the middle of the frame, grown, and bent: no sample lands on a sample.
fn bent() -> Field {
    let mut lattice =
        Grid { dims: [5, 5], basis: Basis::Bspline, lo: [-0.6, -0.5], hi: [2.0, 1.5], angle: 0.0 }.at_rest();
    for handle in &mut lattice.handles {
        let [x, y] = [handle[0] - 0.66, handle[1] - 0.5];
        let (sin, cos) = 0.35_f64.sin_cos();
        *handle = [0.66 + 0.9 * (cos * x - sin * y) + 0.03 * (9.0 * y).sin(), 0.5 + 0.9 * (sin * x + cos * y)];
    }
    Field::of_layer(lattice)
}

/// Coverage of the three names at a pixel; sums to 1.
fn coverage(x: u32, y: u32) -> [f32; 3] {
    let ball = (1.5 - 0.15 * ((x as f32 - 12.0).powi(2) + (y as f32 - 11.0).powi(2)).sqrt()).clamp(0.0, 1.0);
    let side = (0.5 + 0.4 * (x as f32 - 20.3)).clamp(0.0, 1.0) * (1.0 - ball);
    [ball, side, 1.0 - ball - side]
}

/// Its first three ranks, and a beauty with full alpha.
fn matted() -> Plate {
    let ranked = |x: u32, y: u32| {
        let mut shares: Vec<(f32, MatteId)> =
            coverage(x, y).into_iter().zip(NAMES.map(MatteId::of_name)).filter(|(share, _)| *share > 0.0).collect();
        shares.sort_by(|a, b| b.0.total_cmp(&a.0));
        shares
    };
    let id = move |rank: usize, x, y| ranked(x, y).get(rank).map_or(0.0, |(_, id)| id.sample());
    let share = move |rank: usize, x, y| ranked(x, y).get(rank).map_or(0.0, |(share, _)| *share);
    let mut channels: Vec<Channel> = Vec::new();
    for (rank, [first, second]) in [["00.R", "00.G"], ["00.B", "00.A"], ["01.R", "01.G"]].into_iter().enumerate() {
        channels.push(channel(&format!("CryptoObject{first}"), Storage::Float, FRAME, |x, y| id(rank, x, y)));
        channels.push(channel(&format!("CryptoObject{second}"), Storage::Float, FRAME, |x, y| share(rank, x, y)));
    }
    channels.push(channel("A", Storage::Half, FRAME, |_, _| 1.0));
    let mut plate = plate(FRAME, FRAME, channels);
    let header = MatteHeader { name: "CryptoObject".into(), manifest: Manifest::of_names(NAMES), side_file: None };
    for (name, text) in header.attributes() {
        plate.parts[0].set_text(&name, &text);
    }
    plate
}

/// Ids and coverage of a pixel, by id.
fn at(plate: &Plate, pixel: usize) -> BTreeMap<u32, f32> {
    let pairs = [["00.R", "00.G"], ["00.B", "00.A"], ["01.R", "01.G"]];
    let rank = |[id, share]: [&str; 2]| {
        let sample = |suffix: &str| samples(plate, &format!("CryptoObject{suffix}"))[pixel];
        (sample(id).to_bits(), sample(share))
    };
    pairs.into_iter().map(rank).filter(|(_, share)| *share > 0.0).collect()
}

#[test]
fn coverage_is_what_the_footprint_sees() {
    let source = matted();
    let (moved, report) = warped(&source, vec![layer("all", bent(), None)], &WarpSettings::default());
    assert!(report.warnings.is_empty(), "{:?}", report.warnings);
    let map = WarpMap::backward(&bent(), SIZE, FRAME);
    let mut taps = Vec::new();
    let mut mixed = 0;
    for pixel in 0..FRAME.area() {
        footprint_taps(&map, pixel, FRAME, &mut taps);
        let mut expected: BTreeMap<u32, f32> = BTreeMap::new();
        for &(index, weight) in &taps {
            let (x, y) = (index as u32 % FRAME.width, index as u32 / FRAME.width);
            for (share, name) in coverage(x, y).into_iter().zip(NAMES).filter(|(share, _)| *share > 0.0) {
                *expected.entry(MatteId::of_name(name).sample().to_bits()).or_default() += share * weight;
            }
        }
        let found = at(&moved, pixel);
        assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>(), "{pixel}");
        for (id, share) in &expected {
            assert!((found[id] - share).abs() < 1e-5, "{pixel}: {} {share}", found[id]);
        }
        assert!(found.values().sum::<f32>() <= 1.0 + 1e-6);
        let ranks: Vec<f32> = ["00.G", "00.A", "01.G"]
            .iter()
            .map(|suffix| samples(&moved, &format!("CryptoObject{suffix}"))[pixel])
            .collect();
        assert!(ranks.is_sorted_by(|a, b| a >= b), "{ranks:?}");
        mixed += usize::from(found.len() > 1);
    }
    assert!(mixed > 100, "there is something to mix: {mixed}");
    assert_eq!(moved.parts[0].texts("cryptomatte/"), source.parts[0].texts("cryptomatte/"));
}

#[test]
fn a_layer_picked_by_cryptomatte_takes_its_ids_and_leaves_the_others() {
    let pick = |names: &[&str]| Matte::Cryptomatte {
        layer: Some("CryptoObject".into()),
        names: names.iter().map(|&name| name.to_owned()).collect(),
    };
    let id = |name: &str| MatteId::of_name(name).sample().to_bits();
    let still =
        warped(&matted(), vec![layer("ball", Field::identity(), Some(pick(&["ba*"])))], &WarpSettings::default()).0;
    let (moved, report) =
        warped(&matted(), vec![layer("ball", shift(6, 0, 24), Some(pick(&["ball"])))], &WarpSettings::default());
    assert!(report.uncovered_pixels > 0);
    for pixel in 0..FRAME.area() {
        let (x, y) = (pixel as u32 % FRAME.width, pixel as u32 / FRAME.width);
        let before = at(&matted(), pixel);
        for (id, share) in at(&still, pixel) {
            assert!((before[&id] - share).abs() < 1e-6, "{pixel}");
        }
        let after = at(&moved, pixel);
        let came = if x >= 6 { coverage(x - 6, y)[0] } else { 0.0 };
        assert!((after.get(&id("ball")).copied().unwrap_or(0.0) - came).abs() < 1e-5, "{pixel}");
        let stayed = after.get(&id("wall")).copied().unwrap_or(0.0);
        assert!(stayed <= coverage(x, y)[2] + 1e-6, "{pixel}");
    }
}

/// Makes everything in a plate of ranks as transparent as a round window with a soft edge.
fn windowed(mut plate: Plate) -> Plate {
    let opening = |x: f32, y: f32| (4.0 - 0.4 * (x - 18.0).hypot(y - 14.0)).clamp(0.0, 1.0);
    for channel in &mut plate.parts[0].channels {
        if channel.name.ends_with(['G', 'A']) {
            for (pixel, sample) in channel.samples.iter_mut().enumerate() {
                let (x, y) = (pixel as u32 % FRAME.width, pixel as u32 / FRAME.width);
                *sample *= opening(x as f32, y as f32);
            }
        }
    }
    plate
}

#[test]
fn coverages_add_up_to_the_filtered_alpha() {
    let ball = || Some(Matte::Cryptomatte { layer: Some("CryptoObject".into()), names: vec!["ball".into()] });
    let opaque_without_alpha = || {
        let mut plate = matted();
        plate.parts[0].channels.retain(|channel| channel.name != "A");
        plate
    };
    let cases: [(&str, Plate, Option<Matte>); 4] = [
        ("a whole picture", windowed(matted()), None),
        ("a thing of an opaque picture", matted(), ball()),
        ("a thing of a picture with soft edges", windowed(matted()), ball()),
        ("a picture without alpha", opaque_without_alpha(), ball()),
    ];
    for filter in [Filter::Ewa, Filter::Cubic, Filter::Lanczos] {
        let settings = WarpSettings { filter, ..WarpSettings::default() };
        for (name, source, matte) in &cases {
            let (moved, _) = warped(source, vec![layer("all", bent(), matte.clone())], &settings);
            let has_alpha = moved.parts[0].channels.iter().any(|channel| channel.name == "A");
            let sum = |pixel: usize| at(&moved, pixel).values().sum::<f32>();
            let mut between = 0;
            for pixel in (0..FRAME.area()).filter(|_| has_alpha) {
                let alpha = samples(&moved, "A")[pixel].clamp(0.0, 1.0);
                // The other filters reach a little farther than the samples whose ids are known.
                let tolerance = if filter != Filter::Ewa && sum(pixel) == 0.0 { 0.05 } else { 1e-3 };
                assert!((sum(pixel) - alpha).abs() < tolerance, "{name}, {filter:?}, {pixel}: {} {alpha}", sum(pixel));
                between += usize::from(alpha > 0.05 && alpha < 0.95);
            }
            if !has_alpha {
                let with = warped(&matted(), vec![layer("all", bent(), matte.clone())], &settings).0;
                let differs = |&pixel: &usize| (sum(pixel) - samples(&with, "A")[pixel].clamp(0.0, 1.0)).abs() > 1e-3;
                assert_eq!((0..FRAME.area()).find(differs), None, "{name}, {filter:?}");
                continue;
            }
            assert!(between > 20, "{name}, {filter:?}: there are soft edges: {between}");
        }
    }
}

#[test]
fn coverages_of_a_filled_hole_add_up_too() {
    let ball = Matte::Cryptomatte { layer: Some("CryptoObject".into()), names: vec!["ball".into()] };
    let mut clean = matted();
    for channel in &mut clean.parts[0].channels {
        let value = match channel.name.as_str() {
            "CryptoObject00.R" => MatteId::of_name("wall").sample(),
            "CryptoObject00.G" | "A" => 1.0,
            _ => 0.0,
        };
        channel.samples.fill(value);
    }
    for filter in [Filter::Ewa, Filter::Cubic] {
        let settings = WarpSettings { filter, ..WarpSettings::default() };
        let layers = vec![layer("ball", bent(), Some(ball.clone()))];
        let job = PlateJob { layers, settings: &settings, fill: Some(&clean) };
        let (moved, _) = warp_plate(&matted(), &job).expect("warped");
        for pixel in 0..FRAME.area() {
            let (sum, alpha) = (at(&moved, pixel).values().sum::<f32>(), samples(&moved, "A")[pixel].clamp(0.0, 1.0));
            assert!((sum - alpha).abs() < 1e-3, "{filter:?}, {pixel}: {sum} {alpha}");
        }
    }
}

/// The fields of a layer that turns a little more each frame.
fn turning(degrees: f64) -> Field {
    let mut lattice =
        Grid { dims: [4, 4], basis: Basis::Bspline, lo: [-2.0, -2.0], hi: [3.0, 3.0], angle: 0.0 }.at_rest();
    let (sin, cos) = degrees.to_radians().sin_cos();
    for handle in &mut lattice.handles {
        let [x, y] = [handle[0] - 0.5, handle[1] - 0.5];
        *handle = [0.5 + cos * x - sin * y, 0.5 + sin * x + cos * y];
    }
    Field::of_layer(lattice)
}

const SQUARE: PixelRect = PixelRect { x: 0, y: 0, width: 40, height: 40 };

fn moving(names: [&str; 2], u: f32, v: f32) -> Plate {
    let make = |name: &str, value: f32| channel(name, Storage::Float, SQUARE, move |_, _| value);
    plate(SQUARE, SQUARE, vec![make(names[0], u), make(names[1], v)])
}

fn quarter_turn() -> LayerJob {
    LayerJob { previous: Some(turning(0.0)), next: Some(turning(90.0)), ..layer("all", turning(90.0), None) }
}

/// In the middle: what the vector at the centre of the frame has become.
fn middle(plate: &Plate, name: &str) -> f32 {
    samples(plate, name)[20 * 40 + 20]
}

#[test]
fn motion_turns_with_the_picture() {
    let settings =
        |pixels_per_unit| WarpSettings { motion: Some(MotionEncoding { pixels_per_unit }), ..WarpSettings::default() };
    // Three pixels to the right become three pixels up, and so do they where they are stored otherwise.
    for (unit, u, expected) in [([1.0, 1.0], 3.0, [0.0, 3.0]), ([40.0, -40.0], 3.0 / 40.0, [0.0, -3.0 / 40.0])] {
        let plate = moving(["forward.u", "forward.v"], u, 0.0);
        let (moved, report) = warped(&plate, vec![quarter_turn()], &settings(unit));
        assert!(report.warnings.is_empty(), "{:?}", report.warnings);
        let found = [middle(&moved, "forward.u"), middle(&moved, "forward.v")];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?}");
    }
    // Backward: the frame before was not turned. The centre of pixel (20, 20) comes from that of (20, 19) or (19, 20).
    let (moved, _) =
        warped(&moving(["backward.u", "backward.v"], 0.0, 0.0), vec![quarter_turn()], &settings([1.0, 1.0]));
    let found = [middle(&moved, "backward.u"), middle(&moved, "backward.v")];
    assert!(
        (found[0].abs() - 1.0).abs() < 1e-3 && found[1].abs() < 1e-3
            || found[0].abs() < 1e-3 && (found[1].abs() - 1.0).abs() < 1e-3,
        "{found:?}"
    );
}

#[test]
fn vectors_follow_fields_to_a_thousandth_of_a_pixel() {
    let window = PixelRect { x: -8, y: 5, width: 150, height: 80 };
    let size = FrameSize::new(160, 90);
    let u = |x: u32, y: u32| 9.0 * (0.07 * x as f32 + 0.05 * y as f32).sin();
    let v = |x: u32, y: u32| 6.0 * (0.06 * x as f32 - 0.04 * y as f32).cos();
    let make = |name: &str, value: &dyn Fn(u32, u32) -> f32| channel(name, Storage::Float, window, value);
    // P.X tells which pixel of the plate a pixel of the result shows.
    let index = |x: u32, y: u32| (x + y * window.width) as f32;
    let channels = vec![make("P.X", &index), make("forward.u", &u), make("forward.v", &v)];
    let plate = plate(size.window(), window, channels);
    let [now, next] = [7, 8].map(|seed| Field::of_picture(random(Basis::Bspline, 0.3, seed)));
    let job = LayerJob { next: Some(next.clone()), ..layer("all", now.clone(), None) };
    let settings =
        WarpSettings { motion: Some(MotionEncoding { pixels_per_unit: [1.0; 2] }), ..WarpSettings::default() };
    let (moved, _) = warped(&plate, vec![job], &settings);
    let [shown, us, vs] = ["P.X", "forward.u", "forward.v"].map(|name| samples(&moved, name));
    let goes = |field: &Field, at: [f64; 2]| {
        let at = size.screen_from_image(ImagePoint::new(at[0], at[1]));
        size.image_from_screen(field.carry(at)).0
    };
    let (mut worst, mut most): (f64, f64) = (0.0, 0.0);
    for (pixel, &index) in shown.iter().enumerate() {
        let [column, row] = [index as u32 % window.width, index as u32 / window.width];
        let at = [f64::from(window.x) + f64::from(column) + 0.5, f64::from(window.y) + f64::from(row) + 0.5];
        let stored = [u(column, row), v(column, row)].map(f64::from);
        if us[pixel] == 0.0 && vs[pixel] == 0.0 {
            continue;
        }
        let wanted = goes(&next, [at[0] + stored[0], at[1] - stored[1]]) - goes(&now, at);
        worst = worst.max((wanted.x - f64::from(us[pixel])).hypot(-wanted.y - f64::from(vs[pixel])));
        most = most.max((wanted.x - stored[0]).hypot(-wanted.y - stored[1]));
    }
    assert!(worst < 1e-3 && most > 2.0, "{worst} of {most} pixels");
}

#[test]
fn an_undone_warp_gives_the_vectors_back() {
    let size = FrameSize::new(160, 90);
    let make = |name: &str, value: f32| channel(name, Storage::Float, size.window(), move |_, _| value);
    let plate = plate(size.window(), size.window(), vec![make("forward.u", 5.0), make("forward.v", -2.0)]);
    let [now, next] = [7, 8].map(|seed| Field::of_picture(random(Basis::Bspline, 0.3, seed)));
    let job = LayerJob { next: Some(next), ..layer("all", now, None) };
    let settings =
        WarpSettings { motion: Some(MotionEncoding { pixels_per_unit: [1.0; 2] }), ..WarpSettings::default() };
    let moved = warped(&plate, vec![job.clone()], &settings).0;
    let job = PlateJob { layers: vec![job], settings: &settings, fill: None };
    let (back, report) = undo_plate(&moved, &job, size.window()).expect("the map is of this frame");
    assert!(report.warnings.is_empty(), "{:?}", report.warnings);
    let misses = |plate: &Plate| {
        let [us, vs] = ["forward.u", "forward.v"].map(|name| samples(plate, name));
        let inner = (24..66).flat_map(|y| (45..108).map(move |x| y * 160 + x));
        let mut misses: Vec<f32> = inner.map(|at| (us[at] - 5.0).hypot(vs[at] + 2.0)).collect();
        misses.sort_by(f32::total_cmp);
        misses[misses.len() / 2]
    };
    // The nearest sample is up to half a pixel beside, where the field is a little another.
    assert!(misses(&back) < 0.25 && misses(&moved) > 4.0 * misses(&back), "{} after {}", misses(&back), misses(&moved));
}

#[test]
fn blenders_vectors_are_known() {
    let plate = {
        let make = |name: &str, value: f32| channel(name, Storage::Float, SQUARE, move |_, _| value);
        let names = [("Vector.W", 0.0), ("Vector.X", 2.0), ("Vector.Y", 0.0), ("Vector.Z", -3.0)];
        plate(SQUARE, SQUARE, names.map(|(name, value)| make(name, value)).to_vec())
    };
    let still = LayerJob { previous: Some(turning(90.0)), ..quarter_turn() };
    let moved = warped(&plate, vec![still], &WarpSettings::default()).0;
    // Z and W are this place less the next: three to the right are stored as -3, and become three up, stored as -3.
    let found = ["Vector.X", "Vector.Y", "Vector.Z", "Vector.W"].map(|name| middle(&moved, name));
    assert!(found.iter().zip([0.0, 2.0, 0.0, -3.0]).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?}");
}

#[test]
fn a_motion_rule_that_is_stated_is_the_whole_truth() {
    // Named as Blender names them, and stored as the shot says: Z and W lead to the next frame, in sixteenths, y down.
    let plate = moving(["Vector.Z", "Vector.W"], 48.0, 0.0);
    let settings =
        WarpSettings { motion: Some(MotionEncoding { pixels_per_unit: [0.0625, -0.0625] }), ..WarpSettings::default() };
    let moved = warped(&plate, vec![quarter_turn()], &settings).0;
    let found = [middle(&moved, "Vector.Z"), middle(&moved, "Vector.W")];
    assert!(found.iter().zip([0.0, -48.0]).all(|(a, b)| (a - b).abs() < 2e-3), "{found:?}");
    // Four pixels to the right by the next frame: added as the shot says, taken off as Blender's own files would have it.
    let slid = LayerJob { next: Some(shift(4, 0, 40)), ..layer("all", Field::identity(), None) };
    let slides = |settings: &WarpSettings| middle(&warped(&plate, vec![slid.clone()], settings).0, "Vector.Z");
    assert!((slides(&settings) - (48.0 + 4.0 * 16.0)).abs() < 2e-2, "{}", slides(&settings));
    assert!((slides(&WarpSettings::default()) - (48.0 - 4.0)).abs() < 2e-2, "{}", slides(&WarpSettings::default()));
}

#[test]
fn vectors_of_unknown_make_pass_with_a_word() {
    let plate = moving(["forward.u", "forward.v"], 3.0, 0.0);
    let (moved, report) = warped(&plate, vec![quarter_turn()], &WarpSettings::default());
    assert_eq!((middle(&moved, "forward.u"), middle(&moved, "forward.v")), (3.0, 0.0));
    assert!(report.warnings.iter().any(|warning| warning.contains("forward.u")), "{:?}", report.warnings);
    let map = WarpMap::backward(&turning(90.0), FrameSize::new(40, 40), SQUARE);
    let settings =
        WarpSettings { motion: Some(MotionEncoding { pixels_per_unit: [1.0; 2] }), ..WarpSettings::default() };
    let (moved, report) = remap_plate(&plate, &map, &settings).expect("the map is of this frame");
    assert_eq!(middle(&moved, "forward.u"), 3.0);
    assert!(report.warnings.iter().any(|warning| warning.contains("map")), "{:?}", report.warnings);
    let wrong = WarpMap::identity(FrameSize::new(20, 40), window(0, 0, 20, 40));
    assert!(remap_plate(&plate, &wrong, &settings).is_err());
}

#[test]
fn normals_stay_or_turn() {
    let make = |name: &str, value: f32| channel(name, Storage::Float, SQUARE, move |_, _| value);
    let plate = plate(SQUARE, SQUARE, vec![make("N.X", 0.6), make("N.Y", 0.0), make("N.Z", 0.8)]);
    let moved = |normals| {
        let settings = WarpSettings { normals, ..WarpSettings::default() };
        let moved = warped(&plate, vec![layer("all", turning(30.0), None)], &settings).0;
        ["N.X", "N.Y", "N.Z"].map(|name| middle(&moved, name))
    };
    assert_eq!(moved(NormalMode::Keep), [0.6, 0.0, 0.8]);
    let (sin, cos) = 30.0_f32.to_radians().sin_cos();
    let turned = moved(NormalMode::Rotate);
    assert!(turned.iter().zip([0.6 * cos, 0.6 * sin, 0.8]).all(|(a, b)| (a - b).abs() < 1e-4), "{turned:?}");
}

#[test]
fn vectors_and_normals_of_our_own_renders_are_known() {
    let folder = tempfile::tempdir().expect("a folder");
    let make = |name: &str, value: f32| channel(name, Storage::Float, SQUARE, move |_, _| value);
    let channels = vec![make("N.X", 0.6), make("N.Y", 0.0), make("forward.u", 3.0), make("forward.v", 0.0)];
    let frame = Frame { display: SQUARE, data_window: SQUARE, pixel_aspect: 1.0, channels };
    let path = folder.path().join("own.exr");
    write_exr(&path, &frame, &FrameMetadata::default(), Compression::Zip).expect("the folder is there");
    let own = read_plate(&path).expect("just written");
    let settings = WarpSettings { normals: NormalMode::Rotate, ..WarpSettings::default() };
    let (moved, report) = warped(&own, vec![quarter_turn()], &settings);
    assert!((middle(&moved, "forward.v") - 3.0).abs() < 1e-4);
    assert_eq!(middle(&moved, "N.X"), 0.6);
    assert!(report.warnings.iter().any(|warning| warning.contains("scene space")), "{:?}", report.warnings);
}
