//! Warns where a layer that moves all of its scene also bends a background that only the plate shows.
//!
//! In: the layers that are warped in a frame, the plate. Out: a warning. Such layers have no matte by default, because a plate
//! of the scene alone is bent as a whole without loss.

use crate::image::{Channel, Plate};
use crate::pipeline::{PipelineError, PreparedShot};
use crate::shot::Source;

/// Smallest alpha that counts as opaque.
const OPAQUE: f32 = 0.99;

/// Returns the warning; `None` if the plate has transparent pixels, or the boxes of these layers cover the frame.
pub(super) fn warning(
    prepared: &PreparedShot,
    layers: &[usize],
    (frame, plate): (i32, &Plate),
) -> Result<Option<String>, PipelineError> {
    let whole: Vec<usize> = layers.iter().copied().filter(|&layer| prepared.bends_picture_unasked(layer)).collect();
    if !matches!(prepared.shot.source, Source::Scene(_)) || whole.is_empty() || !is_opaque(plate) {
        return Ok(None);
    }
    let sample = prepared.mid_exposure(frame)?;
    let aspect = plate.frame_size().aspect();
    let is_inside = |&&layer: &&usize| {
        let solution = sample.layers[layer].solution.as_ref();
        solution.is_some_and(|solution| {
            let grid = &solution.lattice.grid;
            grid.lo[0] > 0.0 || grid.lo[1] > 0.0 || grid.hi[0] < aspect || grid.hi[1] < 1.0
        })
    };
    let first = whole.iter().find(is_inside).map(|&layer| &prepared.shot.layers[layer].name);
    Ok(first.map(|name| {
        format!(
            "layer '{name}' moves all of the scene and has no matte: the whole plate bends, with the background that the scene does not show; \
             add matte = \"nodes\" to the layer, or matte = \"none\" if it is meant"
        )
    }))
}

/// Whether a plate shows something everywhere.
fn is_opaque(plate: &Plate) -> bool {
    let is_alpha = |channel: &&Channel| channel.name == "A" || channel.name.ends_with(".A");
    let alpha = plate.parts.iter().flat_map(|part| &part.channels).find(is_alpha);
    alpha.is_none_or(|alpha| alpha.samples.iter().all(|&alpha| alpha >= OPAQUE))
}
