//! Contact sheets: labelled thumbnails of many frames in a grid.
//!
//! In: pictures, one by one. Out: one picture.

use super::{Canvas, Preview, Rgba8};
use crate::space::ImagePoint;
use ::image::RgbaImage;
use ::image::imageops::{self, FilterType};

/// Gap between tiles and around the sheet, in pixels.
const GAP: u32 = 8;
/// Height of a tile's label in pixels: twice a line of the font.
const LABEL: u32 = 24;
/// Background colour, behind transparent pixels and around tiles.
const GROUND: [u8; 3] = [40, 40, 40];
const PLAIN: Rgba8 = Rgba8([220, 220, 220, 255]);
const MARKED: Rgba8 = Rgba8([255, 96, 64, 255]);

/// Builds a sheet while frames are read one by one, so that only one full-size frame is in memory.
#[derive(Debug)]
pub(crate) struct ContactSheet {
    columns: u32,
    tile: [u32; 2],
    sheet: RgbaImage,
    filled: u32,
}

impl ContactSheet {
    /// Creates a sheet for `count` tiles of `tile_width` pixels in `columns`; `size` is the width and height of the
    /// frames, which determines the aspect ratio of the tiles.
    pub(crate) fn new(count: usize, columns: usize, tile_width: u32, size: [u32; 2]) -> Self {
        let columns = u32::try_from(columns.clamp(1, count.max(1))).unwrap_or(1);
        let rows = u32::try_from(count).unwrap_or(1).div_ceil(columns).max(1);
        let height = f64::from(tile_width) * f64::from(size[1].max(1)) / f64::from(size[0].max(1));
        let tile = [tile_width, (height.round() as u32).clamp(1, 4 * tile_width)];
        let [red, green, blue] = GROUND;
        let sheet = RgbaImage::from_pixel(
            GAP + columns * (tile[0] + GAP),
            GAP + rows * (tile[1] + LABEL + GAP),
            ::image::Rgba([red, green, blue, 255]),
        );
        Self { columns, tile, sheet, filled: 0 }
    }

    /// Adds a frame, or `None` for an unreadable one; a marked frame gets a coloured border and label.
    pub(crate) fn add(&mut self, picture: Option<&Preview>, label: &str, is_marked: bool) {
        let (column, row) = (self.filled % self.columns, self.filled / self.columns);
        self.filled += 1;
        let [width, height] = self.tile;
        let (x, y) = (GAP + column * (width + GAP), GAP + row * (height + LABEL + GAP));
        if let Some(opaque) = picture.and_then(over_ground) {
            let small = imageops::resize(&opaque, width, height, FilterType::Triangle);
            imageops::replace(&mut self.sheet, &small, i64::from(x), i64::from(y));
        }
        let color = if is_marked { MARKED } else { PLAIN };
        let mut drawn = Preview {
            width: self.sheet.width(),
            height: self.sheet.height(),
            rgba: std::mem::take(&mut self.sheet).into_raw(),
        };
        let mut canvas = Canvas::new(&mut drawn);
        let corner = |dx: u32, dy: u32| ImagePoint::new(f64::from(x + dx), f64::from(y + dy));
        if is_marked || picture.is_none() {
            let corners = [corner(0, 0), corner(width, 0), corner(width, height), corner(0, height)];
            (0..4).for_each(|k| canvas.line(corners[k], corners[(k + 1) % 4], 3.0, color));
        }
        canvas.text(corner(2, height + 4), label, 2, color);
        self.sheet = RgbaImage::from_raw(drawn.width, drawn.height, drawn.rgba).unwrap_or_default();
    }

    /// Returns the finished sheet.
    pub(crate) fn into_picture(self) -> Preview {
        Preview { width: self.sheet.width(), height: self.sheet.height(), rgba: self.sheet.into_raw() }
    }
}

/// Composites the picture over the background colour.
fn over_ground(picture: &Preview) -> Option<RgbaImage> {
    let mut image = RgbaImage::from_raw(picture.width, picture.height, picture.rgba.clone())?;
    for pixel in image.pixels_mut() {
        let alpha = u32::from(pixel.0[3]);
        for (value, ground) in pixel.0.iter_mut().zip(GROUND) {
            *value = ((u32::from(*value) * alpha + u32::from(ground) * (255 - alpha) + 127) / 255) as u8;
        }
        pixel.0[3] = 255;
    }
    Some(image)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_stand_in_rows_and_marked_ones_are_framed() {
        let red = Preview { width: 4, height: 2, rgba: [255, 0, 0, 255].repeat(8) };
        let mut sheet = ContactSheet::new(3, 2, 40, [4, 2]);
        sheet.add(Some(&red), "1", false);
        sheet.add(Some(&Preview::transparent(4, 2)), "2", true);
        sheet.add(None, "3", false);
        let picture = sheet.into_picture();
        assert_eq!([picture.width, picture.height], [GAP + 2 * (40 + GAP), GAP + 2 * (20 + LABEL + GAP)]);
        assert_eq!(picture.pixel(GAP + 20, GAP + 10), Some([255, 0, 0, 255]));
        assert_eq!(picture.pixel(GAP + 48 + 20, GAP + 10), Some([40, 40, 40, 255]));
        assert_eq!(picture.pixel(GAP + 48 + 20, GAP), Some(MARKED.0));
    }
}
