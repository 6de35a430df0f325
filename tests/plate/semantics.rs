//! What channels are taken for, by the names that programs write.

use super::support::{channel, plate, warped, window};
use pinwarp::image::{Plate, PlatePart, Storage};
use pinwarp::plate::Semantic::{Alpha, Backward, Color, Cryptomatte, Data, Depth, Forward, Id, Normal};
use pinwarp::plate::{PlateReport, Semantic, SemanticReason, WarpSettings};
use pinwarp::space::PixelRect;

const PIXEL: PixelRect = PixelRect { x: 0, y: 0, width: 1, height: 1 };

/// What a plate of one pixel with these channels is taken for.
fn report(channels: &[&str], storage: Storage, settings: &WarpSettings) -> PlateReport {
    let channels = channels.iter().map(|name| channel(name, storage, PIXEL, |_, _| 0.0)).collect();
    warped(&plate(PIXEL, PIXEL, channels), Vec::new(), settings).1
}

fn semantics(channels: &[&str], storage: Storage) -> Vec<Semantic> {
    report(channels, storage, &WarpSettings::default()).channels.iter().map(|channel| channel.semantic).collect()
}

#[test]
fn names_of_renderers_are_understood() {
    let cases: &[(&[&str], &[Semantic])] = &[
        (&["R", "G", "B", "A", "Z", "ZBack"], &[Color, Color, Color, Alpha, Depth, Depth]),
        (&["left.R", "left.A", "left.Z", "depth.Z"], &[Color, Alpha, Depth, Depth]),
        (&["forward.u", "forward.left.v", "backward.u"], &[Forward, Forward, Backward]),
        (
            &["ViewLayer.Combined.R", "ViewLayer.Combined.A", "ViewLayer.Depth.Z", "ViewLayer.Depth.V"],
            &[Color, Alpha, Depth, Depth],
        ),
        (
            &["ViewLayer.Vector.X", "ViewLayer.Vector.Y", "ViewLayer.Vector.Z", "ViewLayer.Vector.W"],
            &[Backward, Backward, Forward, Forward],
        ),
        (&["ViewLayer.Normal.X", "ViewLayer.Normal.Z", "N.X", "N.Z", "NX"], &[Normal; 5]),
        (&["ViewLayer.IndexOB.X", "ViewLayer.IndexMA.V", "id.object", "id"], &[Id; 4]),
        (&["ViewLayer.UV.U", "P.X", "P.Z", "Pref.B", "ViewLayer.Position.Y"], &[Data; 5]),
        (&["motionvector.R", "motionvector.G", "motionvector.B"], &[Forward, Forward, Data]),
        (&["diffuse_direct.R", "specular.G", "ViewLayer.DiffCol.B", "AO.V", "Shadow Catcher.G"], &[Color; 5]),
        (&["world_normal.R", "Nworld.X", "world_position.R"], &[Normal, Normal, Data]),
        (&["CryptoObject00.R", "CryptoObject00.G", "ViewLayer.CryptoAsset01.b"], &[Cryptomatte, Cryptomatte, Data]),
        (&["CryptoObject.R", "whitebarmask.mask", "disparityL.x"], &[Color, Color, Data]),
    ];
    for (names, expected) in cases {
        assert_eq!(semantics(names, Storage::Float), *expected, "{names:?}");
    }
    assert_eq!(semantics(&["anything", "R"], Storage::Uint), [Id, Id], "whole numbers are ids");
}

#[test]
fn unknown_channel_names_are_guessed_and_doubtful_guesses_reported() {
    let settings = WarpSettings::default();
    let half = report(&["thing.R", "thing.q", "glow"], Storage::Half, &settings);
    assert!(half.channels.iter().all(|channel| (channel.semantic, channel.reason) == (Color, SemanticReason::Guess)));
    assert!(half.warnings.is_empty(), "{:?}", half.warnings);
    let float = report(&["thing.R", "thing.q"], Storage::Float, &settings);
    assert_eq!(float.channels.iter().map(|channel| channel.semantic).collect::<Vec<_>>(), [Color, Data]);
    assert_eq!(float.warnings.len(), 2, "{:?}", float.warnings);
    assert!(float.warnings.iter().any(|warning| warning.contains("thing.q")), "{:?}", float.warnings);
}

#[test]
fn the_shot_has_the_last_word() {
    let semantics = vec![("thing.?".to_owned(), Depth), ("*".to_owned(), Id)];
    let told = report(&["thing.R", "R", "Z"], Storage::Float, &WarpSettings { semantics, ..WarpSettings::default() });
    assert_eq!(told.channels.iter().map(|channel| channel.semantic).collect::<Vec<_>>(), [Depth, Id, Id]);
    assert!(told.channels.iter().all(|channel| channel.reason == SemanticReason::Shot));
}

#[test]
fn parts_name_what_their_channels_do_not() {
    let part = |name: &str, channels: &[&str]| {
        let channels = channels.iter().map(|name| channel(name, Storage::Float, PIXEL, |_, _| 0.0)).collect();
        let mut part = PlatePart::new(PIXEL, channels);
        part.name = Some(name.to_owned());
        part
    };
    let parts = vec![
        part("rgba_left", &["A", "B", "G", "R"]),
        part("depth_left", &["Z"]),
        part("N", &["X", "Y", "Z"]),
        part("CryptoObject00", &["R", "G", "B", "A"]),
        part("motionvector", &["R", "G", "B"]),
    ];
    let report = warped(&Plate::new(PIXEL, 1.0, parts), Vec::new(), &WarpSettings::default()).1;
    let found: Vec<Semantic> = report.channels.iter().map(|channel| channel.semantic).collect();
    let expected =
        [&[Alpha, Color, Color, Color][..], &[Depth], &[Normal; 3], &[Cryptomatte; 4], &[Forward, Forward, Data]];
    assert_eq!(found, expected.concat());
}

#[test]
fn a_file_that_says_cryptomatte_is_believed() {
    let ids = ["mattes00.R", "mattes00.G"].map(|name| channel(name, Storage::Float, PIXEL, |_, _| 0.0));
    let mut told = plate(PIXEL, window(0, 0, 1, 1), ids.to_vec());
    let report = |plate: &Plate| warped(plate, Vec::new(), &WarpSettings::default()).1.channels;
    assert!(report(&told).iter().all(|channel| channel.semantic == Color), "a name alone is not enough");
    told.parts[0].set_text("cryptomatte/abcdef0/name", "mattes");
    let known = (Cryptomatte, SemanticReason::Metadata);
    assert!(report(&told).iter().all(|channel| (channel.semantic, channel.reason) == known));
}
