//! A picture copied out of a host's memory.
//!
//! In: planes. Out: the same with other channels, as a [`Picture`], or as a [`Coverage`].

use super::{Alpha, Coverage, Picture};
use crate::space::PixelRect;

/// A picture that owns its planes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OwnedPicture {
    /// Window of its samples, in image space.
    pub(crate) window: PixelRect,
    /// 4: RGBA, 3: RGB, 1: alpha; each `window.area()` samples, rows from the top.
    pub(crate) planes: Vec<Vec<f32>>,
    /// Meaning of the last plane.
    pub(crate) alpha: Alpha,
}

impl OwnedPicture {
    /// Returns a mask without pixels, which selects nothing.
    #[must_use]
    pub(crate) fn black_mask() -> Self {
        Self { window: PixelRect::default(), planes: vec![Vec::new()], alpha: Alpha::Premultiplied }
    }

    /// Converts to a number of channels: 4 for RGBA, 3 for RGB, 1 for alpha. Pictures without alpha are opaque.
    #[must_use]
    pub(crate) fn with_channels(mut self, channels: usize) -> Self {
        let area = self.window.area();
        match (self.planes.len(), channels) {
            (4, 3) => self.planes.truncate(3),
            (4, 1) => self.planes = self.planes.split_off(3),
            (3, 4) => self.planes.push(vec![1.0; area]),
            (3, 1) => self.planes = vec![vec![1.0; area]],
            (1, 3) => self.planes = vec![self.planes.swap_remove(0); 3],
            (1, 4) => self.planes = [vec![vec![0.0; area]; 3], self.planes].concat(),
            _ => return self,
        }
        self.alpha = if channels == 3 { Alpha::Opaque } else { Alpha::Premultiplied };
        self
    }

    /// Borrows it as a picture.
    #[must_use]
    pub(crate) fn picture(&self) -> Picture<'_> {
        Picture { window: self.window, planes: self.planes.iter().map(Vec::as_slice).collect(), alpha: self.alpha }
    }

    /// Borrows its alpha; `None` if it has none.
    #[must_use]
    pub(crate) fn coverage(&self) -> Option<Coverage<'_>> {
        let alpha = self.planes.last().filter(|_| self.alpha != Alpha::Opaque)?;
        Some(Coverage { window: self.window, alpha })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_that_a_picture_lacks_are_opaque_or_black() {
        let window = PixelRect { x: 0, y: 0, width: 1, height: 1 };
        let of = |values: &[f32], alpha| OwnedPicture {
            window,
            planes: values.iter().map(|value| vec![*value]).collect(),
            alpha,
        };
        let rgb = of(&[0.1, 0.2, 0.3], Alpha::Opaque);
        assert_eq!(rgb.coverage(), None);
        assert_eq!(rgb.clone().with_channels(4), of(&[0.1, 0.2, 0.3, 1.0], Alpha::Premultiplied));
        assert_eq!(rgb.clone().with_channels(1), of(&[1.0], Alpha::Premultiplied));
        assert_eq!(rgb.clone().with_channels(3), rgb);
        let straight = of(&[0.1, 0.2, 0.3, 0.5], Alpha::Straight);
        assert_eq!(straight.clone().with_channels(4), straight);
        assert_eq!(straight.clone().with_channels(3), rgb);
        assert_eq!(straight.with_channels(1), of(&[0.5], Alpha::Premultiplied));
        let alpha = of(&[0.5], Alpha::Premultiplied);
        assert_eq!(alpha.clone().with_channels(4), of(&[0.0, 0.0, 0.0, 0.5], Alpha::Premultiplied));
        assert_eq!(alpha.with_channels(3), of(&[0.5; 3], Alpha::Opaque));
    }
}
