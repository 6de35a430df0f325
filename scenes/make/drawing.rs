//! Flat drawings made by code: overlapping shapes of one colour each, with ink outlines.
//!
//! In: distance fields, negative inside. Out: the bytes of a PNG file with alpha.

use super::paint::{Rgba, png_rgba};
use glam::{DVec2, DVec3};
use image::ImageError;

/// A distance field: negative inside.
pub(crate) type Field = Box<dyn Fn(DVec2) -> f64>;

/// A linear colour as a function of position.
pub(crate) type Colour = Box<dyn Fn(DVec2) -> DVec3>;

/// A shape in a drawing.
pub(crate) struct Shape {
    /// The area of the shape.
    pub(crate) field: Field,
    /// The colour of its interior.
    pub(crate) colour: Colour,
    /// Width of the outline, half of it outside; 0 for none.
    pub(crate) ink: f64,
    /// A second area, to which the shape is clipped.
    pub(crate) inside: Option<Field>,
}

/// Colour of all outlines.
const INK: DVec3 = DVec3::new(0.035, 0.02, 0.03);

impl Shape {
    pub(crate) fn new(field: impl Fn(DVec2) -> f64 + 'static, colour: DVec3) -> Self {
        Self { field: Box::new(field), colour: Box::new(move |_| colour), ink: 0.0, inside: None }
    }

    pub(crate) fn painted(self, colour: impl Fn(DVec2) -> DVec3 + 'static) -> Self {
        Self { colour: Box::new(colour), ..self }
    }

    pub(crate) fn inked(self, ink: f64) -> Self {
        Self { ink, ..self }
    }

    pub(crate) fn within(self, field: impl Fn(DVec2) -> f64 + 'static) -> Self {
        Self { inside: Some(Box::new(field)), ..self }
    }

    /// Composites the shape over `behind`; `pixel` is the side of a pixel.
    fn over(&self, behind: Rgba, at: DVec2, pixel: f64) -> Rgba {
        let distance = (self.field)(at).max(self.inside.as_ref().map_or(-1e3, |inside| inside(at)));
        let cover = |distance: f64| (0.5 - distance / pixel).clamp(0.0, 1.0);
        let filled = blend(behind, (self.colour)(at), cover(distance));
        let line = cover(distance.abs() - 0.5 * self.ink) * f64::from(u8::from(self.ink > 0.0));
        blend(filled, INK, line)
    }
}

/// The `over` operation on straight (not premultiplied) colours.
fn blend(behind: Rgba, colour: DVec3, cover: f64) -> Rgba {
    let alpha = cover + behind.alpha * (1.0 - cover);
    if alpha <= 0.0 {
        return behind;
    }
    Rgba { color: (colour * cover + behind.color * (behind.alpha * (1.0 - cover))) / alpha, alpha }
}

/// Draws shapes, given from back to front, in a window of the plane; rows start at its upper left corner.
pub(crate) fn drawn(
    [width, height]: [u32; 2],
    corner: DVec2,
    size: DVec2,
    shapes: &[Shape],
) -> Result<Vec<u8>, ImageError> {
    let pixel = size.y / f64::from(height);
    png_rgba(width, height, |uv| {
        let at = DVec2::new(corner.x + uv.x * size.x, corner.y - uv.y * size.y);
        let nothing = Rgba { color: DVec3::ZERO, alpha: 0.0 };
        shapes.iter().fold(nothing, |behind, shape| shape.over(behind, at, pixel))
    })
}

/// A linear colour from sRGB digits.
pub(crate) fn colour(digits: u32) -> DVec3 {
    let linear = |shift: u32| {
        let code = f64::from(digits >> shift & 0xff) / 255.0;
        if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
    };
    DVec3::new(linear(16), linear(8), linear(0))
}
