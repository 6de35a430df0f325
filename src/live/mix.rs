//! Blends the warped picture with its source: a global mix and a per-pixel matte.
//!
//! In: planes of the warped picture. Out: the same planes, blended with the source; bit-identical to the warp where its
//! share is 1, and to the source where it is 0.

use super::picture::{Alpha, Picture};
use crate::space::PixelRect;

/// Blend between source and warped picture.
#[derive(Clone, Copy, Debug)]
pub struct Mix<'a> {
    /// 0: the source; 1: the warped picture.
    pub amount: f32,
    /// One plane, 0 to 1, multiplied by the amount and applied after the warp; the source shows where it has no samples.
    pub matte: Option<&'a Picture<'a>>,
}

impl Mix<'_> {
    /// Only the warped picture.
    pub const FULL: Self = Self { amount: 1.0, matte: None };

    /// Whether nothing of the source shows.
    pub(super) fn is_full(&self) -> bool {
        self.amount >= 1.0 && self.matte.is_none()
    }

    /// Blends `planes` of a window, with the alpha mode of the source, with the source.
    pub(super) fn blend(&self, planes: &mut [Vec<f32>], window: PixelRect, source: &Picture) {
        if self.is_full() {
            return;
        }
        let shares = self.shares(window);
        let own: Vec<Vec<f32>> =
            source.planes.iter().map(|plane| source.window.resized_samples(plane, window, 0.0)).collect();
        let (alphas, colors) = match (source.alpha, own.split_last()) {
            (Alpha::Straight, Some((alpha, colors))) => (Some(alpha), colors),
            _ => (None, &own[..]),
        };
        let warped_alpha = alphas.map(|_| planes[colors.len()].clone());
        for (plane, own) in planes.iter_mut().zip(colors) {
            for (index, sample) in plane.iter_mut().enumerate() {
                // Straight colours are weighted by their alpha.
                let weights = match (alphas, &warped_alpha) {
                    (Some(own), Some(warped)) => [own[index], warped[index]],
                    _ => [1.0; 2],
                };
                *sample = mixed([own[index], *sample], weights, shares[index]);
            }
        }
        if let (Some(alpha), Some(plane)) = (alphas, planes.last_mut()) {
            plane.iter_mut().zip(alpha).zip(&shares).for_each(|((sample, own), share)| {
                *sample = mixed([*own, *sample], [1.0; 2], *share);
            });
        }
    }

    /// Returns the share of the warped picture at each pixel.
    fn shares(&self, window: PixelRect) -> Vec<f32> {
        let amount = self.amount.clamp(0.0, 1.0);
        let Some(matte) = self.matte else { return vec![amount; window.area()] };
        let Some(plane) = matte.planes.last() else { return vec![0.0; window.area()] };
        let mut shares = matte.window.resized_samples(plane, window, 0.0);
        shares.iter_mut().for_each(|share| *share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) * amount });
        shares
    }
}

/// Blends a source and a warped sample, each with its weight.
fn mixed([own, warped]: [f32; 2], weights: [f32; 2], share: f32) -> f32 {
    if share >= 1.0 {
        return warped;
    }
    if share <= 0.0 {
        return own;
    }
    let parts = [weights[0] * (1.0 - share), weights[1] * share];
    let total = parts[0] + parts[1];
    if total == 0.0 { own + (warped - own) * share } else { (own * parts[0] + warped * parts[1]) / total }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_colours_mix_by_their_alpha() {
        let window = PixelRect { x: 0, y: 0, width: 3, height: 1 };
        let (color, alpha, matte) = ([0.2, 0.2, 0.2], [1.0, 1.0, 1.0], [0.0, 0.5, 1.0]);
        let source = Picture { window, planes: vec![&color, &alpha], alpha: Alpha::Straight };
        let matte = Picture { window, planes: vec![&matte], alpha: Alpha::Premultiplied };
        let mut planes = vec![vec![0.8; 3], vec![0.0; 3]];
        Mix { amount: 1.0, matte: Some(&matte) }.blend(&mut planes, window, &source);
        assert_eq!(planes, [[0.2, 0.2, 0.8], [1.0, 0.5, 0.0]], "what is transparent has no colour to give");
        let mut planes = vec![vec![0.8; 3], vec![1.0; 3]];
        Mix { amount: 0.5, matte: None }.blend(&mut planes, window, &source);
        assert!(planes[0].iter().all(|sample| (sample - 0.5).abs() < 1e-6) && planes[1] == [1.0; 3], "{planes:?}");
    }
}
