//! Frames to test with.

use glam::{DMat4, DVec3};
use pinwarp::image::{CameraMatrices, Compression, Frame, FrameMetadata, Storage, write_exr};
use pinwarp::space::PixelRect;
use std::fs;
use std::path::Path;

pub(crate) const ALL: [Compression; 7] = [
    Compression::None,
    Compression::Rle,
    Compression::Zips,
    Compression::Zip,
    Compression::Piz,
    Compression::Dwaa,
    Compression::Dwab,
];

pub(crate) const CHANNELS: [(&str, Storage); 7] = [
    ("R", Storage::Half),
    ("G", Storage::Half),
    ("B", Storage::Half),
    ("A", Storage::Half),
    ("depth.Z", Storage::Float),
    ("N.X", Storage::Float),
    ("other.id", Storage::Uint),
];

pub(crate) fn rect(x: i32, y: i32, width: u32, height: u32) -> PixelRect {
    PixelRect { x, y, width, height }
}

/// Smooth colour (half numbers, so that a round trip is exact), busy data, a data window that leaves the display window.
pub(crate) fn sample_frame() -> Frame {
    let window = rect(-5, -3, 61, 37);
    let mut frame = Frame::blank(rect(0, 0, 48, 32), window, &CHANNELS);
    frame.pixel_aspect = 2.0;
    for (number, channel) in frame.channels.iter_mut().enumerate() {
        for (index, sample) in channel.samples.iter_mut().enumerate() {
            let (x, y) = ((index % 61) as f32, (index / 61) as f32);
            *sample = match channel.storage {
                Storage::Half => ((x + y + number as f32) * 8.0).floor() / 1024.0,
                Storage::Float => (x * 0.37 + y * 1.91 + number as f32).sin() * 1234.567,
                Storage::Uint => f32::from_bits(0x9E37_79B9_u32.wrapping_mul(index as u32 + 1)),
            };
        }
    }
    frame
}

pub(crate) fn metadata() -> FrameMetadata {
    FrameMetadata {
        frame: -12,
        frames_per_second: 23.976,
        shot_hash: "5f1d\"c0de".into(),
        device: "CPU (2 threads)".into(),
        mattes: Vec::new(),
        report: serde_json::json!({"warnings": ["one"]}),
        camera: Some(CameraMatrices {
            camera_from_scene: DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0)),
            screen_from_scene: DMat4::IDENTITY,
        }),
    }
}

/// Bits, so that NaN patterns among ids compare equal; by name, since files order channels by the alphabet.
pub(crate) fn bits(frame: &Frame, name: &str) -> (Storage, Vec<u32>) {
    let channel = frame.channel(name).expect(name);
    (channel.storage, channel.samples.iter().map(|sample| sample.to_bits()).collect())
}

pub(crate) fn write(path: &Path, frame: &Frame) {
    write_exr(path, frame, &metadata(), Compression::Zip).expect("a sound frame in a writable folder");
}

pub(crate) fn names_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("the test's own folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
    let mut names: Vec<_> = names.collect();
    names.sort();
    names
}
