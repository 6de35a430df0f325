//! How much of each layer of a composite is visible behind what stands in front of it.
//!
//! In: the fronts of moving layers. Out: the visibility of every layer, and of the background; dimmed samples.

use super::composite::Composite;
use super::moving_layer::MovingLayer;
use super::{Coverage, Front};
use crate::space::PixelRect;
use rayon::prelude::*;
use std::sync::Arc;

/// Assigns every layer of the composites how much of it is visible.
pub(super) fn assign_visibility(composites: &mut [Composite], moving_layers: &[MovingLayer]) {
    let fronts: Vec<Option<&Front>> = moving_layers.iter().map(|layer| layer.front).collect();
    for layer in composites.iter_mut().flat_map(|composite| &mut composite.layers) {
        let window = layer.window;
        layer.visibility = match layer.moving_layer {
            0 => known_of(&fronts, window),
            index => fronts[index].map(|front| over(&front.visible, window, 1.0)).map(Arc::new),
        };
    }
}

/// Returns how much of the background is known, over a window: all but what a layer should show there.
fn known_of(fronts: &[Option<&Front>], window: PixelRect) -> Option<Arc<Vec<f32>>> {
    let missing = fronts.iter().flatten().map(|front| over(&front.missing, window, 0.0));
    let missing = missing.reduce(|mut sum, other| {
        sum.par_iter_mut().zip(other).for_each(|(sum, other)| *sum += other);
        sum
    })?;
    Some(Arc::new(missing.into_par_iter().map(|missing| 1.0 - missing.clamp(0.0, 1.0)).collect()))
}

/// Returns coverage over a window, with another value outside its own.
fn over(coverage: &Coverage, window: PixelRect, outside: f32) -> Vec<f32> {
    coverage.window.resized_samples(&coverage.samples, window, outside)
}

/// Multiplies samples by visibility. An invisible sample is ignored, even if it is NaN.
pub(super) fn dim(samples: &mut [f32], visibility: &[f32]) {
    samples.par_iter_mut().zip(visibility).with_min_len(1 << 14).for_each(|(sample, visible)| {
        if *visible < 1.0 {
            *sample = if *visible == 0.0 { 0.0 } else { *sample * visible };
        }
    });
}
