//! A channel of a picture as weights, decoded by display value, not by light.
//!
//! In: a path and a channel. Out: a [`PaintedMap`].

use super::srgb::srgb_from_linear;
use super::{ImageError, PictureKind, read_any};
use crate::space::PixelRect;
use std::path::Path;

/// Relative difference below which the aspect ratios of two pictures count as equal.
const SAME_SHAPE: f64 = 0.01;

/// Painted weights over the unit square.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PaintedMap {
    /// Width and height in pixels; not 0.
    pub(crate) size: [u32; 2],
    /// #pixels, rows from the top, 0 to 1.
    pub(crate) values: Vec<f32>,
}

impl PaintedMap {
    /// Reads a channel (0 to 3: red, green, blue, alpha) of a PNG, JPEG or EXR file. In PNG and JPEG files white is 1
    /// and middle grey 0.5; EXR files contain the weight itself. Transparency reduces the weight.
    ///
    /// # Errors
    /// [`ImageError`] as [`read_any`], and if an EXR file has no such channel.
    pub(crate) fn read(path: &Path, channel: usize) -> Result<Self, ImageError> {
        const NAMES: [&str; 4] = ["R", "G", "B", "A"];
        let is_coded = PictureKind::known(path)? != PictureKind::Exr;
        let plate = read_any(path)?;
        let part = plate.parts.iter().find(|part| part.channels.iter().any(|one| one.name == NAMES[channel]));
        let grey = || plate.parts.iter().find(|part| part.channels.iter().any(|one| one.name == "Y"));
        let found = part.map(|part| (part, NAMES[channel])).or_else(|| Some((grey()?, "Y")));
        let Some((part, name)) = found else {
            let wanted = NAMES[channel];
            return Err(ImageError::unsupported(path, format!("it has no channel {wanted}; name another `channel`")));
        };
        let samples = |name: &str| part.channels.iter().find(|one| one.name == name).map(|one| one.samples.as_slice());
        let PixelRect { width, height, .. } = part.data_window;
        let (Some(own), alpha) = (samples(name), samples("A").filter(|_| name != "A" && is_coded)) else {
            return Err(ImageError::damaged(path, "it has no pixels".to_owned()));
        };
        if own.is_empty() {
            return Err(ImageError::damaged(path, "it has no pixels".to_owned()));
        }
        let value = |(index, &light): (usize, &f32)| {
            let share = alpha.map_or(1.0, |alpha| alpha[index]);
            let code = match is_coded && name != "A" {
                // The colour is premultiplied; where alpha is 0 it is lost.
                true => srgb_from_linear(if share > 0.0 { light / share } else { 0.0 }) * share,
                false => light,
            };
            if code.is_finite() { code.clamp(0.0, 1.0) } else { 0.0 }
        };
        Ok(Self { size: [width, height], values: own.iter().enumerate().map(value).collect() })
    }

    /// Returns the bilinearly interpolated value at a position of the unit square, x right, y down from the upper left
    /// corner; repeats beyond it.
    #[must_use]
    pub(crate) fn at(&self, [u, v]: [f32; 2]) -> f32 {
        if !(u.is_finite() && v.is_finite()) {
            return 0.0;
        }
        let inside = |t: f32| if (0.0..=1.0).contains(&t) { t } else { t.rem_euclid(1.0) };
        let [width, height] = self.size;
        let along = |t: f32, count: u32| {
            let x = (f64::from(inside(t)) * f64::from(count) - 0.5).clamp(0.0, f64::from(count - 1));
            let low = x.floor();
            (low as usize, (low as usize + 1).min(count as usize - 1), (x - low) as f32)
        };
        let ((x0, x1, s), (y0, y1, t)) = (along(u, width), along(v, height));
        let texel = |x: usize, y: usize| self.values[y * width as usize + x];
        let row = |y: usize| texel(x0, y) * (1.0 - s) + texel(x1, y) * s;
        row(y0) * (1.0 - t) + row(y1) * t
    }
}

/// Whether width and height of two pictures are in the same proportion.
pub(crate) fn are_of_one_shape(a: [u32; 2], b: [u32; 2]) -> bool {
    let shape = |[width, height]: [u32; 2]| f64::from(width) / f64::from(height.max(1));
    (shape(a) / shape(b) - 1.0).abs() <= SAME_SHAPE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_is_read_between_its_pixels_and_repeats() {
        let map = PaintedMap { size: [2, 2], values: vec![0.0, 1.0, 0.0, 0.5] };
        assert_eq!(map.at([0.0, 0.0]), 0.0);
        assert_eq!(map.at([0.5, 0.25]), 0.5);
        assert_eq!(map.at([1.0, 0.0]), 1.0, "the right edge is no corner of the next copy");
        assert_eq!(map.at([1.0, 1.0]), 0.5);
        assert_eq!(map.at([1.5, -0.75]), map.at([0.5, 0.25]));
        assert_eq!(map.at([f32::NAN, 0.0]), 0.0);
    }
}
