//! The flat colours of a picture as ids.
//!
//! In: a plate. Out: a [`LabelMap`] of its display window with one label per colour.

use super::label_map::NO_LABEL;
use super::{LabelMap, Plate};
use crate::space::around;
use std::collections::HashMap;

/// The channels of a colour, and what stands in for those that are missing.
const CHANNELS: [(&str, f32); 4] = [("R", 0.0), ("G", 0.0), ("B", 0.0), ("A", 1.0)];

/// Returns the colours of the first part that has some, and their number.
///
/// A colour is an id if it fills a square of 3 x 3 pixels somewhere (at the border of the picture what is left of it). The blends of
/// anti-aliased borders do not, nor does noise: such pixels, and transparent ones, take the id of the nearest pixel that has one. `None`
/// if the plate has no colour.
pub(crate) fn flat_colors(plate: &Plate) -> Option<(LabelMap, usize)> {
    let (size, colors) = colors(plate)?;
    let mut ids: HashMap<[u32; 4], u32> = HashMap::new();
    let mut labels = vec![NO_LABEL; colors.len()];
    let inner = (0..colors.len()).filter(|&pixel| is_visible(&colors[pixel]) && is_flat(size, &colors, pixel));
    for pixel in inner {
        let next = ids.len() as u32 + 1;
        ids.entry(colors[pixel]).or_insert(next);
    }
    for (label, color) in labels.iter_mut().zip(&colors) {
        *label = ids.get(color).copied().unwrap_or(NO_LABEL);
    }
    let mut map = LabelMap { size, labels };
    map.spread(|_| true);
    Some((map, ids.len()))
}

/// Returns the size of the display window, and the bits of the colours in it.
fn colors(plate: &Plate) -> Option<([u32; 2], Vec<[u32; 4]>)> {
    let of_name = |name: &str| {
        plate.parts.iter().find_map(|part| Some((part, part.channels.iter().find(|channel| channel.name == name)?)))
    };
    let window = plate.frame_size().window();
    let grey = of_name("Y");
    let mut colors = vec![[0; 4]; window.area()];
    of_name("R").or(of_name("G")).or(of_name("B")).or(grey).filter(|_| !colors.is_empty())?;
    for (index, (name, missing)) in CHANNELS.into_iter().enumerate() {
        let found = of_name(name).or(if index < 3 { grey } else { None });
        let samples = found
            .map(|(part, channel)| plate.window_of(part).resized_samples(&channel.samples, window, 0.0))
            .unwrap_or_else(|| vec![missing; window.area()]);
        // −0 and 0 are one colour.
        colors.iter_mut().zip(samples).for_each(|(color, sample)| color[index] = (sample + 0.0).to_bits());
    }
    Some(([window.width, window.height], colors))
}

fn is_visible(color: &[u32; 4]) -> bool {
    f32::from_bits(color[3]) > 0.0
}

/// Whether all pixels around a pixel have its colour.
fn is_flat([width, height]: [u32; 2], colors: &[[u32; 4]], pixel: usize) -> bool {
    around(width as usize, height as usize, pixel).all(|near| colors[near] == colors[pixel])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Channel, PlatePart, Storage};
    use crate::space::PixelRect;

    /// A grey picture of this size.
    fn grey(width: u32, values: Vec<f32>) -> Plate {
        let window = PixelRect { x: 0, y: 0, width, height: values.len() as u32 / width };
        let channel = Channel { name: "Y".into(), storage: Storage::Half, samples: values };
        Plate::new(window, 1.0, vec![PlatePart::new(window, vec![channel])])
    }

    #[test]
    fn blends_along_borders_belong_to_the_nearest_colour() {
        // Two colours, with blends of two pixels between them.
        let row = [0.1, 0.1, 0.1, 0.3, 0.6, 0.9, 0.9, 0.9];
        let (map, count) = flat_colors(&grey(8, row.repeat(4))).expect("a picture");
        assert_eq!((map.size, count), ([8, 4], 2));
        assert_eq!(map.labels[..8], [1, 1, 1, 1, 2, 2, 2, 2]);
    }

    #[test]
    fn noise_has_no_ids_and_data_no_colour() {
        let noise: Vec<f32> = (0..64).map(|k| k as f32).collect();
        assert_eq!(flat_colors(&grey(8, noise)).map(|(_, count)| count), Some(0));
        let mut depth = grey(8, vec![1.0; 64]);
        depth.parts[0].channels[0].name = "Z".into();
        assert_eq!(flat_colors(&depth), None);
    }

    #[test]
    fn transparent_pixels_are_no_id() {
        let mut plate = grey(8, [0.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 0.5].repeat(4));
        let alpha = plate.parts[0].channels[0].samples.iter().map(|value| f32::from(u8::from(*value > 0.0)));
        let alpha = Channel { name: "A".into(), storage: Storage::Half, samples: alpha.collect() };
        plate.parts[0].channels.push(alpha);
        let (map, count) = flat_colors(&plate).expect("a picture");
        assert!(count == 1 && map.labels.iter().all(|&label| label == 1), "{map:?}");
    }
}
