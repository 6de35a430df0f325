//! Prepares the planes of a host's picture for filtering.
//!
//! In: a [`Picture`]. Out: [`Associated`] planes, with premultiplied colour.

use super::LiveError;
use crate::space::PixelRect;
use rayon::prelude::*;
use std::borrow::Cow;

/// Samples per parallel task.
const BATCH: usize = 1 << 14;

/// A picture as planes of 32-bit floats.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    /// Window of its samples, in image space, y down. May be part of a frame, if the rest is unknown.
    pub window: PixelRect,
    /// Each `window.area()` samples, rows from the top.
    pub planes: Vec<&'a [f32]>,
    /// Meaning of the last plane.
    pub alpha: Alpha,
}

/// The alpha mode of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alpha {
    /// No alpha plane: the picture covers all of its window.
    Opaque,
    /// The last plane is alpha, and the others are premultiplied by it.
    Premultiplied,
    /// The last plane is alpha, and the others are not premultiplied. They are premultiplied for filtering and divided
    /// afterwards; where alpha is 0 they are filtered as they are.
    Straight,
}

/// Premultiplied planes.
pub(super) struct Associated<'a> {
    pub(super) window: PixelRect,
    pub(super) planes: Vec<Cow<'a, [f32]>>,
}

impl<'a> Picture<'a> {
    /// # Errors
    /// [`LiveError::Planes`] if the size of a plane does not match the window.
    pub(super) fn check(&self, what: &'static str) -> Result<(), LiveError> {
        let wanted = self.window.area();
        match self.planes.iter().find(|plane| plane.len() != wanted) {
            Some(plane) => Err(LiveError::Planes { what, found: plane.len(), wanted }),
            None => Ok(()),
        }
    }

    /// Returns the index of the alpha plane, if there is one.
    pub(super) fn coverage(&self) -> Option<usize> {
        let last = self.planes.len().checked_sub(1);
        last.filter(|_| self.alpha != Alpha::Opaque)
    }

    /// Returns all planes, premultiplied.
    pub(super) fn associated(&self) -> Associated<'a> {
        let planes = match (self.alpha, self.planes.split_last()) {
            (Alpha::Straight, Some((alpha, colors))) => {
                let multiplied = colors.iter().map(|color| Cow::Owned(products(color, alpha)));
                multiplied.chain([Cow::Borrowed(*alpha)]).collect()
            }
            _ => self.planes.iter().map(|plane| Cow::Borrowed(*plane)).collect(),
        };
        Associated { window: self.window, planes }
    }

    /// Whether straight colour is non-zero where alpha hides it.
    pub(super) fn has_hidden_color(&self) -> bool {
        let (Alpha::Straight, Some((alpha, colors))) = (self.alpha, self.planes.split_last()) else { return false };
        let hides = |(color, alpha): (&f32, &f32)| *alpha == 0.0 && *color != 0.0;
        colors.iter().any(|color| color.par_iter().zip(*alpha).with_min_len(BATCH).any(hides))
    }
}

/// Multiplies samples by shares. Samples with share 0 become 0, whatever their value.
pub(super) fn products(samples: &[f32], shares: &[f32]) -> Vec<f32> {
    let product = |(&sample, &share): (&f32, &f32)| if share == 0.0 { 0.0 } else { sample * share };
    samples.par_iter().zip(shares).with_min_len(BATCH).map(product).collect()
}
