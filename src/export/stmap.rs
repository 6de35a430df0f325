//! STMaps and displacement maps: where every pixel comes from, as pictures.
//!
//! In: a [`WarpMap`]. Out: a frame of 32-bit channels; or 16-bit integers for programs without float.

use crate::image::{Channel, Frame, Storage};
use crate::plate::WarpMap;

/// What an STMap says of a pixel that shows nothing: a place outside every picture.
const NOWHERE: f32 = -1.0;

/// The map as an STMap: R = (x + ½) / width and G = 1 − (y + ½) / height of the place that a pixel shows, y from the
/// top, measured by the DISPLAY window, so that overscan goes below 0 and above 1. A is 1, or 0 where nothing is seen.
#[must_use]
pub fn stmap(map: &WarpMap) -> Frame {
    let [width, height] = [map.frame.width, map.frame.height].map(f64::from);
    let places: Vec<Option<[f64; 2]>> = pixels(map).map(|(x, y)| map.source(x, y)).collect();
    let channel = |name: &str, value: &dyn Fn([f64; 2]) -> f64, empty: f32| Channel {
        name: name.into(),
        storage: Storage::Float,
        samples: places.iter().map(|place| place.map_or(empty, |place| value(place) as f32)).collect(),
    };
    Frame {
        display: map.frame.window(),
        data_window: map.window,
        pixel_aspect: map.frame.pixel_aspect,
        channels: vec![
            channel("R", &|[x, _]| x / width, NOWHERE),
            channel("G", &|[_, y]| 1.0 - y / height, NOWHERE),
            channel("B", &|_| 0.0, 0.0),
            channel("A", &|_| 1.0, 0.0),
        ],
    }
}

/// The farthest way of any pixel along x or y, in pixels.
#[must_use]
pub fn greatest_offset(map: &WarpMap) -> f64 {
    map.offsets.iter().flatten().filter(|offset| offset.is_finite()).fold(0.0, |most, by| most.max(f64::from(by.abs())))
}

/// Offsets as 16-bit red (x, right) and green (y, DOWN): ½ is none, 0 and 1 are `reach` pixels. Blue is 0, and pixels
/// that show nothing stay where they are.
///
/// Rows from the top, 3 values a pixel. The step between two values is `reach` / 32767 pixels.
#[must_use]
pub fn displacement(map: &WarpMap, reach: f64) -> Vec<u16> {
    let value = |by: f32| {
        let share = if by.is_finite() { f64::from(by) / reach.max(f64::MIN_POSITIVE) } else { 0.0 };
        // 32768 is the middle of programs that count to 65536.
        (32768.0 + 32767.0 * share.clamp(-1.0, 1.0)).round() as u16
    };
    map.offsets.iter().flat_map(|&[x, y]| [value(x), value(y), 0]).collect()
}

/// Pixels of the window in the order of the offsets.
fn pixels(map: &WarpMap) -> impl Iterator<Item = (i32, i32)> {
    let window = map.window;
    let rows = window.y..window.y.saturating_add_unsigned(window.height);
    rows.flat_map(move |y| (window.x..window.x.saturating_add_unsigned(window.width)).map(move |x| (x, y)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{FrameSize, PixelRect};

    #[test]
    fn the_map_that_moves_nothing_is_the_exact_identity() {
        let frame = FrameSize::new(4, 2);
        let map = WarpMap::identity(frame, PixelRect { x: -1, y: 0, width: 6, height: 2 });
        let stmap = stmap(&map);
        assert_eq!(stmap.channels[0].samples[..6], [-0.125, 0.125, 0.375, 0.625, 0.875, 1.125]);
        assert_eq!((stmap.channels[1].samples[0], stmap.channels[1].samples[6]), (0.75, 0.25));
        assert_eq!((stmap.data_window, stmap.display), (map.window, frame.window()));
    }

    #[test]
    fn nothing_is_nowhere() {
        let frame = FrameSize::new(2, 1);
        let mut map = WarpMap::identity(frame, frame.window());
        map.offsets[0] = [f32::NAN; 2];
        let stmap = stmap(&map);
        let at = |pixel: usize| stmap.channels.iter().map(|channel| channel.samples[pixel]).collect::<Vec<_>>();
        assert_eq!((at(0), at(1)), (vec![-1.0, -1.0, 0.0, 0.0], vec![0.75, 0.5, 0.0, 1.0]));
    }

    #[test]
    fn displacements_are_centred_and_reach_both_ends() {
        let frame = FrameSize::new(4, 1);
        let mut map = WarpMap::identity(frame, frame.window());
        map.offsets = vec![[0.0, 3.0], [-3.0, 1.5], [f32::NAN, 0.0], [9.0, -9.0]];
        assert_eq!(greatest_offset(&map), 9.0);
        let values = displacement(&map, 3.0);
        assert_eq!(values, [32768, 65535, 0, 1, 49152, 0, 32768, 32768, 0, 65535, 1, 0]);
    }
}
