//! Checks where branching lattices can be used, and where plain ones are required.
//!
//! In: a [`PreparedShot`]. Out: errors that name the layer and the remedy.

use crate::pipeline::{PipelineError, PreparedShot};
use crate::shot::Source;
use crate::solve::Topology;

/// Refuses layers with branching lattices where only plain ones are supported; `what`: the operation requested.
///
/// # Errors
/// [`PipelineError::Unusable`] for the first such layer.
pub(crate) fn check_plain(prepared: &PreparedShot, what: &str) -> Result<(), PipelineError> {
    match prepared.shot.layers.iter().find(|layer| layer.settings.topology != Topology::Plain) {
        Some(layer) => Err(PipelineError::Unusable {
            what: format!("the lattice of layer '{}' branches, which {what} cannot carry", layer.name),
            hint: "set topology = \"plain\" in its `lattice`, or render the pictures".into(),
        }),
        None => Ok(()),
    }
}

/// Refuses several pictures in one branching layer: they would count as islands, each linked to the others at a single place.
///
/// # Errors
/// [`PipelineError::Mismatch`] for the first such layer.
pub(in crate::pipeline) fn check_branching(prepared: &PreparedShot) -> Result<(), PipelineError> {
    let layers = prepared.shot.layers.iter().zip(&prepared.assignment.parts_of_layer).enumerate();
    let is_picture = matches!(prepared.shot.source, Source::Images(_));
    let mut branching = layers.filter(|(_, (layer, _))| is_picture && layer.settings.topology == Topology::Branching);
    match branching.find(|(_, (_, parts))| parts.len() > 1) {
        Some((index, (layer, parts))) => {
            let what = format!("layer '{}' branches and has {} pictures", layer.name, parts.len());
            let hint = "give each picture a layer of its own, or set topology = \"plain\"";
            let key = format!("layer[{index}].lattice.topology");
            Err(PipelineError::mismatch(&prepared.shot, &key, what, hint))
        }
        None => Ok(()),
    }
}
