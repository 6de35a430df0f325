//! PNG and JPEG in and out.

use super::support::rect;
use image::{DynamicImage, ImageBuffer, Luma, LumaA, Rgb, Rgba};
use pinwarp::image::{Channel, Frame, ImageError, Plate, Storage, read_any, read_picture, write_any, write_picture};
use std::fs;
use std::path::Path;

/// Every code of a channel beside all kinds of alpha, 0 among them.
fn straight<T>(largest: u32, of: impl Fn(u32) -> T) -> Vec<[T; 4]> {
    let alpha = |index: u32| [0, 1, 2, largest / 2, largest - 1, largest][(index % 6) as usize];
    (0..=largest)
        .flat_map(|code| (0..6).map(move |index| (code, index)))
        .map(|(code, index)| [of(code), of(code * 7 % (largest + 1)), of(largest - code), of(alpha(index))])
        .collect()
}

#[test]
fn pngs_come_back_code_by_code() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (path, again) = (folder.path().join("in.png"), folder.path().join("out.png"));
    let eight = straight(255, |code| code as u8).concat();
    let sixteen = straight(65_535, |code| code as u16).concat();
    let eight: ImageBuffer<Rgba<u8>, _> = ImageBuffer::from_raw(6, 256, eight).expect("6 x 256 pixels");
    let sixteen: ImageBuffer<Rgba<u16>, _> = ImageBuffer::from_raw(6 * 256, 256, sixteen).expect("1536 x 256 pixels");
    let opaque: ImageBuffer<Rgb<u8>, _> = ImageBuffer::from_fn(16, 16, |x, y| Rgb([(16 * y + x) as u8, 7, y as u8]));
    for picture in
        [DynamicImage::ImageRgba8(eight), DynamicImage::ImageRgba16(sixteen), DynamicImage::ImageRgb8(opaque)]
    {
        picture.save(&path).expect("written");
        let plate = read_any(&path).expect("read");
        write_any(&again, &plate).expect("written again");
        assert!(image::open(&again).expect("a sound PNG") == picture, "{:?}", picture.color());
        let bytes = fs::read(&again).expect("just written");
        write_picture(&again, &plate).expect("written again");
        assert!(fs::read(&again).expect("just written") == bytes);
    }
}

fn pixel(plate: &Plate, name: &str) -> Option<f32> {
    plate.parts[0].channel(name).map(|channel| channel.samples[0])
}

#[test]
fn pictures_are_linear_light_with_associated_alpha() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("pixel.png");
    let read = |picture: DynamicImage| {
        picture.save(&path).expect("written");
        read_picture(&path).expect("read")
    };
    let half = read(DynamicImage::ImageRgba8(ImageBuffer::from_pixel(1, 1, Rgba([255, 118, 0, 51]))));
    assert_eq!((pixel(&half, "R"), pixel(&half, "B"), pixel(&half, "A")), (Some(0.2), Some(0.0), Some(0.2)));
    assert!((pixel(&half, "G").expect("green") - 0.2 * 0.181_164).abs() < 1e-6);
    assert!(half.parts[0].channels.iter().all(|channel| channel.storage == Storage::Half));

    let grey = read(DynamicImage::ImageLuma16(ImageBuffer::from_pixel(1, 1, Luma([65_535]))));
    assert_eq!(["R", "G", "B", "A"].map(|name| pixel(&grey, name)), [Some(1.0), Some(1.0), Some(1.0), None]);
    assert_eq!(grey.parts[0].channels[0].storage, Storage::Float);
    let clear = read(DynamicImage::ImageLumaA8(ImageBuffer::from_pixel(1, 1, LumaA([255, 0]))));
    assert_eq!((pixel(&clear, "R"), pixel(&clear, "A")), (Some(1e-6), Some(0.0)));
}

fn colour(name: &str, samples: &[f32]) -> Channel {
    Channel { name: name.into(), storage: Storage::Half, samples: samples.to_vec() }
}

#[test]
fn what_a_picture_cannot_hold_is_clipped_and_glows_show() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("glow.png");
    let channels = [
        colour("R", &[2.0, 0.5, f32::NAN]),
        colour("G", &[1.0, 0.25, -1.0]),
        colour("B", &[0.0; 3]),
        colour("A", &[1.0, 0.0, 1.0]),
    ];
    let frame = Frame {
        display: rect(10, 20, 4, 2),
        data_window: rect(11, 21, 3, 1),
        pixel_aspect: 1.0,
        channels: channels.to_vec(),
    };
    let plate = Plate::from_frame(frame);
    write_picture(&path, &plate).expect("written");
    let read = image::open(&path).expect("a sound PNG").into_rgba8();
    assert_eq!(read.dimensions(), (4, 2));
    let row: Vec<_> = (0..4).map(|x| read.get_pixel(x, 1).0).collect();
    assert_eq!(row, [[0; 4], [255, 255, 0, 255], [255, 188, 0, 128], [0, 0, 0, 255]]);
    assert_eq!(read.get_pixel(1, 0).0, [0; 4]);

    let path = folder.path().join("glow.jpg");
    write_picture(&path, &plate).expect("written");
    assert_eq!(image::open(&path).expect("a sound JPEG").color(), image::ColorType::Rgb8);
}

fn fault<T>(result: Result<T, ImageError>) -> String {
    result.err().expect("a fault").to_string()
}

#[test]
fn faults_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    let picture: ImageBuffer<Rgb<u8>, _> = ImageBuffer::from_fn(64, 64, |x, y| Rgb([x as u8, y as u8, (x * y) as u8]));
    picture.save(path("whole.png")).expect("written");
    picture.save(path("whole.jpg")).expect("written");
    let whole = fs::read(path("whole.png")).expect("just written");
    for length in (0..whole.len()).step_by(37) {
        fs::write(path("cut.png"), &whole[..length]).expect("written");
        assert!(read_picture(&path("cut.png")).is_err(), "{length}");
    }
    assert!(read_any(&path("whole.jpg")).is_ok());
    assert!(fault(read_any(&path("absent.png"))).contains("cannot read"));
    assert!(fault(read_any(Path::new("girl.psd"))).contains(".png, .jpg or .exr"));
    let depth = Frame::blank(rect(0, 0, 2, 2), rect(0, 0, 2, 2), &[("depth.Z", Storage::Float)]);
    let depth = Plate::from_frame(depth);
    assert!(fault(write_any(&path("depth.png"), &depth)).contains("no channels R, G, B"));
    assert!(fault(write_any(&path("depth.tif"), &depth)).contains(".png, .jpg or .exr"));
}
