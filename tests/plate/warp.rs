//! Warped plates: real files moved by nothing and by whole pixels, windows, layers, holes.

use super::assets::asset;
use super::support::{layer, shift, warped};
use pinwarp::image::{Plate, read_plate};
use pinwarp::plate::{Field, WarpSettings};
use pinwarp::space::PixelRect;

/// Name, data window, and the names and sample bits of the channels.
type PartBits = (Option<String>, PixelRect, Vec<(String, Vec<u32>)>);

/// Bits of every sample of every channel, by part and name.
fn bits(plate: &Plate) -> Vec<PartBits> {
    let of_part = |part: &pinwarp::image::PlatePart| {
        let channels = part
            .channels
            .iter()
            .map(|channel| (channel.name.clone(), channel.samples.iter().map(|sample| sample.to_bits()).collect()));
        (part.name.clone(), part.data_window, channels.collect())
    };
    plate.parts.iter().map(of_part).collect()
}

fn beachballs() -> Vec<Plate> {
    let names = ["multipart.0001.exr", "singlepart.0001.exr"];
    let path = |name: &str| asset(&format!("openexr-images/Beachball/{name}"));
    names.iter().filter_map(|name| path(name)).map(|path| read_plate(&path).expect("it is sound")).collect()
}

#[test]
fn an_identity_map_changes_nothing() {
    let settings = WarpSettings::default();
    for ball in beachballs() {
        for field in [Field::identity(), shift(0, 0, 1556)] {
            let (still, _) = warped(&ball, vec![layer("all", field, None)], &settings);
            assert!(bits(&still) == bits(&ball));
            assert_eq!(still.display, ball.display);
        }
    }
}

#[test]
fn a_shift_by_whole_pixels_copies_every_channel() {
    let settings = WarpSettings::default();
    for (index, ball) in beachballs().into_iter().enumerate() {
        let (moved, _) = warped(&ball, vec![layer("all", shift(37, -21, 1556), None)], &settings);
        let mut expected = bits(&ball);
        for (_, window, _) in &mut expected {
            (window.x, window.y) = (window.x + 37, window.y - 21);
        }
        for (moved, expected) in bits(&moved).iter().zip(&expected) {
            assert_eq!(moved.0, expected.0);
            assert_eq!(moved.1, expected.1);
            for (moved, expected) in moved.2.iter().zip(&expected.2) {
                let differing = moved.1.iter().zip(&expected.1).filter(|(a, b)| a != b).count();
                assert_eq!((&moved.0, differing), (&expected.0, 0));
            }
        }
        if index == 0 {
            let (other, _) = warped(&ball, vec![layer("all", shift(36, -21, 1556), None)], &settings);
            assert!(bits(&other) != bits(&moved), "the comparison can fail");
        }
    }
}
