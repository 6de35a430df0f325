//! The same frame is the same bytes: twice, in chunks, backwards, in tiles.

use super::support::Studio;
use pinwarp::image::{Channel, Frame, Storage, read_exr};
use pinwarp::pipeline::PreparedShot;
use pinwarp::raster::cpu::CpuRaster;
use pinwarp::raster::{DeviceClass, Pass, Raster, RasterError, Target};
use pinwarp::shot::Shutter;
use std::path::PathBuf;

/// Blurred, so that passes at many times are shared out and built again.
fn studio() -> Studio {
    let mut studio = Studio::teapot(96, 54);
    studio.shot.samples = 2;
    studio.shot.shutter = Shutter { angle: 180.0, phase: -90.0 };
    studio.shot.solve_range = [8, 14];
    studio
}

fn bytes(files: &[PathBuf]) -> Vec<Vec<u8>> {
    files.iter().map(|file| std::fs::read(file).expect("the frame is there")).collect()
}

#[test]
fn order_and_chunks_do_not_matter() {
    let studio = studio();
    let once = bytes(&studio.files(&[10, 11, 12, 13]));
    assert!(bytes(&studio.files(&[10, 11, 12, 13])) == once, "two runs");
    let mut backwards = bytes(&studio.files(&[13, 12, 11, 10]));
    backwards.reverse();
    assert!(backwards == once, "backwards");
    let chunks: Vec<_> = [&[12][..], &[13, 10], &[11]].iter().map(|chunk| bytes(&studio.files(chunk))).collect();
    let sorted = [&chunks[1][1], &chunks[2][0], &chunks[0][0], &chunks[1][0]];
    assert!(sorted.into_iter().eq(&once), "chunks");
    assert!(once.windows(2).all(|pair| pair[0] != pair[1]), "frames differ, or nothing was compared");
}

/// A device that allows small targets only.
struct Small {
    inner: CpuRaster,
    max_side: u32,
    starts: usize,
}

impl Raster for Small {
    fn name(&self) -> String {
        self.inner.name()
    }

    fn class(&self) -> DeviceClass {
        DeviceClass::Cpu
    }

    fn max_side(&self) -> u32 {
        self.max_side
    }

    fn start(&mut self, target: &Target) -> Result<(), RasterError> {
        assert!(target.window.width <= self.max_side && target.window.height <= self.max_side);
        self.starts += 1;
        self.inner.start(target)
    }

    fn draw(&mut self, pass: &Pass) -> Result<(), RasterError> {
        self.inner.draw(pass)
    }

    fn finish(&mut self) -> Result<Frame, RasterError> {
        self.inner.finish()
    }
}

/// Number of samples that differ by more than rounding: places are counted from another corner in a tile.
fn count_different(a: &Frame, b: &Frame) -> usize {
    assert_eq!((a.data_window, a.channels.len()), (b.data_window, b.channels.len()));
    let of_channel = |channel: &Channel| {
        let other = b.channel(&channel.name).map_or(&[][..], |other| &other.samples);
        assert_eq!(channel.samples.len(), other.len(), "{}", channel.name);
        let share = if channel.storage == Storage::Half { 1e-3 } else { 1e-5 };
        let differs = |(a, b): &(&f32, &f32)| (*a - *b).abs() > share * a.abs().max(1.0);
        channel.samples.iter().zip(other).filter(differs).count()
    };
    a.channels.iter().map(of_channel).sum()
}

#[test]
fn tiles_make_the_whole() {
    let studio = studio();
    let whole = studio.frames(&[11, 12]);
    for max_side in [23, 54] {
        let open = |prepared: &PreparedShot| Small { inner: CpuRaster::new(&prepared.scene), max_side, starts: 0 };
        let (files, device) = studio.files_by(&[11, 12], open);
        let tiles = 96_u32.div_ceil(max_side) * 54_u32.div_ceil(max_side);
        assert_eq!(device.starts, 2 * tiles as usize);
        for (file, whole) in files.iter().zip(&whole) {
            let stitched = read_exr(file).expect("the frame is there");
            assert_eq!(count_different(&stitched, whole), 0, "tiles of {max_side} pixels");
        }
    }
    assert!(count_different(&whole[0], &whole[1]) > 100, "the comparison can fail");
}
