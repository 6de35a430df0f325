//! What fills holes is stored as the plate stores it: ids as bits or numbers, motion in the plate's units and signs.

use super::support::{channel, layer, plate, samples, shift};
use pinwarp::image::{Channel, Frame, FrameMetadata, Plate, Storage};
use pinwarp::plate::{Field, LayerJob, Matte, MotionEncoding, PlateJob, PlateReport, WarpSettings, warp_plate};
use pinwarp::space::PixelRect;

const FRAME: PixelRect = PixelRect { x: 0, y: 0, width: 24, height: 16 };

/// A place that the thing leaves, and nothing covers.
const HOLE: usize = 8 * 24 + 8;

fn even(name: &str, storage: Storage, value: f32) -> Channel {
    channel(name, storage, FRAME, move |_, _| value)
}

/// A plate with a thing in columns 5 to 12.
fn room(mut channels: Vec<Channel>) -> Plate {
    let is_thing = |x: u32, _| f32::from(u8::from((5..13).contains(&x)));
    channels.push(channel("mask.A", Storage::Half, FRAME, is_thing));
    plate(FRAME, FRAME, channels)
}

/// As the scene would be drawn.
fn drawn(channels: Vec<Channel>) -> Plate {
    let frame = Frame { display: FRAME, data_window: FRAME, pixel_aspect: 1.0, channels };
    Plate::from_render(frame, &FrameMetadata::default())
}

/// The thing moves 9 to the right, and something fills what it leaves.
fn filled(plate: &Plate, fill: &Plate, motion: Option<[f64; 2]>) -> (Plate, PlateReport) {
    let thing = layer("thing", shift(9, 0, 16), Some(Matte::Channel("mask.A".into())));
    filled_by(plate, fill, (vec![thing], motion))
}

fn filled_by(plate: &Plate, fill: &Plate, (layers, motion): (Vec<LayerJob>, Option<[f64; 2]>)) -> (Plate, PlateReport) {
    let motion = motion.map(|pixels_per_unit| MotionEncoding { pixels_per_unit });
    let settings = WarpSettings { motion, ..WarpSettings::default() };
    warp_plate(plate, &PlateJob { layers, settings: &settings, fill: Some(fill) }).expect("the matte is there")
}

#[test]
fn ids_are_converted_between_bits_and_numbers() {
    let bits = |id: u32| room(vec![even("id.object", Storage::Uint, f32::from_bits(id))]);
    let numbers = |id: f32| room(vec![even("id.object", Storage::Float, id)]);
    let found = |plate: &Plate, fill: &Plate| samples(&filled(plate, fill, None).0, "id.object")[HOLE];
    assert_eq!(found(&bits(7), &drawn(vec![even("id.object", Storage::Float, 5.0)])).to_bits(), 5);
    assert_eq!(found(&numbers(7.0), &bits(5)), 5.0);
    assert_eq!(found(&bits(7), &bits(5)).to_bits(), 5);
    assert_eq!(found(&numbers(7.0), &numbers(5.0)), 5.0);
    assert_eq!(found(&numbers(7.0), &bits(20_000_001)), 0.0, "a float would take it for another thing");
}

#[test]
fn our_vectors_take_the_units_and_signs_of_the_plate() {
    let pair = |names: [&str; 2], [u, v]: [f32; 2]| {
        names.into_iter().zip([u, v]).map(|(name, value)| even(name, Storage::Float, value)).collect::<Vec<_>>()
    };
    let mut ours = pair(["forward.u", "forward.v"], [3.0, 1.0]);
    ours.extend(pair(["backward.u", "backward.v"], [-2.0, 4.0]));
    let ours = drawn(ours);
    let of_frame = room(pair(["forward.u", "forward.v"], [0.0, 0.0]));
    let (moved, report) = filled(&of_frame, &ours, Some([24.0, -16.0]));
    let found = ["forward.u", "forward.v"].map(|name| samples(&moved, name)[HOLE]);
    assert!((found[0] - 3.0 / 24.0).abs() < 1e-6 && (found[1] + 1.0 / 16.0).abs() < 1e-6, "{found:?}");
    assert_eq!(report.warnings, ["the fill plate has no mask.A: holes in these channels stay empty"]);
    let mut blenders = pair(["Vector.X", "Vector.Y"], [0.0, 0.0]);
    blenders.extend(pair(["Vector.Z", "Vector.W"], [0.0, 0.0]));
    let moved = filled(&room(blenders), &ours, None).0;
    let found = ["Vector.X", "Vector.Y", "Vector.Z", "Vector.W"].map(|name| samples(&moved, name)[HOLE]);
    assert_eq!(found, [-2.0, 4.0, -3.0, -1.0]);
}

#[test]
fn vectors_behind_are_carried_by_what_bends_the_whole() {
    let vectors = || vec![even("forward.u", Storage::Float, 3.0), even("forward.v", Storage::Float, 0.0)];
    let thing = layer("thing", shift(9, 0, 16), Some(Matte::Channel("mask.A".into())));
    let whole = LayerJob { next: Some(shift(0, 4, 16)), ..layer("whole", Field::identity(), None) };
    let (moved, _) = filled_by(&room(vectors()), &drawn(vectors()), (vec![thing, whole], Some([1.0, 1.0])));
    let found = ["forward.u", "forward.v"].map(|name| samples(&moved, name)[HOLE]);
    assert!((found[0] - 3.0).abs() < 1e-4 && (found[1] + 4.0).abs() < 1e-4, "four pixels down: {found:?}");
}

#[test]
fn vectors_of_unknown_make_are_filled_by_their_like_only() {
    let vectors = |u: f32| vec![even("forward.u", Storage::Float, u), even("forward.v", Storage::Float, 0.0)];
    let of_ours = filled(&room(vectors(5.0)), &drawn(vectors(3.0)), None);
    assert_eq!(samples(&of_ours.0, "forward.u")[HOLE], 0.0);
    assert!(of_ours.1.warnings.iter().any(|warning| warning.contains("holes stay empty")), "{:?}", of_ours.1.warnings);
    let clean = filled(&room(vectors(5.0)), &room(vectors(3.0)), None).0;
    assert_eq!(samples(&clean, "forward.u")[HOLE], 3.0, "a clean plate stores them as the plate does");
}

#[test]
fn edges_that_show_the_background_too_are_split_by_the_clean_plate() {
    const BEHIND: [f32; 2] = [0.2, 0.6];
    const THING: [f32; 2] = [0.9, 0.1];
    // Columns 5 and 12 show a quarter and three quarters of the thing.
    let coverage = |x: u32| match x {
        5 => 0.25,
        6..12 => 1.0,
        12 => 0.75,
        _ => 0.0_f32,
    };
    let mixed = |index: usize, left: u32| {
        move |x: u32, _: u32| {
            let covered = if x < left { 0.0 } else { coverage(x - left) };
            covered * THING[index] + (1.0 - covered) * BEHIND[index]
        }
    };
    let colors = |left: u32| {
        let color = |(index, name)| channel(name, Storage::Float, FRAME, mixed(index, left));
        ["R", "G"].into_iter().enumerate().map(color).collect::<Vec<_>>()
    };
    let mut channels = colors(0);
    channels.push(channel("mask.A", Storage::Float, FRAME, move |x, _| coverage(x)));
    let whole = plate(FRAME, FRAME, channels);
    let clean = plate(
        FRAME,
        FRAME,
        ["R", "G"].into_iter().zip(BEHIND).map(|(name, value)| even(name, Storage::Float, value)).collect(),
    );
    for by in [0, 3, 9] {
        let thing = layer("thing", shift(by, 0, 16), Some(Matte::Channel("mask.A".into())));
        let (moved, _) = filled_by(&whole, &clean, (vec![thing], None));
        let wanted = plate(FRAME, FRAME, colors(by as u32));
        for name in ["R", "G"] {
            let [found, wanted] = [&moved, &wanted].map(|plate| samples(plate, name));
            let worst = found.iter().zip(wanted.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 1e-4, "{name}, moved by {by}: {worst}");
        }
    }
}
