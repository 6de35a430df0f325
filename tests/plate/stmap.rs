//! STMaps out and in, and OpenImageIO's `st_warp` with ours.

use super::map::random;
use super::python;
use pinwarp::image::{Channel, Compression, Frame, FrameMetadata, Plate, Storage, read_exr, write_exr};
use pinwarp::lattice::Basis;
use pinwarp::plate::{Field, Filter, Planes, PlateError, WarpMap, resampled, stmap_of};
use pinwarp::space::{FrameSize, PixelRect};
use std::path::Path;

const FRAME: FrameSize = FrameSize { width: 320, height: 180, pixel_aspect: 1.0 };
/// Overscan on all sides.
const WINDOW: PixelRect = PixelRect { x: -16, y: -9, width: 352, height: 198 };

fn metadata() -> FrameMetadata {
    FrameMetadata { frame: 1, frames_per_second: 24.0, device: "CPU".into(), ..FrameMetadata::default() }
}

fn write(path: &Path, frame: &Frame) {
    write_exr(path, frame, &metadata(), Compression::Zip).expect("the folder is ours");
}

fn map_of_stmap(stmap: &Frame) -> Result<WarpMap, PlateError> {
    pinwarp::plate::map_of_stmap(&Plate::from_frame(stmap.clone()))
}

/// A picture of waves, three channels.
fn waves() -> Frame {
    let mut frame = Frame::blank(FRAME.window(), FRAME.window(), &["R", "G", "B"].map(|name| (name, Storage::Float)));
    for (number, channel) in frame.channels.iter_mut().enumerate() {
        for (index, sample) in channel.samples.iter_mut().enumerate() {
            let (x, y) = ((index % 320) as f32, (index / 320) as f32);
            *sample = 0.5 + 0.5 * (0.11 * x + number as f32).sin() * (0.13 * y - number as f32).cos();
        }
    }
    frame
}

fn warped(picture: &Frame, map: &WarpMap) -> Frame {
    let planes = picture.channels.iter().map(|channel| &channel.samples[..]).collect();
    let planes = resampled(map, &Planes { window: picture.data_window, planes }, Filter::Cubic);
    let named = picture.channels.iter().zip(planes);
    let channels = named.map(|(channel, samples)| Channel { samples, ..channel.clone() }).collect();
    Frame { data_window: map.window, channels, ..picture.clone() }
}

#[test]
fn a_map_comes_back_from_its_stmap() {
    for aspect in [1.0, 2.0] {
        let frame = FrameSize { pixel_aspect: aspect, ..FRAME };
        let field = Field::of_picture(random(Basis::Bspline, 0.4, 3));
        let mut map = WarpMap::backward(&field, frame, WINDOW);
        map.offsets[77] = [f32::NAN; 2];
        let back = map_of_stmap(&stmap_of(&map)).expect("it is one");
        assert_eq!((back.frame, back.window), (map.frame, map.window));
        for (index, (found, wanted)) in back.offsets.iter().zip(&map.offsets).enumerate() {
            let is_same = (0..2).all(|d| (found[d] - wanted[d]).abs() < 1e-4);
            assert!(is_same || index == 77 && found[0].is_nan(), "{index}: {found:?} {wanted:?}");
        }
    }
}

#[test]
fn the_identity_is_exact_both_ways() {
    for frame in [FRAME, FrameSize::new(3840, 11), FrameSize::new(1999, 13)] {
        let window = PixelRect { x: -7, y: -3, width: frame.width + 14, height: frame.height + 6 };
        let identity = WarpMap::identity(frame, window);
        let mut stmap = stmap_of(&identity);
        assert_eq!(stmap.channels[0].samples[7], (0.5 / f64::from(frame.width)) as f32);
        assert_eq!(map_of_stmap(&stmap), Ok(identity.clone()));
        // Other programs multiply by 1/W in single precision, and name channels otherwise.
        stmap.channels.truncate(2);
        for (channel, name) in stmap.channels.iter_mut().zip(["forward.u", "forward.v"]) {
            channel.name = name.into();
        }
        let scale = 1.0 / frame.width as f32;
        for (index, u) in stmap.channels[0].samples.iter_mut().enumerate() {
            *u = ((index % window.width as usize) as f32 - 7.0 + 0.5) * scale;
        }
        assert_eq!(map_of_stmap(&stmap), Ok(identity));
    }
}

#[test]
fn stmaps_of_others_are_contained_or_refused_with_a_hint() {
    let mut stmap = stmap_of(&WarpMap::identity(FRAME, WINDOW));
    for (index, value) in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].into_iter().enumerate() {
        stmap.channels[1].samples[index] = value;
    }
    stmap.channels[3].samples[5] = 0.0;
    let map = map_of_stmap(&stmap).expect("it is one");
    let unseen: Vec<usize> = (0..WINDOW.area()).filter(|&index| map.offsets[index][0].is_nan()).collect();
    assert_eq!(unseen, [0, 1, 2, 5]);

    stmap.channels[0].samples[40] = 1919.5;
    let refused = map_of_stmap(&stmap).expect_err("these are pixels");
    assert!(refused.to_string().contains("u = (x + 0.5)/width"), "{refused}");
    stmap.channels[0].name = "depth.Z".into();
    let refused = map_of_stmap(&stmap).expect_err("no pair");
    assert_eq!(refused, PlateError::NoStMap { found: "depth.Z, G, B, A".into() });
    stmap.channels[0] = Channel { name: "R".into(), storage: Storage::Uint, ..stmap.channels[0].clone() };
    let refused = map_of_stmap(&stmap).expect_err("integers");
    assert_eq!(refused, PlateError::StMapOfIntegers { channel: "R".into() });
}

#[test]
fn stmaps_are_measured_by_the_display_window_wherever_it_lies() {
    let map = WarpMap::backward(&Field::of_picture(random(Basis::Bspline, 0.2, 4)), FRAME, WINDOW);
    let mut stmap = stmap_of(&map);
    for window in [&mut stmap.display, &mut stmap.data_window] {
        (window.x, window.y) = (window.x + 10, window.y - 20);
    }
    // It need not be the first thing in the file.
    let mut plate = Plate::from_frame(stmap.clone());
    let other = Channel { name: "depth.Z".into(), ..stmap.channels[2].clone() };
    plate.parts.insert(0, plate.parts[0].with_channels(plate.parts[0].data_window, vec![other]));
    let found = pinwarp::plate::map_of_stmap(&plate).expect("its second part is one");
    assert_eq!(found, map_of_stmap(&stmap_of(&map)).expect("it is one"));
    assert_eq!(found.window, WINDOW);
}

/// Mean and greatest difference between `st_warp` of OpenImageIO and ours, away from the borders.
const SCRIPT: &str = r#"
import sys, numpy as np, OpenImageIO as oiio
source, stmap, ours = [oiio.ImageBuf(path) for path in sys.argv[1:4]]
theirs = oiio.ImageBufAlgo.st_warp(source, stmap, "catmull-rom", 0.0, 0, 1, False, True)
assert not theirs.has_error, theirs.geterror()
inner = oiio.ROI(12, 308, 12, 168, 0, 1, 0, 3)
gap = np.abs(theirs.get_pixels(oiio.FLOAT, inner) - ours.get_pixels(oiio.FLOAT, inner))
print(float(gap.mean()), float(gap.max()))
"#;

/// `st_warp` of a picture with a map, against another picture; `None` where OpenImageIO is not at hand.
fn difference(picture: &Frame, map: &WarpMap, ours: &Frame) -> Option<[f64; 2]> {
    let folder = tempfile::tempdir().expect("a folder");
    let paths = ["source.exr", "stmap.exr", "ours.exr"].map(|name| folder.path().join(name));
    for (path, frame) in paths.iter().zip([picture, &stmap_of(map), ours]) {
        write(path, frame);
    }
    let read = read_exr(&paths[1]).expect("it was written");
    assert_eq!(map_of_stmap(&read).map(|map| map.window), Ok(map.window));
    let said = python::run(&["numpy", "OpenImageIO"], SCRIPT, &paths.each_ref().map(|path| path.as_os_str()))?;
    let numbers: Vec<f64> = said.split_whitespace().map(|word| word.parse().expect("a number")).collect();
    Some([numbers[0], numbers[1]])
}

#[test]
fn openimageio_warps_with_our_stmap_as_we_do() {
    let picture = waves();
    let identity = WarpMap::identity(FRAME, FRAME.window());
    let Some(rest) = difference(&picture, &identity, &picture) else { return };
    assert!(rest[1] < 1e-5, "identity: {rest:?}");
    for field in [
        Field::of_picture(random(Basis::Bspline, 0.2, 5)),
        // Nothing comes from beyond the border of the picture, where programs differ.
        Field::of_layer(random(Basis::Bernstein, 0.2, 6)),
    ] {
        let mut map = WarpMap::backward(&field, FRAME, WINDOW);
        let ours = warped(&picture, &map);
        let Some([mean, most]) = difference(&picture, &map, &ours) else { return };
        println!("mean {mean:.2e}, most {most:.2e}");
        // Measured: 2e-7 and 2e-6 of the waves' height.
        assert!(mean < 1e-5 && most < 1e-3, "{mean} {most}");
        map.offsets.iter_mut().for_each(|offset| offset[0] += 1.0);
        let [mean, most] = difference(&picture, &map, &ours).expect("it was there");
        assert!(mean > 1e-2 && most > 3e-2, "a pixel off: {mean} {most}");
    }
}
