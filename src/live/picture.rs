//! Planes of a host's picture, made ready to be filtered.
//!
//! In: a [`Picture`]. Out: [`Associated`] planes: colour multiplied with its coverage.

use super::LiveError;
use crate::space::PixelRect;
use rayon::prelude::*;
use std::borrow::Cow;

/// Samples that a task takes.
const BATCH: usize = 1 << 14;

/// A picture as planes of 32-bit floats.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    /// Where its samples lie, in image space, y down: a part of a frame may be given, then nothing is known of the rest.
    pub window: PixelRect,
    /// Each `window.area()` samples, rows from the top.
    pub planes: Vec<&'a [f32]>,
    /// What the last of them means.
    pub alpha: Alpha,
}

/// The alpha of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alpha {
    /// No plane is one: the picture covers all of its window.
    Opaque,
    /// The last plane, and the others are multiplied with it.
    Premultiplied,
    /// The last plane, and the others are not. They are filtered multiplied, and divided again; where alpha is 0 they are
    /// filtered as they are.
    Straight,
}

/// Planes that can be filtered.
pub(super) struct Associated<'a> {
    pub(super) window: PixelRect,
    pub(super) planes: Vec<Cow<'a, [f32]>>,
}

impl<'a> Picture<'a> {
    /// # Errors
    /// [`LiveError::Planes`] where a plane has not as many samples as the window has pixels.
    pub(super) fn check(&self, what: &'static str) -> Result<(), LiveError> {
        let wanted = self.window.area();
        match self.planes.iter().find(|plane| plane.len() != wanted) {
            Some(plane) => Err(LiveError::Planes { what, found: plane.len(), wanted }),
            None => Ok(()),
        }
    }

    /// The plane that covers, where there is one.
    pub(super) fn coverage(&self) -> Option<usize> {
        let last = self.planes.len().checked_sub(1);
        last.filter(|_| self.alpha != Alpha::Opaque)
    }

    /// All planes, colour multiplied.
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

    /// Whether straight colour says something that its alpha hides.
    pub(super) fn has_hidden_color(&self) -> bool {
        let (Alpha::Straight, Some((alpha, colors))) = (self.alpha, self.planes.split_last()) else { return false };
        let hides = |(color, alpha): (&f32, &f32)| *alpha == 0.0 && *color != 0.0;
        colors.iter().any(|color| color.par_iter().zip(*alpha).with_min_len(BATCH).any(hides))
    }
}

/// Samples times their shares. What has no share does not count, whatever it is.
pub(super) fn products(samples: &[f32], shares: &[f32]) -> Vec<f32> {
    let product = |(&sample, &share): (&f32, &f32)| if share == 0.0 { 0.0 } else { sample * share };
    samples.par_iter().zip(shares).with_min_len(BATCH).map(product).collect()
}
